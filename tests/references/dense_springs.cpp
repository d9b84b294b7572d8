#include "references/dense_springs.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Eigenvalues>

#include "references/link_bounds.h"

namespace maille {
namespace {

constexpr double kWidestGap = 1000.0;

// b(q) with its first two derivatives.
struct Barrier {
  double value;
  double slope;
  double curvature;
};

Barrier barrier(double q, const FoldTerm& fold) {
  if (q >= 1.0) return {0.0, 0.0, 0.0};
  if (fold.rule == FoldRule::wall) {
    if (q < fold.straight_below) {
      return {barrier(fold.straight_below, fold).value + 2.0 * (fold.straight_below - q), -2.0,
              0.0};
    }
    Barrier sum{std::pow(1.0 - q, 2), 2.0 * q - 2.0, 2.0};
    const double s = 3.0 * q;
    if (s >= 1.0) return sum;
    sum.value -= std::pow(1.0 - s, 2) * std::log(s);
    sum.slope += 3.0 * (2.0 * (1.0 - s) * std::log(s) - (1.0 - s) * (1.0 - s) / s);
    sum.curvature += 9.0 * (-2.0 * std::log(s) + 4.0 * (1.0 - s) / s + std::pow((1.0 - s) / s, 2));
    return sum;
  }
  const double at = std::max(q, fold.straight_below);
  const double log = std::log(at);
  const double gap = 1.0 - at;
  const double value = -gap * gap * log;
  const double slope = 2.0 * gap * log - gap * gap / at;
  if (q < at) return {value + (q - at) * slope, slope, 0.0};
  return {value, slope, -2.0 * log + 4.0 * gap / at + gap * gap / (at * at)};
}

bool minds_corners(FoldRule rule) {
  return rule == FoldRule::determinant || rule == FoldRule::wall;
}

Eigen::Matrix3d cross_matrix(const glm::dvec3& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z, v.y, v.z, 0, -v.x, -v.y, v.x, 0;
  return m;
}

// By each edge: the normals of a corner, whose products with the edges are its determinant.
std::array<glm::dvec3, 3> normals_of(const std::array<glm::dvec3, 3>& edge) {
  return {glm::cross(edge[1], edge[2]), glm::cross(edge[2], edge[0]), glm::cross(edge[0], edge[1])};
}

Eigen::Vector3d eigen_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

}  // namespace

std::vector<SpringMaterial> spring_materials(std::span<const Material> materials,
                                             std::optional<double> rest_vector_blend) {
  double stiffest = 0.0;
  for (const Material& m : materials) {
    if (!m.rigid) stiffest = std::max(stiffest, m.stiffness);
  }
  if (stiffest == 0.0) stiffest = 1.0;  // all rigid: only ratios matter
  std::vector<SpringMaterial> springs;
  for (const Material& m : materials) {
    springs.push_back({m.rigid ? kWidestGap * stiffest : m.stiffness,
                       rest_vector_blend.value_or(m.rest_vector_blend.value_or(0.25)), m.compress,
                       m.stretch, m.shear});
  }
  std::vector<std::size_t> order(springs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return springs[a].stiffness < springs[b].stiffness;
  });
  double taken_out = 1.0;
  double before = 0.0;
  for (const std::size_t m : order) {
    const double asked = springs[m].stiffness;
    if (before > 0.0 && asked > kWidestGap * before) taken_out *= asked / (kWidestGap * before);
    before = asked;
    springs[m].stiffness = asked / taken_out;
  }
  return springs;
}

DisplacementField mm_of(const DisplacementField& u_voxels, glm::dvec3 spacing_mm) {
  DisplacementField u = u_voxels;
  for (glm::dvec3& v : u) v *= spacing_mm;
  return u;
}

DisplacementField voxels_of(const DisplacementField& u_mm, glm::dvec3 spacing_mm) {
  DisplacementField u = u_mm;
  for (glm::dvec3& v : u) v /= spacing_mm;
  return u;
}

const std::array<glm::ivec3, DenseSprings::kForward> DenseSprings::kOffsets = {
    glm::ivec3(1, 0, 0),  glm::ivec3(0, 1, 0),  glm::ivec3(0, 0, 1),
    glm::ivec3(1, 1, 0),  glm::ivec3(-1, 1, 0), glm::ivec3(1, 0, 1),
    glm::ivec3(-1, 0, 1), glm::ivec3(0, 1, 1),  glm::ivec3(0, -1, 1)};

