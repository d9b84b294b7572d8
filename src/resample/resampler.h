// From moved elements to voxels: what value does each voxel of a brick show?
//
// Image order where it is known to have one answer for each voxel (image_order.h): Newton from what
// the neighbours found. Else, beside cuts and folds, object order (object_order.h): every deformed
// cell (the box between 8 neighbouring elements) finds the voxels it covers, so nothing inside the
// deformed volume is left unfilled. Newton from a neighbour's answer would pick a branch by
// continuity at folds, and the paper's walk from voxel to voxel finds "more than 99 %". Where
// several cells cover a voxel the one whose element lies nearest wins, ties to the lower element
// index.
//
// The volume reaches half a voxel beyond its border elements; a voxel that no cell covers gets the
// background value. An element at rest owns its voxel: untouched volume comes back bit for bit.
// Where links are removed or elements carved the same holds: material ends half a voxel beyond its
// last element, and nothing is interpolated across (cut_cell.h).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "deform/cuts.h"
#include "deform/lattice.h"
#include "resample/reach.h"
#include "resample/resample_counts.h"
#include "resample/resample_method.h"
#include "volume/volume.h"

namespace maille {

class Resampler {
 public:
  // Shares the bricks of the lattice and the cuts; the volume is cheap to copy.
  Resampler(Volume volume, Lattice lattice, Cuts cuts, ResampleMethod method,
            double background_value);
  ~Resampler();
  Resampler(Resampler&&) noexcept;

  // Fills a box of voxels (x fastest, tightly packed) in the volume's own type. They may lie beyond
  // the volume, where material may have got to; all within one brick of the grid that goes on
  // there. flip_sign_bit stores signed integers offset, as unsigned textures want them. out is
  // written once, in order, and not read here. Any thread.
  ResampleCounts resample(const VoxelBox& voxels, std::span<std::byte> out,
                          bool flip_sign_bit) const;
  // The same for those voxels of a brick that are in the volume.
  ResampleCounts resample(std::int64_t brick, std::span<std::byte> out, bool flip_sign_bit) const;

  // Rest position (voxel space) of every voxel: the inverse map. NaN where nothing is.
  void rest_positions(const VoxelBox& voxels, std::span<glm::vec3> out) const;
  void rest_positions(std::int64_t brick, std::span<glm::vec3> out) const;

  // The smallest box, or nearly, around the volume and all that has been moved out of it.
  VoxelBox extent() const;
  const Volume& volume() const;

  // Rest position of a point of the deformed volume. nullopt: outside of it.
  std::optional<glm::dvec3> rest_position(glm::dvec3 point_voxel) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Cells of the lattice with a corner turned inside out. A cut cell holds nothing that could fold.
std::int64_t count_folded_cells(const Lattice& lattice, const Cuts& cuts, WorkerPool& pool);

// Calls f for the parts of a box of voxels that lie in one brick each: of the volume's, or of the
// grid as it goes on beyond it.
void for_each_brick(const VoxelBox& extent, WorkerPool& pool,
                    const std::function<void(const VoxelBox& voxels, int worker)>& f);

// Where a box of a volume's voxels lies in the world.
glm::dmat4 world_from_voxel_of(const Volume& volume, const VoxelBox& extent);

// The deformed volume in a box of voxels, for saving: its first voxel is the box's lowest.
Volume resample_volume(const Resampler& resampler, const VoxelBox& extent, WorkerPool& pool,
                       ResampleCounts& counts);

}  // namespace maille
