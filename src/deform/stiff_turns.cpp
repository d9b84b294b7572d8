#include "deform/stiff_turns.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "core/trace.h"

namespace maille {
namespace {

constexpr float kStiffer = 30.0f;
// Smaller ones multigrid's smoothing turns; beyond so many the largest are worth it.
constexpr std::int64_t kLeastElements = 8;
constexpr std::size_t kMostParts = 64;

// Where compliances that occur are further apart than kStiffer, the lower of two.
std::vector<float> stiff_compliances(const SpringBox& box) {
  std::set<float> all;
  float last = -1.0f;
  for (std::int64_t e = 0; e < voxel_count(box.extent()); ++e) {
    const float c = box.compliance(e);
    if (c == last || !std::isfinite(c)) continue;
    last = c;
    all.insert(c);
  }
  std::vector<float> stiff;
  for (auto c = all.begin(); c != all.end() && std::next(c) != all.end(); ++c) {
    if (*std::next(c) > kStiffer * *c) stiff.push_back(*c);
  }
  return stiff;
}

glm::dmat3 cross_matrix(const glm::dvec3& v) {  // w -> w x v
  return {{0.0, -v.z, v.y}, {v.z, 0.0, -v.x}, {-v.y, v.x, 0.0}};
}

// None where what resists it does not tell in some direction.
glm::dvec3 turn_by(const glm::dvec3& torque, const glm::dmat3& resistance) {
  constexpr double kFlat = 1e-6;
  const double mean = (resistance[0][0] + resistance[1][1] + resistance[2][2]) / 3.0;
  const double volume = glm::determinant(resistance);
  if (!(volume > kFlat * mean * mean * mean) || !std::isfinite(volume)) return glm::dvec3(0.0);
  const glm::dvec3 turn = glm::inverse(resistance) * torque;
  // Beyond it no turn is straight ahead.
  constexpr double kMost = 0.5;  // radians
  const double size = glm::length(turn);
  return size > kMost ? turn * (kMost / size) : turn;
}

}  // namespace

StiffTurns::StiffTurns(const SpringBox& box, StiffnessMultigrid& multigrid, BoxVectors& forces,
                       BoxVectors& moves)
    : box_(box) {
  if (!box.compliances()) return;
  const trace::Span span("stiff parts");
  for (const float compliance : stiff_compliances(box)) find_parts(compliance);
  std::stable_sort(parts_.begin(), parts_.end(), [](const Part& a, const Part& b) {
    return a.leaving.size() > b.leaving.size();
  });
  if (parts_.size() > kMostParts) parts_.resize(kMostParts);
  if (!parts_.empty()) measure_yielding(multigrid, forces, moves);
}

// Whether there is a spring by an offset.
bool StiffTurns::is_joined(std::int64_t element, glm::ivec3 offset) const {
  for (int s = 0; s < kSprings; ++s) {
    if (box_.springs()[static_cast<std::size_t>(s)].offset != offset) continue;
    return box_.stiffness(element, s) > 0.0f;
  }
  return false;
}

// Runs of stiff elements along x, joined where springs join them.
void StiffTurns::find_parts(float stiff_compliance) {
  const Size3 extent = box_.extent();
  std::vector<Run> runs;
  std::vector<std::size_t> begins;  // of rows, in runs
  const std::int64_t rows = static_cast<std::int64_t>(extent.y) * extent.z;
  for (std::int64_t r = 0; r < rows; ++r) {
    begins.push_back(runs.size());
    const std::int64_t row = r * extent.x;
    for (int x = 0; x < extent.x; ++x) {
      if (!(box_.compliance(row + x) <= stiff_compliance)) continue;
      if (runs.size() > begins.back() && runs.back().first + runs.back().count == row + x &&
          is_joined(row + x - 1, {1, 0, 0})) {
        ++runs.back().count;
      } else {
        runs.push_back({row + x, 1});
      }
    }
  }
  begins.push_back(runs.size());
  std::vector<std::size_t> through(runs.size());
  std::iota(through.begin(), through.end(), std::size_t{0});
  const auto first_of = [&](std::size_t i) {
    while (through[i] != i) i = through[i] = through[through[i]];
    return i;
  };
  const auto join_rows = [&](glm::ivec2 yz, glm::ivec2 by, int reach) {
    const std::int64_t here = box_.row(yz[0], yz[1]);
    const std::int64_t there = box_.row(yz[0] + by[0], yz[1] + by[1]);
    const std::int64_t shift = (here - there) * extent.x;
    const auto any_spring = [&](const Run& run, const Run& other) {
      if (!box_.lacks_springs()) return true;
      for (int x = 0; x < run.count; ++x) {
        for (int dx = -reach; dx <= reach; ++dx) {
          const std::int64_t at = run.first + x - shift + dx;
          if (at < other.first || at >= other.first + other.count) continue;
          if (is_joined(run.first + x, {dx, by[0], by[1]})) return true;
        }
      }
      return false;
    };
    std::size_t j = begins[static_cast<std::size_t>(there)];
    const std::size_t end = begins[static_cast<std::size_t>(there) + 1];
    for (std::size_t i = begins[static_cast<std::size_t>(here)];
         i < begins[static_cast<std::size_t>(here) + 1]; ++i) {
      const std::int64_t low = runs[i].first - shift - reach;
      const std::int64_t high = runs[i].first + runs[i].count - 1 - shift + reach;
      while (j < end && runs[j].first + runs[j].count - 1 < low) ++j;
      for (std::size_t k = j; k < end && runs[k].first <= high; ++k) {
        if (!any_spring(runs[i], runs[k])) continue;
        const auto [first, second] = std::minmax({first_of(i), first_of(k)});
        through[second] = first;
      }
    }
  };
  for (int z = 0; z < extent.z; ++z) {
    for (int y = 0; y < extent.y; ++y) {
      if (y > 0) join_rows({y, z}, {-1, 0}, 1);
      if (z == 0) continue;
      join_rows({y, z}, {0, -1}, 1);
      if (y > 0) join_rows({y, z}, {-1, -1}, 0);
      if (y + 1 < extent.y) join_rows({y, z}, {1, -1}, 0);
    }
  }
  std::map<std::size_t, Part> parts;
  for (std::size_t i = 0; i < runs.size(); ++i) parts[first_of(i)].runs.push_back(runs[i]);
  for (auto& [first, part] : parts) {
    std::int64_t elements = 0;
    std::int64_t held = 0;
    for (const Run& run : part.runs) {
      elements += run.count;
      for (int x = 0; x < run.count; ++x) {
        if (box_.is_free(run.first + x)) continue;
        ++held;
        part.held = run.first + x;
      }
    }
    if (elements < kLeastElements || held > 1) continue;
    for (const Run& run : part.runs) {
      for (std::int64_t e = run.first; e < run.first + run.count; ++e) {
        for (int s = 0; s < kSprings; ++s) {
          const double k = double{box_.stiffness(e, s)};
          if (!(k > 0.0)) continue;
          const std::int64_t other = e + box_.step(s);
          if (!(box_.compliance(other) <= stiff_compliance)) {
            part.leaving.push_back({e, other, s});
            continue;
          }
          const double blend = 0.5 * (double{box_.blend(e)} + double{box_.blend(other)});
          const glm::dmat3 arm =
              cross_matrix(glm::dvec3(box_.springs()[static_cast<std::size_t>(s)].rest_mm));
          part.blend += 0.5 * k * blend * (glm::transpose(arm) * arm);
        }
      }
    }
    parts_.push_back(std::move(part));
  }
}

glm::dvec3 StiffTurns::position_mm(std::int64_t e) const {
  const BoxVectors& u = box_.u_mm();
  return glm::dvec3(box_.voxel(e) - box_.lo()) * box_.spacing_mm() +
         glm::dvec3(u[0][e], u[1][e], u[2][e]);
}

glm::dvec3 StiffTurns::center_of(const Part& part) const {
  if (part.held >= 0) return position_mm(part.held);
  glm::dvec3 sum(0.0);
  std::int64_t count = 0;
  for (const Run& run : part.runs) {
    for (int x = 0; x < run.count; ++x) sum += position_mm(run.first + x);
    count += run.count;
  }
  return sum / static_cast<double>(count);
}

// All of what is around it fixed: the Hessian of the springs that leave it, none of it negative.
glm::dmat3 StiffTurns::resistance(const Part& part) const {
  glm::dmat3 sum = part.blend;
  for (const Leaving& l : part.leaving) {
    const auto& spring = box_.springs()[static_cast<std::size_t>(l.spring)];
    const glm::dvec3 at = position_mm(l.inside);
    const glm::dvec3 p = at - position_mm(l.outside);
    const double k = double{box_.stiffness(l.inside, l.spring)};
    const double blend = 0.5 * (double{box_.blend(l.inside)} + double{box_.blend(l.outside)});
    const double length2 = glm::dot(p, p) + 1e-30;
    const double across = std::max(0.0, 1.0 - double{spring.length_mm} / std::sqrt(length2));
    const glm::dmat3 bend =
        glm::outerProduct(p, p) * (k * (1.0 - blend) * (1.0 - across) / length2) +
        glm::dmat3(k * (1.0 - blend) * across + k * blend);
    const glm::dmat3 arm = cross_matrix(at - part.center_mm);
    sum += glm::transpose(arm) * bend * arm;
  }
  return sum;
}

// One turn of all parts at once: the work that what is around gives way by, of the work it would
// take.
void StiffTurns::measure_yielding(StiffnessMultigrid& multigrid, BoxVectors& forces,
                                  BoxVectors& moves) {
  const glm::dvec3 turn = glm::dvec3(1.0) / std::sqrt(3.0);
  for (Part& part : parts_) {
    part.center_mm = center_of(part);
    for (const Leaving& l : part.leaving) {
      if (!box_.is_free(l.outside)) continue;
      const glm::dvec3 pull = double{box_.stiffness(l.inside, l.spring)} *
                              glm::cross(turn, position_mm(l.inside) - part.center_mm);
      for (int c = 0; c < 3; ++c) {
        forces[static_cast<std::size_t>(c)][l.outside] += static_cast<float>(pull[c]);
      }
    }
  }
  multigrid.solve(forces, moves);
  for (Part& part : parts_) {
    double fixed = 0.0;
    double gives = 0.0;
    for (const Leaving& l : part.leaving) {
      const double k = double{box_.stiffness(l.inside, l.spring)};
      const glm::dvec3 move = glm::cross(turn, position_mm(l.inside) - part.center_mm);
      const glm::dvec3 follows(moves[0][l.outside], moves[1][l.outside], moves[2][l.outside]);
      fixed += k * glm::dot(move, move);
      gives += k * glm::dot(move, follows);
    }
    constexpr double kLeast = 0.05;
    if (fixed > 0.0) part.yielding = std::clamp(1.0 - gives / fixed, kLeast, 1.0);
  }
  for (const Part& part : parts_) {
    for (const Leaving& l : part.leaving) {
      for (auto& component : forces) component[l.outside] = 0.0f;
    }
  }
}

void StiffTurns::take(BoxVectors& forces) {
  const trace::Span span("turns of stiff parts");
  before_.clear();
  for (Part& part : parts_) {
    part.center_mm = center_of(part);
    glm::dvec3 torque(0.0);
    for (const Run& run : part.runs) {
      for (std::int64_t e = run.first; e < run.first + run.count; ++e) {
        torque += glm::cross(position_mm(e) - part.center_mm,
                             glm::dvec3(forces[0][e], forces[1][e], forces[2][e]));
      }
    }
    part.turn = turn_by(torque, part.yielding * resistance(part));
    // What is around follows by multigrid.
    for (const Leaving& l : part.leaving) {
      if (!box_.is_free(l.outside)) continue;
      const std::int64_t e = l.outside;
      before_.emplace_back(e, glm::vec3(forces[0][e], forces[1][e], forces[2][e]));
      const glm::dvec3 pull = double{box_.stiffness(l.inside, l.spring)} *
                              glm::cross(part.turn, position_mm(l.inside) - part.center_mm);
      for (int c = 0; c < 3; ++c) {
        forces[static_cast<std::size_t>(c)][e] += static_cast<float>(pull[c]);
      }
    }
  }
}

void StiffTurns::give_back(BoxVectors& forces) const {
  for (auto change = before_.rbegin(); change != before_.rend(); ++change) {
    for (int c = 0; c < 3; ++c) {
      forces[static_cast<std::size_t>(c)][change->first] = change->second[c];
    }
  }
}

void StiffTurns::add(BoxVectors& moves) const {
  for (const Part& part : parts_) {
    for (const Run& run : part.runs) {
      for (std::int64_t e = run.first; e < run.first + run.count; ++e) {
        if (!box_.is_free(e)) continue;
        const glm::dvec3 move = glm::cross(part.turn, position_mm(e) - part.center_mm);
        for (int c = 0; c < 3; ++c) {
          moves[static_cast<std::size_t>(c)][e] += static_cast<float>(move[c]);
        }
      }
    }
  }
}

std::int64_t StiffTurns::bytes() const {
  std::int64_t sum = 0;
  for (const Part& part : parts_) {
    sum += static_cast<std::int64_t>(part.runs.size() * sizeof(Run) +
                                     part.leaving.size() * sizeof(Leaving));
  }
  return sum;
}

}  // namespace maille
