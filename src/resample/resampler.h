// From moved elements to voxels: what value does each voxel of a brick show?
//
// Image order where it is known to have one answer for each voxel (rest_march.h, nearest_search.h):
// Newton from what the neighbours found. Else, beside cuts and folds, object order: every deformed
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

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "deform/cuts.h"
#include "deform/lattice.h"
#include "resample/reach.h"
#include "volume/volume.h"

namespace maille {

enum class ResampleMethod {
  nearest,  // the value of the element that lies nearest (in mm): labels, masks
  linear,   // the inverse of the cell's trilinear map, then trilinear in the rest volume
};

struct ResampleCounts {
  std::int64_t voxels = 0;
  std::int64_t moved_voxels = 0;       // not owned by an element at rest
  std::int64_t background_voxels = 0;  // covered by no cell
  // Of these, left open though no element of the volume's border has moved, so that nothing can
  // have left the volume, and neither a cut nor carving can have opened them: above 0 there is a
  // bug.
  std::int64_t unfilled_voxels = 0;
  // Known where each brick was timed: a brick in which nothing moved is a copy.
  std::int64_t copied_voxels = 0;
  double copy_seconds = 0.0;      // of one worker after the other
  double resample_seconds = 0.0;  // the same, of all other bricks

  // Says what one brick took, to the counts of this brick alone.
  void timed(double seconds);
  ResampleCounts& operator+=(const ResampleCounts& other);
};

class Resampler {
 public:
  // Shares the bricks of the lattice and the cuts; the volume is cheap to copy.
  Resampler(Volume volume, Lattice lattice, Cuts cuts, ResampleMethod method,
            double background_value);
  ~Resampler();
  Resampler(Resampler&&) noexcept;

  // Fills the voxels of a brick (those in the volume, x fastest, tightly packed) in the volume's
  // own type. flip_sign_bit stores signed integers offset, as unsigned textures want them. out is
  // written once, in order, and not read here. Any thread.
  ResampleCounts resample(std::int64_t brick, std::span<std::byte> out, bool flip_sign_bit) const;

  // Rest position (voxel space) of every voxel of a brick: the inverse map. NaN where nothing is.
  void rest_positions(std::int64_t brick, std::span<glm::vec3> out) const;

  // Rest position of a point of the deformed volume. nullopt: outside of it.
  std::optional<glm::dvec3> rest_position(glm::dvec3 point_voxel) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Cells of the lattice with a corner turned inside out. A cut cell holds nothing that could fold.
std::int64_t count_folded_cells(const Lattice& lattice, const Cuts& cuts, WorkerPool& pool);

// The whole deformed volume, for saving.
Volume resample_volume(const Volume& volume, const Lattice& lattice, const Cuts& cuts,
                       ResampleMethod method, double background_value, WorkerPool& pool,
                       ResampleCounts& counts);

}  // namespace maille
