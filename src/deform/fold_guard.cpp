#include "deform/fold_guard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/trace.h"
#include "deform/cell_rows.h"
#include "deform/spring_rows.h"

namespace maille {
namespace {

// Elements at corners below this are moved one by one.
constexpr double kNear = 1.05 * kFoldReach;
// No step may leave less than this of what an open corner had, or of its reach.
constexpr double kLeft = 0.3;
constexpr double kLeftByElement = 0.2;
// Nor take an open corner below this. The energy of a corner is finite, so hard enough a pull has
// its least beyond J = 0; without a floor J then shrinks by a share a step until its rounding folds
// it, in the floats or in the lattice's fixed point.
constexpr double kLeastOpen = 0.002;
constexpr double kDeterminantRounding = 16 * 0x1p-24;
constexpr int kMostSweeps = 20;

// The least J that a step may leave of an open corner.
double least_left(double was, double share) {
  return std::max(share * std::min(was, kFoldReach), std::min(was, kLeastOpen));
}

struct SpringHere {
  std::int64_t other = 0;
  glm::dvec3 rest_mm{0};
  double length_mm = 0.0;
  double stiffness = 0.0;
  double blend = 0.0;
};

struct CornerHere {
  CellCorner corner;
  glm::dvec3 shares{0};
  double kappa = 0.0;
};

glm::dvec3 at(const BoxVectors& v, std::int64_t e) {
  return {double{v[0][e]}, double{v[1][e]}, double{v[2][e]}};
}

template <class T>
void sort_once(std::vector<T>& v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
}

}  // namespace

// An element with all that its energy takes, gathered once for many moves.
struct FoldGuard::Element {
  std::int64_t element = 0;
  int color = 0;  // elements of one color have no spring or corner in common
  std::vector<SpringHere> springs;
  std::vector<CornerHere> corners;
};

FoldGuard::FoldGuard(SpringBox& box, WorkerPool& pool)
    : box_(box),
      pool_(pool),
      folds_(box),
      rows_(static_cast<std::size_t>(box.extent().y) * static_cast<std::size_t>(box.extent().z)) {
  find_bent(find_near(), {});
}

std::vector<CellCorner> FoldGuard::find_near() {
  const trace::Span span("cells near folding");
  const Size3 extent = box_.extent();
  std::vector<std::vector<CellCorner>> found(static_cast<std::size_t>(extent.z));
  pool_.for_each(extent.z - 1, [&](std::int64_t plane, int) {
    auto& corners = found[static_cast<std::size_t>(plane)];
    for (int y = 0; y < extent.y - 1; ++y) {
      const std::int64_t r = box_.row(y, static_cast<int>(plane));
      RowMeasure& row = rows_[static_cast<std::size_t>(r)];
      if (row.travelled >= 0.0) {
        // An edge changes by what both its ends have moved; J is a product of three.
        const double d = 2.0 * (travelled_voxels_ - row.travelled);
        const double e = double{row.longest_edge};
        const double rounding = kDeterminantRounding * e * e * e;
        if (double{row.least} - rounding - ((3.0 * e + 3.0 * d) * e + d * d) * d > kNear) continue;
      }
      row = {std::numeric_limits<float>::max(), 0.0f, travelled_voxels_};
      for (int x0 = 0; x0 < extent.x - 1; x0 += kLongestRun) {
        const int count = std::min(kLongestRun, extent.x - 1 - x0);
        float least[kLongestRun];
        const auto measure = measure_cells(box_, r * extent.x + x0, count, least);
        row.least = std::min(row.least, measure.least);
        row.longest_edge = std::max(row.longest_edge, measure.longest_edge);
        // J is a product of three edges, and off by its own rounding where they are long.
        const double e = double{measure.longest_edge};
        const double near = kNear + kDeterminantRounding * e * e * e;
        if (double{measure.least} >= near) continue;
        for (int x = 0; x < count; ++x) {
          if (double{least[x]} >= near) continue;
          for (std::uint8_t at_high = 0; at_high < 8; ++at_high) {
            std::int64_t e = r * extent.x + x0 + x;
            for (int axis = 0; axis < 3; ++axis) {
              if ((at_high >> axis) & 1) e += box_.step(2 * axis);
            }
            const CellCorner corner{e, at_high};
            if (folds_.counts(corner) && folds_.determinant(corner) < kNear) {
              corners.push_back(corner);
            }
          }
        }
      }
    }
  });
  std::vector<CellCorner> near;
  for (const auto& corners : found) near.insert(near.end(), corners.begin(), corners.end());
  return near;
}

void FoldGuard::advance(const BoxVectors& direction, double step, double furthest_voxels) {
  const Size3 extent = box_.extent();
  const auto by = static_cast<float>(step);
  pool_.for_each(extent.z, [&](std::int64_t plane, int) {
    const std::int64_t begin = plane * extent.x * extent.y;
    const std::int64_t count = std::int64_t{extent.x} * extent.y;
    for (std::size_t c = 0; c < 3; ++c) {
      float* const u = &box_.u_mm()[c][begin];
      const float* const d = &direction[c][begin];
      for (std::int64_t i = 0; i < count; ++i) u[i] += by * d[i];
    }
  });
  travelled_voxels_ += furthest_voxels;
  const std::vector<CellCorner> near = find_near();
  std::vector<std::int64_t> elements = take_back(near, direction, step);
  for (const CellCorner& corner : near) {
    for (const std::int64_t e : folds_.elements_of(corner)) elements.push_back(e);
  }
  std::erase_if(elements, [&](std::int64_t e) { return !box_.is_free(e); });
  sort_once(elements);
  settle(elements);
  find_bent(near, elements);
}

// Halves the step of the elements of corners that it closed; after a few halvings none of it is
// left. Returns them.
std::vector<std::int64_t> FoldGuard::take_back(const std::vector<CellCorner>& near,
                                               const BoxVectors& direction, double step) {
  constexpr std::array<double, 6> kShares = {1.0, 0.5, 0.25, 0.125, 0.0625, 0.0};
  std::vector<std::pair<std::int64_t, int>> taken_back;  // element and how often, by element
  const auto times = [&](std::int64_t e) {
    const auto it = std::lower_bound(taken_back.begin(), taken_back.end(), std::pair{e, 0});
    return it != taken_back.end() && it->first == e ? it->second : 0;
  };
  // Where an element was: what is left of its step taken off again.
  const auto before = [&](const CellCorner& corner) {
    glm::dmat3 edges = folds_.edges(corner);
    const auto elements = folds_.elements_of(corner);
    for (int axis = 0; axis < 3; ++axis) {
      const double sign = (corner.signs >> axis) & 1 ? -1.0 : 1.0;
      const std::int64_t other = elements[static_cast<std::size_t>(axis + 1)];
      const glm::dvec3 moved =
          step * (kShares[static_cast<std::size_t>(times(other))] * at(direction, other) -
                  kShares[static_cast<std::size_t>(times(elements[0]))] *
                      at(direction, elements[0]));
      edges[axis] -= sign * moved / box_.spacing_mm();
    }
    return glm::determinant(edges);
  };
  const auto closes = [&](const CellCorner& corner) {
    const double now = folds_.determinant(corner);
    if (now >= kLeft * kFoldReach) return false;
    const double was = before(corner);
    return was > 0.0 && now < least_left(was, kLeft);
  };
  std::vector<CellCorner> closed;
  for (const CellCorner& corner : near) {
    if (closes(corner)) closed.push_back(corner);
  }
  while (!closed.empty()) {
    std::vector<std::int64_t> halve;
    for (const CellCorner& corner : closed) {
      for (const std::int64_t e : folds_.elements_of(corner)) {
        if (box_.is_free(e) && times(e) + 1 < static_cast<int>(kShares.size())) halve.push_back(e);
      }
    }
    sort_once(halve);
    if (halve.empty()) break;
    std::vector<std::pair<std::int64_t, int>> merged;
    auto old = taken_back.begin();
    for (const std::int64_t e : halve) {
      const int n = times(e);
      const double off = kShares[static_cast<std::size_t>(n)] - kShares[static_cast<std::size_t>(n + 1)];
      for (std::size_t c = 0; c < 3; ++c) {
        box_.u_mm()[c][e] -= static_cast<float>(step * off * double{direction[c][e]});
      }
      while (old != taken_back.end() && old->first < e) merged.push_back(*old++);
      if (old != taken_back.end() && old->first == e) ++old;
      merged.emplace_back(e, n + 1);
    }
    merged.insert(merged.end(), old, taken_back.end());
    taken_back = std::move(merged);
    std::vector<CellCorner> candidates;
    for (const std::int64_t e : halve) {
      folds_.for_each_corner_at(e, [&](const CellCorner& corner) { candidates.push_back(corner); });
    }
    sort_once(candidates);
    closed.clear();
    for (const CellCorner& corner : candidates) {
      if (closes(corner)) closed.push_back(corner);
    }
  }
  std::vector<std::int64_t> elements;
  elements.reserve(taken_back.size());
  for (const auto& [e, n] : taken_back) elements.push_back(e);
  return elements;
}

void FoldGuard::settle(const std::vector<std::int64_t>& elements) {
  if (elements.empty()) return;
  const trace::Span span("elements near folding");
  const Size3 extent = box_.extent();
  std::vector<Element> all(elements.size());
  pool_.for_each(static_cast<std::int64_t>((elements.size() + 63) / 64), [&](std::int64_t part,
                                                                             int) {
    const std::size_t end = std::min(elements.size(), static_cast<std::size_t>(part + 1) * 64);
    for (std::size_t i = static_cast<std::size_t>(part) * 64; i < end; ++i) {
      const std::int64_t e = elements[i];
      Element& here = all[i];
      here.element = e;
      const std::int64_t row = e / extent.x;
      here.color = static_cast<int>(((e - row * extent.x) & 1) | (row % extent.y & 1) << 1 |
                                    (row / extent.y & 1) << 2);
      for (int s = 0; s < kSprings; ++s) {
        const double k = double{box_.stiffness(e, s)};
        if (!(k > 0.0)) continue;
        const Spring& spring = box_.springs()[static_cast<std::size_t>(s)];
        const std::int64_t other = e + box_.step(s);
        here.springs.push_back({other, glm::dvec3(spring.rest_mm), double{spring.length_mm}, k,
                                0.5 * (double{box_.blend(e)} + double{box_.blend(other)})});
      }
      folds_.for_each_corner_at(e, [&](const CellCorner& corner) {
        here.corners.push_back({corner, folds_.shares(corner, e), folds_.kappa(corner)});
      });
    }
  });
  std::array<std::vector<const Element*>, 8> by_color;
  for (const Element& e : all) by_color[static_cast<std::size_t>(e.color)].push_back(&e);
  double first_move = 0.0;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double largest = 0.0;
    for (const auto& color : by_color) {
      // Waking workers takes as long as a hundred elements.
      constexpr std::size_t kPart = 64;
      const std::size_t parts = (color.size() + kPart - 1) / kPart;
      std::vector<double> moves(parts, 0.0);
      const auto one = [&](std::int64_t part, int) {
        const std::size_t begin = static_cast<std::size_t>(part) * kPart;
        const std::size_t end = std::min(color.size(), begin + kPart);
        double& move = moves[static_cast<std::size_t>(part)];
        for (std::size_t i = begin; i < end; ++i) {
          move = std::max(move, move_to_least_energy(*color[i]));
        }
      };
      if (parts <= 2) {
        for (std::size_t i = 0; i < parts; ++i) one(static_cast<std::int64_t>(i), 0);
      } else {
        pool_.for_each(static_cast<std::int64_t>(parts), one);
      }
      for (const double move : moves) largest = std::max(largest, move);
    }
    if (sweep == 0) first_move = largest;
    if (largest <= 0.02 * first_move || largest < 1e-6) break;
  }
  note_moved(elements);
}

