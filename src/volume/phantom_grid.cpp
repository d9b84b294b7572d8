#include "volume/phantom_grid.h"

namespace maille {

PhantomGrid::PhantomGrid(Size3 voxels, glm::dvec3 lowest, glm::dvec3 highest)
    : size(voxels),
      spacing((highest - lowest) / glm::dvec3(voxels)),
      origin(lowest + 0.5 * spacing) {}

float PhantomGrid::edge_width() const {
  return static_cast<float>(3.0 / 3.0 * (spacing.x + spacing.y + spacing.z));
}

void for_each_block(
    const PhantomGrid& grid, WorkerPool& pool,
    const std::function<void(const PointBlock& block, VoxelIndex first, int worker)>& f) {
  constexpr int n = PointBlock::kEdge;
  const Size3 blocks = (grid.size + (n - 1)) / n;
  pool.for_each(std::int64_t{blocks.y} * blocks.z, [&](std::int64_t row, int worker) {
    VoxelIndex first(0, static_cast<int>(row % blocks.y) * n, static_cast<int>(row / blocks.y) * n);
    for (; first.x < grid.size.x; first.x += n) {
      f(PointBlock(grid.position(glm::dvec3(first)), grid.spacing), first, worker);
    }
  });
}

float smooth_noise(glm::vec3 p, std::uint64_t seed) {
  // A shift keeps positions positive, where conversion to an integer is the floor.
  constexpr float kShift = 4096.0f;
  const glm::vec3 shifted = p + kShift;
  const VoxelIndex cell(shifted);
  glm::vec3 t = shifted - glm::vec3(cell);
  t = t * t * (3.0f - 2.0f * t);
  const auto corner = [&](int x, int y, int z) {
    return static_cast<float>(voxel_hash(cell + VoxelIndex(x, y, z), seed) >> 8) *
           (1.0f / 16777216.0f);
  };
  const auto edge = [&](int y, int z) { return mix(corner(0, y, z), corner(1, y, z), t.x); };
  return mix(mix(edge(0, 0), edge(1, 0), t.y), mix(edge(0, 1), edge(1, 1), t.y), t.z);
}

}  // namespace maille
