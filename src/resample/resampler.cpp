#include "resample/resampler.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include <glm/gtc/matrix_transform.hpp>

#include "core/stopwatch.h"
#include "core/trace.h"
#include "resample/claims.h"
#include "resample/corner_planes.h"
#include "resample/image_order.h"
#include "resample/object_order.h"
#include "resample/rest_finder.h"
#include "resample/rest_march.h"
#include "resample/resting_elements.h"
#include "resample/row_sampler.h"
#include "resample/row_writer.h"

namespace maille {
namespace {

// Image order over a box of voxels where it can, else over its eighths, and what is left of them
// when they are small in object order: a fold or a cut slows down its surroundings only.
template <class ImageOrder, class ObjectOrder>
void in_parts(const VoxelBox& voxels, ImageOrder&& image_order, ObjectOrder&& object_order) {
  if (voxels.empty() || image_order(voxels)) return;
  const glm::ivec3 extent = voxels.size();
  if (std::max({extent.x, extent.y, extent.z}) <= kSmallestPart) {
    object_order(voxels);
    return;
  }
  for (int part = 0; part < 8; ++part) {
    VoxelBox eighth = voxels;
    for (int c = 0; c < 3; ++c) {
      const int half =
          extent[c] > kSmallestPart ? voxels.lo[c] + (extent[c] + 1) / 2 : voxels.hi[c];
      if ((part >> c & 1) != 0) {
        eighth.lo[c] = half;
      } else {
        eighth.hi[c] = half;
      }
    }
    in_parts(eighth, image_order, object_order);
  }
}

// Calls f(box) for what lies in one box and not in another one in it, in up to six parts.
template <class F>
void for_each_outside(VoxelBox of, const VoxelBox& inner, F&& f) {
  if (inner.empty()) return f(of);
  for (int c = 2; c >= 0; --c) {
    VoxelBox below = of;
    VoxelBox above = of;
    below.hi[c] = of.lo[c] = inner.lo[c];
    above.lo[c] = of.hi[c] = inner.hi[c];
    if (!below.empty()) f(below);
    if (!above.empty()) f(above);
  }
}

// Values of one brick, before they go where they are written to once and in order.
std::byte* brick_of_this_thread() {
  static thread_local std::vector<std::byte> brick(kBrickVoxels * sizeof(float));
  return brick.data();
}

}  // namespace

struct Resampler::State : Resampling {
  using Resampling::Resampling;

  // By how many whole voxels all that is shown is displaced, where it is that simple.
  std::optional<glm::ivec3> copied_from(const Sight& sight, const VoxelBox& voxels) const {
    const bool untouched = inside(voxels) && !deformed.moved_at(voxels.lo) &&
                           sight.coverable(voxels).empty() && !sight.cut(voxels);
    if (untouched) return glm::ivec3(0);
    // What is moved as a whole would be smoothed as a whole.
    if (method == ResampleMethod::rbf) return std::nullopt;
    return sight.whole_shift(voxels);
  }
  bool inside(const VoxelBox& voxels) const {
    return intersection(voxels, {VoxelIndex(0), size()}) == voxels;
  }
  ResampleCounts copy(const VoxelBox& voxels, glm::ivec3 shift, std::span<std::byte> out,
                      bool flip_sign_bit) const;
  // Of voxels that no moved cell can cover.
  void keep(const VoxelBox& voxels, const VoxelTarget& target, ResampleCounts& counts) const;
};

Resampler::Resampler(Volume volume, Lattice lattice, Cuts cuts, ResampleMethod method,
                     double background_value)
    : state_(std::make_unique<State>(std::move(volume), std::move(lattice), std::move(cuts), method,
                                     background_value)) {}
Resampler::~Resampler() = default;
Resampler::Resampler(Resampler&&) noexcept = default;

// By whole voxels.
ResampleCounts Resampler::State::copy(const VoxelBox& voxels, glm::ivec3 shift,
                                      std::span<std::byte> out, bool flip_sign_bit) const {
  ResampleCounts counts;
  counts.voxels = voxel_count(voxels.size());
  if (shift != glm::ivec3(0)) counts.moved_voxels = counts.voxels;
  // Voxels that something of the volume lies in now.
  const VoxelBox filled = intersection({shift, size() + shift}, voxels);
  const int count = filled.empty() ? 0 : filled.size().x;
  counts.background_voxels = counts.voxels - (count == 0 ? 0 : voxel_count(filled.size()));
  if (!deformed.border_moved && inside(voxels)) counts.unfilled_voxels = counts.background_voxels;
  with_voxel_type(volume.type(), [&]<class T>() {
    const auto samples = volume.voxels<T>();
    const int width = voxels.size().x;
    RowWriter<T> writer(out, flip_sign_bit);
    T row[kBrickEdge];
    for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
      for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
        const bool any =
            count > 0 && z >= filled.lo.z && z < filled.hi.z && y >= filled.lo.y && y < filled.hi.y;
        if (any && count == width) {
          writer.write(&value_at(samples, VoxelIndex(voxels.lo.x, y, z) - shift, size()), width);
          continue;
        }
        std::fill_n(row, width, stored<T>(background_value));
        if (any) {
          std::copy_n(&value_at(samples, VoxelIndex(filled.lo.x, y, z) - shift, size()), count,
                      row + (filled.lo.x - voxels.lo.x));
        }
        writer.write(row, width);
      }
    }
  });
  return counts;
}

