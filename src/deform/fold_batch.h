// Up to eight elements near folding, each moved to where its own energy is least.
//
// Newton's method on three unknowns, what is around an element held: its springs and the corners
// that it is part of (fold_energy.h), gathered once for many moves. No move closes an open corner.
// Eight at a time, one in each lane of a vector of doubles, because a hard pull makes thousands of
// moves a step (131,606 elements, 565 of them near folding: 7.4 ms a cycle where one element at a
// time took 12.2).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "deform/fold_energy.h"

namespace maille {

class FoldBatch {
 public:
  static constexpr int kLanes = 8;
  using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));
  using LaneMask = long long __attribute__((vector_size(kLanes * sizeof(double))));

  // From 0 to 7; elements of one color have no spring or corner in common.
  static int color_of(const SpringBox& box, std::int64_t element);

  // elements: free ones of one color, at most kLanes.
  FoldBatch(const FoldEnergy& folds, std::span<const std::int64_t> elements);

  // One step of each: first_share of Newton's, shortened until the energy does not rise. Returns
  // how far the furthest moved, in voxels. Writes u_mm of these elements and reads that of their
  // neighbours. The same for an element whatever others are in the batch.
  double move_to_least_energy(const FoldEnergy& folds, BoxVectors& u_mm, double first_share) const;

  // What is not there has no stiffness.
  struct alignas(64) SpringLanes {
    std::array<Lanes, 3> rest_mm{};
    std::array<Lanes, 3> kept_mm{};  // of it, what material keeps that has yielded
    Lanes length_mm{};
    Lanes plain{};     // stiffness along its length alone
    Lanes straight{};  // and in all directions
  };
  // J is straight in the position of any one of its four elements: an edge that it ends changes
  // with it, and where all three do, what they change by is one and the same direction.
  struct alignas(64) CornerLanes {
    Lanes kappa{};
    LaneMask guarded{};
    bool present = false;
  };
  static constexpr int kCorners = 32;

 private:
  int count_ = 0;
  std::array<std::int64_t, kLanes> elements_{};
  std::array<SpringLanes, kSprings> springs_;
  std::array<CornerLanes, kCorners> corners_;
};

}  // namespace maille