DenseSprings::DenseSprings(const SpringProblem& problem, WorkerPool& pool)
    : problem_(problem), pool_(pool) {
  const Size3 size = problem.size;
  const auto count = static_cast<std::size_t>(voxel_count(size));
  for (std::size_t s = 0; s < kForward; ++s) {
    const glm::ivec3 o = kOffsets[s];
    steps_[s] = o.x + std::ptrdiff_t{size.x} * (o.y + std::ptrdiff_t{size.y} * o.z);
    rest_mm_[s] = glm::dvec3(o) * problem.spacing_mm;
    length_mm_[s] = glm::length(rest_mm_[s]);
  }
  std::vector<Material> limits;
  for (const SpringMaterial& m : problem.materials) {
    Material material;
    material.compress = m.compress;
    material.stretch = m.stretch;
    material.shear = m.shear;
    limits.push_back(material);
  }
  const LinkBounds bounds(limits);
  for (std::size_t a = 0; a < limits.size(); ++a) {
    for (std::size_t b = 0; b < limits.size(); ++b) {
      const SpringMaterial& low = problem.materials[a];
      const SpringMaterial& high = problem.materials[b];
      Pair p{2.0 / (1.0 / low.stiffness + 1.0 / high.stiffness),
             0.5 * (low.rest_vector_blend + high.rest_vector_blend),
             {},
             {}};
      for (int axis = 0; axis < 3; ++axis) {
        const LinkBound& bound =
            bounds.of(axis, static_cast<MaterialId>(a), static_cast<MaterialId>(b));
        p.lower[static_cast<std::size_t>(axis)] = glm::dvec3(bound.lower) / double{kUnitsPerVoxel};
        p.upper[static_cast<std::size_t>(axis)] = glm::dvec3(bound.upper) / double{kUnitsPerVoxel};
      }
      pairs_.push_back(p);
    }
  }
  held_ = problem.held;
  held_.resize(count);
  springs_.resize(count);
  std::vector<std::uint32_t> forward;
  for (int backward = 0; backward < 2; ++backward) {
    forward = springs_;
    for_each_layer([&](int z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
          const VoxelIndex at(x, y, z);
          const std::size_t i = element_of(at, size);
          for (std::size_t s = 0; s < kForward; ++s) {
            if (!backward) {
              if (spring_left(i, at, kOffsets[s])) springs_[i] |= 1u << s;
            } else if (const VoxelIndex from = at - kOffsets[s]; contains(size, from)) {
              if ((forward[element_of(from, size)] >> s) & 1) springs_[i] |= 1u << (kForward + s);
            }
          }
        }
      }
    });
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (springs_[i] == 0) held_[i] = 1;
    free_elements_ += held_[i] == 0;
  }
}

bool DenseSprings::spring_left(std::size_t i, VoxelIndex at, glm::ivec3 offset) const {
  if (!contains(problem_.size, at + offset)) return false;
  if (problem_.removed.empty()) return true;
  // A step from an element along an axis, up or down.
  const auto step_of = [&](int axis) {
    return offset[axis] * (axis == 0   ? std::ptrdiff_t{1}
                           : axis == 1 ? std::ptrdiff_t{problem_.size.x}
                                       : static_cast<std::ptrdiff_t>(layer()));
  };
  const auto way = [&](std::size_t from, int axis) {
    const std::size_t to = from + static_cast<std::size_t>(step_of(axis));
    return link_left(std::min(from, to), axis);
  };
  int axes[2] = {0, 0};
  int count = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (offset[axis] != 0) axes[count++] = axis;
  }
  if (count == 1) return way(i, axes[0]);
  const auto round = [&](int first, int second) {
    return way(i, first) && way(i + static_cast<std::size_t>(step_of(first)), second);
  };
  return round(axes[0], axes[1]) || round(axes[1], axes[0]);
}

double DenseSprings::stiffness_sum(std::size_t element) const {
  double sum = 0.0;
  for_each_spring_of(element, [&](std::size_t, const SpringView& s) { sum += s.stiffness; });
  return sum;
}

// --- energy

double DenseSprings::energy(const DisplacementField& u_mm) const {
  return spring_energy(u_mm) + fold_energy(u_mm);
}

