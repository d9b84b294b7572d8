// How tissue behaves, looked up from the value of its voxel: no segmentation.
//
// A link between two elements takes the mean of their limits (Schill 1998) and the stiffness of
// both springs in series. Limits are kept in the lattice's fixed-point unit, rounded towards the
// inside here, so that no rounding ever shows as a violated link.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/spaces.h"
#include "material/material.h"
#include "material/material_levels.h"

namespace maille {

// Displacement is counted in 1/512 voxel wherever sums must be exact (design: ChainMail).
inline constexpr int kUnitsPerVoxel = 512;

using MaterialId = std::uint8_t;

// What one element brings to its links, in fixed-point units, all >= 0.
struct ElementLimits {
  glm::ivec3 compress;  // how far a link along each axis may shorten
  glm::ivec3 stretch;   // and lengthen
  glm::ivec3 shear;     // how far each component may slip across a link of another axis
};

// What u_j - u_i may be for element j one step along `axis` from element i, for each component, in
// fixed-point units: lower <= 0 <= upper.
struct LinkLimits {
  std::array<glm::ivec3, 3> lower;  // [axis][component]
  std::array<glm::ivec3, 3> upper;
};

class MaterialTable {
 public:
  // Errors: bad_input, each naming the material and what was expected: no material or more than
  // 256, what refusal_of refuses, overlapping value ranges.
  static Result<MaterialTable> create(std::vector<Material> materials,
                                      Interpolation interpolation = Interpolation::step);

  // Air, fat, soft tissue, bone, in Hounsfield units. Bone is fixed. Soft tissue may shear further
  // than the no-fold rule of warnings() allows: within that rule the slope of a drag is below 1/2,
  // and a nose, 25 voxels from the skull, could be pulled by 8 only. A drag along one axis cannot
  // fold all the same (its Jacobian's determinant is 1 + du_a/dx_a >= compress). Nor do its limits
  // go by stiffness: air a thousand times softer would leave tissue a thousandth of air's room.
  static MaterialTable ct(Interpolation interpolation = Interpolation::step);
  // For scans whose values mean nothing absolute: soft below a third of the range, firm above.
  static MaterialTable relative(double lowest, double highest,
                                Interpolation interpolation = Interpolation::step);

  // As given, by rising value; rigid ones with the limits that this means, all with a blend.
  const std::vector<Material>& materials() const { return materials_; }
  Interpolation interpolation() const { return interpolation_; }

  // Ids run from 0 to count() - 1 by rising value: one a material, or one a level where ranges are
  // interpolated.
  int count() const { return static_cast<int>(levels_.size()); }

  // A value outside every range takes the nearest one; NaN takes the first material.
  MaterialId id_of(double value) const;

  const ElementLimits& limits(MaterialId id) const { return levels_[id].limits; }

  // The floor of the mean of both elements' limits, each an integer >= 0: solvers that work on many
  // links at once compute the same. limits() are floors themselves, so this never exceeds the mean
  // of what was asked for: floor((floor a + floor b) / 2) <= (a + b) / 2; it is up to one unit
  // below. Beside a rigid element a link has half of what the other one allows.
  LinkLimits link(MaterialId i, MaterialId j) const {
    const ElementLimits& a = levels_[i].limits;
    const ElementLimits& b = levels_[j].limits;
    const glm::ivec3 shortest = -((a.compress + b.compress) >> 1);
    const glm::ivec3 longest = (a.stretch + b.stretch) >> 1;
    const glm::ivec3 shear = (a.shear + b.shear) >> 1;
    LinkLimits link{{-shear, -shear, -shear}, {shear, shear, shear}};
    for (int axis = 0; axis < 3; ++axis) {
      link.lower[static_cast<std::size_t>(axis)][axis] = shortest[axis];
      link.upper[static_cast<std::size_t>(axis)][axis] = longest[axis];
    }
    return link;
  }
  float compliance(MaterialId id) const { return levels_[id].compliance; }  // 1 / stiffness
  float rest_vector_blend(MaterialId id) const { return levels_[id].rest_vector_blend; }
  // > 0; infinite where links never yield, so that nobody has to ask whether there is one.
  float yield_strain(MaterialId id) const { return levels_[id].yield_strain; }
  bool fixed(MaterialId id) const { return levels_[id].fixed; }
  bool any_fixed() const;
  bool any_yields() const;

  // What a person may want to change, as sentences; see warnings_of.
  std::vector<std::string> warnings() const;

  std::int64_t bytes() const;

 private:
  struct Level {
    ElementLimits limits;
    float compliance;
    float rest_vector_blend;
    float yield_strain;
    bool fixed;
  };

  MaterialTable() = default;
  std::vector<Material> materials_;
  Interpolation interpolation_ = Interpolation::step;
  std::vector<double> level_begins_;  // the lowest value of each, rising
  std::vector<Level> levels_;
};

}  // namespace maille
