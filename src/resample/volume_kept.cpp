#include "resample/volume_kept.h"

#include <cmath>
#include <limits>

#include "resample/corner_planes.h"

namespace maille {
namespace {

glm::dvec3 xyz(Float4 v) { return {double{v[0]}, double{v[1]}, double{v[2]}}; }

// The map's determinant is of degree two in each coordinate: two Gauss points along each are exact.
double volume_of(const DeformedCell& cell) {
  const double kGauss[2] = {0.5 - std::sqrt(1.0 / 12.0), 0.5 + std::sqrt(1.0 / 12.0)};
  double sum = 0.0;
  for (int point = 0; point < 8; ++point) {
    const glm::dvec3 t(kGauss[point & 1], kGauss[(point >> 1) & 1], kGauss[point >> 2]);
    glm::dmat3 x_from_t(0.0);
    for (int corner = 0; corner < 8; ++corner) {
      glm::dvec3 weight;
      glm::dvec3 slope;
      for (int axis = 0; axis < 3; ++axis) {
        const bool high = (corner >> axis) & 1;
        weight[axis] = high ? t[axis] : 1.0 - t[axis];
        slope[axis] = high ? 1.0 : -1.0;
      }
      const glm::dvec3 x = xyz(cell.corner[static_cast<std::size_t>(corner)]);
      x_from_t[0] += slope.x * weight.y * weight.z * x;
      x_from_t[1] += weight.x * slope.y * weight.z * x;
      x_from_t[2] += weight.x * weight.y * slope.z * x;
    }
    sum += glm::determinant(x_from_t);
  }
  return sum / 8.0;
}

struct Sums {
  std::int64_t cells = 0;
  double volume = 0.0;
  double squares = 0.0;
};

}  // namespace

std::vector<VolumeKept> volume_kept(const Lattice& lattice, const Cuts& cuts,
                                    const MaterialField& materials, WorkerPool& pool) {
  const BrickGrid& grid = lattice.grid();
  const auto levels = static_cast<std::size_t>(materials.table().count());
  const std::vector<std::int64_t> bricks = bricks_with_moved_cells(lattice);
  const Cuts* const cuts_or_null = cuts.empty() ? nullptr : &cuts;
  std::vector<std::vector<Sums>> by_brick(bricks.size());
  pool.for_each(static_cast<std::int64_t>(bricks.size()), [&](std::int64_t i, int) {
    auto& sums = by_brick[static_cast<std::size_t>(i)];
    sums.resize(levels + 1);
    const VoxelBox box = grid.box(grid.brick(bricks[static_cast<std::size_t>(i)]));
    const VoxelBox cells{box.lo, glm::min(box.hi, grid.volume_size() - 1)};
    if (cells.empty()) return;
    const VoxelBox corners{cells.lo, cells.hi + 1};
    std::vector<MaterialId> ids(static_cast<std::size_t>(voxel_count(corners.size())));
    const std::optional<MaterialId> one = materials.read(corners, ids);
    const auto level_at = [&](VoxelIndex at) -> std::size_t {
      if (one) return *one;
      return ids[static_cast<std::size_t>(linear_index(at - corners.lo, corners.size()))];
    };
    constexpr float kFar = std::numeric_limits<float>::max();
    for_each_moved_cell(lattice, cuts_or_null, cells, box.lo, glm::vec3(-kFar), glm::vec3(kFar),
                        [&](const DeformedCell& cell, VoxelIndex base, Float4, Float4) {
                          std::size_t level = level_at(base);
                          for (int corner = 1; corner < 8 && level != levels; ++corner) {
                            const VoxelIndex at =
                                base + VoxelIndex(corner & 1, (corner >> 1) & 1, corner >> 2);
                            if (level_at(at) != level) level = levels;
                          }
                          const double volume = volume_of(cell);
                          Sums& to = sums[level];
                          ++to.cells;
                          to.volume += volume;
                          to.squares += (volume - 1.0) * (volume - 1.0);
                        });
  });
  std::vector<VolumeKept> kept(levels + 1);
  for (std::size_t level = 0; level <= levels; ++level) {
    Sums total;
    for (const auto& sums : by_brick) {
      total.cells += sums[level].cells;
      total.volume += sums[level].volume;
      total.squares += sums[level].squares;
    }
    if (total.cells == 0) continue;
    const auto cells = static_cast<double>(total.cells);
    kept[level] = {total.cells, total.volume / cells, std::sqrt(total.squares / cells)};
  }
  return kept;
}

VolumeKept sum_of(const std::vector<VolumeKept>& parts) {
  VolumeKept all;
  double volume = 0.0;
  double squares = 0.0;
  for (const VolumeKept& part : parts) {
    const auto cells = static_cast<double>(part.cells);
    all.cells += part.cells;
    volume += part.ratio * cells;
    squares += part.change_rms * part.change_rms * cells;
  }
  if (all.cells == 0) return all;
  const auto cells = static_cast<double>(all.cells);
  return {all.cells, volume / cells, std::sqrt(squares / cells)};
}

}  // namespace maille
