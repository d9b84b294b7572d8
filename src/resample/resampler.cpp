#include "resample/resampler.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/stopwatch.h"
#include "core/trace.h"
#include "resample/brick_set.h"
#include "resample/corner_planes.h"
#include "resample/cut_value.h"
#include "resample/nearest_finder.h"
#include "resample/nearest_search.h"
#include "resample/rest_finder.h"
#include "resample/rest_march.h"
#include "resample/row_sampler.h"
#include "resample/row_writer.h"

namespace maille {
namespace {

// Kept by thread: a brick's worth is too much for the stack and too often needed for the heap.
BrickClaims& claims_of_this_thread() {
  static thread_local BrickClaims claims;
  return claims;
}

}  // namespace

struct Resampler::State {
  Volume volume;
  DeformedVolume deformed;
  ResampleMethod method;
  double background_value;

  ResampleCounts copy(const VoxelBox& voxels, glm::ivec3 shift, std::span<std::byte> out,
                      bool flip_sign_bit) const;
  // Where each voxel has one answer; none: elsewhere.
  std::optional<ResampleCounts> march(std::int64_t brick, std::span<std::byte> out,
                                      bool flip_sign_bit) const;
  template <class Values>
  ResampleCounts follow(RestMarch& march, const VoxelBox& voxels, std::span<std::byte> out,
                        bool flip_sign_bit, Values&& values) const;
  ResampleCounts claim(std::int64_t brick, std::span<std::byte> out, bool flip_sign_bit) const;

  Size3 size() const { return volume.size(); }
  const auto& at(auto voxels, VoxelIndex voxel) const {
    return voxels[static_cast<std::size_t>(linear_index(voxel, size()))];
  }
  bool carved(std::int64_t brick) const {
    const CutBrick* cuts = deformed.cuts.brick(brick);
    return cuts && std::any_of(cuts->carved.begin(), cuts->carved.end(),
                               [](std::uint32_t bits) { return bits != 0; });
  }
  bool touched(std::int64_t brick) const {
    if (deformed.lattice.brick(brick) || carved(brick)) return true;
    const VoxelBox voxels = deformed.box(brick);
    return std::any_of(deformed.entries.begin(), deformed.entries.end(), [&](const auto& entry) {
      return !intersection(entry.covered, voxels).empty();
    });
  }
};

ResampleCounts& ResampleCounts::operator+=(const ResampleCounts& other) {
  voxels += other.voxels;
  moved_voxels += other.moved_voxels;
  background_voxels += other.background_voxels;
  unfilled_voxels += other.unfilled_voxels;
  copied_voxels += other.copied_voxels;
  copy_seconds += other.copy_seconds;
  resample_seconds += other.resample_seconds;
  return *this;
}

void ResampleCounts::timed(double seconds) {
  if (moved_voxels > 0) {
    resample_seconds = seconds;
  } else {
    copied_voxels = voxels;
    copy_seconds = seconds;
  }
}

Resampler::Resampler(Volume volume, Lattice lattice, Cuts cuts, ResampleMethod method,
                     double background_value) {
  DeformedVolume deformed(std::move(lattice), std::move(cuts), volume.spacing_mm());
  state_ = std::make_unique<State>(
      State{std::move(volume), std::move(deformed), method, background_value});
}

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
  if (!deformed.border_moved) counts.unfilled_voxels = counts.background_voxels;
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
          writer.write(&at(samples, VoxelIndex(voxels.lo.x, y, z) - shift), width);
          continue;
        }
        std::fill_n(row, width, stored<T>(background_value));
        if (any) {
          std::copy_n(&at(samples, VoxelIndex(filled.lo.x, y, z) - shift), count,
                      row + (filled.lo.x - voxels.lo.x));
        }
        writer.write(row, width);
      }
    }
  });
  return counts;
}

