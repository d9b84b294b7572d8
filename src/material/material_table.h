// How tissue behaves, looked up from the value of its voxel: no segmentation.
//
// ChainMail limits are fractions of the voxel spacing (Gibson 1997; the paper, section 4). A link
// between two elements takes the mean of their limits (Schill 1998) and the stiffness of both
// springs in series. Limits are kept in the lattice's fixed-point unit, rounded towards the inside
// once, here, so that no rounding ever shows as a violated link.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/spaces.h"

namespace maille {

// Displacement is counted in 1/512 voxel wherever sums must be exact (design: ChainMail).
inline constexpr int kUnitsPerVoxel = 512;

using MaterialId = std::uint8_t;
inline constexpr int kMaxMaterials = 256;

struct Material {
  std::string name;
  double value_low = 0.0;  // half-open range [low, high) of voxel values, in the file's own units
  double value_high = 0.0;
  glm::dvec3 compress{0.6};  // shortest link along each axis, 0 <= compress <= 1
  glm::dvec3 stretch{1.5};   // longest link along each axis, >= 1
  glm::dvec3 shear{0.25};    // how far each component may slip across a link of another axis, >= 0
  double stiffness = 1.0;    // of its springs, > 0; only ratios matter
  bool fixed = false;        // an anchor: never moves
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
  // 256, a limit outside its range, stiffness not above 0, an empty or overlapping value range.
  static Result<MaterialTable> create(std::vector<Material> materials);

  // Air, fat, soft tissue, bone, in Hounsfield units. Bone is fixed. Soft tissue may shear further
  // than the no-fold rule of warnings() allows: within that rule the slope of a drag is below 1/2,
  // and a nose, 25 voxels from the skull, could be pulled by 8 only. A drag along one axis cannot
  // fold all the same (its Jacobian's determinant is 1 + du_a/dx_a >= compress).
  static MaterialTable ct();
  // For scans whose values mean nothing absolute: soft below a third of the range, firm above.
  static MaterialTable relative(double lowest, double highest);

  const std::vector<Material>& materials() const { return materials_; }
  int count() const { return static_cast<int>(materials_.size()); }

  // A value outside every range takes the nearest one; NaN takes the first material.
  MaterialId id_of(double value) const;

  const LinkLimits& link(MaterialId i, MaterialId j) const {
    return links_[static_cast<std::size_t>(i) * materials_.size() + j];
  }
  float compliance(MaterialId id) const { return compliances_[id]; }  // 1 / stiffness
  bool fixed(MaterialId id) const { return materials_[id].fixed; }
  bool any_fixed() const;

  // One sentence for each material whose limits allow a folded cell (a component's compress not
  // above twice its shear: no state within the limits of the others has one).
  std::vector<std::string> warnings() const;

 private:
  MaterialTable() = default;
  std::vector<Material> materials_;  // by rising value_low
  std::vector<LinkLimits> links_;
  std::vector<float> compliances_;
};

}  // namespace maille
