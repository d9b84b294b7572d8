#include "deform/stiffness_level.h"

#include <algorithm>

namespace maille {

StiffnessLevel::StiffnessLevel(Size3 extent, WorkerPool& pool) : extent_(extent), pool_(pool) {
  const auto edge = static_cast<std::int64_t>(tile_edge() + 2);
  const std::int64_t floats = 3 * (edge * edge * extent_.x + 2 * kGap);
  scratch_.resize(static_cast<std::size_t>(alone() ? 1 : pool.thread_count()));
  for (auto& s : scratch_) s.resize(static_cast<std::size_t>(floats));
}

void StiffnessLevel::restrict_forces(const BoxVectors& forces, BoxVectors& coarse) {
  const Size3 coarse_extent = parent_extent(extent_);
  for_each_tile([&](const Tile& tile, int worker) {
    float* const moves = gather(tile, forces, nullptr, worker);
    std::vector<float> left(static_cast<std::size_t>(extent_.x) + 2);
    for (int z = tile.z0; z < tile.z1; ++z) {
      for (int y = tile.y0; y < tile.y1; ++y) {
        const bool first = (((y - 1) | (z - 1)) & 1) == 0;
        const std::int64_t to =
            (static_cast<std::int64_t>(parent(z)) * coarse_extent.y + parent(y)) * coarse_extent.x;
        for_each_run_of(y, z, [&](std::int64_t begin, int x0, int count) {
          RunVectors out;
          apply(begin, count, rows_around(tile, moves, y, z, x0), out);
          const float* const parts[3] = {out.x, out.y, out.z};
          // x0 - 1 is even, so pairs never straddle two runs.
          for (std::size_t c = 0; c < 3; ++c) {
            leave_over(begin, count, &forces[c][begin], parts[c], left.data());
            left[static_cast<std::size_t>(count)] = 0.0f;
            float* const sum = &coarse[c][to + parent(x0)];
            const int pairs = (count + 1) / 2;
            if (first) {
              for (int x = 0; x < pairs; ++x) sum[x] = left[2 * x] + left[2 * x + 1];
            } else {
              for (int x = 0; x < pairs; ++x) sum[x] += left[2 * x] + left[2 * x + 1];
            }
          }
        });
      }
    }
  });
}

void StiffnessLevel::prolong_and_smooth(const BoxVectors& forces, const BoxVectors& coarse,
                                        BoxVectors& moves) {
  for_each_tile([&](const Tile& tile, int worker) {
    float* const before = gather(tile, forces, &coarse, worker);
    for (int z = tile.z0; z < tile.z1; ++z) {
      for (int y = tile.y0; y < tile.y1; ++y) {
        for_each_run_of(y, z, [&](std::int64_t begin, int x0, int count) {
          RunVectors out;
          const auto w = rows_around(tile, before, y, z, x0);
          apply(begin, count, w, out);
          float gain[kLongestRun];
          gains(begin, count, gain);
          const float* const parts[3] = {out.x, out.y, out.z};
          for (std::size_t c = 0; c < 3; ++c) {
            const float* const from = w[c].at[4];
            const float* const force = &forces[c][begin];
            float* const to = &moves[c][begin];
            for (int x = 0; x < count; ++x) to[x] = from[x] + gain[x] * (force[x] - parts[c][x]);
          }
        });
      }
    }
  });
}

void StiffnessLevel::part_blocks() {
  joins_ = BoxArray<std::uint8_t>(extent_, pool_);
  const Size3 blocks = parent_extent(extent_) - 2;
  pool_.for_each(blocks.z, [&](std::int64_t plane, int) {
    for (int y = 1; y <= blocks.y; ++y) {
      for (int x = 1; x <= blocks.x; ++x) part_block({x, y, static_cast<int>(plane) + 1});
    }
  });
}

std::array<RowsAround, 3> StiffnessLevel::rows_of(const BoxVectors& v, std::int64_t begin) const {
  std::array<RowsAround, 3> rows;
  for (std::size_t c = 0; c < 3; ++c) {
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        rows[c].at[static_cast<std::size_t>((dz + 1) * 3 + dy + 1)] =
            &v[c][begin + (static_cast<std::int64_t>(dz) * extent_.y + dy) * extent_.x];
      }
    }
  }
  return rows;
}

