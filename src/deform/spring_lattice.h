// The lattice as springs see it: the bricks that take part in a relaxation, in mm and floats.
//
// One Jacobi step of a brick reads the state before of its neighbours and writes its own next one,
// so that bricks can be swept in any order and by any worker with the same bits.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "deform/anchors.h"
#include "deform/cuts.h"
#include "deform/lattice.h"
#include "deform/spring_forces.h"
#include "material/material_field.h"

namespace maille {

// A brick that takes part.
struct SpringBrick {
  std::vector<float> u_mm[3];
  std::vector<float> next_mm[3];
  std::vector<float> gain;             // step / sum of stiffnesses; 0 holds the element
  std::vector<std::uint32_t> missing;  // missing_springs(): empty far from cuts
  std::int64_t free_elements = 0;
  bool active = true;   // in the next sweep
  bool changed = true;  // since the state was last asked for
  // Largest moves of the last sweep, in voxels: anywhere, and in each face's layer.
  float largest_move = 0.0f;
  std::array<float, 6> face_move{};

  void take_step();  // into the next state
};

class SpringLattice {
 public:
  struct Problem {
    const Lattice& start;
    const MaterialField& materials;  // must outlive the SpringLattice
    const Cuts& cuts;
    const ElementSet& held;
    AnchorRules anchors;
    double step = 0.0;  // of the safe step, in (0, 1)
    double rest_vector_blend = 0.0;
  };
  SpringLattice(const Problem& problem, int workers);

  const BrickGrid& grid() const { return start_.grid(); }

  // Makes a brick, or it and its 26 neighbours, take part. Not while workers are at it.
  void take_in(std::int64_t b);
  void take_in_with_neighbours(std::int64_t b);
  const std::vector<std::int64_t>& bricks() const { return taking_part_; }  // by rising index

  SpringBrick& brick(std::int64_t b) { return *bricks_[static_cast<std::size_t>(b)]; }
  const SpringBrick* brick_or_none(std::int64_t b) const {
    return bricks_[static_cast<std::size_t>(b)].get();
  }

  // For bricks that take part; any number at a time, each by a worker of its own.

  // One Jacobi step, from the state of all bricks into this one's next state.
  void sweep(std::int64_t b, int worker);
  // Energy of the springs of a brick's elements. A spring to a brick that takes part is counted
  // half here and half there, one to a brick that does not is counted whole.
  double energy_of(std::int64_t b, int worker);
  // Its state in fixed point; null where all of it rests.
  LatticeBrick::Pointer rounded(std::int64_t b) const;

  std::int64_t bytes() const;

 private:
  // A brick and one element around it, gathered so that the sweep runs straight through memory.
  struct Halo {
    std::vector<float> u_mm[3];
    std::vector<float> compliance;
    Halo();
  };

  template <class F>
  void for_each_neighbour(BrickIndex brick, F&& f) const;
  void prepare_compliance(std::int64_t b);
  void prepare_gains(std::int64_t b);
  bool is_held(VoxelIndex voxel, const ElementSet::Mask* mask, bool fixed_materials) const;
  template <class Source>
  void gather(std::int64_t b, std::vector<float>& out, float beyond, Source&& source) const;
  void gather_compliance(std::int64_t b, Halo& halo) const;
  void gather_all(std::int64_t b, Halo& halo) const;

  Lattice start_;
  const MaterialField& materials_;
  Cuts cuts_;
  ElementSet held_;
  AnchorRules anchors_;
  double step_;
  double rest_vector_blend_;
  glm::dvec3 spacing_mm_;
  Springs springs_;

  std::vector<std::vector<float>> compliances_;  // 1 / stiffness; infinite beyond the volume
  std::vector<std::unique_ptr<SpringBrick>> bricks_;
  std::vector<std::int64_t> taking_part_;
  std::vector<Halo> halos_;  // one a worker
};

}  // namespace maille
