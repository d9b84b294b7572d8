// Stiff parts turning as a whole: what multigrid over the stiffness graph cannot see.
//
// A ball of bone in soft tissue turns against next to nothing. The Laplacian takes a turn for
// strain of the bone, so its inverse gives a thousandth of the turn that a torque asks for. Here
// each part that is stiffer than what is around it by kStiffer, and is held nowhere or at one
// element, has its three turns: the torque on it over what resists it, the springs that leave the
// part and the rest-vector blend within. What is around a part gives way; by how much less it
// resists than if it were fixed is measured once, with multigrid.
#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "deform/spring_box.h"
#include "deform/stiffness_multigrid.h"

namespace maille {

class StiffTurns {
 public:
  // forces and moves: scratch, of the box's extent; forces are left 0. The box must outlive it.
  StiffTurns(const SpringBox& box, StiffnessMultigrid& multigrid, BoxVectors& forces,
             BoxVectors& moves);

  bool empty() const { return parts_.empty(); }

  // Turns the parts by what forces ask for, and takes off these what that has dealt with: solve()
  // with what is left, then add(), gives the moves.
  void take(BoxVectors& forces);
  void give_back(BoxVectors& forces) const;  // what take() changed
  void add(BoxVectors& moves) const;

  std::int64_t bytes() const;

 private:
  struct Run {
    std::int64_t first = 0;
    int count = 0;
  };
  struct Leaving {  // a spring that leaves the part
    std::int64_t inside = 0;
    std::int64_t outside = 0;
    int spring = 0;  // from inside
  };
  struct Part {
    std::vector<Run> runs;
    std::vector<Leaving> leaving;
    std::int64_t held = -1;   // the one element that is; -1: none
    double yielding = 1.0;    // resistance by what it would be in fixed surroundings
    glm::dmat3 blend{0.0};    // resistance of the blend within
    glm::dvec3 center_mm{0};  // of the turn
    glm::dvec3 turn{0};       // the last, radians
  };

  bool is_joined(std::int64_t element, glm::ivec3 offset) const;
  void find_parts(float stiff_compliance);
  void measure_yielding(StiffnessMultigrid& multigrid, BoxVectors& forces, BoxVectors& moves);
  glm::dvec3 position_mm(std::int64_t element) const;
  glm::dvec3 center_of(const Part& part) const;
  glm::dmat3 resistance(const Part& part) const;

  const SpringBox& box_;
  std::vector<Part> parts_;
  std::vector<std::pair<std::int64_t, glm::vec3>> before_;  // of forces
};

}  // namespace maille
