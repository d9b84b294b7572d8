// The springs of a whole small volume in plain arrays and double precision: energy, gradient and
// Hessian, written from the formulas alone. What relaxation is measured against; shares no code
// with it.
//
// Springs run to the 6 axis neighbours and the 12 face diagonals. With r = X_i - X_j, d = |r|,
// p = x_i - x_j, l = |p|, and k, b the stiffness (in series) and rest-vector blend of both ends:
//
//     E_ij = 1/2 (1 - b) k (l - d)^2 + 1/2 b k |p - r|^2            (stiffness * mm^2)
//
// which is Schulze et al. 2007, eq. (4), with its sign and scale mended, and blended. A pair at
// zero distance has no direction: its length pulls nowhere. Cuts take springs away: one along an
// axis goes with its link, one across a face when both ways round the face are broken.
//
// Where the problem says that material keeps displacements P, a spring has r' = r + P_i - P_j and
// d' = |r'| in place of r and d.
//
// On top of that, if asked for, one energy that keeps cells from folding (FoldRule).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/spaces.h"
#include "material/material_table.h"
#include "references/dense_problem.h"

namespace maille {

struct SpringMaterial {
  double stiffness = 1.0;  // > 0
  double rest_vector_blend = 0.25;
  // Of FoldRule::limits alone, as in Material.
  glm::dvec3 compress{0.6};
  glm::dvec3 stretch{1.5};
  glm::dvec3 shear{0.25};
};

// Materials as springs know them: a gap of more than 1000 between two stiffnesses that follow each
// other is narrowed to 1000, and rigid ones are 1000 times stiffer than the stiffest that is not.
// Blends are the materials' own, or one for all.
std::vector<SpringMaterial> spring_materials(
    std::span<const Material> materials, std::optional<double> rest_vector_blend = std::nullopt);

enum class FoldRule {
  none,
  // A barrier of finite reach at every corner of every cell whose three links are left, on the
  // determinant J of its edges in voxels (1 at rest): with q = J / reach and kappa the mean of
  // k h^2 over the links, weight * kappa * b(q),
  //     b = 0 for q >= 1,  -(1 - q)^2 ln q below,  its tangent from q = straight_below on down.
  // Finite for folded cells too, which it unfolds. A barrier that grows with the square there, or
  // is steep (from q = 0.05 on), pulls cells that ChainMail folded so hard that others fold.
  determinant,
  // At the same corners weight * kappa * b(q), with kappa the links' mean stiffness times the 2/3
  // power of the cell's volume and, with s = 3 q,
  //     b = (1 - q)^2 for q < 1,  less (1 - s)^2 ln s for s < 1,  with slope -2 below
  //     q = straight_below.
  // Needs someone who takes no step across J = 0.
  wall,
  // A spring on every component of a link beyond its ChainMail limits:
  // 1/2 weight k (excess_mm)^2.
  limits
};

struct FoldTerm {
  FoldRule rule = FoldRule::none;
  double reach = 0.2;
  double weight = 1.0;
  double straight_below =
      0.3;  // of q, for the determinant and the wall: from where on they go straight
};

struct SpringProblem {
  Size3 size{0};
  glm::dvec3 spacing_mm{1.0};
  std::vector<SpringMaterial> materials;   // by id
  std::vector<MaterialId> ids;             // of each element, x fastest; empty: all are 0
  std::vector<std::uint8_t> removed;       // bit a of an element: its link to the next one along
                                           // axis a is gone; empty: none is
  std::vector<std::uint8_t> held;          // of each element: 1 where it never moves
  std::vector<glm::dvec3> start_voxels;    // displacement of each element
  std::vector<glm::dvec3> plastic_voxels;  // P of each element; empty: 0
  FoldTerm fold;
};

using DisplacementField = std::vector<glm::dvec3>;  // of each element, x fastest

DisplacementField mm_of(const DisplacementField& u_voxels, glm::dvec3 spacing_mm);
DisplacementField voxels_of(const DisplacementField& u_mm, glm::dvec3 spacing_mm);

class DenseSprings {
 public:
  // The 9 springs of an element to elements of higher index; the other 9 are these of its
  // neighbours. The first three run along the axes.
  static constexpr int kForward = 9;
  static const std::array<glm::ivec3, kForward> kOffsets;

  // Problem and pool must outlive this. Elements without any spring count as held.
  DenseSprings(const SpringProblem& problem, WorkerPool& pool);

  Size3 size() const { return problem_.size; }
  std::size_t count() const { return held_.size(); }
  bool held(std::size_t element) const { return held_[element] != 0; }
  std::int64_t free_elements() const { return free_elements_; }
  std::ptrdiff_t step(int forward) const { return steps_[static_cast<std::size_t>(forward)]; }
  bool has_spring(std::size_t element, int forward) const {
    return (springs_[element] >> forward) & 1;
  }
  // Bit f: the forward spring f is there; bit 9 + f: the one that runs from -kOffsets[f] to here.
  std::uint32_t springs_of(std::size_t element) const { return springs_[element]; }
  double stiffness(std::size_t element, int forward) const {
    return pair(element, element + static_cast<std::size_t>(step(forward))).stiffness;
  }
  // Of all springs of an element.
  double stiffness_sum(std::size_t element) const;

