#include "resample/image_order.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <optional>

#include "resample/gaussian_mean.h"
#include "resample/nearest_search.h"
#include "resample/neighbour_rows.h"
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
  ByNearest(const Resampling& resampling, const RestMarch& march, NearestSearch& nearest)
      : values_(resampling.volume.voxels<T>()),
        size_(resampling.size()),
        tile_(march.tile()),
        nearest_(nearest) {}

  void operator()(RowSampler& sampler, const Float4* rest, VoxelIndex voxel, int count, T* row) {
    sampler.locate(rest, count);
    const VoxelIndex first = tile_.elements().lo;
    const glm::vec3 now(voxel - first - tile_.common_voxels());
    NearestSearch::Found found[kBrickEdge + 1];
    nearest_.find(Float4{now.x, now.y, now.z, 0.0f}, rest, count, sampler.among(count), found);
    for (int x = 0; x < count; ++x) {
      const auto& e = found[x].element;
      if (sampler.is_among(x))
        row[x] = value_at(values_, first + VoxelIndex(e[0], e[1], e[2]), size_);
    }
  }

 private:
  std::span<const T> values_;
  Size3 size_;
  const DisplacementTile& tile_;
  NearestSearch& nearest_;
};

// Kept by thread, as the tile is.
template <class T>
const NeighbourRows& neighbour_rows_of(const Resampling& resampling, const DisplacementTile& tile) {
  static thread_local NeighbourRows rows;
  rows.fill(tile, resampling.volume.voxels<T>(), resampling.size());
  return rows;
}

// The means around the nearest.
template <class T>
class ByMean {
 public:
  ByMean(const Resampling& resampling, const RestMarch& march, NearestSearch& nearest)
      : tile_(march.tile()), nearest_(nearest), rows_(neighbour_rows_of<T>(resampling, tile_)) {}

  void operator()(RowSampler& sampler, const Float4* rest, VoxelIndex voxel, int count, T* row) {
    sampler.locate(rest, count);
    const VoxelIndex first = tile_.elements().lo;
    const glm::vec3 now(voxel - first - tile_.common_voxels());
    NearestSearch::Found found[kBrickEdge + 1];
    nearest_.find(Float4{now.x, now.y, now.z, 0.0f}, rest, count, sampler.among(count), found);
    for (int x = 0; x < count; ++x) {
      const Float4 here{now.x + static_cast<float>(x), now.y, now.z, 0.0f};
      const auto& e = found[x].element;
      rows_.take(VoxelIndex(e[0], e[1], e[2]), here, mean_, x);
    }
    mean_.compute(count);
    for (int x = 0; x < count; ++x) row[x] = stored_float<T>(mean_.mean(x));
  }

 private:
  const DisplacementTile& tile_;
  NearestSearch& nearest_;
  const NeighbourRows& rows_;
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
      last = around;
      around =
          std::max(around, NearestSearch::around_voxels(march->injection(), deformed.spacing_mm));
    }
    nearest.emplace(march->tile(), march->injection(), deformed.spacing_mm,
                    voxel_count(voxels.size()));
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
