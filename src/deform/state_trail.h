// How far relaxation still has to go, told from how far it came of late.
//
// The next move says it where multigrid sees all of the error. Where it takes turns of stiff parts,
// or of what is thin, for strain, moves are short and go on for long: 0.003 voxel at a time may
// leave 0.3. So the state is looked at over two spans of cycles one after the other, a quarter of
// all cycles each: what is left after the second shrinks as the second did against the first. (Ritz
// values of the Lanczos process behind conjugate gradients were tried: what is left is slow just
// because the forces hold next to nothing of it, and they do not see it either.)
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "deform/spring_box.h"

namespace maille {

class StateTrail {
 public:
  // Follows some thousand of the box's free elements, spread evenly.
  explicit StateTrail(const SpringBox& box);

  // After each cycle, and once before the first.
  void add(const SpringBox& box);

  struct Left {
    double largest_voxels = 0.0;
    double rms_voxels = 0.0;
    bool one_way = false;  // the second span went on where the first had gone
  };
  // 0 until there are two spans to compare.
  Left left() const;

  std::int64_t bytes() const;

 private:
  struct State {
    std::int64_t cycle = 0;
    std::vector<glm::vec3> u_mm;  // of the elements
  };
  Left between(const State& a, const State& b) const;
  // One that is kept.
  const State& at(std::int64_t cycle) const;

  glm::vec3 voxels_from_mm_;
  std::vector<std::int64_t> elements_;
  std::int64_t cycle_ = -1;  // of the state added last
  std::int64_t stride_ = 1;  // cycles between those kept
  std::deque<State> kept_;   // of the later half, and the last one
};

}  // namespace maille
