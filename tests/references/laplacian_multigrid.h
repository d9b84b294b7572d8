// A preconditioner for the Hessian of dense_springs.h: one multigrid cycle on the graph Laplacian
// of its weights, the same for each component.
//
// Aggregation by 2^3 elements (piecewise constant transfer, coarse weights are sums of fine ones),
// a W cycle with damped Jacobi sweeps. Every step of it is symmetric and lowers the error whatever
// the weights are, so that jumps of stiffness cost iterations but never the sign; a W cycle makes
// up for what constant transfer lacks, at 4/3 of the work of the finest level. In floats: conjugate
// gradients around it are in double.
#pragma once

#include <vector>

#include "core/parallel.h"
#include "references/dense_springs.h"

namespace maille {

class LaplacianMultigrid {
 public:
  // Springs as they are linearised now; they are not kept. pool must outlive this.
  LaplacianMultigrid(const DenseSprings& springs, WorkerPool& pool);

  // z ~ L^-1 r; 0 where held.
  void apply(const DisplacementField& r, DisplacementField& z);

 private:
  struct Level {
    Size3 size{0};
    std::ptrdiff_t margin = 0;  // zeros before and after each array, as far as a spring reaches
    std::array<std::ptrdiff_t, DenseSprings::kForward> steps{};
    std::vector<float> weights[DenseSprings::kForward];  // between free elements
    std::vector<float> inverse_diagonal;                 // 0: held
    std::vector<glm::vec3> x, r, next;

    explicit Level(Size3 of_size);
    std::size_t at(VoxelIndex voxel) const;
  };

  template <class F>
  void for_each_element(const Level& level, F&& f);
  Level coarser(const Level& fine, const std::vector<float>& fine_diagonal,
                std::vector<float>& diagonal) const;
  void smooth(Level& level, int sweeps);
  void residual(Level& level);  // into next
  void cycle(std::size_t level);

  WorkerPool& pool_;
  std::vector<Level> levels_;
};

}  // namespace maille
