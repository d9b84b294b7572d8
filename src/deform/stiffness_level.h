// One level of the stiffness multigrid (stiffness_multigrid.h): elements in a box with a layer of
// held ones around them, and what passes between a level and the next coarser one.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "deform/box_array.h"
#include "deform/spring_rows.h"

namespace maille {

class StiffnessLevel {
 public:
  StiffnessLevel(Size3 extent, WorkerPool& pool);
  virtual ~StiffnessLevel() = default;

  Size3 extent() const { return extent_; }
  Size3 inner() const { return extent_ - 2; }
  std::int64_t row(int y, int z) const { return static_cast<std::int64_t>(z) * extent_.y + y; }
  // The element of the next level that an element is part of, along an axis.
  static int parent(int x) { return ((x - 1) >> 1) + 1; }
  static Size3 parent_extent(Size3 extent) { return (extent - 2 + 1) / 2 + 2; }

  // The forces that one Jacobi step from nothing leaves over, summed up for the next level.
  void restrict_forces(const BoxVectors& forces, BoxVectors& coarse);
  // That Jacobi step, the next level's moves, and another Jacobi step.
  void prolong_and_smooth(const BoxVectors& forces, const BoxVectors& coarse, BoxVectors& moves);

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
  void part_blocks();
  bool joins(std::int64_t e) const { return !joins_ || joins_[e] != 0; }

  // Of the spring by springs_of()'s offset s; 0: none.
  virtual float stiffness_of(std::int64_t e, int s) const = 0;

  // Jacobi's step for a unit of force: 0.9 over the diagonal, 0 where held.
  virtual void gains(std::int64_t begin, int count, float* gain) const = 0;
  virtual void apply(std::int64_t begin, int count, const std::array<RowsAround, 3>& w,
                     RunVectors& out) const = 0;

  // The rows of a vector around an element, as apply() takes them.
  std::array<RowsAround, 3> rows_of(const BoxVectors& v, std::int64_t begin) const;

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

  float* gather(const Tile& tile, const BoxVectors& forces, const BoxVectors* coarse, int worker);
  std::int64_t place(const Tile& tile, int c, int y, int z) const {
    const std::int64_t edge = tile_edge() + 2;
    return ((c * edge + (z - tile.z0 + 1)) * edge + (y - tile.y0 + 1)) * extent_.x;
  }

  std::array<RowsAround, 3> rows_around(const Tile& tile, const float* scratch, int y, int z,
                                        int x0) const;
  void leave_over(std::int64_t begin, int count, const float* force, const float* taken,
                  float* left) const;
  void part_block(glm::ivec3 block);

  Size3 extent_;
  WorkerPool& pool_;
  BoxArray<std::uint8_t> joins_;             // none: all that is free
  std::vector<std::vector<float>> scratch_;  // one a worker
};

}  // namespace maille
