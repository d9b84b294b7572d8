// A relaxation's problem for the reference that knows nothing of how the product solves it.
#pragma once

#include <vector>

#include "deform/anchors.h"
#include "deform/cuts.h"
#include "material/default_blend.h"
#include "references/spring_equilibrium.h"
#include "tests/deform/lattices.h"

namespace maille::testing {

// The fold energy of relaxation, as deform/fold_energy.h states it.
inline constexpr FoldTerm kCorners{FoldRule::wall, 0.3, 1.0, 1.0 / 3000.0};

// materials by the volume's values: 0, 1, 2 …
inline SpringProblem spring_twin(const Volume& volume, std::vector<SpringMaterial> materials,
                                 const Lattice& start, const Cuts& cuts,
                                 const Lattice* kept = nullptr) {
  SpringProblem twin;
  twin.size = volume.size();
  twin.spacing_mm = volume.spacing_mm();
  twin.materials = std::move(materials);
  twin.fold = kCorners;
  twin.held.assign(static_cast<std::size_t>(voxel_count(twin.size)), 0);
  for_each_voxel(twin.size, [&](VoxelIndex v) {
    twin.ids.push_back(static_cast<MaterialId>(volume.value_at(v)));
    twin.start_voxels.push_back(start.displacement_voxels(v));
    if (kept) twin.plastic_voxels.push_back(kept->displacement_voxels(v));
    int removed = 0;
    for (int axis = 0; axis < 3; ++axis) removed |= int{cuts.removed(v, axis)} << axis;
    twin.removed.push_back(static_cast<std::uint8_t>(removed));
  });
  return twin;
}

// The same with what holds in relaxation, by the words of anchors.h.
inline SpringProblem relaxation_twin(const Volume& volume, const std::vector<Material>& materials,
                                     const Lattice& start, const Cuts& cuts, const ElementSet& held,
                                     AnchorRules anchors, const Lattice* kept = nullptr) {
  auto whole = materials;
  give_default_blends(whole);
  SpringProblem twin = spring_twin(volume, spring_materials(whole), start, cuts, kept);
  const int faces = anchors.faces != 0 ? anchors.faces : anchors.free_border ? 0 : 63;
  for_each_voxel(twin.size, [&](VoxelIndex v) {
    const auto i = static_cast<std::size_t>(linear_index(v, twin.size));
    twin.held[i] = held.contains(v, start.grid()) || materials[twin.ids[i]].fixed ||
                   (faces_of(v, twin.size) & faces) != 0 || cuts.carved(v);
  });
  return twin;
}

}  // namespace maille::testing
