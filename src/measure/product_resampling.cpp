#include "measure/product_resampling.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "core/stopwatch.h"

namespace maille {
namespace {

std::size_t place_of(std::int64_t brick) {
  return static_cast<std::size_t>(brick) * static_cast<std::size_t>(kBrickVoxels);
}

// Values that lie brick by brick, voxel by voxel.
template <class T>
std::vector<T> by_voxel(const BrickGrid& grid, std::span<const T> bricks) {
  const Size3 size = grid.volume_size();
  std::vector<T> voxels(static_cast<std::size_t>(voxel_count(size)));
  for (std::int64_t b = 0; b < grid.count(); ++b) {
    const VoxelBox box = grid.box(grid.brick(b));
    const T* row = &bricks[place_of(b)];
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y, row += box.size().x) {
        std::copy_n(row, box.size().x,
                    &voxels[static_cast<std::size_t>(linear_index({box.lo.x, y, z}, size))]);
      }
    }
  }
  return voxels;
}

}  // namespace

ProductResampling::ProductResampling(Volume volume, Lattice lattice)
    : volume_(std::move(volume)),
      lattice_(std::move(lattice)),
      bricks_(static_cast<std::size_t>(lattice_.grid().count())),
      bricks_shown_(place_of(lattice_.grid().count()), kBackground) {
  std::iota(bricks_.begin(), bricks_.end(), 0);
}

void ProductResampling::skip_empty_bricks() {
  std::erase_if(bricks_, [&](std::int64_t b) {
    const auto count = voxel_count(lattice_.grid().box(lattice_.grid().brick(b)).size());
    const float* const first = &bricks_shown_[place_of(b)];
    return std::all_of(first, first + count, [](float shown) { return shown == kBackground; });
  });
}

double ProductResampling::run(ResampleMethod method, WorkerPool& pool) {
  const Stopwatch clock;
  const Resampler resampler(volume_, lattice_, Cuts(volume_.size()), method, kBackground);
  pool.for_each(static_cast<std::int64_t>(bricks_.size()), [&](std::int64_t i, int) {
    const std::int64_t b = bricks_[static_cast<std::size_t>(i)];
    const auto count =
        static_cast<std::size_t>(voxel_count(lattice_.grid().box(lattice_.grid().brick(b)).size()));
    resampler.resample(
        b, std::as_writable_bytes(std::span(bricks_shown_).subspan(place_of(b), count)), false);
  });
  return clock.seconds();
}

std::vector<float> ProductResampling::shown() const {
  std::vector<float> voxels = by_voxel<float>(lattice_.grid(), bricks_shown_);
  std::replace(voxels.begin(), voxels.end(), kBackground, std::numeric_limits<float>::quiet_NaN());
  return voxels;
}

std::vector<glm::vec3> ProductResampling::rest_positions(WorkerPool& pool) const {
  const BrickGrid& grid = lattice_.grid();
  std::vector<glm::vec3> bricks(place_of(grid.count()));
  const Resampler resampler(volume_, lattice_, Cuts(volume_.size()), ResampleMethod::linear,
                            kBackground);
  pool.for_each(grid.count(), [&](std::int64_t b, int) {
    resampler.rest_positions(
        b, std::span(bricks).subspan(place_of(b), static_cast<std::size_t>(kBrickVoxels)));
  });
  return by_voxel<glm::vec3>(grid, bricks);
}

}  // namespace maille
