// Which elements relax: a box around what was disturbed, larger while what lies beyond is pulled.
//
// A displacement falls off only like one over the distance, so that in the end nearly all of a
// volume has its part in an equilibrium; yet what a person looks at is settled long before. So a
// region starts at a few times what was disturbed and grows when its rim, which holds meanwhile,
// carries a force that matters.
#pragma once

#include <cstdint>

#include "deform/anchors.h"
#include "volume/brick.h"

namespace maille {

class RelaxationRegion {
 public:
  // most_elements: what memory allows. anchors: faces that hold stay out.
  RelaxationRegion(const VoxelBox& disturbed, Size3 volume, AnchorRules anchors,
                   std::int64_t most_elements);

  const VoxelBox& box() const { return box_; }  // empty: nothing can move
  const VoxelBox& whole_box() const { return whole_; }
  bool whole() const { return box_ == whole_; }
  // Memory allows no more, although there is more.
  bool limited() const { return limited_; }
  // False where it cannot.
  bool grow();

 private:
  bool take(const VoxelBox& wanted);

  VoxelBox whole_;
  VoxelBox box_;
  std::int64_t most_elements_;
  bool limited_ = false;
};

}  // namespace maille
