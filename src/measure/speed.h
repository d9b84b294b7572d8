// How fast a drag is answered: by number of elements, direction, material, size of the volume and
// number of threads, beside what the machine's memory can do in the same run, and how much memory
// the answer takes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/result.h"
#include "measure/drag_scene.h"
#include "measure/machine.h"
#include "measure/timing.h"

namespace maille {

// Schulze, Bühler and Hadwiger 2007, one thread of their machine.
inline constexpr double kPaperElementsPerSecond = 2.34e6;

struct SpeedOptions {
  std::vector<int> threads{1, 2};
  int runs = 7;  // of which the median counts
  std::vector<std::int64_t> element_counts{10'000, 100'000, 1'000'000, 10'000'000};
  std::int64_t small_count = 38'000;  // the drag that fits in small_volume too
  Size3 small_volume{64, 64, 64};
  Size3 large_volume{832, 832, 494};
  std::int64_t large_count = 1'000'000;
  int mixed_edge = 256;  // of the volumes of more than one material
  double ball_drag_voxels = 17.0;
  double block_drag_voxels = 62.0;       // far enough that all of mixed_edge^3 moves
  std::int64_t again_count = 1'000'000;  // of the drags over tissue that has moved before
  int moved_again_edge = 96;
  int row_bricks = 1024;  // of the row of single voxels
  int pointer_positions = 60;
  std::int64_t pointer_count = 1'000'000;
  std::uint64_t seed = 1;
  std::function<void(const std::string&)> progress = [](const std::string&) {};
};

struct SpeedReport {
  // One drag.
  struct Row {
    std::string group;  // rows that differ in number of elements or volume only
    std::string title;
    Size3 size{0};
    glm::dvec3 drag_voxels{0};
    int threads = 1;
    std::int64_t elements = 0;  // that moved
    // Button-down and the first position, which gathers materials and meets fresh memory; and a
    // later one of the same stroke, which is what a person dragging waits for: nearly all are. Each
    // is solved from the state at button-down.
    Timing first;
    Timing next;
    // What the answer must at least write and read, an element: see bytes_an_element().
    double least_bytes_per_element = 0.0;
    StrokeMemory in_stroke;  // between two positions
    StrokePeak at_most;      // while a position was answered, of the one that took most
    LatticeUse at_rest;      // after button-up

    double elements_per_second() const;  // of `next`
    double least_gb_per_s() const;       // of least_bytes_per_element
    // The same bytes for every element of the bricks touched, moved or not: bricks are whole.
    double bricks_gb_per_s() const;
    double microseconds_per_brick() const;
  };
  // A pointer that is dragged along a curve.
  struct Pointer {
    int threads = 1;
    std::vector<std::int64_t> elements;  // moved at each position
    std::vector<Timing> positions;
    Timing all;  // of every position of every run
    double percentile_99_seconds = 0.0;
  };
  Machine machine;
  std::uint64_t seed = 1;
  std::vector<Row> rows;
  std::vector<Pointer> pointers;

  double triad_share(const Row& row) const;         // least_gb_per_s() of what the machine does
  double bricks_triad_share(const Row& row) const;  // bricks_gb_per_s() of it
  // The first row of a group whose number of elements is within a tenth of that (0: the first), or
  // null.
  const Row* find(const std::string& group, int threads, std::int64_t elements) const;
  // Exponent of time over elements within a group, by least squares in logarithms: 1 is linear.
  // 0 where there are not two numbers of elements to tell it from.
  double growth(const std::string& group, int threads) const;
};

// The bound that speeds are held against: for each component that moves 2 bytes written (a 16-bit
// displacement, as small as it is stored) and, where tissue has moved before, 2 read; where
// materials differ a byte read to know which.
double bytes_an_element(const DragScene& scene);

// Errors: as Deformer::drag_to, for options that ask for the impossible.
Result<SpeedReport> measure_speed(const SpeedOptions& options);

}  // namespace maille