// Each voxel the value that `values` gives for where it was at rest; it is asked row by row.
template <class Values>
ResampleCounts Resampler::State::follow(RestMarch& march, const VoxelBox& voxels,
                                        std::span<std::byte> out, bool flip_sign_bit,
                                        Values&& values) const {
  const DisplacementTile& tile = march.tile();
  const VoxelIndex first = tile.elements().lo;
  const glm::vec3 at_rest(-tile.common_voxels());
  RowSampler sampler(size(), tile.elements());
  ResampleCounts counts;
  counts.voxels = voxel_count(voxels.size());
  with_voxel_type(volume.type(), [&]<class T>() {
    const auto samples = volume.voxels<T>();
    const T background = stored<T>(background_value);
    const int width = voxels.size().x;
    RowWriter<T> writer(out, flip_sign_bit);
    T row[kBrickEdge];
    for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
      for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
        const Float4* const rest = march.next_row();
        values(samples, sampler, rest, VoxelIndex(voxels.lo.x, y, z), row);
        const T* const own = &at(samples, {voxels.lo.x, y, z});
        const Float4* const u = tile.row(y - first.y, z - first.z) + (voxels.lo.x - first.x);
        for (int x = 0; x < width; ++x) {
          const bool moved = u[x][0] != at_rest.x || u[x][1] != at_rest.y || u[x][2] != at_rest.z;
          const bool filled = sampler.is_among(x);
          const T value = filled ? row[x] : background;
          row[x] = moved ? value : own[x];
          counts.moved_voxels += moved;
          counts.background_voxels += moved && !filled;
        }
        writer.write(row, width);
      }
    }
  });
  if (!deformed.border_moved) counts.unfilled_voxels = counts.background_voxels;
  return counts;
}

std::optional<ResampleCounts> Resampler::State::march(std::int64_t brick, std::span<std::byte> out,
                                                      bool flip_sign_bit) const {
  const VoxelBox box = deformed.box(brick);
  const int width = box.size().x;
  if (method == ResampleMethod::linear) {
    auto march = march_through(deformed, brick);
    if (!march) return std::nullopt;
    return follow(*march, box, out, flip_sign_bit,
                  [&]<class T>(std::span<const T> samples, RowSampler& sampler, const Float4* rest,
                               VoxelIndex, T* row) {
                    sampler.sample(samples, rest, width);
                    for (int x = 0; x < width; ++x) row[x] = stored_float<T>(sampler.value(x));
                  });
  }
  auto march = march_through(deformed, brick, NearestSearch::kMargin);
  if (!march) return std::nullopt;
  const NearestSearch nearest(march->tile(), march->injection(), deformed.spacing_mm);
  if (!nearest.within_margin()) return std::nullopt;
  const VoxelIndex first = march->tile().elements().lo;
  return follow(*march, box, out, flip_sign_bit,
                [&]<class T>(std::span<const T> samples, RowSampler& sampler, const Float4* rest,
                             VoxelIndex voxel, T* row) {
                  sampler.locate(rest, width);
                  const glm::vec3 now(voxel - first - march->tile().common_voxels());
                  for (int x = 0; x < width; ++x) {
                    if (!sampler.is_among(x)) continue;
                    const Float4 here{now.x + static_cast<float>(x), now.y, now.z, 0.0f};
                    row[x] = at(samples, first + nearest(here, rest[x]));
                  }
                });
}

ResampleCounts Resampler::State::claim(std::int64_t brick, std::span<std::byte> out,
                                       bool flip_sign_bit) const {
  const VoxelBox box = deformed.box(brick);
  const int width = box.size().x;
  const bool nearest = method == ResampleMethod::nearest;
  ResampleCounts counts;
  counts.voxels = voxel_count(box.size());
  BrickClaims& claims = claims_of_this_thread();
  counts.moved_voxels = claims.open(deformed, brick);
  if (nearest) {
    find_nearest(deformed, box, claims);
  } else {
    find_rest(deformed, box, claims);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(counts.voxels); ++i) {
    if (claims.score[i] != BrickClaims::kUncovered) continue;
    ++counts.background_voxels;
    const bool by_cut = !claims.cut.empty() && claims.cut[i] != 0;
    counts.unfilled_voxels += !by_cut && !deformed.border_moved;
  }
  // Claims may be of any element.
  RowSampler sampler(size(), {VoxelIndex(0), size()});
  const auto in_lanes = [](glm::vec3 at) { return Float4{at.x, at.y, at.z, 0.0f}; };
  with_voxel_type(volume.type(), [&]<class T>() {
    const auto voxels = volume.voxels<T>();
    const T background = stored<T>(background_value);
    RowWriter<T> writer(out, flip_sign_bit);
    T row[kBrickEdge];
    Float4 rest[kBrickEdge];
    std::size_t i = 0;
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        const T* const own = &at(voxels, {box.lo.x, y, z});
        if (!nearest) {
          std::transform(&claims.rest[i], &claims.rest[i] + width, rest, in_lanes);
          sampler.sample(voxels, rest, width);
        }
        for (int x = 0; x < width; ++x, ++i) {
          if (claims.score[i] == BrickClaims::kOwned) {
            row[x] = own[x];
          } else if (claims.score[i] == BrickClaims::kUncovered) {
            row[x] = background;
          } else if (nearest) {
            row[x] = voxels[static_cast<std::size_t>(claims.element[i])];
          } else if (!claims.cut.empty() && (claims.cut[i] & BrickClaims::in_octant) != 0) {
            const VoxelIndex element = voxel_index(claims.element[i], size());
            row[x] = stored<T>(value_in_octant(voxels, deformed.cuts, element, claims.rest[i]));
          } else {
            row[x] = stored_float<T>(sampler.value(x));
          }
        }
        writer.write(row, width);
      }
    }
  });
  return counts;
}

