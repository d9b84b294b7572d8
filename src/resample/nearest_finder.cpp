#include "resample/nearest_finder.h"

#include <algorithm>
#include <cmath>

#include "resample/corner_planes.h"
#include "resample/rest_finder.h"

namespace maille {
namespace {

// Squared half diagonals (mm) of the bounds of one plane of cells, rows of width size.x. 0 where no
// corner has moved: elements at rest own their voxels and have no one else to find.
class CellPlane {
 public:
  void compute(const CornerPlanes& planes, const VoxelBox& cells, int z, Float4 spacing_mm) {
    clear(cells);
    for (int y = cells.lo.y; y < cells.hi.y; ++y) {
      float* out = row(y - cells.lo.y);
      // A cut cell's bounds span the gap: its voxels are found by its octants.
      CellRow(planes, y, z, width_).for_each_whole([&](int x, Float4 lowest, Float4 highest) {
        const Float4 extent_mm = (highest - lowest) * spacing_mm;
        const Float4 squared = extent_mm * extent_mm;
        out[x] = highest[3] > 0.0f ? 0.25f * (squared[0] + squared[1] + squared[2]) : 0.0f;
      });
    }
  }
  void clear(const VoxelBox& cells) {
    width_ = cells.size().x;
    reach_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(cells.size().y),
                  0.0f);
  }
  float* row(int y) { return reach_.data() + static_cast<std::ptrdiff_t>(y) * width_; }

 private:
  int width_ = 0;
  std::vector<float> reach_;
};

// The elements of one entry, offered to the voxels of a box.
class Offer {
 public:
  Offer(const DeformedVolume& volume, const VoxelBox& box, BrickClaims& claims)
      : volume_(volume),
        box_(box),
        claims_(claims),
        spacing_{volume.spacing_mm.x, volume.spacing_mm.y, volume.spacing_mm.z, 0.0f} {}

  void elements_of(VoxelBox cells) {
    // Elements on the rim need the cells on both sides to know how far they reach.
    const Size3 size = volume_.size();
    cells = intersection({cells.lo - 1, cells.hi + 1}, {VoxelIndex(-1), VoxelIndex(size)});
    if (cells.empty()) return;
    CornerPlanes planes(volume_.lattice, volume_.cuts_or_null(), cells, box_.lo);
    CellPlane below, here;
    below.clear(cells);
    for (int z = cells.lo.z; z < cells.hi.z; ++z) {
      planes.advance_to(z);
      here.compute(planes, cells, z, spacing_);
      if (z >= 0) plane_of_elements(planes, cells, below, here, z);
      std::swap(below, here);
    }
  }

 private:
  void plane_of_elements(const CornerPlanes& planes, const VoxelBox& cells, CellPlane& below,
                         CellPlane& above, int z) {
    const Size3 size = volume_.size();
    const int width = cells.size().x;
    reach_.resize(static_cast<std::size_t>(width) + 1);
    for (int y = std::max(cells.lo.y, 0); y < cells.hi.y; ++y) {
      const CornerRow& corners = planes.row(y, z);
      const float* around[4] = {below.row(y - cells.lo.y), above.row(y - cells.lo.y),
                                below.row(std::max(y - 1 - cells.lo.y, 0)),
                                above.row(std::max(y - 1 - cells.lo.y, 0))};
      float most = 0.0f;
      for (int x = 0; x < width; ++x) {
        reach_[static_cast<std::size_t>(x)] =
            std::max(std::max(around[0][x], around[1][x]), std::max(around[2][x], around[3][x]));
        most = std::max(most, reach_[static_cast<std::size_t>(x)]);
      }
      if (most == 0.0f || misses(corners, std::sqrt(most))) continue;
      const int x_begin = std::max(0, -cells.lo.x);
      std::int64_t element = linear_index({cells.lo.x + x_begin, y, z}, size);
      for (int x = x_begin; x < width; ++x, ++element) {
        const float squared = std::max(reach_[static_cast<std::size_t>(x)],
                                       reach_[static_cast<std::size_t>(std::max(x - 1, 0))]);
        if (squared > 0.0f) offer(corners.corners[x], element, squared);
      }
    }
  }

  // Whether no voxel of the box is within reach of a row's bounds.
  bool misses(const CornerRow& row, float reach_mm) const {
    for (int c = 0; c < 3; ++c) {
      const float reach = reach_mm / spacing_[c];
      if (row.highest[c] + reach < 0.0f) return true;
      if (row.lowest[c] - reach > static_cast<float>(box_.size()[c] - 1)) return true;
    }
    return false;
  }