double DenseSprings::spring_energy(const DisplacementField& u_mm) const {
  return sum_of_layers([&](int z) {
    double sum = 0.0;
    const std::size_t first = layer() * static_cast<std::size_t>(z);
    for (std::size_t i = first; i < first + layer(); ++i) {
      for (std::size_t s = 0; s < kForward; ++s) {
        if (!((springs_[i] >> s) & 1)) continue;
        const std::size_t j = i + static_cast<std::size_t>(steps_[s]);
        const Pair& p = pair(i, j);
        const glm::dvec3 kept = kept_mm(i, s);
        const glm::dvec3 rest = rest_mm_[s] + kept;
        const glm::dvec3 du = u_mm[j] - u_mm[i] - kept;
        const double l = glm::length(rest + du);
        // l - d without its rounding.
        const double longer = (2.0 * glm::dot(rest, du) + glm::dot(du, du)) / (l + length_mm(i, s));
        sum += 0.5 * p.stiffness * ((1.0 - p.blend) * longer * longer + p.blend * glm::dot(du, du));
      }
    }
    return sum;
  });
}

glm::dvec3 DenseSprings::excess_mm(std::size_t lower, int axis,
                                   const DisplacementField& u_mm) const {
  const std::size_t higher = lower + static_cast<std::size_t>(step(axis));
  const Pair& p = pair(lower, higher);
  const glm::dvec3 du = u_mm[higher] - u_mm[lower];
  const glm::dvec3 low = p.lower[static_cast<std::size_t>(axis)] * problem_.spacing_mm;
  const glm::dvec3 high = p.upper[static_cast<std::size_t>(axis)] * problem_.spacing_mm;
  return du - glm::clamp(du, low, high);
}

glm::dvec3 DenseSprings::within_limits(std::size_t i, const DisplacementField& u_mm,
                                       glm::dvec3 asked_mm) const {
  glm::dvec3 low(-INFINITY);
  glm::dvec3 high(INFINITY);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const auto step_of = static_cast<std::size_t>(steps_[a]);
    if ((springs_[i] >> axis) & 1) {
      const Pair& p = pair(i, i + step_of);
      low = glm::max(low, u_mm[i + step_of] - p.upper[a] * problem_.spacing_mm);
      high = glm::min(high, u_mm[i + step_of] - p.lower[a] * problem_.spacing_mm);
    }
    if ((springs_[i] >> (kForward + axis)) & 1) {
      const Pair& p = pair(i - step_of, i);
      low = glm::max(low, u_mm[i - step_of] + p.lower[a] * problem_.spacing_mm);
      high = glm::min(high, u_mm[i - step_of] + p.upper[a] * problem_.spacing_mm);
    }
  }
  return glm::clamp(asked_mm, glm::min(low, u_mm[i]), glm::max(high, u_mm[i]));
}

double DenseSprings::limit_energy_of(std::size_t element, const DisplacementField& u_mm) const {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!has_spring(element, axis)) continue;
    const glm::dvec3 excess = excess_mm(element, axis, u_mm);
    sum += 0.5 * problem_.fold.weight * stiffness(element, axis) * glm::dot(excess, excess);
  }
  return sum;
}

double DenseSprings::fold_energy(const DisplacementField& u_mm) const {
  switch (problem_.fold.rule) {
    case FoldRule::none: return 0.0;
    case FoldRule::limits:
      return sum_of_layers([&](int z) {
        double sum = 0.0;
        const std::size_t first = layer() * static_cast<std::size_t>(z);
        for (std::size_t i = first; i < first + layer(); ++i) sum += limit_energy_of(i, u_mm);
        return sum;
      });
    case FoldRule::determinant:
    case FoldRule::wall:
      return sum_of_layers([&](int z) {
        double sum = 0.0;
        for_each_corner_of_layer(z, u_mm, [&](const Corner& corner) {
          if (corner.determinant < problem_.fold.reach) {
            sum += corner.scale *
                   barrier(corner.determinant / problem_.fold.reach, problem_.fold).value;
          }
        });
        return sum;
      });
  }
  return 0.0;
}

// --- corners

