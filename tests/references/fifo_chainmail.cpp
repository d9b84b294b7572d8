#include "references/fifo_chainmail.h"

#include <queue>

#include "references/link_bounds.h"

namespace maille {

DenseAnswer fifo_chainmail(const DenseProblem& problem) {
  struct Candidate {
    std::size_t sponsor;  // that moved
    std::size_t element;
    int axis;
    int side;
  };
  const LinkBounds bounds(problem.materials);
  auto done = immovable(problem);
  DenseAnswer answer{problem.start, problem.by};
  auto& u = answer.u;
  std::queue<Candidate> list;
  const auto push_neighbours = [&](std::size_t i) {
    for_each_neighbour(i, problem.size, [&](std::size_t j, int axis, int side) {
      if (!done[j]) list.push({i, j, axis, side});
    });
  };
  for (const VoxelIndex voxel : problem.handle) {
    const std::size_t element = element_of(voxel, problem.size);
    u[element] += problem.by;
    done[element] = 1;
  }
  for (const VoxelIndex voxel : problem.handle) push_neighbours(element_of(voxel, problem.size));
  while (!list.empty()) {
    const auto [i, j, axis, side] = list.front();
    list.pop();
    if (done[j]) continue;
    const glm::ivec3 moved =
        pulled_within(bounds.between(axis, side, problem.ids[i], problem.ids[j]), side, u[i], u[j]);
    if (moved == u[j]) continue;
    u[j] = moved;
    done[j] = 1;
    push_neighbours(j);
  }
  return answer;
}

}  // namespace maille
