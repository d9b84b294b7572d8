// How well a deformation keeps volume: springs along edges and face diagonals resist its change
// only as well as such springs can, so it is measured and said.
#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "deform/cuts.h"
#include "deform/lattice.h"
#include "material/material_field.h"

namespace maille {

// Of moved, uncut cells; a cell's volume is that of its trilinear map, 1 at rest.
struct VolumeKept {
  std::int64_t cells = 0;
  double ratio = 1.0;       // all their volume by all it was at rest
  double change_rms = 0.0;  // of a cell's volume less 1
};

// By the material level of a cell's eight elements; last, those of cells where they differ.
std::vector<VolumeKept> volume_kept(const Lattice& lattice, const Cuts& cuts,
                                    const MaterialField& materials, WorkerPool& pool);
// Of the cells of all of them.
VolumeKept sum_of(const std::vector<VolumeKept>& parts);

}  // namespace maille