// Returns how far it moved, in voxels.
double FoldGuard::move_to_least_energy(const Element& here) {
  struct Measured {
    double energy = 0.0;
    bool closes = false;
  };
  const glm::dvec3 u = at(box_.u_mm(), here.element);
  const glm::dvec3 voxels_from_mm = 1.0 / box_.spacing_mm();
  glm::dvec3 gradient(0.0);
  glm::dmat3 hessian(0.0);
  double energy = 0.0;
  for (const SpringHere& s : here.springs) {
    const glm::dvec3 du = u - at(box_.u_mm(), s.other);
    const glm::dvec3 p = s.rest_mm + du;
    const double length = std::sqrt(glm::dot(p, p) + 1e-30);
    const double stretch = length - s.length_mm;
    const double plain = s.stiffness * (1.0 - s.blend);
    const double straight = s.stiffness * s.blend;
    energy += 0.5 * (plain * stretch * stretch + straight * glm::dot(du, du));
    gradient += plain * (stretch / length) * p + straight * du;
    const double across = std::max(0.0, 1.0 - s.length_mm / length);
    const double along = plain * (1.0 - across) / (length * length);
    hessian += glm::outerProduct(along * p, p) + glm::dmat3(plain * across + straight);
  }
  struct CornerNow {
    glm::dmat3 edges;
    double determinant;
  };
  std::array<CornerNow, 32> now;
  std::size_t n = 0;
  for (const CornerHere& c : here.corners) {
    CornerNow& corner = now[n++];
    corner.edges = folds_.edges(c.corner);
    corner.determinant = glm::determinant(corner.edges);
    const FoldPenalty penalty = fold_penalty(corner.determinant);
    if (!(penalty.value > 0.0)) continue;
    const glm::dvec3 slope =
        (FoldEnergy::cofactors(corner.edges) * c.shares) * voxels_from_mm / kFoldReach;
    energy += c.kappa * penalty.value;
    gradient += c.kappa * penalty.slope * slope;
    hessian += glm::outerProduct(2.0 * c.kappa * slope, slope);
  }
  const double volume = glm::determinant(hessian);
  if (!(volume > 0.0) || !std::isfinite(volume)) return 0.0;
  const glm::dvec3 full = -glm::inverse(hessian) * gradient;
  double share = 1.0;
  for (int attempt = 0; attempt < 12; ++attempt, share *= 0.5) {
    const glm::dvec3 move = share * full;
    double moved_energy = 0.0;
    bool closes = false;
    for (std::size_t i = 0; i < n && !closes; ++i) {
      const CornerHere& c = here.corners[i];
      glm::dmat3 edges = now[i].edges;
      for (int a = 0; a < 3; ++a) edges[a] += c.shares[a] * move * voxels_from_mm;
      const double j = glm::determinant(edges);
      const double was = now[i].determinant;
      closes = was > 0.0 && j < least_left(was, kLeftByElement);
      moved_energy += c.kappa * fold_penalty(j).value;
    }
    if (closes) continue;
    for (const SpringHere& s : here.springs) {
      const glm::dvec3 du = u + move - at(box_.u_mm(), s.other);
      const glm::dvec3 p = s.rest_mm + du;
      const double stretch = std::sqrt(glm::dot(p, p) + 1e-30) - s.length_mm;
      moved_energy += 0.5 * s.stiffness *
                      ((1.0 - s.blend) * stretch * stretch + s.blend * glm::dot(du, du));
    }
    if (!(moved_energy <= energy)) continue;
    for (int c = 0; c < 3; ++c) {
      box_.u_mm()[static_cast<std::size_t>(c)][here.element] = static_cast<float>(u[c] + move[c]);
    }
    return glm::length(move * voxels_from_mm);
  }
  return 0.0;
}

