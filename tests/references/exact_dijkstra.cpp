#include "references/exact_dijkstra.h"

#include <algorithm>
#include <cstdlib>
#include <queue>
#include <utility>

#include "references/link_bounds.h"

namespace maille {

DenseAnswer exact_dijkstra(const DenseProblem& problem) {
  const LinkBounds bounds(problem.materials);
  const auto fixed = immovable(problem);
  const auto& start = problem.start;
  DenseAnswer answer{start, problem.by};
  for (int c = 0; c < 3; ++c) {
    const std::int64_t sign = problem.by[c] < 0 ? -1 : 1;
    const std::int64_t drag = std::abs(problem.by[c]);
    std::vector<std::int64_t> label(start.size(), 0);
    using Item = std::pair<std::int64_t, std::size_t>;
    std::priority_queue<Item> queue;
    for (const VoxelIndex voxel : problem.handle) {
      const std::size_t element = element_of(voxel, problem.size);
      label[element] = drag;
      queue.push({drag, element});
    }
    while (!queue.empty()) {
      const auto [value, i] = queue.top();
      queue.pop();
      if (value < label[i]) continue;
      for_each_neighbour(i, problem.size, [&](std::size_t j, int axis, int side) {
        if (link_removed(problem, i, j, axis, side)) return;
        const LinkBound& bound = bounds.between(axis, side, problem.ids[i], problem.ids[j]);
        const std::int64_t link =
            side * (std::int64_t{start[j][c]} - start[i][c]);  // how far the higher one is ahead
        // i moves towards j, and may until the link is as short as it gets; or away from it, until
        // it is as long.
        const bool towards = side == sign;
        const std::int64_t slack =
            std::max<std::int64_t>(0, towards ? link - bound.lower[c] : bound.upper[c] - link);
        if (value - slack <= label[j]) return;
        label[j] = value - slack;
        queue.push({label[j], j});
      });
    }
    // Every label falls by as much as the drag does: the highest at an anchor is what it gives up.
    std::int64_t overshoot = 0;
    for (std::size_t i = 0; i < label.size(); ++i) {
      if (fixed[i]) overshoot = std::max(overshoot, label[i]);
    }
    for (std::size_t i = 0; i < label.size(); ++i) {
      answer.u[i][c] += static_cast<int>(sign * std::max<std::int64_t>(0, label[i] - overshoot));
    }
    answer.moved_by[c] = static_cast<int>(sign * (drag - overshoot));
  }
  return answer;
}

}  // namespace maille
