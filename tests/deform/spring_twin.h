// A relaxation's problem for the reference that knows nothing of how the product solves it.
#pragma once

#include <vector>

#include "deform/cuts.h"
#include "references/spring_equilibrium.h"
#include "tests/deform/lattices.h"

namespace maille::testing {

// materials by the volume's values: 0, 1, 2 …
inline SpringProblem spring_twin(const Volume& volume, std::vector<SpringMaterial> materials,
                                 const Lattice& start, const Cuts& cuts) {
  SpringProblem twin;
  twin.size = volume.size();
  twin.spacing_mm = volume.spacing_mm();
  twin.materials = std::move(materials);
  twin.held.assign(static_cast<std::size_t>(voxel_count(twin.size)), 0);
  for_each_voxel(twin.size, [&](VoxelIndex v) {
    twin.ids.push_back(static_cast<MaterialId>(volume.value_at(v)));
    twin.start_voxels.push_back(start.displacement_voxels(v));
    int removed = 0;
    for (int axis = 0; axis < 3; ++axis) removed |= int{cuts.removed(v, axis)} << axis;
    twin.removed.push_back(static_cast<std::uint8_t>(removed));
  });
  return twin;
}

inline std::vector<SpringMaterial> spring_materials_of(const std::vector<double>& stiffness,
                                                       double rest_vector_blend) {
  std::vector<SpringMaterial> materials;
  for (const double k : stiffness) {
    SpringMaterial material;
    material.stiffness = k;
    material.rest_vector_blend = rest_vector_blend;
    materials.push_back(material);
  }
  return materials;
}

}  // namespace maille::testing
