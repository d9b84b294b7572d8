// A coarse level of the stiffness multigrid (stiffness_multigrid.h): 2^3 elements of the level
// before are one, and the springs between those are added up and kept, to 8 bits: an inverse that
// is rough anyway loses nothing by it, and 18 bytes an element are half of 36.
#pragma once

#include <array>
#include <cstdint>

#include "core/parallel.h"
#include "deform/bfloat16.h"
#include "deform/box_array.h"
#include "deform/spring_box.h"
#include "deform/stiffness_level.h"

namespace maille {

class CoarseStiffness : public StiffnessLevel {
 public:
  BoxVectors forces;
  BoxVectors moves;
  BoxVectors first_moves;  // of two

  // finer: the box's own level.
  CoarseStiffness(const SpringBox& box, const StiffnessLevel& finer, WorkerPool& pool);
  CoarseStiffness(const CoarseStiffness& finer, WorkerPool& pool);

  void gains(std::int64_t begin, int count, float* gain) const override;
  void apply(std::int64_t begin, int count, const std::array<RowsAround, 3>& w,
             RunVectors& out) const override;
  float stiffness_of(std::int64_t e, int s) const override {
    return s % 2 ? stiffness(s / 2, e - step(s / 2)) : stiffness(s / 2, e);
  }

  // What only making the next level needs.
  void forget_ground() { ground_ = {}; }

  float diagonal(std::int64_t e) const { return diagonal_[e]; }
  // Of the spring from an element by springs_of()[2 s].offset.
  float stiffness(int s, std::int64_t e) const {
    return static_cast<float>(k_[static_cast<std::size_t>(s)][e]);
  }
  std::int64_t step(int s) const { return steps_[static_cast<std::size_t>(s)]; }

  std::int64_t bytes() const;

 private:
  // Springs of a row of elements while they are added up, by element.
  using RowOfSums = std::array<std::vector<float>, kSprings / 2>;

  CoarseStiffness(Size3 extent, WorkerPool& pool);
  void add_up_row(const SpringBox& box, const StiffnessLevel& finer, glm::ivec2 yz, int first_x,
                  int last_x, RowOfSums& sums);
  void add_up_row(const CoarseStiffness& finer, glm::ivec2 yz, RowOfSums& sums);
  void add_spring(RowOfSums& sums, std::int64_t row_begin, int x, glm::ivec3 offset, bool free,
                  float k);
  void keep(std::int64_t row_begin, const RowOfSums& sums);
  void add_up_diagonal(WorkerPool& pool);

  Springs springs_;
  std::array<std::int64_t, kSprings / 2> steps_{};
  std::array<BoxArray<Bfloat16>, kSprings / 2> k_;
  BoxArray<float> ground_;
  BoxArray<float> diagonal_;
};

}  // namespace maille
