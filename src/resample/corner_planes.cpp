#include "resample/corner_planes.h"

#include "resample/brick_set.h"

#include <limits>

namespace maille {
namespace {

constexpr float kVoxelsFromUnits = 1.0f / kUnitsPerVoxel;

}  // namespace

CornerPlanes::CornerPlanes(const Lattice& lattice, const Cuts* cuts, const VoxelBox& cells,
                           glm::ivec3 origin)
    : lattice_(lattice), cells_(cells), origin_(origin), width_(cells.size().x + 1) {
  const auto height = static_cast<std::size_t>(cells.size().y + 1);
  for (auto& plane : planes_) {
    plane.corners.resize(static_cast<std::size_t>(width_) * height);
    plane.rows.resize(height);
  }
  if (cuts) cut_rows_.emplace(*cuts, cells);
  if (cut_rows_ && !cut_rows_->any()) cut_rows_.reset();
  fill(cells.lo.z);
}

void CornerPlanes::fill(int z) {
  Plane& plane = planes_[static_cast<std::size_t>(z & 1)];
  Float4* out = plane.corners.data();
  for (int y = cells_.lo.y; y <= cells_.hi.y; ++y, out += width_) {
    plane.rows[static_cast<std::size_t>(y - cells_.lo.y)] = fill_row(out, y, z);
  }
}

CornerRow CornerPlanes::fill_row(Float4* out, int y, int z) const {
  const BrickGrid& grid = lattice_.grid();
  const Size3 size = grid.volume_size();
  const VoxelIndex row_element{0, std::clamp(y, 0, size.y - 1), std::clamp(z, 0, size.z - 1)};
  const float rest_y = rest_coordinate(y, size.y) - static_cast<float>(origin_.y);
  const float rest_z = rest_coordinate(z, size.z) - static_cast<float>(origin_.z);
  constexpr float kFar = std::numeric_limits<float>::max();
  CornerRow row{out, splat(kFar), splat(-kFar), width_, -1};
  for (int x = cells_.lo.x; x <= cells_.hi.x;) {
    // One stretch of corners whose elements lie in one brick.
    const VoxelIndex first{std::clamp(x, 0, size.x - 1), row_element.y, row_element.z};
    const int end = std::min(cells_.hi.x + 1, x < 0         ? 0
                                              : x >= size.x ? x + 1
                                                            : std::min((x | 31) + 1, size.x));
    const LatticeBrick* brick = lattice_.brick(grid.linear(BrickGrid::brick_of(first)));
    std::int32_t u[3][kBrickEdge];
    if (brick) {
      const int count = x < 0 ? 1 : end - x;
      for (int c = 0; c < 3; ++c) brick->read_row(c, element_in_brick(first), count, u[c]);
    }
    int in_row = 0;
    for (; x < end; ++x, ++in_row) {
      const float rest_x = rest_coordinate(x, size.x) - static_cast<float>(origin_.x);
      Float4 corner{rest_x, rest_y, rest_z, 0.0f};
      if (brick) {
        const std::int32_t ux = u[0][in_row];
        const std::int32_t uy = u[1][in_row];
        const std::int32_t uz = u[2][in_row];
        if ((ux | uy | uz) != 0) {
          corner +=
              Float4{static_cast<float>(ux), static_cast<float>(uy), static_cast<float>(uz), 0.0f} *
              splat(kVoxelsFromUnits);
          corner[3] = 1.0f;
          row.last_moved = x - cells_.lo.x;
          row.first_moved = std::min(row.first_moved, row.last_moved);
        }
      }
      row.lowest = least(row.lowest, corner);
      row.highest = greatest(row.highest, corner);
      out[x - cells_.lo.x] = corner;
    }
  }
  return row;
}

std::vector<std::int64_t> bricks_with_moved_cells(const Lattice& lattice) {
  const BrickGrid& grid = lattice.grid();
  BrickSet touched(grid);
  lattice.for_each_brick([&](std::int64_t b, const LatticeBrick&) {
    const VoxelBox box = grid.box(grid.brick(b));
    touched.add_over({glm::max(box.lo - 1, VoxelIndex(0)), box.hi});
  });
  return touched.list();
}

}  // namespace maille
