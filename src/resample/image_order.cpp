#include "resample/image_order.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <optional>

#include "resample/gaussian_mean.h"
#include "resample/nearest_search.h"
#include "resample/rest_march.h"
#include "resample/row_sampler.h"
#include "resample/row_writer.h"

namespace maille {
namespace {

constexpr std::uint32_t first_bits(int count) {
  return static_cast<std::uint32_t>(~std::uint64_t{0} >> (64 - count));
}

// How a method makes the values of a row from where its voxels were at rest. Positions are counted
// from the tile's first element; `voxel` from the volume's.

template <class T>
class ByCell {
 public:
  explicit ByCell(const Resampling& resampling)
      : values_(resampling.volume.voxels<T>()), map_(resampling.deformed.cell_map) {}

  void operator()(RowSampler& sampler, const Float4* rest, VoxelIndex, int count, T* row) const {
    sampler.sample(values_, map_, rest, count);
    for (int x = 0; x < count; ++x) row[x] = stored_float<T>(sampler.value(x));
  }

 private:
  std::span<const T> values_;
  CellMap map_;
};

template <class T>
class ByNearest {
 public:
  ByNearest(const Resampling& resampling, const RestMarch& march, const NearestSearch& nearest)
      : values_(resampling.volume.voxels<T>()),
        size_(resampling.size()),
        tile_(march.tile()),
        nearest_(nearest) {}

  void operator()(RowSampler& sampler, const Float4* rest, VoxelIndex voxel, int count,
                  T* row) const {
    sampler.locate(rest, count);
    const VoxelIndex first = tile_.elements().lo;
    const glm::vec3 now(voxel - first - tile_.common_voxels());
    for (int x = 0; x < count; ++x) {
      if (!sampler.is_among(x)) continue;
      const Float4 here{now.x + static_cast<float>(x), now.y, now.z, 0.0f};
      row[x] = value_at(values_, first + nearest_(here, rest[x]), size_);
    }
  }

 private:
  std::span<const T> values_;
  Size3 size_;
  const DisplacementTile& tile_;
  const NearestSearch& nearest_;
};

// The means around the nearest.
template <class T>
class ByMean {
 public:
  ByMean(const Resampling& resampling, const RestMarch& march, const NearestSearch& nearest)
      : values_(resampling.volume.voxels<T>()),
        size_(resampling.size()),
        tile_(march.tile()),
        nearest_(nearest) {}

  void operator()(RowSampler& sampler, const Float4* rest, VoxelIndex voxel, int count, T* row) {
    sampler.locate(rest, count);
    const VoxelIndex first = tile_.elements().lo;
    const glm::vec3 now(voxel - first - tile_.common_voxels());
    for (int x = 0; x < count; ++x) {
      const Float4 here{now.x + static_cast<float>(x), now.y, now.z, 0.0f};
      // What lies beyond is not asked for; the first of all stands in for it.
      const VoxelIndex element = sampler.is_among(x) ? nearest_(here, rest[x]) : VoxelIndex(0);
      take_neighbours(element, here, x);
    }
    mean_.compute(count, GaussianMean::kMost);
    for (int x = 0; x < count; ++x) row[x] = stored_float<T>(mean_.value(x));
  }

 private:
  void take_neighbours(VoxelIndex element, Float4 here, int x) {
    const VoxelIndex last = tile_.elements().size() - 1;
    constexpr Float4 kNoSpareLane{1.0f, 1.0f, 1.0f, 0.0f};
    int k = 0;
    for (int z = element.z - 1; z <= element.z + 1; ++z) {
      for (int y = element.y - 1; y <= element.y + 1; ++y, k += 3) {
        const bool row_there = z >= 0 && z <= last.z && y >= 0 && y <= last.y;
        if (!row_there) {
          for (int i = 0; i < 3; ++i) mean_.set(x, k + i, kNowhere, 0.0f);
          continue;
        }
        const int before = std::max(element.x - 1, 0);
        const int after = std::min(element.x + 1, last.x);
        const Float4* const u = tile_.row(y, z);
        const T* const values =
            &value_at(values_, tile_.elements().lo + VoxelIndex(0, y, z), size_);
        const Float4 from = Float4{static_cast<float>(element.x), static_cast<float>(y),
                                   static_cast<float>(z), 0.0f} -
                            here;
        constexpr Float4 kNext{1.0f, 0.0f, 0.0f, 0.0f};
        const Float4 a = (u[before] + (from - kNext)) * kNoSpareLane;
        const Float4 b = (u[element.x] + from) * kNoSpareLane;
        const Float4 c = (u[after] + (from + kNext)) * kNoSpareLane;
        const Float4 squared = quads::sums<1>(a * a, b * b, c * c, Float4{});
        mean_.set(x, k, before < element.x ? squared[0] : kNowhere,
                  static_cast<float>(values[before]));
        mean_.set(x, k + 1, squared[1], static_cast<float>(values[element.x]));
        mean_.set(x, k + 2, after > element.x ? squared[2] : kNowhere,
                  static_cast<float>(values[after]));
      }
    }
  }