void Resampler::State::keep(const VoxelBox& voxels, const VoxelTarget& target,
                            ResampleCounts& counts) const {
  const RestingElements resting(deformed, voxels);
  const CutBrick* const cuts = deformed.cuts_at(voxels.lo);
  with_voxel_type(volume.type(), [&]<class T>() {
    const auto at_rest = volume.voxels<T>();
    const T background = stored<T>(background_value);
    for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
      for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
        const std::uint32_t owned = resting.row(y, z);
        for (int x = voxels.lo.x; x < voxels.hi.x; ++x) {
          const VoxelIndex voxel(x, y, z);
          const bool own = (owned >> (x - voxels.lo.x) & 1) != 0;
          *target.at<T>(voxel) = own ? value_at(at_rest, voxel, size()) : background;
          counts.moved_voxels += !own;
          counts.background_voxels += !own;
          const bool by_cut = cuts && deformed.cuts.carved(voxel);
          counts.unfilled_voxels += !own && !by_cut && must_be_filled(voxel);
        }
      }
    }
  });
}

ResampleCounts Resampler::resample(const VoxelBox& voxels, std::span<std::byte> out,
                                   bool flip_sign_bit) const {
  const State& state = *state_;
  const Sight sight(state.deformed, voxels);
  if (const auto shift = state.copied_from(sight, voxels)) {
    return state.copy(voxels, *shift, out, flip_sign_bit);
  }
  ResampleCounts counts;
  counts.voxels = voxel_count(voxels.size());
  const VoxelTarget target{voxels, brick_of_this_thread()};
  const VoxelBox coverable = sight.coverable(voxels);
  for_each_outside(voxels, coverable,
                   [&](const VoxelBox& part) { state.keep(part, target, counts); });
  in_parts(
      coverable,
      [&](const VoxelBox& part) {
        if (sight.coverable(part).empty()) {
          state.keep(part, target, counts);
          return true;
        }
        return resample_in_image_order(state, sight, part, target, counts);
      },
      [&](const VoxelBox& part) { resample_in_object_order(state, sight, part, target, counts); });
  with_voxel_type(state.volume.type(), [&]<class T>() {
    RowWriter<T> writer(out, flip_sign_bit);
    const T* row = target.at<T>(voxels.lo);
    const int width = voxels.size().x;
    const T* const end = row + counts.voxels;
    for (; row != end; row += width) writer.write(row, width);
  });
  return counts;
}

ResampleCounts Resampler::resample(std::int64_t brick, std::span<std::byte> out,
                                   bool flip_sign_bit) const {
  const BrickGrid& grid = state_->deformed.lattice.grid();
  return resample(grid.box(grid.brick(brick)), out, flip_sign_bit);
}

void Resampler::rest_positions(std::int64_t brick, std::span<glm::vec3> out) const {
  const DeformedVolume& deformed = state_->deformed;
  const BrickGrid& grid = deformed.lattice.grid();
  rest_positions(grid.box(grid.brick(brick)), out);
}

void Resampler::rest_positions(const VoxelBox& voxels, std::span<glm::vec3> out) const {
  const DeformedVolume& deformed = state_->deformed;
  const Sight sight(deformed, voxels);
  const auto row_of = [&](const VoxelBox& part, std::int64_t row) {
    const VoxelIndex first = part.lo + VoxelIndex(0, row % part.size().y, row / part.size().y);
    return out.begin() + linear_index(first - voxels.lo, voxels.size());
  };
  const auto by_claims = [&](const VoxelBox& part) {
    static thread_local BrickClaims claims;
    claims.open(deformed, part);
    find_rest(sight, part, claims);
    const int width = part.size().x;
    for (std::int64_t row = 0; row < voxel_count(part.size()) / width; ++row) {
      std::copy_n(claims.rest.begin() + row * width, width, row_of(part, row));
    }
  };
  in_parts(
      voxels,
      [&](const VoxelBox& part) {
        if (sight.coverable(part).empty()) {  // no one claims what does not rest
          by_claims(part);
          return true;
        }
        auto march = march_through(sight, part);
        if (!march) return false;
        const VoxelIndex first = march->tile().elements().lo;
        RowSampler sampler(state_->size(), march->tile().elements());
        const int width = part.size().x;
        for (std::int64_t row = 0; row < voxel_count(part.size()) / width; ++row) {
          sampler.locate(march->next_row(), width);
          const auto to = row_of(part, row);
          for (int x = 0; x < width; ++x) {
            to[x] = sampler.is_among(x) ? glm::vec3(first) + sampler.position(x)
                                        : glm::vec3(std::numeric_limits<float>::quiet_NaN());
          }
        }
        return true;
      },
      by_claims);
}

