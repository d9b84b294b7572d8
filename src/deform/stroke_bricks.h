// What a stroke reads of each brick it reaches: materials, cuts and what is held. It does not
// change while the button is down, and a stroke comes back to the same bricks at every position of
// the pointer, so it is gathered once, when first asked for.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "deform/anchors.h"
#include "deform/cuts.h"
#include "material/material_field.h"
#include "volume/brick.h"

namespace maille {

struct StrokeBrick {
  // A bit an element, bit x of row z * 32 + y.
  using Rows = std::array<std::uint32_t, kBrickEdge * kBrickEdge>;

  std::int64_t linear = 0;
  BrickIndex index{0};
  VoxelBox box;   // the brick's voxels in the volume
  VoxelBox halo;  // and one around them

  std::optional<MaterialId> uniform;  // the one material of all of the halo
  std::vector<MaterialId> ids;        // else that of each of its voxels, x fastest

  std::unique_ptr<Rows> held;  // elements that must not move; null: none

  MaterialId id(VoxelIndex voxel) const { return uniform ? *uniform : *row(voxel); }
  // The ids from a voxel on, along x; not of a uniform brick.
  const MaterialId* row(VoxelIndex voxel) const {
    return &ids[static_cast<std::size_t>(linear_index(voxel - halo.lo, halo.size()))];
  }
};

class StrokeBricks {
 public:
  // What it is given must outlive it and stay as it is. pinned: fixed besides faces and materials.
  StrokeBricks(const MaterialField& materials, const Cuts& cuts, const ElementSet& pinned,
               AnchorRules anchors);

  const MaterialTable& table() const { return materials_.table(); }
  const BrickGrid& grid() const { return grid_; }
  const Cuts& cuts() const { return cuts_; }

  // For several threads at once, as long as they ask for different bricks. The reference stays
  // valid.
  const StrokeBrick& of(std::int64_t linear);

  std::int64_t bytes() const;

 private:
  std::unique_ptr<StrokeBrick> gather(std::int64_t linear) const;
  std::unique_ptr<StrokeBrick::Rows> held_in(const StrokeBrick& brick) const;

  const MaterialField& materials_;
  const Cuts& cuts_;
  const ElementSet& pinned_;
  AnchorRules anchors_;
  BrickGrid grid_;
  mutable std::mutex mutex_;  // of what follows
  std::unordered_map<std::int64_t, std::unique_ptr<const StrokeBrick>> bricks_;
};

}  // namespace maille
