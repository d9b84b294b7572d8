#include "deform/fold_cluster.h"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace maille {
std::vector<std::vector<std::int64_t>> connected_elements(const std::vector<std::int64_t>& elements,
                                                          Size3 extent) {
  // Each element's part by the first of its elements, found through others of the part.
  std::vector<std::size_t> through(elements.size());
  std::iota(through.begin(), through.end(), std::size_t{0});
  const auto first_of = [&](std::size_t i) {
    while (through[i] != i) i = through[i] = through[through[i]];
    return i;
  };
  for (int z = -1; z <= 0; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const std::int64_t to_other = (std::int64_t{z} * extent.y + y) * extent.x + x;
        if (to_other >= 0) continue;
        std::size_t j = 0;
        for (std::size_t i = 0; i < elements.size(); ++i) {
          while (elements[j] < elements[i] + to_other) ++j;
          if (elements[j] != elements[i] + to_other) continue;
          const auto [first, second] = std::minmax({first_of(i), first_of(j)});
          through[second] = first;
        }
      }
    }
  }
  std::map<std::size_t, std::vector<std::int64_t>> parts;
  for (std::size_t i = 0; i < elements.size(); ++i) parts[first_of(i)].push_back(elements[i]);
  std::vector<std::vector<std::int64_t>> all;
  for (auto& [first, part] : parts) all.push_back(std::move(part));
  return all;
}

// Gradient and curvature of the energy, in mm.
struct FoldCluster::Newton {
  std::vector<Eigen::Triplet<double>> entries;  // of the lower half
  Eigen::VectorXd downhill;

  explicit Newton(std::size_t elements)
      : downhill(Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(elements))) {}

  void push(int a, const glm::dvec3& force) {
    if (a < 0) return;
    for (int c = 0; c < 3; ++c) downhill[3 * a + c] += force[c];
  }
  void bend(int a, int b, const glm::dmat3& block) {
    if (a < 0 || b < 0 || a < b) return;
    for (int c = 0; c < 3; ++c) {
      for (int r = a == b ? c : 0; r < 3; ++r)
        entries.emplace_back(3 * a + r, 3 * b + c, block[c][r]);
    }
  }
};

FoldCluster::FoldCluster(const FoldEnergy& folds, std::vector<std::int64_t> elements)
    : folds_(folds),
      voxels_from_mm_(1.0 / folds.box().spacing_mm()),
      elements_(std::move(elements)) {
  u_mm_.reserve(elements_.size());
  for (const std::int64_t e : elements_) u_mm_.push_back(at_element(folds_.box().u_mm(), e));
  gather_springs();
  gather_corners();
}

int FoldCluster::index_of(std::int64_t element) const {
  const auto it = std::lower_bound(elements_.begin(), elements_.end(), element);
  return it != elements_.end() && *it == element ? static_cast<int>(it - elements_.begin()) : -1;
}

void FoldCluster::gather_springs() {
  const SpringBox& box = folds_.box();
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    const std::int64_t e = elements_[i];
    for (int s = 0; s < kSprings; ++s) {
      const double k = double{box.stiffness(e, s)};
      if (!(k > 0.0)) continue;
      const std::int64_t other = e + box.step(s);
      const int b = index_of(other);
      if (b > static_cast<int>(i)) continue;  // it has it
      const auto& spring = box.springs()[static_cast<std::size_t>(s)];
      const double blend = 0.5 * (double{box.blend(e)} + double{box.blend(other)});
      const glm::dvec3 kept_mm = box.kept_mm(e, s);
      const glm::dvec3 rest_mm = glm::dvec3(spring.rest_mm) + kept_mm;
      const double length_mm = box.keeps() ? glm::length(rest_mm) : double{spring.length_mm};
      springs_.push_back({static_cast<int>(i), b, at_element(box.u_mm(), other), rest_mm, kept_mm,
                          length_mm, k * (1.0 - blend), k * blend});
    }
  }
}