  void offer(Float4 position, std::int64_t element, float reach_squared_mm) {
    const glm::ivec3 extent = box_.size();
    const float reach_mm = std::sqrt(reach_squared_mm);
    glm::ivec3 first, last;
    for (int c = 0; c < 3; ++c) {
      const float reach = reach_mm / spacing_[c];
      const float low = std::max(position[c] - reach, 0.0f);
      const float high = std::min(position[c] + reach, static_cast<float>(extent[c] - 1));
      if (!(low <= high)) return;
      first[c] = static_cast<int>(low);
      first[c] += static_cast<float>(first[c]) < low;
      last[c] = static_cast<int>(high);
    }
    for (int z = first.z; z <= last.z; ++z) {
      const float dz = (position[2] - static_cast<float>(z)) * spacing_[2];
      for (int y = first.y; y <= last.y; ++y) {
        const float dy = (position[1] - static_cast<float>(y)) * spacing_[1];
        const float across = dz * dz + dy * dy;
        auto i = static_cast<std::size_t>((z * extent.y + y) * extent.x + first.x);
        for (int x = first.x; x <= last.x; ++x, ++i) {
          const float dx = (position[0] - static_cast<float>(x)) * spacing_[0];
          const float score = dx * dx + across;
          if (score > claims_.score[i]) continue;
          if (score == claims_.score[i] && element >= claims_.element[i]) continue;
          claims_.score[i] = score;
          claims_.element[i] = element;
        }
      }
    }
  }

  const DeformedVolume& volume_;
  const VoxelBox box_;
  BrickClaims& claims_;
  Float4 spacing_;
  std::vector<float> reach_;
};

// An element of the border reaches as far outside as inside: what is nearest to one may lie outside
// of the deformed volume.
void drop_outside(const DeformedVolume& volume, const VoxelBox& box, BrickClaims& claims) {
  const Size3 size = volume.size();
  std::size_t i = 0;
  for (int z = box.lo.z; z < box.hi.z; ++z) {
    for (int y = box.lo.y; y < box.hi.y; ++y) {
      for (int x = box.lo.x; x < box.hi.x; ++x, ++i) {
        if (claims.score[i] < 0.0f || claims.score[i] == BrickClaims::kUncovered) continue;
        const VoxelIndex element = voxel_index(claims.element[i], size);
        const bool border = glm::any(glm::equal(element, VoxelIndex(0))) ||
                            glm::any(glm::equal(element, VoxelIndex(size - 1)));
        if (border &&
            !covered_beside(volume, element, box.lo, glm::vec3(VoxelIndex(x, y, z) - box.lo))) {
          claims.score[i] = BrickClaims::kUncovered;
        }
      }
    }
  }
}

// Kept by thread, as the claims it corrects.
BrickClaims& covered_of_this_thread() {
  static thread_local BrickClaims claims;
  return claims;
}

// Corrects what distance alone says where cut cells are.
void keep_to_sides(const Sight& sight, const VoxelBox& box, BrickClaims& claims) {
  BrickClaims& covered = covered_of_this_thread();
  covered.open(sight.volume(), box);
  find_rest(sight, box, covered);
  for (std::size_t i = 0; i < static_cast<std::size_t>(voxel_count(box.size())); ++i) {
    if (covered.cut[i] == 0 || covered.score[i] == BrickClaims::kOwned) continue;
    const bool by_cells = claims.score[i] == BrickClaims::kUncovered ||
                          covered.score[i] == BrickClaims::kUncovered ||
                          (covered.cut[i] & BrickClaims::in_octant) != 0;
    if (!by_cells) continue;
    claims.score[i] = covered.score[i];
    claims.element[i] = covered.element[i];
  }
  std::swap(claims.cut, covered.cut);
}

}  // namespace

void find_nearest(const Sight& sight, const VoxelBox& box, BrickClaims& claims) {
  const DeformedVolume& volume = sight.volume();
  bool border_claims = false;
  Offer offer(volume, box, claims);
  sight.for_each_cells_over(box, [&](const VoxelBox& cells, const DeformedVolume::Entry& entry) {
    border_claims = border_claims || entry.at_border;
    offer.elements_of(cells);
  });
  if (border_claims) drop_outside(volume, box, claims);
  if (sight.cut(box)) keep_to_sides(sight, box, claims);
}

}  // namespace maille
