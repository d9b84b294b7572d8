// The part of a lattice that relaxes: a box of elements as dense arrays, in mm and floats.
//
// The elements of the outermost layer are held, whatever they are, and stand for all that lies
// beyond: those of the volume's border that hold anyway, the last ones within reach of a region
// that ends inside the volume, or, beside a face that is free, none at all (their springs have no
// stiffness). So no loop minds an end.
//
// Boxes, not the lattice's bricks: springs carry far (a displacement falls off like one over the
// distance), so that what relaxes fills its box sooner or later, and rows that run on through
// memory need no gathering. Measured: gathering a brick and its neighbours took a third of a sweep.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/parallel.h"
#include "deform/anchors.h"
#include "deform/box_array.h"
#include "deform/cuts.h"
#include "deform/lattice.h"
#include "deform/springs.h"
#include "material/material_field.h"
#include "material/spring_table.h"

namespace maille {

// What a row of elements needs looked at.
enum class RowKind : std::uint8_t {
  held,   // none of its elements is free
  plain,  // free elements, one stiffness and one blend in it and all rows around it
  mixed,  // more than one
  cut     // mixed, and some springs are missing
};

class SpringBox {
 public:
  struct Problem {
    const Lattice& start;
    const MaterialField& materials;
    const Cuts& cuts;
    const ElementSet& held;
    AnchorRules anchors;
    const Lattice* kept = nullptr;  // what material that has yielded keeps (springs.h); none: 0
  };
  // free: voxels that may move, unless something holds them; inside the volume, not empty.
  // Throws std::bad_alloc.
  SpringBox(const Problem& problem, const VoxelBox& free, WorkerPool& pool);

  // Every other element along each axis, twice as far apart, in the state that this one is in.
  // Stiffness is the geometric mean of 2^3 elements'; a spring is missing where one of the two
  // along it is; what is held stays held, if by an element beside it. Knows no voxels.
  static std::unique_ptr<SpringBox> at_half_resolution(const SpringBox& fine, WorkerPool& pool);

  // With the layer around it. Element (0, 0, 0) is voxel lo().
  Size3 extent() const { return extent_; }
  VoxelIndex lo() const { return free_.lo - 1; }
  const VoxelBox& free_box() const { return free_; }
  std::int64_t element(int x, int y, int z) const {
    return (static_cast<std::int64_t>(z) * extent_.y + y) * extent_.x + x;
  }
  std::int64_t element(VoxelIndex voxel) const {
    const glm::ivec3 at = voxel - lo();
    return element(at.x, at.y, at.z);
  }
  VoxelIndex voxel(std::int64_t element) const {
    const std::int64_t r = element / extent_.x;
    return lo() + VoxelIndex(static_cast<int>(element - r * extent_.x),
                             static_cast<int>(r % extent_.y), static_cast<int>(r / extent_.y));
  }
  std::int64_t row(int y, int z) const { return static_cast<std::int64_t>(z) * extent_.y + y; }
  std::int64_t free_elements() const { return free_elements_; }

  glm::dvec3 spacing_mm() const { return spacing_mm_; }
  const Springs& springs() const { return springs_; }
  const std::int64_t* steps() const { return steps_.data(); }  // to the springs' other ends
  std::int64_t step(int spring) const { return steps_[static_cast<std::size_t>(spring)]; }

  // Displacements, less one that is the same for all: far from rest floats would have no digits
  // left for what matters.
  BoxVectors& u_mm() { return u_mm_; }
  const BoxVectors& u_mm() const { return u_mm_; }
  glm::dvec3 displacement_voxels(std::int64_t element) const;

  // P of springs.h. False: it is 0 in all of the box.
  bool keeps() const { return static_cast<bool>(kept_mm_[0]); }
  const BoxVectors& kept_mm() const { return kept_mm_; }
  // Whether it is not 0 at some end of a spring of a row.
  bool keeps(std::int64_t row) const {
    return keeps() && keeping_rows_[static_cast<std::size_t>(row)] != 0;
  }
  // P_i - P_j: what has been added to the rest vector of a spring.
  glm::dvec3 kept_mm(std::int64_t e, int spring) const {
    if (!keeps()) return glm::dvec3(0.0);
    const std::int64_t j = e + step(spring);
    return {double{kept_mm_[0][e]} - double{kept_mm_[0][j]},
            double{kept_mm_[1][e]} - double{kept_mm_[1][j]},
            double{kept_mm_[2][e]} - double{kept_mm_[2][j]}};
  }