// sides: bit a: the corner's edge along axis a runs up. False where there is no such corner, or a
// cut goes through it.
bool DenseSprings::corner_at(std::size_t i, VoxelIndex at, int sides, const DisplacementField& u_mm,
                             Corner& corner) const {
  const glm::dvec3 h = problem_.spacing_mm;
  double kappa = 0.0;
  corner.element[0] = i;
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    const bool up = (sides >> a) & 1;
    if (up ? at[a] + 1 >= problem_.size[a] : at[a] == 0) return false;
    const auto step_of = static_cast<std::size_t>(steps_[axis]);
    const std::size_t j = up ? i + step_of : i - step_of;
    if (!link_left(std::min(i, j), a)) return false;
    corner.element[1 + axis] = j;
    corner.side[axis] = up ? 1.0 : -1.0;
    corner.edge[axis] = corner.side[axis] * (u_mm[j] - u_mm[i]) / h;
    corner.edge[axis][a] += 1.0;
    const double area =
        problem_.fold.rule == FoldRule::wall ? std::pow(h.x * h.y * h.z, 2.0 / 3.0) : h[a] * h[a];
    kappa += pair(i, j).stiffness * area / 3.0;
  }
  corner.scale = problem_.fold.weight * kappa;
  corner.determinant = glm::dot(corner.edge[0], glm::cross(corner.edge[1], corner.edge[2]));
  return true;
}

template <class F>
void DenseSprings::for_each_corner_of_layer(int z, const DisplacementField& u_mm, F&& f) const {
  Corner corner;
  for (int y = 0; y < problem_.size.y; ++y) {
    for (int x = 0; x < problem_.size.x; ++x) {
      const VoxelIndex at(x, y, z);
      const std::size_t i = element_of(at, problem_.size);
      for (int sides = 0; sides < 8; ++sides) {
        if (corner_at(i, at, sides, u_mm, corner)) f(corner);
      }
    }
  }
}

std::vector<DenseSprings::Corner> DenseSprings::near_folding(const DisplacementField& u_mm) const {
  std::vector<std::vector<Corner>> by_layer(static_cast<std::size_t>(problem_.size.z));
  for_each_layer([&](int z) {
    for_each_corner_of_layer(z, u_mm, [&](const Corner& corner) {
      if (corner.determinant < problem_.fold.reach) {
        by_layer[static_cast<std::size_t>(z)].push_back(corner);
      }
    });
  });
  std::vector<Corner> all;
  for (const auto& some : by_layer) all.insert(all.end(), some.begin(), some.end());
  return all;
}

double DenseSprings::least_determinant(const DisplacementField& u_mm) const {
  std::vector<double> least(static_cast<std::size_t>(problem_.size.z), INFINITY);
  for_each_layer([&](int z) {
    double& here = least[static_cast<std::size_t>(z)];
    for_each_corner_of_layer(
        z, u_mm, [&](const Corner& corner) { here = std::min(here, corner.determinant); });
  });
  return *std::min_element(least.begin(), least.end());
}

std::vector<std::size_t> DenseSprings::turning(const DisplacementField& from_mm,
                                               const DisplacementField& to_mm) const {
  std::vector<std::vector<std::size_t>> by_layer(static_cast<std::size_t>(problem_.size.z));
  for_each_layer([&](int z) {
    std::vector<bool> right;
    for_each_corner_of_layer(
        z, from_mm, [&](const Corner& corner) { right.push_back(corner.determinant > 0.0); });
    std::size_t index = 0;
    for_each_corner_of_layer(z, to_mm, [&](const Corner& corner) {
      if (!right[index++] || corner.determinant > 0.0) return;
      auto& here = by_layer[static_cast<std::size_t>(z)];
      here.insert(here.end(), corner.element.begin(), corner.element.end());
    });
  });
  std::vector<std::size_t> all;
  for (const auto& some : by_layer) all.insert(all.end(), some.begin(), some.end());
  return all;
}

// --- gradient

glm::dvec3 DenseSprings::spring_gradient_of(std::size_t i, const DisplacementField& u_mm) const {
  glm::dvec3 sum(0.0);
  for_each_spring_of(i, [&](std::size_t j, const SpringView& s) {
    const glm::dvec3 rest = s.rest_mm + s.kept_mm;
    const glm::dvec3 du = u_mm[j] - u_mm[i] - s.kept_mm;
    const glm::dvec3 along = rest + du;
    const double l = glm::length(along);
    glm::dvec3 pull = s.blend * du;
    if (l > 0.0) {
      const double longer = (2.0 * glm::dot(rest, du) + glm::dot(du, du)) / (l + s.length_mm);
      pull += (1.0 - s.blend) * longer / l * along;
    }
    sum -= s.stiffness * pull;
  });
  return sum;
}

