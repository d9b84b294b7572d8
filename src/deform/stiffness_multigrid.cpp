#include "deform/stiffness_multigrid.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "core/several_widths.h"
#include "core/trace.h"
#include "deform/spring_rows.h"

namespace maille {
namespace {

// One level: elements in a box with a layer of held ones around them.
class StiffnessLevel {
 public:
  StiffnessLevel(Size3 extent, WorkerPool& pool) : extent_(extent), pool_(pool) {
    const auto edge = static_cast<std::int64_t>(tile_edge() + 2);
    const std::int64_t floats = 3 * (edge * edge * extent_.x + 2 * kGap);
    scratch_.resize(static_cast<std::size_t>(alone() ? 1 : pool.thread_count()));
    for (auto& s : scratch_) s.resize(static_cast<std::size_t>(floats));
  }
  virtual ~StiffnessLevel() = default;

  Size3 extent() const { return extent_; }
  Size3 inner() const { return extent_ - 2; }
  std::int64_t row(int y, int z) const { return static_cast<std::int64_t>(z) * extent_.y + y; }
  // The element of the next level that an element is part of, along an axis.
  static int parent(int x) { return ((x - 1) >> 1) + 1; }
  static Size3 parent_extent(Size3 extent) { return (extent - 2 + 1) / 2 + 2; }

