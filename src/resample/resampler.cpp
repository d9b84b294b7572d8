#include "resample/resampler.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/stopwatch.h"
#include "core/trace.h"
#include "resample/brick_set.h"
#include "resample/corner_planes.h"
#include "resample/cut_value.h"
#include "resample/nearest_finder.h"
#include "resample/rest_finder.h"
#include "resample/rest_march.h"
#include "resample/row_sampler.h"

namespace maille {
namespace {

// Kept by thread: a brick's worth is too much for the stack and too often needed for the heap.
BrickClaims& claims_of_this_thread() {
  static thread_local BrickClaims claims;
  return claims;
}

template <class T>
T stored(double value) {
  if constexpr (std::is_integral_v<T>) {
    const double rounded = std::nearbyint(value);
    return static_cast<T>(std::clamp(rounded, double{std::numeric_limits<T>::lowest()},
                                     double{std::numeric_limits<T>::max()}));
  } else {
    return static_cast<T>(value);
  }
}

// The same of a float, whose integers go no further than it can tell.
template <class T>
T stored_float(float value) {
  if constexpr (std::is_integral_v<T> && sizeof(T) <= 2) {
    constexpr auto kLowest = static_cast<float>(std::numeric_limits<T>::lowest());
    constexpr auto kMost = static_cast<float>(std::numeric_limits<T>::max());
    constexpr float kRounding = 12582912.0f;
    const float rounded = (value + kRounding) - kRounding;
    return static_cast<T>(static_cast<std::int32_t>(std::min(std::max(rounded, kLowest), kMost)));
  } else {
    return stored<T>(static_cast<double>(value));
  }
}

template <class T>
T trilinear(std::span<const T> voxels, Size3 size, glm::vec3 rest) {
  glm::vec3 t;
  VoxelIndex base;
  for (int c = 0; c < 3; ++c) {
    const float inside = std::clamp(rest[c], 0.0f, static_cast<float>(size[c] - 1));
    base[c] = std::min(static_cast<int>(inside), std::max(0, size[c] - 2));
    t[c] = inside - static_cast<float>(base[c]);
  }
  const std::int64_t step_x = size.x > 1 ? 1 : 0;
  const std::int64_t step_y = size.y > 1 ? size.x : 0;
  const std::int64_t step_z = size.z > 1 ? std::int64_t{size.x} * size.y : 0;
  const T* at = &voxels[static_cast<std::size_t>(linear_index(base, size))];
  const auto along_x = [&](const T* p) {
    const auto a = static_cast<float>(p[0]);
    // Equal ends, infinite ones among them, must give themselves back.
    return t.x == 0.0f ? a : a + t.x * (static_cast<float>(p[step_x]) - a);
  };
  const auto mix = [](float a, float b, float s) { return s == 0.0f ? a : a + s * (b - a); };
  const float y0 = mix(along_x(at), along_x(at + step_y), t.y);
  const float y1 = mix(along_x(at + step_z), along_x(at + step_z + step_y), t.y);
  return stored<T>(mix(y0, y1, t.z));
}

// Kept by thread, as the claims are.
DisplacementTile& tile_of_this_thread() {
  static thread_local DisplacementTile tile;
  return tile;
}

bool rests(Float4 u) { return u[0] == 0.0f && u[1] == 0.0f && u[2] == 0.0f; }

template <class T>
void flip_sign_bits(T* row) {
  if constexpr (std::is_integral_v<T>) {
    using Bits = std::make_unsigned_t<T>;
    constexpr Bits kSign = static_cast<Bits>(Bits{1} << (8 * sizeof(T) - 1));
    for (int x = 0; x < kBrickEdge; ++x) {
      row[x] = static_cast<T>(static_cast<Bits>(row[x]) ^ kSign);
    }
  }
}

}  // namespace

struct Resampler::State {
  Volume volume;
  DeformedVolume deformed;
  ResampleMethod method;
  double background_value;

  std::optional<RestMarch> march(std::int64_t brick) const;
  ResampleCounts follow(RestMarch& march, const VoxelBox& voxels, std::span<std::byte> out,
                        bool flip_sign_bit) const;

