// One element near folding, moved to where its own energy is least.
//
// Newton's method on three unknowns, what is around it held: its springs and the corners it is part
// of (fold_energy.h), gathered once for many moves. No move closes an open corner.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "deform/fold_energy.h"

namespace maille {

class FoldElement {
 public:
  FoldElement() = default;
  FoldElement(const FoldEnergy& folds, std::int64_t element);

  // From 0 to 7; elements of one color have no spring or corner in common.
  int color() const { return color_; }
  struct Move {
    double voxels = 0.0;
    bool in_wall = false;  // of a corner, before it
  };
  // One step, shortened until the energy does not rise. Writes u_mm of this element and reads that
  // of its neighbours.
  Move move_to_least_energy(const FoldEnergy& folds, BoxVectors& u_mm) const;

 private:
  struct SpringHere {
    std::int64_t other = 0;
    glm::dvec3 rest_mm{0};
    glm::dvec3 kept_mm{0};  // of it, what material keeps that has yielded
    double length_mm = 0.0;
    double stiffness = 0.0;
    double blend = 0.0;
  };

  // J is straight in the position of any one of its four elements: an edge that it ends changes
  // with it, and where all three do, what they change by is one and the same direction.
  struct CornerHere {
    std::array<std::int64_t, 4> elements{};
    glm::dvec3 signs{1};
    glm::dvec3 shares{0};
    double kappa = 0.0;
    bool guarded = true;
  };

  std::int64_t element_ = 0;
  int color_ = 0;
  std::vector<SpringHere> springs_;
  std::vector<CornerHere> corners_;
};

}  // namespace maille
