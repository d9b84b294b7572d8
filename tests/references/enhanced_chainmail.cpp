#include "references/enhanced_chainmail.h"

#include <algorithm>
#include <queue>

#include "references/link_bounds.h"

namespace maille {
namespace {

struct Candidate {
  int violation;  // largest component of the move it needs, 1/512 voxel
  std::int8_t axis;
  std::int8_t side;  // of the step from the element that pushed it
  std::size_t element;

  // Equal violations: the lower element first, so that the answer is the same everywhere.
  bool operator<(const Candidate& other) const {
    return violation != other.violation ? violation < other.violation : element > other.element;
  }
};

}  // namespace

DenseAnswer enhanced_chainmail(const DenseProblem& problem) {
  const LinkBounds bounds(problem.materials);
  auto done = immovable(problem);
  DenseAnswer answer{problem.start, problem.by};
  auto& u = answer.u;
  std::priority_queue<Candidate> heap;
  const std::size_t steps[3] = {
      1, static_cast<std::size_t>(problem.size.x),
      static_cast<std::size_t>(problem.size.x) * static_cast<std::size_t>(problem.size.y)};
  const auto within = [&](std::size_t i, std::size_t j, int axis, int side) {
    return pulled_within(bounds.between(axis, side, problem.ids[i], problem.ids[j]), side, u[i],
                         u[j]);
  };
  const auto push_neighbours = [&](std::size_t i) {
    for_each_neighbour(i, problem.size, [&](std::size_t j, int axis, int side) {
      if (done[j]) return;
      const glm::ivec3 move = glm::abs(within(i, j, axis, side) - u[j]);
      const int violation = std::max({move.x, move.y, move.z});
      if (violation == 0) return;
      heap.push({violation, static_cast<std::int8_t>(axis), static_cast<std::int8_t>(side), j});
    });
  };
  for (const VoxelIndex voxel : problem.handle) {
    const std::size_t element = element_of(voxel, problem.size);
    u[element] += problem.by;
    done[element] = 1;
  }
  for (const VoxelIndex voxel : problem.handle) push_neighbours(element_of(voxel, problem.size));
  while (!heap.empty()) {
    const Candidate next = heap.top();
    heap.pop();
    const std::size_t j = next.element;
    if (done[j]) continue;
    const std::size_t step = steps[next.axis];
    u[j] = within(next.side > 0 ? j - step : j + step, j, next.axis, next.side);
    done[j] = 1;
    push_neighbours(j);
  }
  return answer;
}

}  // namespace maille
