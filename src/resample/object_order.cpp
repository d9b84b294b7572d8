#include "resample/object_order.h"

#include "resample/claims.h"
#include "resample/cut_value.h"
#include "resample/gaussian_mean.h"
#include "resample/nearest_finder.h"
#include "resample/rest_finder.h"
#include "resample/row_sampler.h"
#include "resample/row_writer.h"

namespace maille {
namespace {

// Kept by thread: a brick's worth is too much for the stack and too often needed for the heap.
BrickClaims& claims_of_this_thread() {
  static thread_local BrickClaims claims;
  return claims;
}

// What a claimed voxel gets where cells are whole: from rest positions, or from elements.
template <class T>
class ClaimedRow {
 public:
  ClaimedRow(const Resampling& resampling, const BrickClaims& claims)
      : resampling_(resampling),
        claims_(claims),
        values_(resampling.volume.voxels<T>()),
        // Claims may be of any element.
        sampler_(resampling.size(), {VoxelIndex(0), resampling.size()}) {}

  // The row of a box's claims that begins at one of them.
  void take(std::size_t first, VoxelIndex voxel, int count) {
    first_ = first;
    switch (resampling_.method) {
      case ResampleMethod::nearest: break;
      case ResampleMethod::linear:
      case ResampleMethod::barycentric:
        for (int x = 0; x < count; ++x) {
          const glm::vec3 at = claims_.rest[first + static_cast<std::size_t>(x)];
          rest_[x] = Float4{at.x, at.y, at.z, 0.0f};
        }
        sampler_.sample(values_, resampling_.deformed.cell_map, rest_, count);
        break;
      case ResampleMethod::rbf:
        for (int x = 0; x < count; ++x) take_neighbours(x, voxel + VoxelIndex(x, 0, 0));
        mean_.compute(count);
        break;
    }
  }

  T value(int x) const {
    const std::size_t i = first_ + static_cast<std::size_t>(x);
    const std::int64_t element = claims_.element[i];
    switch (resampling_.method) {
      case ResampleMethod::nearest: return values_[static_cast<std::size_t>(element)];
      case ResampleMethod::linear:
      case ResampleMethod::barycentric: break;
      case ResampleMethod::rbf: return stored_float<T>(mean_.mean(x));
    }
    if (!claims_.cut.empty() && (claims_.cut[i] & BrickClaims::in_octant) != 0) {
      const VoxelIndex own = voxel_index(element, resampling_.size());
      return stored<T>(value_in_octant(values_, resampling_.deformed.cuts, own, claims_.rest[i]));
    }
    return stored_float<T>(sampler_.value(x));
  }

 private:
  // Those that a removed link keeps apart from the element count no more than those that are not
  // there.
  void take_neighbours(int x, VoxelIndex voxel) {
    const float score = claims_.score[first_ + static_cast<std::size_t>(x)];
    const bool claimed = score != BrickClaims::kUncovered && score != BrickClaims::kOwned;
    const DeformedVolume& deformed = resampling_.deformed;
    const VoxelIndex element =
        claimed
            ? voxel_index(claims_.element[first_ + static_cast<std::size_t>(x)], deformed.size())
            : VoxelIndex(0);
    for (int k = 0; k < GaussianMean::kEach; ++k) {
      const glm::ivec3 step(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      const VoxelIndex other = element + step;
      if (!contains(deformed.size(), other) || !joined(element, step)) {
        mean_.set(x, k, GaussianMean::kNowhere, 0.0f);
        continue;
      }
      const glm::dvec3 away =
          glm::dvec3(other - voxel) + deformed.lattice.displacement_voxels(other);
      mean_.set(x, k, static_cast<float>(glm::dot(away, away)),
                static_cast<float>(value_at(values_, other, deformed.size())));
    }
  }

  bool joined(VoxelIndex element, glm::ivec3 step) const {
    if (!resampling_.deformed.any_cut || step == glm::ivec3(0)) return true;
    const CutCell cell(resampling_.deformed.cuts, element + glm::min(step, glm::ivec3(0)));
    unsigned corner = 0;
    unsigned axes = 0;
    for (int c = 0; c < 3; ++c) {
      corner |= static_cast<unsigned>(step[c] < 0) << c;
      axes |= static_cast<unsigned>(step[c] != 0) << c;
    }
    if (cell.carved(corner)) return false;
    return (cell.joined(corner, axes) >> (corner ^ axes) & 1u) != 0;
  }

  const Resampling& resampling_;
  const BrickClaims& claims_;
  std::span<const T> values_;
  RowSampler sampler_;
  GaussianMean mean_;
  Float4 rest_[kBrickEdge];
  std::size_t first_ = 0;
};

template <class T>
void write(const Resampling& resampling, const BrickClaims& claims, const VoxelBox& voxels,
           const VoxelTarget& target) {
  const auto at_rest = resampling.volume.voxels<T>();
  const T background = stored<T>(resampling.background_value);
  const int width = voxels.size().x;
  ClaimedRow<T> claimed(resampling, claims);
  std::size_t i = 0;
  for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
    for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
      const VoxelIndex first(voxels.lo.x, y, z);
      T* const row = target.at<T>(first);
      claimed.take(i, first, width);
      for (int x = 0; x < width; ++x, ++i) {
        if (claims.score[i] == BrickClaims::kOwned) {
          row[x] = value_at(at_rest, first + VoxelIndex(x, 0, 0), resampling.size());
        } else {
          row[x] = claims.score[i] == BrickClaims::kUncovered ? background : claimed.value(x);
        }
      }
    }
  }
}

}  // namespace

void resample_in_object_order(const Resampling& resampling, const Sight& sight,
                              const VoxelBox& voxels, const VoxelTarget& target,
                              ResampleCounts& counts) {
  const DeformedVolume& deformed = resampling.deformed;
  BrickClaims& claims = claims_of_this_thread();
  counts.moved_voxels += claims.open(deformed, voxels);
  const bool by_nearest =
      resampling.method == ResampleMethod::nearest || resampling.method == ResampleMethod::rbf;
  if (by_nearest) {
    find_nearest(sight, voxels, claims);
  } else {
    find_rest(sight, voxels, claims);
  }
  for (std::size_t i = 0; i < claims.score.size(); ++i) {
    if (claims.score[i] != BrickClaims::kUncovered) continue;
    ++counts.background_voxels;
    const bool by_cut = !claims.cut.empty() && claims.cut[i] != 0;
    const VoxelIndex voxel = voxels.lo + voxel_index(static_cast<std::int64_t>(i), voxels.size());
    counts.unfilled_voxels += !by_cut && resampling.must_be_filled(voxel);
  }
  with_voxel_type(resampling.volume.type(),
                  [&]<class T>() { write<T>(resampling, claims, voxels, target); });
}

}  // namespace maille