  // A spring as one of its ends sees it.
  struct SpringView {
    glm::dvec3 rest_mm;  // X_j - X_i
    glm::dvec3 kept_mm;  // P_j - P_i
    double length_mm;    // of the sum of both
    double stiffness;
    double blend;
  };
  // Calls f(other end j, SpringView) for each spring of an element i.
  template <class F>
  void for_each_spring_of(std::size_t element, F&& f) const;

  double energy(const DisplacementField& u_mm) const;  // springs and fold rule
  double spring_energy(const DisplacementField& u_mm) const;
  double fold_energy(const DisplacementField& u_mm) const;
  // Of energy(), by u_mm; 0 where held.
  void gradient(const DisplacementField& u_mm, DisplacementField& out) const;
  glm::dvec3 spring_gradient_of(std::size_t element, const DisplacementField& u_mm) const;

  // The least J of any corner; infinite where there is none.
  double least_determinant(const DisplacementField& u_mm) const;
  // The elements of corners with J > 0 in one state and J <= 0 in another, each once or more.
  std::vector<std::size_t> turning(const DisplacementField& from_mm,
                                   const DisplacementField& to_mm) const;

  // Calls f(J) for each of the up to 32 corners that an element takes part in, always in one order.
  template <class F>
  void for_each_determinant_around(std::size_t element, const DisplacementField& u_mm, F&& f) const;
  // The place nearest to `asked_mm`, by component, that keeps the links of an element within their
  // ChainMail limits, or no further outside than they are.
  glm::dvec3 within_limits(std::size_t element, const DisplacementField& u_mm,
                           glm::dvec3 asked_mm) const;

  // Takes the Hessian of energy() at a state, for what follows. positive: each spring's and each
  // corner's part with its negative curvature taken out, so that the sum has none either; else the
  // exact one, which may be indefinite far from an equilibrium. Kept as floats, so exact to 1e-7 of
  // each spring's stiffness.
  void linearise(const DisplacementField& u_mm, bool positive);
  // H x, of free elements; x is 0 where held.
  void apply(const DisplacementField& x, DisplacementField& out) const;
  // Calls f(element i, element j, block of H) for every pair with i <= j or i > j that shares an
  // entry, both orders; several calls for one pair add up.
  template <class F>
  void for_each_block(F&& f) const;
  // A scalar weight a forward spring so that the graph Laplacian of these weights is of the size of
  // the linearised Hessian (exact bound for the springs alone).
  float laplacian_weight(std::size_t element, int forward) const;

  // Calls f(z) for every layer of elements, on any worker; sums f's values in order of z.
  template <class F>
  double sum_of_layers(F&& f) const;
  template <class F>
  void for_each_layer(F&& f) const;

 private:
  struct Pair {
    double stiffness;
    double blend;
    std::array<glm::dvec3, 3> lower;  // [axis], of u_j - u_i for the higher j, voxels
    std::array<glm::dvec3, 3> upper;
  };
  // t I + v v^T.
  struct Curvature {
    float tangent = 0.0f;
    float radial[3] = {};
  };
  struct Corner {
    std::array<std::size_t, 4> element;  // the corner's own, then along x, y, z
    std::array<double, 3> side;          // -1 or 1, along x, y, z
    double scale = 0.0;                  // weight * kappa
    std::array<glm::dvec3, 3> edge;      // voxels
    double determinant = 0.0;
  };
  struct CornerCurvature {
    std::array<std::size_t, 4> element;
    std::array<float, 81> by_edge;  // of the edges in mm, side taken in
  };

  std::size_t layer() const {
    return static_cast<std::size_t>(problem_.size.x) * static_cast<std::size_t>(problem_.size.y);
  }
  MaterialId id(std::size_t element) const {
    return problem_.ids.empty() ? MaterialId{0} : problem_.ids[element];
  }
  glm::dvec3 kept_mm(std::size_t i, std::size_t forward) const {
    if (problem_.plastic_voxels.empty()) return glm::dvec3(0.0);
    const std::size_t j = i + static_cast<std::size_t>(steps_[forward]);
    return (problem_.plastic_voxels[j] - problem_.plastic_voxels[i]) * problem_.spacing_mm;
  }
  double length_mm(std::size_t i, std::size_t forward) const {
    return problem_.plastic_voxels.empty() ? length_mm_[forward]
                                           : glm::length(rest_mm_[forward] + kept_mm(i, forward));
  }
  const Pair& pair(std::size_t i, std::size_t j) const {
    return pairs_[std::size_t{id(i)} * problem_.materials.size() + id(j)];
  }
  bool link_left(std::size_t lower, int axis) const {
    return problem_.removed.empty() || !((problem_.removed[lower] >> axis) & 1);
  }
  bool spring_left(std::size_t i, VoxelIndex at, glm::ivec3 offset) const;
  bool corner_at(std::size_t element, VoxelIndex at, int sides, const DisplacementField& u_mm,
                 Corner& corner) const;
  template <class F>
  void for_each_corner_of_layer(int z, const DisplacementField& u_mm, F&& f) const;
  double limit_energy_of(std::size_t element, const DisplacementField& u_mm) const;
  glm::dvec3 excess_mm(std::size_t lower, int axis, const DisplacementField& u_mm) const;
  std::vector<Corner> near_folding(const DisplacementField& u_mm) const;