  bool is_free(std::int64_t element) const { return free_flags_[element] != 0; }
  const std::uint8_t* free_flags() const { return free_flags_.data(); }
  // Whether all elements of a row are free, but for its two ends.
  bool all_free(std::int64_t row) const { return all_free_[static_cast<std::size_t>(row)] != 0; }
  RowKind kind(std::int64_t row) const { return kinds_[static_cast<std::size_t>(row)]; }

  // 1 / stiffness, infinite outside the volume; an array only where not all are the same.
  const float* compliances() const { return compliance_ ? compliance_.data() : nullptr; }
  float one_compliance() const { return one_compliance_; }
  const float* blends() const { return blend_ ? blend_.data() : nullptr; }
  float one_blend() const { return one_blend_; }
  float compliance(std::int64_t e) const { return compliance_ ? compliance_[e] : one_compliance_; }
  float blend(std::int64_t e) const { return blend_ ? blend_[e] : one_blend_; }

  // Bits of the springs missing, for the elements of a row of kind cut; null for other rows.
  const std::uint32_t* missing(std::int64_t row) const {
    if (missing_row_.empty() || missing_row_[static_cast<std::size_t>(row)] < 0) return nullptr;
    return &missing_[static_cast<std::size_t>(missing_row_[static_cast<std::size_t>(row)])];
  }
  // False: every spring between elements of the box is there.
  bool may_lack_springs() const { return beyond_volume_ || !missing_row_.empty(); }
  bool lacks_springs() const { return !missing_row_.empty(); }  // to cuts
  // Stiffness of a spring, 0 for none.
  float stiffness(std::int64_t e, int spring) const {
    const float c = compliance(e) + compliance(e + step(spring));
    if (!missing_row_.empty()) {
      const std::int64_t r = e / extent_.x;
      const std::uint32_t* const gone = missing(r);
      if (gone && ((gone[e - r * extent_.x] >> spring) & 1)) return 0.0f;
    }
    return 2.0f / c;
  }

  // Takes those of the elements in the volume that are asked for to be so many times stiffer.
  template <class F>
  void stiffen(F&& whether, float times, WorkerPool& pool) {
    if (!compliance_) {
      compliance_ = BoxArray<float>(extent_, pool);
      std::fill_n(compliance_.data(), voxel_count(extent_), one_compliance_);
    }
    for (std::int64_t e = 0; e < voxel_count(extent_); ++e) {
      if (whether(e)) compliance_[e] /= times;
    }
    tell_rows_apart(pool);
  }

  // The state as lattice() rounds it, in mm.
  void round_to_fixed_point(BoxVectors& rounded_mm, WorkerPool& pool) const;
  // The state in fixed point, of the bricks that it touches; what has not moved keeps its bricks.
  Lattice lattice(const Lattice& published, WorkerPool& pool) const;

  std::int64_t bytes() const;
  static VoxelBox clipped_to_volume(const VoxelBox& box, Size3 volume);

 private:
  SpringBox() = default;
  float mean_compliance(glm::ivec3 at) const;
  void read_displacements(const Lattice& start, WorkerPool& pool);
  void read_kept(const Lattice& kept, WorkerPool& pool);
  void read_brick(const LatticeBrick* brick, const VoxelBox& voxels, glm::ivec3 less,
                  BoxVectors& to) const;
  void read_materials(const Problem& problem, WorkerPool& pool);
  void read_held(const Problem& problem, WorkerPool& pool);
  void read_cuts(const Cuts& cuts);
  void tell_rows_apart(WorkerPool& pool);
  void find_keeping_rows(WorkerPool& pool);

  VoxelBox free_;
  Size3 volume_size_{0};
  Size3 extent_{0};
  glm::dvec3 spacing_mm_{1};
  Springs springs_;
  std::array<std::int64_t, kSprings> steps_{};
  glm::ivec3 common_u_{0};  // fixed point: what u_mm leaves out
  BoxVectors u_mm_;
  BoxVectors kept_mm_;  // empty: 0
  std::vector<std::uint8_t> keeping_rows_;
  BoxArray<std::uint8_t> free_flags_;
  std::int64_t free_elements_ = 0;
  BoxArray<float> compliance_;
  float one_compliance_ = 1.0f;
  BoxArray<float> blend_;
  float one_blend_ = 0.0f;
  bool beyond_volume_ = false;  // some elements are
  std::vector<RowKind> kinds_;
  std::vector<std::uint8_t> all_free_;
  std::vector<std::int64_t> missing_row_;  // where a row's begin in missing_; -1: none are
  std::vector<std::uint32_t> missing_;
};

}  // namespace maille