void DenseSprings::gradient(const DisplacementField& u_mm, DisplacementField& out) const {
  out.resize(count());
  for_each_layer([&](int z) {
    const std::size_t first = layer() * static_cast<std::size_t>(z);
    for (std::size_t i = first; i < first + layer(); ++i) {
      out[i] = glm::dvec3(0.0);
      if (held_[i]) continue;
      out[i] = spring_gradient_of(i, u_mm);
      if (problem_.fold.rule != FoldRule::limits) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const auto step_of = static_cast<std::size_t>(step(axis));
        if (has_spring(i, axis)) {
          out[i] -= problem_.fold.weight * stiffness(i, axis) * excess_mm(i, axis, u_mm);
        }
        if ((springs_[i] >> (kForward + axis)) & 1) {
          out[i] += problem_.fold.weight * stiffness(i - step_of, axis) *
                    excess_mm(i - step_of, axis, u_mm);
        }
      }
    }
  });
  if (!minds_corners(problem_.fold.rule)) return;
  for (const Corner& corner : near_folding(u_mm)) {
    const double slope = corner.scale *
                         barrier(corner.determinant / problem_.fold.reach, problem_.fold).slope /
                         problem_.fold.reach;
    const auto normal = normals_of(corner.edge);
    for (std::size_t a = 0; a < 3; ++a) {
      const glm::dvec3 g = slope * corner.side[a] * normal[a] / problem_.spacing_mm;
      if (!held_[corner.element[1 + a]]) out[corner.element[1 + a]] += g;
      if (!held_[corner.element[0]]) out[corner.element[0]] -= g;
    }
  }
}

// --- Hessian

void DenseSprings::linearise(const DisplacementField& u_mm, bool positive) {
  curvatures_.resize(count() * kForward);
  for_each_layer([&](int z) {
    const std::size_t first = layer() * static_cast<std::size_t>(z);
    for (std::size_t i = first; i < first + layer(); ++i) {
      for (std::size_t s = 0; s < kForward; ++s) {
        Curvature& c = curvatures_[i * kForward + s];
        c = {};
        if (!((springs_[i] >> s) & 1)) continue;
        const std::size_t j = i + static_cast<std::size_t>(steps_[s]);
        const Pair& p = pair(i, j);
        const glm::dvec3 along = rest_mm_[s] + (u_mm[j] - u_mm[i]);
        const double l = glm::length(along);
        const double rest_length = length_mm(i, s);
        if (!(l > 1e-12 * rest_length)) {
          c.tangent = static_cast<float>(p.stiffness * p.blend);
          continue;
        }
        double tangent = p.stiffness * ((1.0 - p.blend) * (1.0 - rest_length / l) + p.blend);
        if (positive) tangent = std::max(0.0, tangent);
        const glm::dvec3 v = std::sqrt(p.stiffness - tangent) / l * along;
        c = {static_cast<float>(tangent),
             {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}};
      }
    }
  });
  if (problem_.fold.rule == FoldRule::limits) {
    beyond_.assign(count(), 0);
    for_each_layer([&](int z) {
      const std::size_t first = layer() * static_cast<std::size_t>(z);
      for (std::size_t i = first; i < first + layer(); ++i) {
        for (int axis = 0; axis < 3; ++axis) {
          if (!has_spring(i, axis)) continue;
          const glm::dvec3 excess = excess_mm(i, axis, u_mm);
          for (int c = 0; c < 3; ++c) {
            if (excess[c] != 0.0) {
              beyond_[i] = static_cast<std::uint16_t>(beyond_[i] | 1u << (3 * axis + c));
            }
          }
        }
      }
    });
  }
  if (!minds_corners(problem_.fold.rule)) return;
  corner_curvatures_.clear();
  fold_weights_.assign(count() * 3, 0.0f);
  for (const Corner& corner : near_folding(u_mm)) {
    const Barrier b = barrier(corner.determinant / problem_.fold.reach, problem_.fold);
    const double slope = corner.scale * b.slope / problem_.fold.reach;
    const double curvature = corner.scale * b.curvature / problem_.fold.reach / problem_.fold.reach;
    const auto normal = normals_of(corner.edge);
    Eigen::Matrix<double, 9, 1> g;
    for (int a = 0; a < 3; ++a) {
      g.segment<3>(3 * a) = eigen_of(normal[static_cast<std::size_t>(a)]);
    }
    Eigen::Matrix<double, 9, 9> h = Eigen::Matrix<double, 9, 9>::Zero();
    h.block<3, 3>(0, 3) = -cross_matrix(corner.edge[2]);
    h.block<3, 3>(0, 6) = cross_matrix(corner.edge[1]);
    h.block<3, 3>(3, 6) = -cross_matrix(corner.edge[0]);
    h = (slope * (h + h.transpose()) + curvature * g * g.transpose()).eval();
    if (positive) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(h);
      h = solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() *
          solver.eigenvectors().transpose();
    }
    CornerCurvature out{corner.element, {}};
    for (std::size_t row = 0; row < 9; ++row) {
      for (std::size_t column = 0; column < 9; ++column) {
        const double to_mm = corner.side[row / 3] / problem_.spacing_mm[static_cast<int>(row % 3)] *
                             corner.side[column / 3] /
                             problem_.spacing_mm[static_cast<int>(column % 3)];
        out.by_edge[row * 9 + column] = static_cast<float>(
            to_mm * h(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)));
      }
    }
    corner_curvatures_.push_back(out);
    for (std::size_t a = 0; a < 3; ++a) {
      const glm::dvec3 n = normal[a] / problem_.spacing_mm;
      const std::size_t lower = std::min(corner.element[0], corner.element[1 + a]);
      fold_weights_[lower * 3 + a] += static_cast<float>(curvature * glm::dot(n, n));
    }
  }
}

