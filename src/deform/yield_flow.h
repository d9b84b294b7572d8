// Material that yields: what stays of a deformation when its handle is released.
//
// Perfectly plastic flow, at once and once a release, from the equilibrium with the handle still
// held. A spring's strain is its change of length over its rest length, so that turning is none. It
// yields at the larger of its ends' yield strains: clay beside rubber flows, the springs between
// them and rubber itself keep nothing. Of a strain e beyond the yield strain y the share
// s = 1 - y / e is kept, so that the rest springs back by y again; an element's share is the
// largest of its springs'. Each spring asks for its share of what has been added to its rest
// vector,
//
//     t = (s_i + s_j) / 2 (p - r')             (springs.h; 0 for a spring that never yields),
//
// and what is kept are the displacements P whose growth fits that best: least
// sum k |(dP_i - dP_j) - t|^2. Elements of no share keep their shape: a part of them that what
// yields encloses (the inside of a handle, rubber in clay) goes as one, all others stay. These are
// linear equations with the stiffness Laplacian, so StiffnessMultigrid and conjugate gradients
// solve them; a part that goes as one is 1000 times stiffer meanwhile, so that springs between it
// and what yields count double, and then goes the mean way of its elements.
//
// Shares go by elements, not by springs: a spring across a stretch keeps its length and would ask
// for nothing, and so hold back those along it (of a strain of 20 % and a yield strain of 5 %, 11 %
// were kept and not 15).
//
// So clay flows less next to what does not yield and stays: P is 0 there, and goes on from that
// (measured: a shell of clay in air of a third of its stiffness, pulled by 12 voxels, keeps
// 0.06; 9.3 where the air yields too).
//
// Where P would come near to folding the state of rest, J of X + P not above 0.05 at some corner of
// a cell, less of the flow is taken there: springs at rest in a folded cell would have nothing to
// fear from folding.
#pragma once

#include <cstdint>

#include "core/parallel.h"
#include "deform/cuts.h"
#include "deform/lattice.h"
#include "material/material_field.h"

namespace maille {

struct YieldProblem {
  const Lattice& lattice;  // in equilibrium
  const Lattice& kept;     // P so far
  const MaterialField& materials;
  const Cuts& cuts;
  std::int64_t memory_bytes;  // what it may take
};

struct YieldFlow {
  Lattice kept;          // P now; the very same bricks where nothing yields
  VoxelBox yielded;      // of the elements that did; empty: none
  bool limited = false;  // memory did not allow for all of them: those further out keep P
};

// Bit-equal for any number of threads. Throws std::bad_alloc.
YieldFlow let_yield(const YieldProblem& problem, WorkerPool& pool);

}  // namespace maille
