// Small volumes and tables for the tests of this room.
#pragma once

#include <map>
#include <memory>
#include <random>
#include <vector>

#include "deform/chainmail.h"
#include "deform/deformer.h"

namespace maille::testing {

inline Material material(double value_low, double value_high, double compress, double stretch,
                         double shear, double stiffness = 1.0, bool fixed = false) {
  Material m;
  m.name = "m" + std::to_string(static_cast<int>(value_low));
  m.value_low = value_low;
  m.value_high = value_high;
  m.compress = glm::dvec3(compress);
  m.stretch = glm::dvec3(stretch);
  m.shear = glm::dvec3(shear);
  m.stiffness = stiffness;
  m.fixed = fixed;
  return m;
}

inline MaterialTable table(std::vector<Material> materials) {
  return std::move(MaterialTable::create(std::move(materials))).value();
}

inline Volume constant_volume(Size3 size, std::uint8_t value = 0,
                              glm::dvec3 spacing_mm = glm::dvec3(1)) {
  return Volume::of(size, VoxelType::uint8, axis_aligned(spacing_mm),
                    std::vector<std::uint8_t>(static_cast<std::size_t>(voxel_count(size)), value));
}

// Values 0 .. kinds-1, in blocks of the given edge.
inline Volume random_volume(Size3 size, int kinds, int block, unsigned seed,
                            glm::dvec3 spacing_mm = glm::dvec3(1)) {
  std::mt19937 random(seed);
  const Size3 blocks = (size + block - 1) / block;
  std::vector<std::uint8_t> of_block(static_cast<std::size_t>(voxel_count(blocks)));
  for (auto& v : of_block) v = static_cast<std::uint8_t>(random() % static_cast<unsigned>(kinds));
  std::vector<std::uint8_t> samples(static_cast<std::size_t>(voxel_count(size)));
  std::size_t i = 0;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x, ++i) {
        samples[i] =
            of_block[static_cast<std::size_t>(linear_index(VoxelIndex(x, y, z) / block, blocks))];
      }
    }
  }
  return Volume::of(size, VoxelType::uint8, axis_aligned(spacing_mm), std::move(samples));
}

// Workers of a number, made once: tests ask for one unless they compare numbers.
inline WorkerPool& workers(int count = 1) {
  static std::map<int, std::unique_ptr<WorkerPool>> pools;
  auto& pool = pools[count];
  if (!pool) pool = std::make_unique<WorkerPool>(count);
  return *pool;
}

inline ElementSet elements(const std::vector<VoxelIndex>& voxels, const BrickGrid& grid) {
  ElementSet set;
  for (const VoxelIndex v : voxels) set.insert(v, grid);
  return set;
}

// One drag without a Deformer.
struct Drag {
  const MaterialField& field;
  const Lattice& start;
  std::vector<VoxelIndex> handle;
  std::vector<VoxelIndex> pinned = {};
  AnchorRules anchors = {};
  Cuts cuts = {};
  int threads = 1;
  std::uint32_t brick_order = 0;

  ChainMailAnswer by(glm::ivec3 units) const {
    const BrickGrid& grid = start.grid();
    const Cuts whole(grid.volume_size());
    const ElementSet fixed = elements(pinned, grid);
    const ElementSet moved = elements(handle, grid);
    StrokeBricks bricks(field, cuts.grid().count() > 0 ? cuts : whole, fixed, anchors);
    return solve_chainmail({start, bricks, moved, brick_order}, units, workers(threads));
  }
};

inline bool equal(const Lattice& a, const Lattice& b) {
  const Size3 size = a.grid().volume_size();
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        if (a.u({x, y, z}) != b.u({x, y, z})) return false;
      }
    }
  }
  return true;
}

}  // namespace maille::testing
