#include "resample/cut_finder.h"

#include <algorithm>
#include <cmath>

#include "resample/cell_inverse.h"
#include "resample/corner_planes.h"
#include "resample/cut_cell.h"

namespace maille {
namespace {

VoxelBox voxels_within(Float4 lowest, Float4 highest, float slack, glm::ivec3 extent) {
  VoxelBox voxels;
  for (int c = 0; c < 3; ++c) {
    const auto end = static_cast<float>(extent[c]);
    voxels.lo[c] = static_cast<int>(std::clamp(std::ceil(lowest[c] - slack), 0.0f, end));
    voxels.hi[c] = static_cast<int>(std::clamp(std::floor(highest[c] + slack), -1.0f, end - 1)) + 1;
  }
  return voxels;
}

template <class F>
void for_each_voxel(const VoxelBox& voxels, glm::ivec3 extent, F&& f) {
  for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
    for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
      auto i = static_cast<std::size_t>((z * extent.y + y) * extent.x + voxels.lo.x);
      for (int x = voxels.lo.x; x < voxels.hi.x; ++x, ++i) f(i, glm::vec3(x, y, z));
    }
  }
}

// The octants of one cut cell as they lie now.
class Octants {
 public:
  Octants(const DeformedVolume& volume, const DeformedCell& cell, VoxelIndex base,
          glm::ivec3 origin)
      : cell_(cell), base_(base), volume_(volume), links_(volume.cuts, base) {
    for (int c = 0; c < 3; ++c) {
      const int size = volume.size()[c];
      const auto from = static_cast<float>(origin[c]);
      lower_[c] = rest_coordinate(base[c], size) - from;
      upper_[c] = rest_coordinate(base[c] + 1, size) - from;
    }
  }

  bool there(unsigned corner) const { return !links_.carved(corner); }

  // Turned as the cell is: lower end first along each axis.
  DeformedCell shape(unsigned corner) const {
    DeformedCell octant;
    for (unsigned i = 0; i < 8; ++i) octant.corner[i] = middle(corner, i ^ corner);
    return octant;
  }

  std::optional<Claim> claim(unsigned corner, const CellInverse& inverse, glm::vec3 point) const {
    std::optional<Claim> best;
    inverse.for_each_answer(point, kInside_cells, [&](glm::vec3 t) {
      if (beyond_end(corner, t)) return;
      const Claim claim = claim_at(corner, t, point);
      if (!best || claim.beats(best->score, best->element)) best = claim;
    });
    return best;
  }

 private:
  Claim claim_at(unsigned corner, glm::vec3 t, glm::vec3 point) const {
    unsigned own = corner;  // where the element is, if this corner stands in for it
    for (int c = 0; c < 3; ++c) {
      const bool upper = (corner >> c & 1) != 0;
      float& s = t[c];
      const float at_element = upper ? 1.0f : 0.0f;
      if (std::abs(s - at_element) < kOnElement_cells) s = at_element;
      if (base_[c] < 0) own |= 1u << c;
      if (base_[c] == volume_.size()[c] - 1) own &= ~(1u << c);
    }
    const glm::vec3 inside = glm::clamp(t, 0.0f, 1.0f);
    const glm::vec3 in_cell(0.5f * (inside.x + static_cast<float>(corner & 1)),
                            0.5f * (inside.y + static_cast<float>(corner >> 1 & 1)),
                            0.5f * (inside.z + static_cast<float>(corner >> 2)));
    return {score_of(cell_.corner[own], point, volume_),
            linear_index(links_.element(corner), volume_.size()),
            rest_in_cell(base_, in_cell, volume_.size())};
  }

  Float4 rest(unsigned corner) const {
    return Float4{corner & 1 ? upper_[0] : lower_[0], corner & 2 ? upper_[1] : lower_[1],
                  corner & 4 ? upper_[2] : lower_[2], 0.0f};
  }