// The moves that a Jacobi step from nothing makes, the next level's added, of a tile's rows and
// those around it: made anew for each use, which costs less than keeping them.
float* StiffnessLevel::gather(const Tile& tile, const BoxVectors& forces, const BoxVectors* coarse,
                              int worker) {
  float* const scratch = scratch_[static_cast<std::size_t>(worker)].data() + kGap;
  const Size3 coarse_extent = parent_extent(extent_);
  for (int z = tile.z0 - 1; z <= tile.z1; ++z) {
    for (int y = tile.y0 - 1; y <= tile.y1; ++y) {
      const std::int64_t begin = row(y, z) * extent_.x;
      float* to[3];
      for (int c = 0; c < 3; ++c) to[c] = scratch + place(tile, c, y, z);
      const bool outside = y == 0 || z == 0 || y == extent_.y - 1 || z == extent_.z - 1;
      if (outside) {
        for (float* const t : to) std::fill(t, t + extent_.x, 0.0f);
        continue;
      }
      const std::int64_t from =
          (static_cast<std::int64_t>(parent(z)) * coarse_extent.y + parent(y)) * coarse_extent.x;
      for (int x0 = 0; x0 < extent_.x; x0 += kLongestRun) {
        const int count = std::min(kLongestRun, extent_.x - x0);
        float gain[kLongestRun];
        gains(begin + x0, count, gain);
        for (std::size_t c = 0; c < 3; ++c) {
          const float* const force = &forces[c][begin + x0];
          float* const t = to[c] + x0;
          for (int x = 0; x < count; ++x) t[x] = gain[x] * force[x];
          if (!coarse) continue;
          const float* const e = &(*coarse)[c][from];
          if (joins_) {
            const std::uint8_t* const joins = &joins_[begin + x0];
            for (int x = 0; x < count; ++x) t[x] += joins[x] ? e[(x0 + x + 1) >> 1] : 0.0f;
            continue;
          }
          for (int x = 0; x < count; ++x) t[x] += gain[x] > 0.0f ? e[(x0 + x + 1) >> 1] : 0.0f;
        }
      }
    }
  }
  return scratch;
}

std::array<RowsAround, 3> StiffnessLevel::rows_around(const Tile& tile, const float* scratch, int y,
                                                      int z, int x0) const {
  std::array<RowsAround, 3> rows;
  for (int c = 0; c < 3; ++c) {
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        rows[static_cast<std::size_t>(c)].at[static_cast<std::size_t>((dz + 1) * 3 + dy + 1)] =
            scratch + place(tile, c, y + dy, z + dz) + x0;
      }
    }
  }
  return rows;
}

void StiffnessLevel::leave_over(std::int64_t begin, int count, const float* force,
                                const float* taken, float* left) const {
  float gain[kLongestRun];
  gains(begin, count, gain);
  for (int x = 0; x < count; ++x) left[x] = gain[x] > 0.0f ? force[x] - taken[x] : 0.0f;
  if (!joins_) return;
  const std::uint8_t* const joins = &joins_[begin];
  for (int x = 0; x < count; ++x) left[x] = joins[x] ? left[x] : 0.0f;
}

void StiffnessLevel::part_block(glm::ivec3 block) {
  const Springs springs = springs_of(glm::dvec3(1.0));
  std::array<std::int64_t, 8> element;
  std::array<int, 8> part;  // the lowest of those it hangs together with; -1: not there, or held
  for (int i = 0; i < 8; ++i) {
    const glm::ivec3 at = 2 * block - 1 + glm::ivec3(i & 1, (i >> 1) & 1, (i >> 2) & 1);
    const auto n = static_cast<std::size_t>(i);
    const bool inside = glm::all(glm::lessThan(at, extent_ - 1));
    element[n] = row(at.y, at.z) * extent_.x + at.x;
    float gain = 0.0f;
    if (inside) gains(element[n], 1, &gain);
    part[n] = gain > 0.0f ? i : -1;
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (int i = 0; i < 8; ++i) {
      for (int s = 0; s < kSprings; s += 2) {
        const glm::ivec3 o = springs[static_cast<std::size_t>(s)].offset;
        const glm::ivec3 to = glm::ivec3(i & 1, (i >> 1) & 1, (i >> 2) & 1) + o;
        if (glm::any(glm::lessThan(to, glm::ivec3(0))) ||
            glm::any(glm::greaterThan(to, glm::ivec3(1)))) {
          continue;
        }
        int& here = part[static_cast<std::size_t>(i)];
        int& there = part[static_cast<std::size_t>(to.x + 2 * to.y + 4 * to.z)];
        if (here < 0 || there < 0 || here == there) continue;
        if (!(stiffness_of(element[static_cast<std::size_t>(i)], s) > 0.0f)) continue;
        here = there = std::min(here, there);
        changed = true;
      }
    }
  }
  std::array<int, 8> size{};
  for (const int p : part) {
    if (p >= 0) ++size[static_cast<std::size_t>(p)];
  }
  const auto most = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
  for (std::size_t i = 0; i < 8; ++i) {
    if (part[i] == most) joins_[element[i]] = 1;
  }
}

}  // namespace maille