  static constexpr float kNowhere = std::numeric_limits<float>::infinity();
  std::span<const T> values_;
  Size3 size_;
  const DisplacementTile& tile_;
  const NearestSearch& nearest_;
  GaussianMean mean_;
};

// Bit x: voxel x of a row is that of an element at rest. Nothing near is carved.
std::uint32_t resting(const DisplacementTile& tile, VoxelIndex voxel, int count) {
  const VoxelIndex first = voxel - tile.elements().lo;
  if (first.y < 0 || first.y >= tile.height() || first.z < 0 || first.z >= tile.depth()) return 0;
  const Float4* const u = tile.row(first.y, first.z) + first.x;
  const int end = std::min(count, tile.width() - first.x);
  std::uint32_t bits = 0;
  for (int x = std::max(0, -first.x); x < end; ++x) bits |= std::uint32_t{u[x][3] == 0.0f} << x;
  return bits;
}

template <class T, class Values>
void follow(const Resampling& resampling, RestMarch& march, const VoxelBox& voxels,
            const VoxelTarget& target, ResampleCounts& counts, Values&& values) {
  const auto at_rest = resampling.volume.voxels<T>();
  const T background = stored<T>(resampling.background_value);
  const int width = voxels.size().x;
  const std::uint32_t all = first_bits(width);
  const VoxelBox& elements = march.tile().elements();
  RowSampler sampler(resampling.size(), elements);
  for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
    for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
      const VoxelIndex first(voxels.lo.x, y, z);
      T* const row = target.at<T>(first);
      const Float4* const rest = march.next_row();
      const std::uint32_t owned = resting(march.tile(), first, width);
      counts.moved_voxels += width - std::popcount(owned);
      if (owned != all) values(sampler, rest, first, width, row);
      for (std::uint32_t left = owned; left != 0; left &= left - 1) {
        const int x = std::countr_zero(left);
        row[x] = value_at(at_rest, first + VoxelIndex(x, 0, 0), resampling.size());
      }
      if (owned == all || sampler.all_among()) continue;
      for (int x = 0; x < width; ++x) {
        if (sampler.is_among(x) || (owned >> x & 1) != 0) continue;
        row[x] = background;
        ++counts.background_voxels;
        counts.unfilled_voxels += resampling.must_be_filled(first + VoxelIndex(x, 0, 0));
      }
    }
  }
}

}  // namespace

bool resample_in_image_order(const Resampling& resampling, const Sight& sight,
                             const VoxelBox& voxels, const VoxelTarget& target,
                             ResampleCounts& counts) {
  const DeformedVolume& deformed = resampling.deformed;
  const bool by_nearest =
      resampling.method == ResampleMethod::nearest || resampling.method == ResampleMethod::rbf;
  std::optional<RestMarch> march;
  std::optional<NearestSearch> nearest;
  if (!by_nearest) {
    march = march_through(sight, voxels);
    if (!march) return false;
  } else {
    // What is nearest may have cells that hold none of the voxels.
    int around = NearestSearch::kUsuallyAround_voxels;
    for (int last = 0; around > last;) {
      if (around > Sight::kAround_voxels) return false;
      // The mean takes the neighbours of what was found too.
      const int more = resampling.method == ResampleMethod::rbf ? 1 : 0;
      march = march_through(sight, voxels, {around, more});
      if (!march) return false;
      nearest.emplace(march->tile(), march->injection(), deformed.spacing_mm);
      last = around;
      around = std::max(around, nearest->around_voxels());
    }
    // Bounds of a part are tighter, but its tile holds more that it shares with others; and where
    // material is squeezed many elements are near anyway.
    constexpr float kManyCandidates = 64.0f;
    const Size3 extent = voxels.size();
    const bool can_be_parted =
        std::max({extent.x, extent.y, extent.z}) > kSmallestPart &&
        voxel_count(march->tile().elements().size()) < 8 * voxel_count(extent);
    if (can_be_parted && nearest->candidates() > kManyCandidates) return false;
  }
  with_voxel_type(resampling.volume.type(), [&]<class T>() {
    const auto by = [&](auto&& values) {
      follow<T>(resampling, *march, voxels, target, counts, values);
    };
    switch (resampling.method) {
      case ResampleMethod::nearest: return by(ByNearest<T>(resampling, *march, *nearest));
      case ResampleMethod::linear:
      case ResampleMethod::barycentric: return by(ByCell<T>(resampling));
      case ResampleMethod::rbf: return by(ByMean<T>(resampling, *march, *nearest));
    }
  });
  return true;
}

}  // namespace maille