  // Where the middle between a corner and its opposite along `axes` lies now.
  Float4 middle(unsigned corner, unsigned axes) const {
    Float4 moved{};
    int count = 0;
    for_each_corner(links_.joined(corner, axes), [&](unsigned k) {
      moved += cell_.corner[k] - rest(k);
      ++count;
    });
    return splat(0.5f) * (rest(corner) + rest(corner ^ axes)) +
           moved / splat(static_cast<float>(count));
  }

  // A point that misses the octant where its material ends: past a removed link, or past the
  // volume's border.
  bool beyond_end(unsigned corner, glm::vec3 t) const {
    for (int c = 0; c < 3; ++c) {
      const bool upper = (corner >> c & 1) != 0;
      const float from_element = upper ? 1.0f - t[c] : t[c];
      const bool ends_here = upper ? base_[c] == volume_.size()[c] - 1 : base_[c] < 0;
      if (from_element > 1.0f + kInside_cells && !links_.intact(corner, c)) return true;
      if (from_element < -kInside_cells && ends_here) return true;
    }
    return false;
  }

  const DeformedCell& cell_;
  VoxelIndex base_;
  const DeformedVolume& volume_;
  CutCell links_;
  Float4 lower_{}, upper_{};  // rest positions of the cell's ends
};

void claim_voxels_of(const Octants& octants, const VoxelBox& box, BrickClaims& claims,
                     ClaimPass pass) {
  const glm::ivec3 extent = box.size();
  for (unsigned corner = 0; corner < 8; ++corner) {
    if (!octants.there(corner)) continue;
    const DeformedCell shape = octants.shape(corner);
    Float4 lowest = shape.corner[0];
    Float4 highest = shape.corner[0];
    for (const Float4& at : shape.corner) {
      lowest = least(lowest, at);
      highest = greatest(highest, at);
    }
    std::optional<CellInverse> inverse;
    const VoxelBox voxels = voxels_within(lowest, highest, kBoundsSlack_voxels, extent);
    for_each_voxel(voxels, extent, [&](std::size_t i, glm::vec3 point) {
      if (!claims.is_open(i, pass)) return;
      if (!inverse) inverse.emplace(shape, CellMap::trilinear);
      const auto claim = octants.claim(corner, *inverse, point);
      if (claim && claims.take(i, *claim)) claims.cut[i] |= BrickClaims::in_octant;
    });
  }
}

}  // namespace

void claim_cut_voxels(const Sight& sight, const VoxelBox& box, BrickClaims& claims,
                      ClaimPass pass) {
  const DeformedVolume& volume = sight.volume();
  const glm::ivec3 extent = box.size();
  claims.cut.resize(claims.score.size(), 0);
  sight.for_each_cells_over(box, [&](const VoxelBox& cells, const DeformedVolume::Entry& entry) {
    if (!entry.cut) return;
    for_each_moved_cell<CellKind::cut>(
        volume.lattice, &volume.cuts, cells, box.lo, glm::vec3(-kBoundsSlack_voxels),
        glm::vec3(extent - 1) + kBoundsSlack_voxels,
        [&](const DeformedCell& cell, VoxelIndex base, Float4 lowest, Float4 highest) {
          for_each_voxel(
              voxels_within(lowest, highest, kBoundsSlack_voxels, extent), extent,
              [&](std::size_t i, glm::vec3) { claims.cut[i] |= BrickClaims::may_be_open; });
          claim_voxels_of(Octants(volume, cell, base, box.lo), box, claims, pass);
        });
  });
}

std::optional<Claim> cut_claim(const DeformedVolume& volume, const DeformedCell& cell,
                               VoxelIndex base, glm::ivec3 origin, glm::vec3 point) {
  const Octants octants(volume, cell, base, origin);
  std::optional<Claim> best;
  for (unsigned corner = 0; corner < 8; ++corner) {
    if (!octants.there(corner)) continue;
    const DeformedCell shape = octants.shape(corner);
    const CellInverse inverse(shape, CellMap::trilinear);
    const auto claim = octants.claim(corner, inverse, point);
    if (claim && (!best || claim->beats(best->score, best->element))) best = claim;
  }
  return best;
}

}  // namespace maille