float DenseSprings::laplacian_weight(std::size_t element, int forward) const {
  if (!has_spring(element, forward)) return 0.0f;
  auto weight = static_cast<float>(stiffness(element, forward));
  if (forward >= 3) return weight;
  if (!beyond_.empty() && ((beyond_[element] >> (3 * forward)) & 7)) {
    weight += static_cast<float>(problem_.fold.weight * stiffness(element, forward));
  }
  if (!fold_weights_.empty())
    weight += fold_weights_[element * 3 + static_cast<std::size_t>(forward)];
  return weight;
}

void DenseSprings::apply(const DisplacementField& x, DisplacementField& out) const {
  out.resize(count());
  for_each_layer([&](int z) {
    const std::size_t first = layer() * static_cast<std::size_t>(z);
    for (std::size_t i = first; i < first + layer(); ++i) {
      glm::dvec3 sum(0.0);
      if (!held_[i]) {
        const auto add = [&](const Curvature& c, const glm::dvec3& d) {
          const glm::dvec3 v(c.radial[0], c.radial[1], c.radial[2]);
          sum += double{c.tangent} * d + glm::dot(v, d) * v;
        };
        for (std::size_t s = 0; s < kForward; ++s) {
          const auto step_of = static_cast<std::size_t>(steps_[s]);
          if ((springs_[i] >> s) & 1) add(curvatures_[i * kForward + s], x[i] - x[i + step_of]);
          if ((springs_[i] >> (kForward + s)) & 1) {
            add(curvatures_[(i - step_of) * kForward + s], x[i] - x[i - step_of]);
          }
        }
        for (int axis = 0; axis < 3 && !beyond_.empty(); ++axis) {
          const auto step_of = static_cast<std::size_t>(step(axis));
          const auto add_beyond = [&](std::size_t lower, const glm::dvec3& d) {
            for (int c = 0; c < 3; ++c) {
              if ((beyond_[lower] >> (3 * axis + c)) & 1) {
                sum[c] += problem_.fold.weight * stiffness(lower, axis) * d[c];
              }
            }
          };
          if (has_spring(i, axis)) add_beyond(i, x[i] - x[i + step_of]);
          if ((springs_[i] >> (kForward + axis)) & 1)
            add_beyond(i - step_of, x[i] - x[i - step_of]);
        }
      }
      out[i] = sum;
    }
  });
  for (const CornerCurvature& corner : corner_curvatures_) {
    std::array<double, 9> edge;
    for (std::size_t r = 0; r < 9; ++r) {
      const int c = static_cast<int>(r % 3);
      edge[r] = x[corner.element[1 + r / 3]][c] - x[corner.element[0]][c];
    }
    for (std::size_t r = 0; r < 9; ++r) {
      double sum = 0.0;
      for (std::size_t c = 0; c < 9; ++c) sum += double{corner.by_edge[r * 9 + c]} * edge[c];
      const int component = static_cast<int>(r % 3);
      const std::size_t end = corner.element[1 + r / 3];
      if (!held_[end]) out[end][component] += sum;
      if (!held_[corner.element[0]]) out[corner.element[0]][component] -= sum;
    }
  }
}

}  // namespace maille
