// A small scene that relaxes, and the same one for the reference.
#pragma once

#include <cmath>
#include <vector>

#include "deform/relaxation.h"
#include "tests/deform/lattices.h"
#include "tests/deform/scenes.h"
#include "tests/deform/spring_twin.h"

namespace maille::testing {

inline constexpr AnchorRules kFree{0, true};

// How springs take a material: limits as wide as no test minds.
inline Material springy(double value, double stiffness, double blend = 0.25) {
  Material m = material(value, value + 1, 0.0, 100.0, 100.0, stiffness);
  m.rest_vector_blend = blend;
  return m;
}

struct RelaxationScene {
  Volume volume;
  std::vector<Material> materials;
  MaterialField field;
  Lattice start;
  Lattice kept;  // by material that has yielded
  Cuts cuts;
  ElementSet held;
  ElementSet released;  // held until what yields has flown
  AnchorRules anchors = kFree;

  RelaxationScene(Volume volume_of, std::vector<Material> materials_of)
      : volume(std::move(volume_of)),
        materials(std::move(materials_of)),
        field(volume, table(materials)),
        start(volume.size()),
        kept(volume.size()),
        cuts(volume.size()) {}
  RelaxationScene(const RelaxationScene&) = delete;  // a relaxation reads its field

  Size3 size() const { return volume.size(); }

  Relaxation relaxation(WorkerPool& pool, const RelaxationOptions& options = {}) const {
    return Relaxation(start, field, cuts, held, anchors, pool, options, std::nullopt,
                      {kept, released});
  }
  SpringProblem twin() const {
    return relaxation_twin(volume, materials, start, cuts, held, anchors, &kept);
  }

  // u(voxel): displacement in voxels.
  template <class F>
  void displace(F&& u) {
    start = lattice_by(u);
  }
  template <class F>
  void keep(F&& u) {
    kept = lattice_by(u);
  }
  template <class F>
  Lattice lattice_by(F&& u) const {
    std::vector<glm::ivec3> fixed_point;
    for_each_voxel(size(), [&](VoxelIndex v) {
      fixed_point.emplace_back(glm::round(u(v) * double{kUnitsPerVoxel}));
    });
    return lattice_of(size(), fixed_point);
  }
  template <class F>
  void hold(F&& whether) {
    for_each_voxel(size(), [&](VoxelIndex v) {
      if (whether(v)) held.insert(v, start.grid());
    });
  }
};

inline const RelaxationProgress& run(Relaxation& relaxation, int most_iterations) {
  while (!relaxation.progress().finished() && relaxation.progress().iterations < most_iterations) {
    relaxation.iterate();
  }
  return relaxation.progress();
}

struct Distance {
  double rms = 0.0;  // over the free elements
  double largest = 0.0;
};
inline Distance distance_of(const DisplacementField& a, const DisplacementField& b,
                            const std::vector<std::uint8_t>& held) {
  Distance d;
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (held[i]) continue;
    const double away = glm::length(a[i] - b[i]);
    sum += away * away;
    count += 1.0;
    d.largest = std::max(d.largest, away);
  }
  d.rms = std::sqrt(sum / std::max(1.0, count));
  return d;
}

inline DisplacementField displacements_of(const Lattice& lattice) {
  DisplacementField u;
  for_each_voxel(lattice.grid().volume_size(),
                 [&](VoxelIndex v) { u.push_back(lattice.displacement_voxels(v)); });
  return u;
}

}  // namespace maille::testing