  const SpringProblem& problem_;
  WorkerPool& pool_;
  std::array<std::ptrdiff_t, kForward> steps_{};
  std::array<glm::dvec3, kForward> rest_mm_{};  // X_j - X_i
  std::array<double, kForward> length_mm_{};
  std::vector<Pair> pairs_;  // [lower id * count + higher id]
  std::vector<std::uint32_t>
      springs_;  // bit f: forward spring f; bit 9 + f: the one that ends here
  std::vector<std::uint8_t> held_;
  std::int64_t free_elements_ = 0;

  std::vector<Curvature> curvatures_;  // [element * 9 + forward]
  std::vector<std::uint16_t> beyond_;  // bit 3 * axis + c: beyond its limit at linearise()
  std::vector<CornerCurvature> corner_curvatures_;
  std::vector<float> fold_weights_;  // [element * 3 + axis]: laplacian_weight() of corners
};

// --- templates

template <class F>
void DenseSprings::for_each_layer(F&& f) const {
  pool_.for_each(problem_.size.z, [&](std::int64_t z, int) { f(static_cast<int>(z)); });
}

template <class F>
double DenseSprings::sum_of_layers(F&& f) const {
  std::vector<double> sums(static_cast<std::size_t>(problem_.size.z));
  for_each_layer([&](int z) { sums[static_cast<std::size_t>(z)] = f(z); });
  double sum = 0.0;
  for (const double s : sums) sum += s;
  return sum;
}

template <class F>
void DenseSprings::for_each_spring_of(std::size_t i, F&& f) const {
  for (std::size_t s = 0; s < kForward; ++s) {
    const auto step_of = static_cast<std::size_t>(steps_[s]);
    if ((springs_[i] >> s) & 1) {
      const Pair& p = pair(i, i + step_of);
      const glm::dvec3 kept = kept_mm(i, s);
      f(i + step_of, SpringView{rest_mm_[s], kept, length_mm(i, s), p.stiffness, p.blend});
    }
    if ((springs_[i] >> (kForward + s)) & 1) {
      const Pair& p = pair(i - step_of, i);
      const glm::dvec3 kept = -kept_mm(i - step_of, s);
      f(i - step_of,
        SpringView{-rest_mm_[s], kept, length_mm(i - step_of, s), p.stiffness, p.blend});
    }
  }
}

template <class F>
void DenseSprings::for_each_determinant_around(std::size_t i, const DisplacementField& u_mm,
                                               F&& f) const {
  const VoxelIndex at = voxel_of(i, problem_.size);
  Corner corner;
  for (int sides = 0; sides < 8; ++sides) {
    if (corner_at(i, at, sides, u_mm, corner)) f(corner.determinant);
    for (int axis = 0; axis < 3; ++axis) {
      // The corner at the neighbour, of the same cell.
      VoxelIndex beside = at;
      beside[axis] += (sides >> axis) & 1 ? 1 : -1;
      if (!contains(problem_.size, beside)) continue;
      if (corner_at(element_of(beside, problem_.size), beside, sides ^ (1 << axis), u_mm, corner)) {
        f(corner.determinant);
      }
    }
  }
}

template <class F>
void DenseSprings::for_each_block(F&& f) const {
  for (std::size_t i = 0; i < count(); ++i) {
    for (int s = 0; s < kForward; ++s) {
      if (!has_spring(i, s)) continue;
      const std::size_t j = i + static_cast<std::size_t>(step(s));
      const Curvature& c = curvatures_[i * kForward + static_cast<std::size_t>(s)];
      const glm::dvec3 v(c.radial[0], c.radial[1], c.radial[2]);
      glm::dmat3 block = glm::outerProduct(v, v);
      for (int a = 0; a < 3; ++a) block[a][a] += c.tangent;
      if (s < 3 && !beyond_.empty()) {
        for (int a = 0; a < 3; ++a) {
          if ((beyond_[i] >> (3 * s + a)) & 1) {
            block[a][a] += problem_.fold.weight * stiffness(i, s);
          }
        }
      }
      f(i, i, block);
      f(j, j, block);
      f(i, j, -block);
      f(j, i, -block);
    }
  }
  for (const CornerCurvature& corner : corner_curvatures_) {
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        glm::dmat3 block(0.0);  // columns by b's component
        for (std::size_t r = 0; r < 3; ++r) {
          for (std::size_t c = 0; c < 3; ++c) {
            block[static_cast<int>(c)][static_cast<int>(r)] =
                corner.by_edge[(3 * a + r) * 9 + 3 * b + c];
          }
        }
        const std::size_t o = corner.element[0];
        f(corner.element[1 + a], corner.element[1 + b], block);
        f(corner.element[1 + a], o, -block);
        f(o, corner.element[1 + b], -block);
        f(o, o, block);
      }
    }
  }
}

}  // namespace maille
