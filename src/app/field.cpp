#include "app/field.h"

#include <cmath>

#include "core/trace.h"

namespace maille {
namespace {

// Calls f(voxel, position of the voxel in the brick's packed box, position in the whole extent's).
template <class F>
void for_each_voxel(const VoxelBox& box, const VoxelBox& extent, F&& f) {
  std::size_t in_box = 0;
  for (int z = box.lo.z; z < box.hi.z; ++z) {
    for (int y = box.lo.y; y < box.hi.y; ++y) {
      auto in_extent = static_cast<std::size_t>(
          linear_index(VoxelIndex(box.lo.x, y, z) - extent.lo, extent.size()));
      for (int x = box.lo.x; x < box.hi.x; ++x) f(VoxelIndex{x, y, z}, in_box++, in_extent++);
    }
  }
}

}  // namespace

std::vector<glm::vec3> inverse_field_mm(const Resampler& resampler, const VoxelBox& extent,
                                        WorkerPool& pool) {
  const trace::Span span("inverse field");
  const glm::dmat3 mm_from_voxels(resampler.volume().world_from_voxel());
  std::vector<glm::vec3> field(static_cast<std::size_t>(voxel_count(extent.size())));
  std::vector<std::vector<glm::vec3>> scratch(static_cast<std::size_t>(pool.thread_count()));
  for_each_brick(extent, pool, [&](const VoxelBox& box, int worker) {
    auto& rest = scratch[static_cast<std::size_t>(worker)];
    rest.resize(static_cast<std::size_t>(voxel_count(box.size())));
    resampler.rest_positions(box, rest);
    for_each_voxel(box, extent, [&](VoxelIndex voxel, std::size_t i, std::size_t at) {
      if (std::isnan(rest[i].x)) return;
      field[at] = glm::vec3(mm_from_voxels * (glm::dvec3(rest[i]) - glm::dvec3(voxel)));
    });
  });
  return field;
}

std::vector<glm::vec3> forward_field_mm(const Volume& volume, const Lattice& lattice,
                                        WorkerPool& pool) {
  const trace::Span span("forward field");
  const BrickGrid& grid = lattice.grid();
  const glm::dmat3 mm_from_units =
      glm::dmat3(volume.world_from_voxel()) * (1.0 / double{kUnitsPerVoxel});
  std::vector<glm::vec3> field(static_cast<std::size_t>(voxel_count(volume.size())));
  pool.for_each(grid.count(), [&](std::int64_t index, int) {
    const LatticeBrick* const brick = lattice.brick(index);
    if (brick == nullptr) return;
    for_each_voxel(grid.box(grid.brick(index)), {VoxelIndex(0), volume.size()},
                   [&](VoxelIndex voxel, std::size_t, std::size_t at) {
                     const glm::dvec3 u(brick->u(element_in_brick(voxel)));
                     field[at] = glm::vec3(mm_from_units * u);
                   });
  });
  return field;
}

}  // namespace maille