void FoldCluster::gather_corners() {
  const SpringBox& box = folds_.box();
  std::vector<std::int64_t> centers = elements_;
  for (const std::int64_t e : elements_) {
    for (int s = 0; s < 6; ++s) centers.push_back(e + box.step(s));
  }
  std::sort(centers.begin(), centers.end());
  centers.erase(std::unique(centers.begin(), centers.end()), centers.end());
  for (const std::int64_t e : centers) {
    for (std::uint8_t signs = 0; signs < 8; ++signs) {
      const CellCorner corner{e, signs};
      if (!folds_.counts(corner)) continue;
      const auto elements = folds_.elements_of(corner);
      Corner here;
      bool any = false;
      for (std::size_t n = 0; n < 4; ++n) {
        here.at[n] = index_of(elements[n]);
        any = any || here.at[n] >= 0;
      }
      if (!any) continue;
      for (std::size_t n = 0; n < 4; ++n) here.held_mm[n] = at_element(box.u_mm(), elements[n]);
      for (int axis = 0; axis < 3; ++axis) here.signs[axis] = (signs >> axis) & 1 ? -1.0 : 1.0;
      here.kappa = folds_.kappa(corner);
      here.guarded = folds_.is_guarded(corner);
      corners_.push_back(here);
    }
  }
}

glm::dmat3 FoldCluster::edges(const Corner& corner, const std::vector<glm::dvec3>& u_mm) const {
  const auto u = [&](std::size_t n) {
    return corner.at[n] < 0 ? corner.held_mm[n] : u_mm[static_cast<std::size_t>(corner.at[n])];
  };
  const glm::dvec3 center = u(0);
  glm::dmat3 edges(1.0);
  for (int a = 0; a < 3; ++a) {
    edges[a] += corner.signs[a] * voxels_from_mm_ * (u(static_cast<std::size_t>(a + 1)) - center);
  }
  return edges;
}

double FoldCluster::energy(const std::vector<glm::dvec3>& u_mm,
                           const std::vector<double>& open) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const glm::dmat3 e = edges(corners_[i], u_mm);
    const double j = glm::determinant(e);
    if (!open.empty() && corners_[i].guarded &&
        closes(open[i], j, kLeftByElement, folds_.least_open(FoldEnergy::cofactors(e))))
      return std::numeric_limits<double>::infinity();
    sum += corners_[i].kappa * folds_.penalty(j).value;
  }
  for (const Spring& s : springs_) {
    const glm::dvec3 du = u_mm[static_cast<std::size_t>(s.a)] -
                          (s.b < 0 ? s.end_mm : u_mm[static_cast<std::size_t>(s.b)]) - s.kept_mm;
    const double stretch = glm::length(s.rest_mm + du) - s.length_mm;
    sum += 0.5 * (s.plain * stretch * stretch + s.straight * glm::dot(du, du));
  }
  return sum;
}

// exact: with the curvature that is negative somewhere; without, in no direction.
void FoldCluster::add_springs(Newton& newton, bool exact) const {
  for (const Spring& s : springs_) {
    const glm::dvec3 du = u_mm_[static_cast<std::size_t>(s.a)] -
                          (s.b < 0 ? s.end_mm : u_mm_[static_cast<std::size_t>(s.b)]) - s.kept_mm;
    const glm::dvec3 p = s.rest_mm + du;
    const double length2 = glm::dot(p, p) + 1e-30;
    const double relative = 1.0 - s.length_mm / std::sqrt(length2);
    const glm::dvec3 force = s.plain * relative * p + s.straight * du;
    newton.push(s.a, -force);
    newton.push(s.b, force);
    const double across = exact ? relative : std::max(0.0, relative);
    const glm::dmat3 bend = glm::outerProduct(p, p) * (s.plain * (1.0 - across) / length2) +
                            glm::dmat3(s.plain * across + s.straight);
    newton.bend(s.a, s.a, bend);
    newton.bend(s.b, s.b, bend);
    newton.bend(s.a, s.b, -bend);
  }
}