  Size3 size() const { return volume.size(); }
  VoxelBox box(std::int64_t brick) const {
    const BrickGrid& grid = deformed.lattice.grid();
    return grid.box(grid.brick(brick));
  }
  bool carved(std::int64_t brick) const {
    const CutBrick* cuts = deformed.cuts.brick(brick);
    return cuts && std::any_of(cuts->carved.begin(), cuts->carved.end(),
                               [](std::uint32_t bits) { return bits != 0; });
  }
  // Elements of all cells that can cover a voxel of a box, and a margin around them.
  VoxelBox elements_over(const VoxelBox& voxels) const {
    VoxelBox cells{voxels.lo - 1, voxels.hi};
    for (const DeformedVolume::Entry& entry : deformed.entries) {
      if (intersection(entry.covered, voxels).empty()) continue;
      cells =
          united(cells, cells_over(entry.reach, glm::dvec3(voxels.lo), glm::dvec3(voxels.hi - 1)));
    }
    return intersection({cells.lo, cells.hi + 2}, {VoxelIndex(0), size()});
  }
  bool touched(std::int64_t brick) const {
    if (deformed.lattice.brick(brick) || carved(brick)) return true;
    const VoxelBox voxels = box(brick);
    return std::any_of(deformed.entries.begin(), deformed.entries.end(), [&](const auto& entry) {
      return !intersection(entry.covered, voxels).empty();
    });
  }
};

// None where cells have to look for voxels: beside cuts, and where two cells might cover one voxel.
std::optional<RestMarch> Resampler::State::march(std::int64_t brick) const {
  // Where material is squeezed most of it is between voxels, and writing it out takes longer than
  // all else.
  constexpr std::int64_t kMostElementsAVoxel = 8;
  constexpr double kSurely = 0.98;
  const VoxelBox voxels = box(brick);
  if (deformed.cuts.brick(brick) || deformed.cut_in_sight(voxels)) return std::nullopt;
  const VoxelBox elements = elements_over(voxels);
  if (voxel_count(elements.size()) > kMostElementsAVoxel * kBrickVoxels) return std::nullopt;
  DisplacementTile& tile = tile_of_this_thread();
  tile.fill(deformed.lattice, elements);
  const bool at_border =
      glm::any(glm::equal(elements.lo, VoxelIndex(0))) || glm::any(glm::equal(elements.hi, size()));
  const auto injection = tile.injection(at_border);
  if (!(injection.share < kSurely)) return std::nullopt;
  return RestMarch(tile, injection, voxels);
}

ResampleCounts Resampler::State::follow(RestMarch& march, const VoxelBox& voxels,
                                        std::span<std::byte> out, bool flip_sign_bit) const {
  const DisplacementTile& tile = tile_of_this_thread();
  const VoxelIndex first = tile.elements().lo;
  RowSampler sampler(size(), first);
  ResampleCounts counts;
  counts.voxels = voxel_count(voxels.size());
  with_voxel_type(volume.type(), [&]<class T>() {
    const auto samples = volume.voxels<T>();
    const T background = stored<T>(background_value);
    T row[kBrickEdge] = {};
    std::byte* to = out.data();
    for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
      for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
        const Float4* const rest = march.next_row();
        const T* const own =
            &samples[static_cast<std::size_t>(linear_index({voxels.lo.x, y, z}, size()))];
        const Float4* const u = tile.row(y - first.y, z - first.z) + (voxels.lo.x - first.x);
        sampler.sample(samples, rest, voxels.size().x);
        for (int x = 0; x < voxels.size().x; ++x) {
          const bool moved = !rests(u[x]);
          const bool filled = sampler.in_volume(x);
          const T value = filled ? stored_float<T>(sampler.value(x)) : background;
          row[x] = moved ? value : own[x];
          counts.moved_voxels += moved;
          counts.background_voxels += moved && !filled;
        }
        if (flip_sign_bit) flip_sign_bits(row);
        const std::size_t bytes = static_cast<std::size_t>(voxels.size().x) * sizeof(T);
        std::memcpy(to, row, bytes);
        to += bytes;
      }
    }
  });
  if (!deformed.border_moved) counts.unfilled_voxels = counts.background_voxels;
  return counts;
}

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

ResampleCounts Resampler::resample(std::int64_t brick, std::span<std::byte> out,
                                   bool flip_sign_bit) const {
  const State& state = *state_;
  const VoxelBox box = state.box(brick);
  const Size3 extent = box.size();
  const bool nearest = state.method == ResampleMethod::nearest;
  ResampleCounts counts;
  counts.voxels = voxel_count(extent);
  const bool touched = state.touched(brick);
  if (touched && !nearest) {
    if (auto march = state.march(brick)) return state.follow(*march, box, out, flip_sign_bit);
  }
  BrickClaims& claims = claims_of_this_thread();
  if (touched) {
    counts.moved_voxels = claims.open(state.deformed, brick);
    if (nearest) {
      find_nearest(state.deformed, box, claims);
    } else {
      find_rest(state.deformed, box, claims);
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(counts.voxels); ++i) {
      if (claims.score[i] != BrickClaims::kUncovered) continue;
      ++counts.background_voxels;
      const bool by_cut = !claims.cut.empty() && claims.cut[i] != 0;
      counts.unfilled_voxels += !by_cut && !state.deformed.border_moved;
    }
  }
  with_voxel_type(state.volume.type(), [&]<class T>() {
    const auto voxels = state.volume.voxels<T>();
    const T background = stored<T>(state.background_value);
    const auto claimed = [&](std::size_t i) {
      if (claims.score[i] == BrickClaims::kUncovered) return background;
      if (nearest) return voxels[static_cast<std::size_t>(claims.element[i])];
      const bool in_octant = !claims.cut.empty() && (claims.cut[i] & BrickClaims::in_octant) != 0;
      if (!in_octant) return trilinear(voxels, state.size(), claims.rest[i]);
      const VoxelIndex element = voxel_index(claims.element[i], state.size());
      return stored<T>(value_in_octant(voxels, state.deformed.cuts, element, claims.rest[i]));
    };
    T row[kBrickEdge] = {};
    std::byte* to = out.data();
    std::size_t i = 0;
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        const T* own =
            &voxels[static_cast<std::size_t>(linear_index({box.lo.x, y, z}, state.size()))];
        for (int x = 0; x < extent.x; ++x, ++i) {
          row[x] = touched && claims.score[i] != BrickClaims::kOwned ? claimed(i) : own[x];
        }
        if (flip_sign_bit) flip_sign_bits(row);
        const std::size_t bytes = static_cast<std::size_t>(extent.x) * sizeof(T);
        std::memcpy(to, row, bytes);
        to += bytes;
      }
    }
  });
  return counts;
}

void Resampler::rest_positions(std::int64_t brick, std::span<glm::vec3> out) const {
  const VoxelBox box = state_->box(brick);
  if (auto march = state_->march(brick)) {
    const VoxelIndex first = tile_of_this_thread().elements().lo;
    RowSampler sampler(state_->size(), first);
    const int width = box.size().x;
    for (auto to = out.begin(); to < out.begin() + voxel_count(box.size()); to += width) {
      sampler.locate(march->next_row(), width);
      for (int x = 0; x < width; ++x) {
        to[x] = sampler.in_volume(x) ? glm::vec3(first) + sampler.position(x)
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