// What one by one has moved is measured anew, whatever the way of all others was.
void FoldGuard::note_moved(const std::vector<std::int64_t>& elements) {
  const Size3 extent = box_.extent();
  for (const std::int64_t e : elements) {
    const std::int64_t r = e / extent.x;
    for (const std::int64_t back : {std::int64_t{0}, std::int64_t{1}}) {
      for (const std::int64_t down : {std::int64_t{0}, std::int64_t{extent.y}}) {
        rows_[static_cast<std::size_t>(r - back - down)].travelled = -1.0;
      }
    }
  }
}

void FoldGuard::find_bent(const std::vector<CellCorner>& near,
                          const std::vector<std::int64_t>& moved) {
  std::vector<CellCorner> candidates = near;
  for (const std::int64_t e : moved) {
    folds_.for_each_corner_at(e, [&](const CellCorner& c) { candidates.push_back(c); });
  }
  sort_once(candidates);
  bent_.clear();
  folded_ = 0;
  for (const CellCorner& corner : candidates) {
    const double j = folds_.determinant(corner);
    if (j < kFoldReach) bent_.push_back(corner);
    folded_ += j <= 0.0;
  }
}

double FoldGuard::energy() const {
  double sum = 0.0;
  for (const CellCorner& corner : bent_) sum += folds_.energy(corner);
  return sum;
}

void FoldGuard::add_forces(BoxVectors& forces) const {
  for (const CellCorner& corner : bent_) folds_.add_forces(corner, forces);
}

double FoldGuard::curvature(const BoxVectors& direction) const {
  double sum = 0.0;
  for (const CellCorner& corner : bent_) sum += folds_.curvature(corner, direction);
  return sum;
}

}  // namespace maille