std::optional<glm::dvec3> Resampler::rest_position(glm::dvec3 point_voxel) const {
  return rest_position_of(state_->deformed, point_voxel);
}

std::int64_t count_folded_cells(const Lattice& lattice, const Cuts& cuts, WorkerPool& pool) {
  const BrickGrid& grid = lattice.grid();
  const std::vector<std::int64_t> bricks = bricks_with_moved_cells(lattice);
  const Cuts* const cuts_or_null = cuts.empty() ? nullptr : &cuts;
  std::vector<std::int64_t> folded(bricks.size(), 0);
  pool.for_each(static_cast<std::int64_t>(bricks.size()), [&](std::int64_t i, int) {
    const VoxelBox box = grid.box(grid.brick(bricks[static_cast<std::size_t>(i)]));
    const VoxelBox cells{box.lo, glm::min(box.hi, grid.volume_size() - 1)};
    constexpr float kFar = std::numeric_limits<float>::max();
    for_each_moved_cell(lattice, cuts_or_null, cells, box.lo, glm::vec3(-kFar), glm::vec3(kFar),
                        [&](const DeformedCell& cell, VoxelIndex, Float4, Float4) {
                          folded[static_cast<std::size_t>(i)] += cell.folded();
                        });
  });
  std::int64_t sum = 0;
  for (const std::int64_t f : folded) sum += f;
  return sum;
}

VoxelBox Resampler::extent() const {
  VoxelBox extent{VoxelIndex(0), state_->size()};
  for (const DeformedVolume::Entry& entry : state_->deformed.entries) {
    if (intersection(entry.cover.roughly(), extent) == entry.cover.roughly()) continue;
    extent = united(extent, entry.cover.closely());
  }
  return extent;
}

Volume resample_volume(const Resampler& resampler, const VoxelBox& extent, WorkerPool& pool,
                       ResampleCounts& counts) {
  const trace::Span span("resample volume");
  const Volume& volume = resampler.volume();
  const std::size_t voxel_bytes = bytes_per_voxel(volume.type());
  auto samples = std::make_shared<std::vector<std::byte>>(
      static_cast<std::size_t>(voxel_count(extent.size())) * voxel_bytes);
  std::vector<ResampleCounts> by_worker(static_cast<std::size_t>(pool.thread_count()));
  for_each_brick(extent, pool, [&](const VoxelBox& box, int worker) {
    const Stopwatch start;
    std::vector<std::byte> brick(kBrickVoxels * voxel_bytes);
    auto brick_counts = resampler.resample(box, brick, false);
    const std::size_t row = static_cast<std::size_t>(box.size().x) * voxel_bytes;
    const std::byte* from = brick.data();
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y, from += row) {
        const VoxelIndex first = VoxelIndex(box.lo.x, y, z) - extent.lo;
        const auto at = static_cast<std::size_t>(linear_index(first, extent.size()));
        std::memcpy(samples->data() + at * voxel_bytes, from, row);
      }
    }
    brick_counts.timed(start.seconds());
    by_worker[static_cast<std::size_t>(worker)] += brick_counts;
  });
  for (const ResampleCounts& c : by_worker) counts += c;
  const std::span<const std::byte> bytes(*samples);
  return Volume(extent.size(), volume.type(), world_from_voxel_of(volume, extent), bytes,
                std::move(samples));
}

glm::dmat4 world_from_voxel_of(const Volume& volume, const VoxelBox& extent) {
  return glm::translate(volume.world_from_voxel(), glm::dvec3(extent.lo));
}

void for_each_brick(const VoxelBox& extent, WorkerPool& pool,
                    const std::function<void(const VoxelBox& voxels, int worker)>& f) {
  const BrickIndex first = BrickGrid::brick_of(extent.lo);
  const glm::ivec3 bricks = BrickGrid::brick_of(extent.hi - 1) - first + 1;
  pool.for_each(voxel_count(bricks), [&](std::int64_t i, int worker) {
    const VoxelIndex lo = (first + voxel_index(i, bricks)) * kBrickEdge;
    f(intersection({lo, lo + kBrickEdge}, extent), worker);
  });
}

const Volume& Resampler::volume() const { return state_->volume; }

}  // namespace maille
