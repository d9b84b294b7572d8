// One solid over the block of points at hand: what a formula volume asks it point by point.
#pragma once

#include <vector>

#include "volume/phantom_grid.h"
#include "volume/solid.h"

namespace maille {

class SolidLayer {
 public:
  // edge_width as of PhantomGrid: edges are that wide, in mm.
  SolidLayer(const Solid& solid, float edge_width)
      : solid_(solid), half_edge_(0.5f * edge_width), inverse_edge_(1.0f / edge_width) {}

  // enough_depth: how far below the edge, in mm, distances are all the same to the caller. Where
  // the whole block lies deeper, distance() is only some value deeper than that.
  void enter(const PointBlock& block, float enough_depth) {
    const auto range = solid_.select(block, which_);
    is_outside_ = range.lowest > half_edge_;
    if (is_outside_) return;
    if (range.highest < -(half_edge_ + enough_depth)) {
      distances_.fill(range.highest);
    } else {
      solid_.evaluate(block, which_, distances_);
    }
  }

  // Whether the whole block lies beyond the solid's edge. distance() then says nothing.
  bool is_outside() const { return is_outside_; }
  float distance(std::size_t i) const { return distances_[i]; }  // mm, negative inside
  float coverage_at(std::size_t i) const {
    return is_outside_ ? 0.0f : coverage(distances_[i], inverse_edge_);
  }

 private:
  const Solid& solid_;
  float half_edge_;
  float inverse_edge_;
  bool is_outside_ = true;
  std::vector<std::uint16_t> which_;
  PointBlock::Values distances_{};
};

}  // namespace maille
