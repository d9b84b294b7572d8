#include "references/dense_problem.h"

namespace maille {

std::vector<std::uint8_t> immovable(const DenseProblem& problem) {
  std::vector<std::uint8_t> flags(problem.ids.size());
  for (std::size_t i = 0; i < flags.size(); ++i) {
    flags[i] = problem.materials[problem.ids[i]].fixed ? 1 : 0;
  }
  for (const VoxelIndex voxel : problem.held) flags[element_of(voxel, problem.size)] = 1;
  return flags;
}

}  // namespace maille