ResampleCounts Resampler::resample(std::int64_t brick, std::span<std::byte> out,
                                   bool flip_sign_bit) const {
  const State& state = *state_;
  const VoxelBox box = state.deformed.box(brick);
  if (!state.touched(brick)) return state.copy(box, glm::ivec3(0), out, flip_sign_bit);
  if (const auto shift = state.deformed.whole_shift(brick)) {
    return state.copy(box, *shift, out, flip_sign_bit);
  }
  if (const auto counts = state.march(brick, out, flip_sign_bit)) return *counts;
  return state.claim(brick, out, flip_sign_bit);
}

void Resampler::rest_positions(std::int64_t brick, std::span<glm::vec3> out) const {
  const VoxelBox box = state_->deformed.box(brick);
  if (auto march = march_through(state_->deformed, brick)) {
    const VoxelIndex first = march->tile().elements().lo;
    RowSampler sampler(state_->size(), march->tile().elements());
    const int width = box.size().x;
    for (auto to = out.begin(); to < out.begin() + voxel_count(box.size()); to += width) {
      sampler.locate(march->next_row(), width);
      for (int x = 0; x < width; ++x) {
        to[x] = sampler.is_among(x) ? glm::vec3(first) + sampler.position(x)
                                    : glm::vec3(std::numeric_limits<float>::quiet_NaN());
      }
    }
    return;
  }
  BrickClaims& claims = claims_of_this_thread();
  claims.open(state_->deformed, brick);
  find_rest(state_->deformed, box, claims);
  std::copy_n(claims.rest.begin(), voxel_count(box.size()), out.begin());
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

Volume resample_volume(const Volume& volume, const Lattice& lattice, const Cuts& cuts,
                       ResampleMethod method, double background_value, WorkerPool& pool,
                       ResampleCounts& counts) {
  const trace::Span span("resample volume");
  const Resampler resampler(volume, lattice, cuts, method, background_value);
  const BrickGrid& grid = lattice.grid();
  const std::size_t voxel_bytes = bytes_per_voxel(volume.type());
  auto samples = std::make_shared<std::vector<std::byte>>(volume.bytes().size());
  std::vector<ResampleCounts> by_worker(static_cast<std::size_t>(pool.thread_count()));
  pool.for_each(grid.count(), [&](std::int64_t b, int worker) {
    const Stopwatch start;
    std::vector<std::byte> brick(kBrickVoxels * voxel_bytes);
    auto brick_counts = resampler.resample(b, brick, false);
    const VoxelBox box = grid.box(grid.brick(b));
    const std::size_t row = static_cast<std::size_t>(box.size().x) * voxel_bytes;
    const std::byte* from = brick.data();
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y, from += row) {
        const auto at = static_cast<std::size_t>(linear_index({box.lo.x, y, z}, volume.size()));
        std::memcpy(samples->data() + at * voxel_bytes, from, row);
      }
    }
    brick_counts.timed(start.seconds());
    by_worker[static_cast<std::size_t>(worker)] += brick_counts;
  });
  for (const ResampleCounts& c : by_worker) counts += c;
  const std::span<const std::byte> bytes(*samples);
  return Volume(volume.size(), volume.type(), volume.world_from_voxel(), bytes, std::move(samples));
}

}  // namespace maille