void FoldCluster::add_corners(Newton& newton, bool exact) const {
  for (const Corner& corner : corners_) {
    const glm::dmat3 e = edges(corner, u_mm_);
    const glm::dmat3 by_edges = FoldEnergy::cofactors(e);
    const FoldPenalty penalty = folds_.penalty(glm::dot(e[0], by_edges[0]));
    if (!(penalty.value > 0.0)) continue;
    // Edge a = ... + shares[n][a] * u of the nth element.
    const std::array<glm::dvec3, 4> shares = {-corner.signs, glm::dvec3(corner.signs.x, 0, 0),
                                              glm::dvec3(0, corner.signs.y, 0),
                                              glm::dvec3(0, 0, corner.signs.z)};
    std::array<glm::dvec3, 4> slopes;  // of J
    for (std::size_t n = 0; n < 4; ++n) slopes[n] = by_edges * shares[n] * voxels_from_mm_;
    const double slope = corner.kappa * penalty.slope / kFoldReach;
    const double curvature = corner.kappa * penalty.curvature / (kFoldReach * kFoldReach);
    for (std::size_t n = 0; n < 4; ++n) {
      newton.push(corner.at[n], -slope * slopes[n]);
      for (std::size_t m = 0; m < 4; ++m) {
        glm::dmat3 block = curvature * glm::outerProduct(slopes[n], slopes[m]);
        if (exact && n != m) {
          // J is e0 . (e1 x e2): its second derivative by two edges is a cross product by the
          // third.
          glm::dvec3 third(0.0);
          for (int a = 0; a < 3; ++a) {
            const int b = (a + 1) % 3;
            third += (shares[n][a] * shares[m][b] - shares[n][b] * shares[m][a]) * e[(a + 2) % 3];
          }
          glm::dmat3 cross(0.0);  // v -> v x third
          cross[0] = {0.0, -third.z, third.y};
          cross[1] = {third.z, 0.0, -third.x};
          cross[2] = {-third.y, third.x, 0.0};
          for (int c = 0; c < 3; ++c)
            block[c] += slope * voxels_from_mm_[c] * (cross[c] * voxels_from_mm_);
        }
        newton.bend(corner.at[n], corner.at[m], block);
      }
    }
  }
}

// Empty where the curvature is not positive in every direction.
std::optional<Eigen::VectorXd> FoldCluster::full_step(bool exact) const {
  Newton newton(elements_.size());
  add_springs(newton, exact);
  add_corners(newton, exact);
  const auto unknowns = newton.downhill.size();
  Eigen::SparseMatrix<double> hessian(unknowns, unknowns);
  hessian.setFromTriplets(newton.entries.begin(), newton.entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(hessian);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0.0)) return {};
  return factors.solve(newton.downhill);
}

bool FoldCluster::step() {
  std::optional<Eigen::VectorXd> full = full_step(true);
  if (!full) full = full_step(false);
  if (!full) return false;
  std::vector<double> open;
  open.reserve(corners_.size());
  for (const Corner& corner : corners_) open.push_back(glm::determinant(edges(corner, u_mm_)));
  const double before = energy(u_mm_, {});
  std::vector<glm::dvec3> moved(u_mm_.size());
  constexpr int kMostHalvings = 12;
  double share = 1.0;
  for (int halving = 0; halving < kMostHalvings; ++halving, share *= 0.5) {
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const auto row = 3 * static_cast<Eigen::Index>(i);
      moved[i] = u_mm_[i] + share * glm::dvec3((*full)[row], (*full)[row + 1], (*full)[row + 2]);
    }
    if (!(energy(moved, open) <= before)) continue;
    u_mm_ = moved;
    return true;
  }
  return false;
}

void FoldCluster::write_to(BoxVectors& u_mm) const {
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      u_mm[static_cast<std::size_t>(c)][elements_[i]] = static_cast<float>(u_mm_[i][c]);
    }
  }
}

}  // namespace maille
