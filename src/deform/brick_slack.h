// The slack of a brick's links for one component of a drag: how far one end may move before it
// moves the other (design: ChainMail).
//
// Seen along the drag: a drag downwards is an upwards one of the mirrored lattice. For a link from
// an element to the next one along an axis, `up` is the slack with which the lower element pushes
// the upper one and `down` that with which the upper one pulls the lower. A link outside its limits
// has no slack; a removed one has more than any label.
//
// L: type of the labels, std::uint16_t where drag and limits stay below 128 voxels, else
// std::uint32_t. Sums saturate: what exceeds a label can not push.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/aligned_array.h"
#include "deform/lattice.h"
#include "deform/stroke_bricks.h"

namespace maille {

// Limits of every material for one component and direction, in fixed-point units >= 0.
template <class L>
struct DirectedLimits {
  int component = 0;
  int sign = 1;  // of the drag
  // By material: how far a link along the component's axis may shorten and lengthen, and how far
  // the ends of one along another axis may slip. A link takes the mean of its ends' (rounded down).
  std::array<L, kMaxMaterials> shorten{};
  std::array<L, kMaxMaterials> lengthen{};
  std::array<L, kMaxMaterials> slip{};

  DirectedLimits(const MaterialTable& table, int drag_component, bool downwards);
};

template <class L>
class BrickSlack {
 public:
  static constexpr L kRemoved = std::numeric_limits<L>::max();

  // Looks at a brick; what it is given must outlive the look.
  void begin(const StrokeBricks& bricks, const StrokeBrick& brick, const Lattice& start,
             const DirectedLimits<L>& limits);

  // Whether the links inside the brick have one slack an axis and direction.
  bool uniform() const { return uniform_; }
  L uniform_up(int axis) const { return one_up_[static_cast<std::size_t>(axis)]; }
  L uniform_down(int axis) const { return one_down_[static_cast<std::size_t>(axis)]; }

  // Otherwise: of the 32 links that start in a row (y, z) and run along an axis, after prepare()
  // for that row.
  void prepare(int y, int z) {
    const auto row = static_cast<std::size_t>(z * kBrickEdge + y);
    if (!ready_[row]) fill(y, z);
  }
  const L* up(int axis, int row) const {
    return &up_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(row) * kBrickEdge];
  }
  const L* down(int axis, int row) const {
    return &down_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(row) * kBrickEdge];
  }

  // Of the 32 links that cross a side of the brick in line i of that side: along y in plane z = i
  // for axis 0, along x in plane z = i for axis 1 and along x in row y = i for axis 2.
  struct Crossing {
    alignas(64) L into[kBrickEdge];    // with which the neighbour moves our elements
    alignas(64) L out_of[kBrickEdge];  // with which ours move the neighbour's
  };
  void cross(int axis, int side, int line, Crossing& crossing) const;

 private:
  void fill(int y, int z);
  void limits_from(VoxelIndex voxel, int count, const std::array<L, kMaxMaterials>& limit,
                   L* out) const;

  const StrokeBrick* brick_ = nullptr;
  const DirectedLimits<L>* limits_ = nullptr;
  const CutBrick* cut_ = nullptr;
  const DisplacementPlane* here_ = nullptr;           // of the component; null: at rest
  std::array<const DisplacementPlane*, 6> beside_{};  // [2 * axis + (side > 0)]
  std::array<const CutBrick*, 3> cut_before_{};       // of the neighbours below
  bool uniform_ = false;
  std::array<bool, 6> crossing_uniform_{};
  std::array<L, 3> one_up_{};
  std::array<L, 3> one_down_{};
  std::array<bool, kBrickEdge * kBrickEdge> ready_{};
  AlignedArray<L> up_[3];
  AlignedArray<L> down_[3];
};

extern template class BrickSlack<std::uint16_t>;
extern template class BrickSlack<std::uint32_t>;
extern template struct DirectedLimits<std::uint16_t>;
extern template struct DirectedLimits<std::uint32_t>;

}  // namespace maille
