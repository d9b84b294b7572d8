#include "deform/coarse_stiffness.h"

#include <algorithm>

#include "core/several_widths.h"

namespace maille {
namespace {

// Sums of springs are too stiff: they hold what lies between two coarse elements' middles as if
// nothing within them gave way.
constexpr float kCoarseStiffness = 0.6f;

// Which of the nine springs kept with an element runs by an offset; -1: its other end keeps it.
int kept_spring(const Springs& springs, glm::ivec3 offset) {
  for (int s = 0; s < kSprings; s += 2) {
    if (springs[static_cast<std::size_t>(s)].offset == offset) return s / 2;
  }
  return -1;
}

// The springs of a run of elements.
struct KeptSprings {
  const float* diagonal = nullptr;
  std::array<glm::ivec3, kSprings / 2> offset;
  std::array<const Bfloat16*, kSprings / 2> k{};       // to the element at the offset
  std::array<const Bfloat16*, kSprings / 2> k_back{};  // to the one opposite
};

MAILLE_FOR_SEVERAL_WIDTHS
void apply_kept_springs(const KeptSprings& kept, int count, const std::array<RowsAround, 3>& w,
                        RunVectors& out) {
  float* const parts[3] = {out.x, out.y, out.z};
  for (std::size_t c = 0; c < 3; ++c) {
    const float* const own = w[c].at[4];
    float sum[kLongestRun];
    for (int x = 0; x < count; ++x) sum[x] = kept.diagonal[x] * own[x];
    for (std::size_t s = 0; s < kept.k.size(); ++s) {
      const glm::ivec3 o = kept.offset[s];
      const auto row = static_cast<std::size_t>((o.z + 1) * 3 + o.y + 1);
      const float* const forward = w[c].at[row] + o.x;
      const float* const backward = w[c].at[8 - row] - o.x;
      const Bfloat16* const k = kept.k[s];
      const Bfloat16* const k_back = kept.k_back[s];
      for (int x = 0; x < count; ++x) {
        sum[x] -=
            static_cast<float>(k[x]) * forward[x] + static_cast<float>(k_back[x]) * backward[x];
      }
    }
    std::copy(sum, sum + count, parts[c]);
  }
}

}  // namespace

CoarseStiffness::CoarseStiffness(Size3 extent, WorkerPool& pool)
    : StiffnessLevel(extent, pool),
      forces(make_box_vectors(extent, pool)),
      moves(make_box_vectors(extent, pool)),
      first_moves(make_box_vectors(extent, pool)),
      springs_(springs_of(glm::dvec3(1.0))),
      ground_(extent, pool),
      diagonal_(extent, pool) {
  for (auto& k : k_) k = BoxArray<Bfloat16>(extent, pool);
  for (int s = 0; s < kSprings / 2; ++s) {
    const glm::ivec3 o = springs_[static_cast<std::size_t>(2 * s)].offset;
    steps_[static_cast<std::size_t>(s)] =
        (static_cast<std::int64_t>(o.z) * extent.y + o.y) * extent.x + o.x;
  }
}

// The springs between two elements become one, those to held elements run to the ground, and those
// within an element vanish.
CoarseStiffness::CoarseStiffness(const SpringBox& box, const StiffnessLevel& finer,
                                 WorkerPool& pool)
    : CoarseStiffness(parent_extent(box.extent()), pool) {
  const Size3 fine = box.extent();
  // Rows between full ones have the same springs from end to end, and none to the ground.
  const auto all_full = [&](glm::ivec2 yz) {
    for (int z = 2 * yz[1] - 2; z <= 2 * yz[1] + 1; ++z) {
      for (int y = 2 * yz[0] - 2; y <= 2 * yz[0] + 1; ++y) {
        if (y < 0 || z < 0 || y >= fine.y || z >= fine.z) return false;
        const std::int64_t r = box.row(y, z);
        if (box.kind(r) != RowKind::plain || !box.all_free(r)) return false;
      }
    }
    return true;
  };
  const int length = extent().x;
  pool.for_each(inner().z, [&](std::int64_t plane, int) {
    RowOfSums sums;
    for (int y = 1; y < extent().y - 1; ++y) {
      const glm::ivec2 yz(y, static_cast<int>(plane) + 1);
      for (auto& sum : sums) sum.assign(static_cast<std::size_t>(length), 0.0f);
      if (length >= 8 && all_full(yz)) {
        const float one =
            kCoarseStiffness / box.compliance(box.row(2 * yz[0] - 1, 2 * yz[1] - 1) * fine.x + 1);
        for (std::size_t s = 0; s < sums.size(); ++s) {
          std::fill(sums[s].begin() + 2, sums[s].end() - 3, s < 3 ? 12.0f * one : 2.0f * one);
        }
        add_up_row(box, finer, yz, 1, 1, sums);
        add_up_row(box, finer, yz, length - 3, length - 2, sums);
      } else {
        add_up_row(box, finer, yz, 1, length - 2, sums);
      }
      keep(row(yz[0], yz[1]) * length, sums);
    }
  });
  add_up_diagonal(pool);
}

CoarseStiffness::CoarseStiffness(const CoarseStiffness& finer, WorkerPool& pool)
    : CoarseStiffness(parent_extent(finer.extent()), pool) {
  pool.for_each(inner().z, [&](std::int64_t plane, int) {
    RowOfSums sums;
    for (int y = 1; y < extent().y - 1; ++y) {
      const glm::ivec2 yz(y, static_cast<int>(plane) + 1);
      for (auto& sum : sums) sum.assign(static_cast<std::size_t>(extent().x), 0.0f);
      add_up_row(finer, yz, sums);
      keep(row(yz[0], yz[1]) * extent().x, sums);
    }
  });
  add_up_diagonal(pool);
}

// The elements first_x to last_x of a row, both included.
void CoarseStiffness::add_up_row(const SpringBox& box, const StiffnessLevel& finer, glm::ivec2 yz,
                                 int first_x, int last_x, RowOfSums& sums) {
  const Size3 fine = box.extent();
  const std::int64_t row_begin = row(yz[0], yz[1]) * extent().x;
  for (int z = 2 * yz[1] - 1; z <= std::min(2 * yz[1], fine.z - 2); ++z) {
    for (int y = 2 * yz[0] - 1; y <= std::min(2 * yz[0], fine.y - 2); ++y) {
      const std::int64_t r = box.row(y, z);
      if (box.kind(r) == RowKind::held) continue;
      for_each_run(
          box, r, 2 * first_x - 1, std::min(2 * last_x + 1, fine.x - 1), [&](const SpringRun& run) {
            const int x0 = static_cast<int>(run.first - r * fine.x);
            for (int s = 0; s < kSprings; ++s) {
              float k[kLongestRun];
              stiffnesses(box, run, s, k);
              const glm::ivec3 o = springs_[static_cast<std::size_t>(s)].offset;
              const int dy = parent(y + o.y) - yz[0];
              const int dz = parent(z + o.z) - yz[1];
              for (int i = 0; i < run.count; ++i) {
                const int x = x0 + i;
                const std::int64_t other = run.first + i + box.step(s);
                if (!box.is_free(run.first + i) || !finer.joins(run.first + i)) continue;
                if (box.is_free(other) && !finer.joins(other)) continue;
                add_spring(sums, row_begin, parent(x), {parent(x + o.x) - parent(x), dy, dz},
                           box.is_free(other), k[i]);
              }
            }
          });
    }
  }
}

void CoarseStiffness::add_up_row(const CoarseStiffness& finer, glm::ivec2 yz, RowOfSums& sums) {
  const Size3 fine = finer.extent();
  const std::int64_t row_begin = row(yz[0], yz[1]) * extent().x;
  for (int z = 2 * yz[1] - 1; z <= std::min(2 * yz[1], fine.z - 2); ++z) {
    for (int y = 2 * yz[0] - 1; y <= std::min(2 * yz[0], fine.y - 2); ++y) {
      for (int x = 1; x < fine.x - 1; ++x) {
        const std::int64_t e = finer.row(y, z) * fine.x + x;
        if (finer.diagonal(e) == 0.0f || !finer.joins(e)) continue;
        for (int s = 0; s < kSprings; ++s) {
          const glm::ivec3 o = springs_[static_cast<std::size_t>(s)].offset;
          const float k = finer.stiffness_of(e, s);
          const std::int64_t other = e + (s % 2 ? -finer.step(s / 2) : finer.step(s / 2));
          if (k == 0.0f || !finer.joins(other)) continue;
          add_spring(
              sums, row_begin, parent(x),
              {parent(x + o.x) - parent(x), parent(y + o.y) - yz[0], parent(z + o.z) - yz[1]}, true,
              k);
        }
        ground_[row_begin + parent(x)] += kCoarseStiffness * finer.ground_[e];
      }
    }
  }
}

void CoarseStiffness::add_spring(RowOfSums& sums, std::int64_t row_begin, int x, glm::ivec3 offset,
                                 bool free, float k) {
  if (!free) {
    ground_[row_begin + x] += kCoarseStiffness * k;
    return;
  }
  if (const int s = kept_spring(springs_, offset); s >= 0) {
    sums[static_cast<std::size_t>(s)][static_cast<std::size_t>(x)] += kCoarseStiffness * k;
  }
}

void CoarseStiffness::keep(std::int64_t row_begin, const RowOfSums& sums) {
  for (std::size_t s = 0; s < sums.size(); ++s) {
    for (std::size_t x = 0; x < sums[s].size(); ++x) {
      k_[s][row_begin + static_cast<std::int64_t>(x)] = Bfloat16(sums[s][x]);
    }
  }
}

// Of the springs as they are kept, so that the level stays a Laplacian.
void CoarseStiffness::add_up_diagonal(WorkerPool& pool) {
  pool.for_each(inner().z, [&](std::int64_t plane, int) {
    for (int y = 1; y < extent().y - 1; ++y) {
      for (int x = 1; x < extent().x - 1; ++x) {
        const std::int64_t e = row(y, static_cast<int>(plane) + 1) * extent().x + x;
        float sum = ground_[e];
        for (int s = 0; s < kSprings / 2; ++s) {
          sum += stiffness(s, e) + stiffness(s, e - step(s));
        }
        diagonal_[e] = sum;
      }
    }
  });
}

void CoarseStiffness::gains(std::int64_t begin, int count, float* gain) const {
  const float* const d = &diagonal_[begin];
  for (int x = 0; x < count; ++x) gain[x] = d[x] > 0.0f ? kJacobi / d[x] : 0.0f;
}

void CoarseStiffness::apply(std::int64_t begin, int count, const std::array<RowsAround, 3>& w,
                            RunVectors& out) const {
  KeptSprings kept;
  kept.diagonal = &diagonal_[begin];
  for (std::size_t s = 0; s < kept.k.size(); ++s) {
    kept.offset[s] = springs_[2 * s].offset;
    kept.k[s] = &k_[s][begin];
    kept.k_back[s] = kept.k[s] - steps_[s];
  }
  apply_kept_springs(kept, count, w, out);
}

std::int64_t CoarseStiffness::bytes() const {
  std::int64_t sum = diagonal_.bytes();
  for (const auto& k : k_) sum += k.bytes();
  return sum + bytes_of(forces) + bytes_of(moves) + bytes_of(first_moves);
}

}  // namespace maille
