// An approximate inverse of the stiffness-weighted graph Laplacian of a box of springs, the same
// for x, y and z: what turns forces into moves that reach across the whole box at once.
//
// The Laplacian is fixed while materials, cuts and what is held are, and bounds the Hessian of the
// springs at any state (springs.h); near rest the two are alike to a factor of five, or two with a
// rest-vector blend of 1/4.
//
// Multigrid by aggregation: 2^3 elements make one of the next level, whose springs are the sums of
// those between its elements. So a spring that a cut took is missing on every level, what is held
// stays held (springs to it become springs to the ground), and a stiff part stays stiff, whatever
// its shape: interpolation between neighbours, the usual way, strains a stiff part's surface and
// fails from a stiffness ratio of 1000 on (measured: 22 iterations to a tenth of the error that
// this takes 6 for). Sums alone are too stiff by up to two, so they are taken times 0.6; and each
// coarse level is solved by two steps of conjugate gradients around its own cycle (a K-cycle: Notay
// and Vassilevski, Recursive Krylov-based multigrid cycles, Numer. Linear Algebra Appl. 15, 2008).
// Smoothing is one Jacobi step before and after.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "core/parallel.h"
#include "deform/box_array.h"
#include "deform/spring_box.h"

namespace maille {

class CoarseStiffness;

class StiffnessMultigrid {
 public:
  // The box must outlive it; of its state nothing is read. Throws std::bad_alloc.
  StiffnessMultigrid(const SpringBox& box, WorkerPool& pool);
  ~StiffnessMultigrid();

  // One cycle: moves (mm) for forces (stiffness * mm), both 0 where the box is held. Bit-equal for
  // any number of threads.
  void solve(const BoxVectors& forces, BoxVectors& moves);

  std::int64_t bytes() const;

 private:
  class Fine;
  class Direct;

  void cycle(std::size_t level);
  void solve_level(std::size_t level);

  std::unique_ptr<Fine> fine_;
  std::vector<std::unique_ptr<CoarseStiffness>> levels_;  // finer to coarser
  std::unique_ptr<Direct> direct_;
};

}  // namespace maille
