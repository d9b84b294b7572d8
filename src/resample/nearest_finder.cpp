#include "resample/nearest_finder.h"

#include <algorithm>
#include <cmath>

#include "resample/corner_planes.h"
#include "resample/rest_finder.h"

namespace maille {
namespace {

// Whether a voxel's element is still sought.
bool is_sought(const BrickClaims& claims, std::size_t i) {
  const bool claimed =
      claims.score[i] != BrickClaims::kOwned && claims.score[i] != BrickClaims::kUncovered;
  return claimed && (claims.cut.empty() || (claims.cut[i] & BrickClaims::in_octant) == 0);
}

// Offers elements to the voxels of a box, each to those nearer to it than what they have.
class Offer {
 public:
  Offer(const DeformedVolume& volume, const VoxelBox& box, float reach_mm, BrickClaims& claims)
      : volume_(volume),
        box_(box),
        claims_(claims),
        reach_mm_(reach_mm),
        spacing_{volume.spacing_mm.x, volume.spacing_mm.y, volume.spacing_mm.z, 0.0f} {}

  void elements_of(const VoxelBox& cells) {
    const VoxelBox corners =
        intersection({cells.lo, cells.hi + 1}, {VoxelIndex(0), VoxelIndex(volume_.size())});
    if (corners.empty()) return;
    CornerPlanes planes(volume_.lattice, nullptr, cells, box_.lo);
    for (int z = cells.lo.z; z < cells.hi.z; ++z) {
      planes.advance_to(z);
      if (z >= 0) rows_of(planes, cells, corners, z);
    }
    if (corners.hi.z == cells.hi.z + 1) rows_of(planes, cells, corners, cells.hi.z);
  }

 private:
  void rows_of(const CornerPlanes& planes, const VoxelBox& cells, const VoxelBox& corners, int z) {
    for (int y = corners.lo.y; y < corners.hi.y; ++y) {
      const CornerRow& row = planes.row(y, z);
      if (misses(row)) continue;
      std::int64_t element = linear_index({corners.lo.x, y, z}, volume_.size());
      for (int x = corners.lo.x; x < corners.hi.x; ++x, ++element) {
        const Float4 at = row.corners[x - cells.lo.x];
        if (volume_.any_cut && volume_.cuts.carved({x, y, z})) continue;
        offer(at, element);
      }
    }
  }

  // Whether no voxel of the box is within reach of a row's bounds.
  bool misses(const CornerRow& row) const {
    for (int c = 0; c < 3; ++c) {
      const float reach = reach_mm_ / spacing_[c];
      if (row.highest[c] + reach < 0.0f) return true;
      if (row.lowest[c] - reach > static_cast<float>(box_.size()[c] - 1)) return true;
    }
    return false;
  }

  void offer(Float4 position, std::int64_t element) {
    const glm::ivec3 extent = box_.size();
    glm::ivec3 first, last;
    for (int c = 0; c < 3; ++c) {
      const float reach = reach_mm_ / spacing_[c];
      const float low = std::max(position[c] - reach, 0.0f);
      const float high = std::min(position[c] + reach, static_cast<float>(extent[c] - 1));
      if (!(low <= high)) return;
      first[c] = static_cast<int>(std::ceil(low));
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
          if (!is_sought(claims_, i)) continue;
          claims_.score[i] = score;
          claims_.element[i] = element;
        }
      }
    }
  }

  const DeformedVolume& volume_;
  const VoxelBox box_;
  BrickClaims& claims_;
  float reach_mm_;
  Float4 spacing_;
};

}  // namespace

void find_nearest(const Sight& sight, const VoxelBox& box, BrickClaims& claims) {
  const DeformedVolume& volume = sight.volume();
  find_rest(sight, box, claims);
  float furthest = 0.0f;
  for (std::size_t i = 0; i < claims.score.size(); ++i) {
    if (is_sought(claims, i)) furthest = std::max(furthest, claims.score[i]);
  }
  if (furthest == 0.0f) return;
  // What floats may leave out.
  const float reach_mm = std::sqrt(furthest) * 1.0001f;
  VoxelBox around = box;
  for (int c = 0; c < 3; ++c) {
    const int reach = static_cast<int>(reach_mm / volume.spacing_mm[c]) + 1;
    around.lo[c] -= reach;
    around.hi[c] += reach;
  }
  Offer offer(volume, box, reach_mm, claims);
  const Sight wider(volume, around);
  wider.for_each_cells_over(around,
                            [&](const VoxelBox& cells, const auto&) { offer.elements_of(cells); });
}

}  // namespace maille