  // The forces that one Jacobi step from nothing leaves over, summed up for the next level.
  void restrict_forces(const BoxVectors& forces, BoxVectors& coarse) {
    const Size3 coarse_extent = parent_extent(extent_);
    for_each_tile([&](const Tile& tile, int worker) {
      float* const moves = gather(tile, forces, nullptr, worker);
      std::vector<float> left(static_cast<std::size_t>(extent_.x) + 2);
      for (int z = tile.z0; z < tile.z1; ++z) {
        for (int y = tile.y0; y < tile.y1; ++y) {
          const bool first = (((y - 1) | (z - 1)) & 1) == 0;
          const std::int64_t to =
              (static_cast<std::int64_t>(parent(z)) * coarse_extent.y + parent(y)) *
              coarse_extent.x;
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

  // That Jacobi step, the next level's moves, and another Jacobi step.
  void prolong_and_smooth(const BoxVectors& forces, const BoxVectors& coarse, BoxVectors& moves) {
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

  // f(worker-free sums of a tile's rows): what rows give, added up in the order of the tiles.
  template <std::size_t kSums, class F>
  std::array<double, kSums> sum_over_rows(F&& f) {
    std::vector<std::array<double, kSums>> parts(static_cast<std::size_t>(tile_count()));
    for_each_tile([&](const Tile& tile, int) {
      auto& sums = parts[static_cast<std::size_t>(tile.number)];
      sums.fill(0.0);
      for (int z = tile.z0; z < tile.z1; ++z) {
        for (int y = tile.y0; y < tile.y1; ++y) {
          for_each_run_of(y, z, [&](std::int64_t begin, int, int count) { f(begin, count, sums); });
        }
      }
    });
    std::array<double, kSums> total{};
    for (const auto& part : parts) {
      for (std::size_t i = 0; i < kSums; ++i) total[i] += part[i];
    }
    return total;
  }

  // Where springs are missing, the elements of a block that hang together: the most of them take
  // part in the next level's element, the others only here, and springs to them are left out of it.
  // One that joined the two sides of a cut would drag along what hangs on nothing; to hold the next
  // level by such springs would hold the side of a cut that is free.
  void part_blocks() {
    joins_ = BoxArray<std::uint8_t>(extent_, pool_);
    const Size3 blocks = parent_extent(extent_) - 2;
    pool_.for_each(blocks.z, [&](std::int64_t plane, int) {
      for (int y = 1; y <= blocks.y; ++y) {
        for (int x = 1; x <= blocks.x; ++x) part_block({x, y, static_cast<int>(plane) + 1});
      }
    });
  }
  bool joins(std::int64_t e) const { return !joins_ || joins_[e] != 0; }

  // Of the spring by springs_of()'s offset s; 0: none.
  virtual float stiffness_of(std::int64_t e, int s) const = 0;

  // Jacobi's step for a unit of force: 0.9 over the diagonal, 0 where held.
  virtual void gains(std::int64_t begin, int count, float* gain) const = 0;
  virtual void apply(std::int64_t begin, int count, const std::array<RowsAround, 3>& w,
                     RunVectors& out) const = 0;

  // The rows of a vector around an element, as apply() takes them.
  std::array<RowsAround, 3> rows_of(const BoxVectors& v, std::int64_t begin) const {
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

 protected:
  static constexpr float kJacobi = 0.9f;

 private:
  static constexpr std::int64_t kGap = 64;

  struct Tile {
    std::int64_t number = 0;
    int y0 = 0, y1 = 0, z0 = 0, z1 = 0;
  };

  // Rows of a tile and around it should stay in a core's own cache; of an even number, so that what
  // becomes one element lies in one tile.
  int tile_edge() const { return extent_.x <= 256 ? 8 : extent_.x <= 1024 ? 4 : 2; }
  // Waking workers for fewer elements takes longer than the work.
  bool alone() const { return voxel_count(extent_) < 6000; }

  Size3 tiles() const {
    const int edge = tile_edge();
    return {1, (inner().y + edge - 1) / edge, (inner().z + edge - 1) / edge};
  }
  std::int64_t tile_count() const { return voxel_count(tiles()); }

  template <class F>
  void for_each_tile(F&& f) {
    const auto one = [&](std::int64_t number, int worker) {
      const int edge = tile_edge();
      const int y = 1 + static_cast<int>(number % tiles().y) * edge;
      const int z = 1 + static_cast<int>(number / tiles().y) * edge;
      f(Tile{number, y, std::min(y + edge, extent_.y - 1), z, std::min(z + edge, extent_.z - 1)},
        worker);
    };
    if (alone()) {
      for (std::int64_t i = 0; i < tile_count(); ++i) one(i, 0);
    } else {
      pool_.for_each(tile_count(), one);
    }
  }

  template <class F>
  void for_each_run_of(int y, int z, F&& f) const {
    for (int x = 1; x < extent_.x - 1; x += kLongestRun) {
      f(row(y, z) * extent_.x + x, x, std::min(kLongestRun, extent_.x - 1 - x));
    }
  }

  // The moves that a Jacobi step from nothing makes, the next level's added, of a tile's rows and
  // those around it: made anew for each use, which costs less than keeping them.
  float* gather(const Tile& tile, const BoxVectors& forces, const BoxVectors* coarse, int worker) {
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

  std::int64_t place(const Tile& tile, int c, int y, int z) const {
    const std::int64_t edge = tile_edge() + 2;
    return ((c * edge + (z - tile.z0 + 1)) * edge + (y - tile.y0 + 1)) * extent_.x;
  }

  std::array<RowsAround, 3> rows_around(const Tile& tile, const float* scratch, int y, int z,
                                        int x0) const {
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

  void leave_over(std::int64_t begin, int count, const float* force, const float* taken,
                  float* left) const {
    float gain[kLongestRun];
    gains(begin, count, gain);
    for (int x = 0; x < count; ++x) left[x] = gain[x] > 0.0f ? force[x] - taken[x] : 0.0f;
    if (!joins_) return;
    const std::uint8_t* const joins = &joins_[begin];
    for (int x = 0; x < count; ++x) left[x] = joins[x] ? left[x] : 0.0f;
  }

  void part_block(glm::ivec3 block) {
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

  Size3 extent_;
  WorkerPool& pool_;
  BoxArray<std::uint8_t> joins_;             // none: all that is free
  std::vector<std::vector<float>> scratch_;  // one a worker
};

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

// The springs of a run of elements of a coarse level.
struct KeptSprings {
  const float* diagonal = nullptr;
  std::array<glm::ivec3, kSprings / 2> offset;
  std::array<const float*, kSprings / 2> k{};       // to the element at the offset
  std::array<const float*, kSprings / 2> k_back{};  // to the one opposite
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
      const float* const k = kept.k[s];
      const float* const k_back = kept.k_back[s];
      for (int x = 0; x < count; ++x) sum[x] -= k[x] * forward[x] + k_back[x] * backward[x];
    }
    std::copy(sum, sum + count, parts[c]);
  }
}

}  // namespace

// The elements of the lattice.
class StiffnessMultigrid::Fine : public StiffnessLevel {
 public:
  Fine(const SpringBox& box, WorkerPool& pool) : StiffnessLevel(box.extent(), pool), box_(box) {
    bool plain = true;
    const std::int64_t rows = std::int64_t{box.extent().y} * box.extent().z;
    for (std::int64_t r = 0; r < rows; ++r) {
      plain = plain && (box.kind(r) == RowKind::plain || box.kind(r) == RowKind::held);
    }
    if (plain && !box.compliances()) return;
    gain_ = BoxArray<float>(box.extent(), pool);
    pool.for_each(rows, [&](std::int64_t r, int) {
      if (box.kind(r) == RowKind::held) return;
      for_each_run(box, r, 1, box.extent().x - 1, [&](const SpringRun& run) {
        float sum[kLongestRun] = {};
        for (int s = 0; s < kSprings; ++s) {
          float k[kLongestRun];
          stiffnesses(box, run, s, k);
          for (int x = 0; x < run.count; ++x) sum[x] += k[x];
        }
        for (int x = 0; x < run.count; ++x) {
          if (sum[x] > 0.0f && box.is_free(run.first + x)) gain_[run.first + x] = kJacobi / sum[x];
        }
      });
    });
  }

  void gains(std::int64_t begin, int count, float* gain) const override {
    if (gain_) {
      std::copy(&gain_[begin], &gain_[begin] + count, gain);
      return;
    }
    const float one = kJacobi * box_.one_compliance() / static_cast<float>(kSprings);
    const std::uint8_t* const free = box_.free_flags() + begin;
    for (int x = 0; x < count; ++x) gain[x] = free[x] ? one : 0.0f;
  }

  void apply(std::int64_t begin, int count, const std::array<RowsAround, 3>& w,
             RunVectors& out) const override {
    const std::int64_t r = begin / extent().x;
    const std::uint32_t* const missing = box_.missing(r);
    laplacian(box_,
              {box_.kind(r), begin, count, missing ? missing + (begin - r * extent().x) : nullptr},
              w, out);
  }

  float stiffness_of(std::int64_t e, int s) const override { return box_.stiffness(e, s); }

  std::int64_t bytes() const { return gain_.bytes(); }

 private:
  const SpringBox& box_;
  BoxArray<float> gain_;  // none where all springs are alike
};

// Elements of 2^3 elements of the level before, their springs kept.
class StiffnessMultigrid::Coarse : public StiffnessLevel {
 public:
  BoxVectors forces;
  BoxVectors moves;
  BoxVectors first_moves;  // of two

  Coarse(const SpringBox& box, const Fine& finer, WorkerPool& pool)
      : Coarse(parent_extent(box.extent()), pool, 0) {
    add_up_springs(box, finer, pool);
    finish(pool);
  }
  Coarse(const Coarse& finer, WorkerPool& pool) : Coarse(parent_extent(finer.extent()), pool, 0) {
    add_up_springs(finer, pool);
    finish(pool);
  }

  void gains(std::int64_t begin, int count, float* gain) const override {
    const float* const d = &diagonal_[begin];
    for (int x = 0; x < count; ++x) gain[x] = d[x] > 0.0f ? kJacobi / d[x] : 0.0f;
  }

  void apply(std::int64_t begin, int count, const std::array<RowsAround, 3>& w,
             RunVectors& out) const override {
    KeptSprings kept;
    kept.diagonal = &diagonal_[begin];
    for (std::size_t s = 0; s < kept.k.size(); ++s) {
      kept.offset[s] = springs_[2 * s].offset;
      kept.k[s] = &k_[s][begin];
      kept.k_back[s] = kept.k[s] - steps_[s];
    }
    apply_kept_springs(kept, count, w, out);
  }

  float stiffness_of(std::int64_t e, int s) const override {
    return s % 2 ? stiffness(s / 2, e - step(s / 2)) : stiffness(s / 2, e);
  }

  // What only making the next level needs.
  void forget_ground() { ground_ = {}; }

  float diagonal(std::int64_t e) const { return diagonal_[e]; }
  // Of the spring from an element by springs()[2 s].offset.
  float stiffness(int s, std::int64_t e) const { return k_[static_cast<std::size_t>(s)][e]; }
  const Springs& springs() const { return springs_; }
  std::int64_t step(int s) const { return steps_[static_cast<std::size_t>(s)]; }

  std::int64_t bytes() const {
    std::int64_t sum = diagonal_.bytes();
    for (const auto& k : k_) sum += k.bytes();
    return sum + bytes_of(forces) + bytes_of(moves) + bytes_of(first_moves);
  }

 private:
  Coarse(Size3 extent, WorkerPool& pool, int)
      : StiffnessLevel(extent, pool),
        forces(make_box_vectors(extent, pool)),
        moves(make_box_vectors(extent, pool)),
        first_moves(make_box_vectors(extent, pool)),
        springs_(springs_of(glm::dvec3(1.0))),
        ground_(extent, pool),
        diagonal_(extent, pool) {
    for (auto& k : k_) k = BoxArray<float>(extent, pool);
    for (int s = 0; s < kSprings / 2; ++s) {
      const glm::ivec3 o = springs_[static_cast<std::size_t>(2 * s)].offset;
      steps_[static_cast<std::size_t>(s)] =
          (static_cast<std::int64_t>(o.z) * extent.y + o.y) * extent.x + o.x;
    }
  }

  // The springs between two elements become one, those to held elements run to the ground, and
  // those within an element vanish.
  void add_up_springs(const SpringBox& box, const Fine& finer, WorkerPool& pool) {
    const Size3 fine = box.extent();
    // Rows between full ones have the same springs from end to end, and none to the ground.
    const auto all_full = [&](int Y, int Z) {
      for (int z = 2 * Z - 2; z <= 2 * Z + 1; ++z) {
        for (int y = 2 * Y - 2; y <= 2 * Y + 1; ++y) {
          if (y < 0 || z < 0 || y >= fine.y || z >= fine.z) return false;
          const std::int64_t r = box.row(y, z);
          if (box.kind(r) != RowKind::plain || !box.all_free(r)) return false;
        }
      }
      return true;
    };
    pool.for_each(inner().z, [&](std::int64_t plane, int) {
      const int Z = static_cast<int>(plane) + 1;
      for (int Y = 1; Y < extent().y - 1; ++Y) {
        const std::int64_t to = row(Y, Z) * extent().x;
        if (extent().x >= 8 && all_full(Y, Z)) {
          const float one =
              kCoarseStiffness / box.compliance(box.row(2 * Y - 1, 2 * Z - 1) * fine.x + 1);
          for (int s = 0; s < kSprings / 2; ++s) {
            auto& k = k_[static_cast<std::size_t>(s)];
            std::fill(&k[to + 2], &k[to + extent().x - 3], s < 3 ? 12.0f * one : 2.0f * one);
          }
          add_up_row(box, finer, Y, Z, 1, 1);
          add_up_row(box, finer, Y, Z, extent().x - 3, extent().x - 2);
        } else {
          add_up_row(box, finer, Y, Z, 1, extent().x - 2);
        }
      }
    });
  }

  // The elements X0 to X1 of a row, both included.
  void add_up_row(const SpringBox& box, const Fine& finer, int Y, int Z, int X0, int X1) {
    const Size3 fine = box.extent();
    for (int z = 2 * Z - 1; z <= std::min(2 * Z, fine.z - 2); ++z) {
      for (int y = 2 * Y - 1; y <= std::min(2 * Y, fine.y - 2); ++y) {
        const std::int64_t r = box.row(y, z);
        if (box.kind(r) == RowKind::held) continue;
        for_each_run(
            box, r, 2 * X0 - 1, std::min(2 * X1 + 1, fine.x - 1), [&](const SpringRun& run) {
              const int x0 = static_cast<int>(run.first - r * fine.x);
              for (int s = 0; s < kSprings; ++s) {
                float k[kLongestRun];
                stiffnesses(box, run, s, k);
                const glm::ivec3 o = springs_[static_cast<std::size_t>(s)].offset;
                const int dy = parent(y + o.y) - Y;
                const int dz = parent(z + o.z) - Z;
                for (int i = 0; i < run.count; ++i) {
                  const int x = x0 + i;
                  const std::int64_t other = run.first + i + box.step(s);
                  if (!box.is_free(run.first + i) || !finer.joins(run.first + i)) continue;
                  if (box.is_free(other) && !finer.joins(other)) continue;
                  add_spring(row(Y, Z) * extent().x + parent(x),
                             {parent(x + o.x) - parent(x), dy, dz}, box.is_free(other), k[i]);
                }
              }
            });
      }
    }
  }

  void add_up_springs(const Coarse& finer, WorkerPool& pool) {
    const Size3 fine = finer.extent();
    std::array<std::int64_t, kSprings> finer_steps{};
    for (int s = 0; s < kSprings; ++s) {
      finer_steps[static_cast<std::size_t>(s)] = s % 2 ? -finer.step(s / 2) : finer.step(s / 2);
    }
    pool.for_each(inner().z, [&](std::int64_t plane, int) {
      const int Z = static_cast<int>(plane) + 1;
      for (int z = 2 * Z - 1; z <= std::min(2 * Z, fine.z - 2); ++z) {
        for (int y = 1; y < fine.y - 1; ++y) {
          for (int x = 1; x < fine.x - 1; ++x) {
            const std::int64_t e = finer.row(y, z) * fine.x + x;
            if (finer.diagonal(e) == 0.0f || !finer.joins(e)) continue;
            const std::int64_t to = row(parent(y), Z) * extent().x + parent(x);
            for (int s = 0; s < kSprings; ++s) {
              const glm::ivec3 o = springs_[static_cast<std::size_t>(s)].offset;
              const float k =
                  s % 2 ? finer.stiffness(s / 2, e - finer.step(s / 2)) : finer.stiffness(s / 2, e);
              if (k == 0.0f || !finer.joins(e + finer_steps[static_cast<std::size_t>(s)])) continue;
              add_spring(
                  to,
                  {parent(x + o.x) - parent(x), parent(y + o.y) - parent(y), parent(z + o.z) - Z},
                  true, k);
            }
            ground_[to] += kCoarseStiffness * finer.ground_[e];
          }
        }
      }
    });
  }

  void add_spring(std::int64_t to, glm::ivec3 offset, bool free, float k) {
    if (!free) {
      ground_[to] += kCoarseStiffness * k;
      return;
    }
    if (const int s = kept_spring(springs_, offset); s >= 0) {
      k_[static_cast<std::size_t>(s)][to] += kCoarseStiffness * k;
    }
  }

  void finish(WorkerPool& pool) {
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

  Springs springs_;
  std::array<std::int64_t, kSprings / 2> steps_{};
  std::array<BoxArray<float>, kSprings / 2> k_;
  BoxArray<float> ground_;
  BoxArray<float> diagonal_;
};

// The coarsest level, solved at once.
class StiffnessMultigrid::Direct {
 public:
  explicit Direct(const Coarse& level) {
    const Size3 inner = level.inner();
    const auto n = static_cast<Eigen::Index>(voxel_count(inner));
    elements_.reserve(static_cast<std::size_t>(n));
    std::vector<Eigen::Index> unknown(static_cast<std::size_t>(voxel_count(level.extent())), -1);
    for (int z = 1; z <= inner.z; ++z) {
      for (int y = 1; y <= inner.y; ++y) {
        for (int x = 1; x <= inner.x; ++x) {
          const std::int64_t e = level.row(y, z) * level.extent().x + x;
          if (level.diagonal(e) <= 0.0f) continue;
          unknown[static_cast<std::size_t>(e)] = static_cast<Eigen::Index>(elements_.size());
          elements_.push_back(e);
        }
      }
    }
    const auto count = static_cast<Eigen::Index>(elements_.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const std::int64_t e = elements_[static_cast<std::size_t>(i)];
      // What hangs on nothing may lie anywhere: a little holds it.
      matrix(i, i) = static_cast<double>(level.diagonal(e)) * (1.0 + kHold);
      for (int s = 0; s < kSprings / 2; ++s) {
        const Eigen::Index j = unknown[static_cast<std::size_t>(e + level.step(s))];
        if (j < 0) continue;
        matrix(i, j) -= static_cast<double>(level.stiffness(s, e));
        matrix(j, i) -= static_cast<double>(level.stiffness(s, e));
      }
    }
    factors_.compute(matrix);
  }

  void solve(const BoxVectors& forces, BoxVectors& moves) const {
    Eigen::MatrixXd right(static_cast<Eigen::Index>(elements_.size()), 3);
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        right(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) =
            static_cast<double>(forces[c][elements_[i]]);
      }
    }
    const Eigen::MatrixXd solved = factors_.solve(right);
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        moves[c][elements_[i]] =
            static_cast<float>(solved(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)));
      }
    }
  }

 private:
  static constexpr double kHold = 1e-6;

  std::vector<std::int64_t> elements_;
  Eigen::LDLT<Eigen::MatrixXd> factors_;
};

StiffnessMultigrid::StiffnessMultigrid(const SpringBox& box, WorkerPool& pool)
    : fine_(std::make_unique<Fine>(box, pool)) {
  const trace::Span span("multigrid set-up");
  // Few enough to solve at once.
  constexpr std::int64_t kDirect = 80;
  const bool cut = box.lacks_springs();
  if (cut) fine_->part_blocks();
  levels_.push_back(std::make_unique<Coarse>(box, *fine_, pool));
  while (voxel_count(levels_.back()->inner()) > kDirect) {
    if (cut) levels_.back()->part_blocks();
    auto coarser = std::make_unique<Coarse>(*levels_.back(), pool);
    levels_.back()->forget_ground();
    levels_.push_back(std::move(coarser));
  }
  levels_.back()->forget_ground();
  direct_ = std::make_unique<Direct>(*levels_.back());
}
StiffnessMultigrid::~StiffnessMultigrid() = default;

void StiffnessMultigrid::solve(const BoxVectors& forces, BoxVectors& moves) {
  const trace::Span span("multigrid");
  fine_->restrict_forces(forces, levels_.front()->forces);
  solve_level(0);
  fine_->prolong_and_smooth(forces, levels_.front()->moves, moves);
}

// One cycle from a level's forces to its moves.
void StiffnessMultigrid::cycle(std::size_t l) {
  Coarse& level = *levels_[l];
  if (l + 1 == levels_.size()) return direct_->solve(level.forces, level.moves);
  level.restrict_forces(level.forces, levels_[l + 1]->forces);
  solve_level(l + 1);
  level.prolong_and_smooth(level.forces, levels_[l + 1]->moves, level.moves);
}

// Up to two cycles, the best combination of what they give; forces become what the first leaves.
void StiffnessMultigrid::solve_level(std::size_t l) {
  cycle(l);
  if (l + 1 == levels_.size()) return;
  Coarse& level = *levels_[l];
  const auto dot = [](const RunVectors& a, const BoxVectors& b, std::int64_t e, int count) {
    return dot_of_run(a.x, &b[0][e], count) + dot_of_run(a.y, &b[1][e], count) +
           dot_of_run(a.z, &b[2][e], count);
  };
  const auto dot_of = [](const BoxVectors& a, const BoxVectors& b, std::int64_t e, int count) {
    return dot_of_run(&a[0][e], &b[0][e], count) + dot_of_run(&a[1][e], &b[1][e], count) +
           dot_of_run(&a[2][e], &b[2][e], count);
  };
  const auto first = level.sum_over_rows<3>([&](std::int64_t e, int count, auto& sums) {
    RunVectors out;
    level.apply(e, count, level.rows_of(level.moves, e), out);
    sums[0] += dot(out, level.moves, e, count);
    sums[1] += dot_of(level.forces, level.moves, e, count);
    sums[2] += dot_of(level.forces, level.forces, e, count);
  });
  if (!(first[0] > 0.0)) return;  // nothing moves
  const double step = first[1] / first[0];
  std::swap(level.moves, level.first_moves);
  const auto left = level.sum_over_rows<1>([&](std::int64_t e, int count, auto& sums) {
    RunVectors out;
    level.apply(e, count, level.rows_of(level.first_moves, e), out);
    const float* const parts[3] = {out.x, out.y, out.z};
    for (std::size_t c = 0; c < 3; ++c) {
      float* const f = &level.forces[c][e];
      for (int x = 0; x < count; ++x) f[x] -= static_cast<float>(step) * parts[c][x];
    }
    sums[0] += dot_of(level.forces, level.forces, e, count);
  });
  // Notay's threshold: a quarter of the residual is as good as the finer levels can use.
  constexpr double kEnough = 0.25 * 0.25;
  double share_first = step;
  double share_second = 0.0;
  if (left[0] > kEnough * first[2]) {
    cycle(l);
    const auto second = level.sum_over_rows<3>([&](std::int64_t e, int count, auto& sums) {
      RunVectors out;
      level.apply(e, count, level.rows_of(level.moves, e), out);
      sums[0] += dot(out, level.moves, e, count);
      sums[1] += dot(out, level.first_moves, e, count);
      sums[2] += dot_of(level.forces, level.moves, e, count);
    });
    const double rest = second[0] - second[1] * second[1] / first[0];
    if (rest > 0.0) {
      share_second = second[2] / rest;
      share_first -= second[1] / first[0] * share_second;
    }
  }
  static_cast<void>(level.sum_over_rows<1>([&](std::int64_t e, int count, auto&) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float* const a = &level.first_moves[c][e];
      float* const b = &level.moves[c][e];
      for (int x = 0; x < count; ++x) {
        b[x] = static_cast<float>(share_first) * a[x] + static_cast<float>(share_second) * b[x];
      }
    }
  }));
}

std::int64_t StiffnessMultigrid::bytes() const {
  std::int64_t sum = fine_->bytes();
  for (const auto& level : levels_) sum += level->bytes();
  return sum;
}

}  // namespace maille
