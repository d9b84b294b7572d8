#include "measure/spring_scene.h"

#include <algorithm>
#include <cmath>

#include "references/dense_problem.h"

namespace maille {

SpringProblem spring_problem_of(const Deformer& deformer, std::span<const Grab> pinned,
                                const AnchorRules& anchors, double rest_vector_blend) {
  const MaterialField& field = deformer.materials();
  const Cuts& cuts = deformer.cuts();
  SpringProblem problem;
  problem.size = field.size();
  problem.spacing_mm = field.spacing_mm();
  problem.materials = spring_materials(field.table().materials(), rest_vector_blend);
  problem.ids.resize(static_cast<std::size_t>(voxel_count(problem.size)));
  field.read({VoxelIndex(0), problem.size}, problem.ids);
  problem.start_voxels = displacements_of(deformer.lattice());
  problem.held.resize(problem.ids.size());
  if (!cuts.empty()) problem.removed.resize(problem.ids.size());
  const BrickGrid grid(problem.size);
  ElementSet handles;
  for (const Grab& grab : pinned) {
    handles.insert(ball_of_elements(grab.element, grab.radius_voxels, grid));
  }
  for (std::size_t i = 0; i < problem.held.size(); ++i) {
    const VoxelIndex at = voxel_of(i, problem.size);
    const std::uint8_t faces = faces_of(at, problem.size);
    problem.held[i] = field.table().fixed(problem.ids[i]) || (faces & anchors.faces) != 0 ||
                      (faces != 0 && anchors.faces == 0 && !anchors.free_border) ||
                      handles.contains(at, grid);
    for (int axis = 0; axis < 3 && !cuts.empty(); ++axis) {
      problem.removed[i] |= static_cast<std::uint8_t>(int{cuts.removed(at, axis)} << axis);
    }
  }
  return problem;
}

DisplacementField displacements_of(const Lattice& lattice) {
  const Size3 size = lattice.grid().volume_size();
  DisplacementField u;
  u.reserve(static_cast<std::size_t>(voxel_count(size)));
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) u.push_back(lattice.displacement_voxels({x, y, z}));
    }
  }
  return u;
}

FieldDistance distance_between(const DisplacementField& a_voxels, const DisplacementField& b_voxels,
                               std::span<const std::uint8_t> counted) {
  double sum = 0.0;
  double most = 0.0;
  std::int64_t count = 0;
  for (std::size_t i = 0; i < counted.size(); ++i) {
    if (!counted[i]) continue;
    const glm::dvec3 apart = a_voxels[i] - b_voxels[i];
    const double squared = glm::dot(apart, apart);
    sum += squared;
    most = std::max(most, squared);
    ++count;
  }
  if (count == 0) return {};
  return {std::sqrt(sum / static_cast<double>(count)), std::sqrt(most)};
}

}  // namespace maille
