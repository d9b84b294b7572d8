#include "references/paper_walk.h"

namespace maille {
namespace {

// Calls f(voxel), x fastest.
template <class F>
void for_each_voxel_of(VoxelIndex lo, VoxelIndex hi, F&& f) {
  for (int z = lo.z; z < hi.z; ++z) {
    for (int y = lo.y; y < hi.y; ++y) {
      for (int x = lo.x; x < hi.x; ++x) f(VoxelIndex(x, y, z));
    }
  }
}

// The nearest of an element and its neighbours.
ElementDistance nearest_around(const DeformedElements& elements, ElementDistance here,
                               glm::dvec3 point_mm, PaperWalkOptions::Neighbours neighbours) {
  ElementDistance best = here;
  const auto look_at = [&](std::size_t element) {
    const ElementDistance there = elements.distance(element, point_mm);
    if (there.before(best)) best = there;
  };
  if (neighbours == PaperWalkOptions::Neighbours::six) {
    for_each_neighbour(here.element, elements.size(),
                       [&](std::size_t element, int, int) { look_at(element); });
  } else {
    for_each_in_neighbourhood(here.element, elements.size(), look_at);
  }
  return best;
}

WalkedVoxel walk(const DeformedElements& elements, ElementDistance here, glm::dvec3 point_mm,
                 const PaperWalkOptions& options) {
  for (int steps = 0;; ++steps) {
    const ElementDistance next = nearest_around(elements, here, point_mm, options.neighbours);
    if (next.element == here.element) {
      const bool reaches = elements.reaches(here.element, point_mm);
      return {here.element, steps, reaches ? WalkedVoxel::End::found : WalkedVoxel::End::too_far};
    }
    if (steps == options.most_steps) {
      return {here.element, steps, WalkedVoxel::End::too_many_steps};
    }
    here = next;
  }
}

// The element whose rest position is the voxel's less a displacement, or the nearest of the border
// to it.
std::size_t element_displaced_to(VoxelIndex voxel, glm::dvec3 u_voxels, Size3 size) {
  const glm::dvec3 rest = glm::round(glm::dvec3(voxel) - u_voxels);
  return element_of(VoxelIndex(glm::clamp(rest, glm::dvec3(0.0), glm::dvec3(size - 1))), size);
}

}  // namespace

std::vector<WalkedVoxel> paper_walk(const DeformedElements& elements, VoxelIndex lo, VoxelIndex hi,
                                    const PaperWalkOptions& options) {
  std::vector<WalkedVoxel> walked;
  const std::size_t none = elements.count();
  // Found for the voxel before, for the first of the row before and for the first of the plane
  // before; the last that was, where there was none.
  std::size_t before = none, of_row = none, of_plane = none;
  for_each_voxel_of(lo, hi, [&](VoxelIndex voxel) {
    const bool first_of_row = voxel.x == lo.x;
    const bool first_of_plane = first_of_row && voxel.y == lo.y;
    if (first_of_plane) {
      before = of_plane;
    } else if (first_of_row) {
      before = of_row;
    }
    const glm::dvec3 point_mm = glm::dvec3(voxel) * elements.spacing_mm();
    const glm::dvec3 last_u = before == none ? glm::dvec3(0.0) : elements.u_voxels(before);
    ElementDistance start =
        elements.distance(element_displaced_to(voxel, last_u, elements.size()), point_mm);
    if (before != none) {
      const ElementDistance at_last = elements.distance(before, point_mm);
      if (at_last.before(start)) start = at_last;
    }
    const WalkedVoxel end = walk(elements, start, point_mm, options);
    if (end.found()) {
      before = end.element;
      if (first_of_row) of_row = end.element;
      if (first_of_plane) of_plane = end.element;
    }
    walked.push_back(end);
  });
  return walked;
}

WalkCounts count_walks(const DeformedElements& elements, const NearestBruteForce& nearest,
                       VoxelIndex lo, VoxelIndex hi, const std::vector<WalkedVoxel>& walked) {
  WalkCounts counts;
  for_each_voxel_of(lo, hi, [&](VoxelIndex voxel) {
    const WalkedVoxel& end = walked[static_cast<std::size_t>(counts.voxels)];
    const glm::dvec3 point_mm = glm::dvec3(voxel) * elements.spacing_mm();
    const std::size_t right = nearest.nearest_to(point_mm).element;
    const bool there = elements.reaches(right, point_mm);
    ++counts.voxels;
    counts.there += there;
    counts.found += end.found();
    counts.right += end.found() && end.element == right;
    counts.missed += there && !end.found();
    counts.gave_up += end.end == WalkedVoxel::End::too_many_steps;
    counts.steps += end.steps;
  });
  return counts;
}

}  // namespace maille
