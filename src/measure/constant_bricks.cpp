#include "measure/constant_bricks.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "core/stopwatch.h"
#include "measure/product_resampling.h"
#include "measure/resample_scene.h"

namespace maille {

double ConstantBricks::gb_per_s() const {
  return 1e-9 * static_cast<double>(bytes) / resampled.median_seconds;
}

double ConstantBricks::copy_gb_per_s() const {
  return 1e-9 * static_cast<double>(bytes) / copied.median_seconds;
}

double ConstantBricks::rows_gb_per_s() const {
  return 1e-9 * static_cast<double>(bytes) / copied_by_rows.median_seconds;
}

double ConstantBricks::share_of_copy() const {
  return copied.median_seconds / resampled.median_seconds;
}

double ConstantBricks::share_of_rows() const {
  return copied_by_rows.median_seconds / resampled.median_seconds;
}

ConstantBricks measure_constant_bricks(int edge, int runs, WorkerPool& pool) {
  const Size3 size(edge);
  std::vector<float> samples(static_cast<std::size_t>(voxel_count(size)));
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<float>(i % 1021);
  const Volume volume =
      Volume::of(size, VoxelType::float32, axis_aligned(glm::dvec3(1)), std::move(samples));
  const std::span<const std::byte> from = volume.bytes();
  const Lattice lattice = lattice_of(whole_shift_scene("constant", "", {5, -3, 2}), size, pool);
  const BrickGrid& grid = lattice.grid();
  ProductResampling resampling(volume, lattice);

  constexpr std::size_t kPiece = kBrickVoxels * sizeof(float);
  std::vector<std::byte> to(static_cast<std::size_t>(grid.count()) * kPiece);
  const auto pieces = static_cast<std::int64_t>((from.size() + kPiece - 1) / kPiece);
  std::vector<double> resampled, copied, copied_by_rows;
  for (int run = 0; run < runs; ++run) {
    resampled.push_back(resampling.run(ResampleMethod::linear, pool));
    const Stopwatch clock;
    pool.for_each(pieces, [&](std::int64_t piece, int) {
      const std::size_t at = static_cast<std::size_t>(piece) * kPiece;
      std::memcpy(&to[at], &from[at], std::min(kPiece, from.size() - at));
    });
    copied.push_back(clock.seconds());
    const Stopwatch rows_clock;
    pool.for_each(grid.count(), [&](std::int64_t b, int) {
      const VoxelBox box = grid.box(grid.brick(b));
      const std::size_t row = static_cast<std::size_t>(box.size().x) * sizeof(float);
      std::byte* at = &to[static_cast<std::size_t>(b) * kPiece];
      for (int z = box.lo.z; z < box.hi.z; ++z) {
        for (int y = box.lo.y; y < box.hi.y; ++y, at += row) {
          const auto first = static_cast<std::size_t>(linear_index({box.lo.x, y, z}, size));
          std::memcpy(at, &from[first * sizeof(float)], row);
        }
      }
    });
    copied_by_rows.push_back(rows_clock.seconds());
  }
  return {pool.thread_count(), 2 * static_cast<std::int64_t>(from.size()), timing_of(resampled),
          timing_of(copied), timing_of(copied_by_rows)};
}

}  // namespace maille
