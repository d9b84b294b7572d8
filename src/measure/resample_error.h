// Resampling by several ways of the same deformed volumes: how far what they show is from the truth
// of the formula, and what a voxel takes.
//
// Maille's methods with set-up counted, beside the paper's walk (its two heuristics, its three ways
// to a value) and plain fixed-point inversion. Those are measured on one thread, as the paper was,
// and in the middle layers of a volume: all of it would take minutes and say the same.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "measure/constant_bricks.h"
#include "measure/machine.h"
#include "measure/resample_truth.h"
#include "measure/timing.h"
#include "resample/resampler.h"

namespace maille {

struct ResampleErrorOptions {
  std::vector<int> threads{1, 2};  // for Maille's methods
  int edge = 128;                  // of the volumes, voxels
  int runs = 7;                    // of Maille, of which the median counts; fewer, but 3, where
  double seconds = 3.0;            // they would take more than this in all
  int reference_runs = 3;          // of the others; fewer where they would take more than
  double reference_seconds = 1.0;  // in all
  int reference_layers = 32;       // that the others are measured in
  std::int64_t nearest_voxels = std::int64_t{1} << 22;  // at most, held against brute force
  int copy_edge = 256;  // of the volume of constant bricks: beyond the caches
  std::function<void(const std::string&)> progress = [](const std::string&) {};
};

struct ResampleError {
  // Whether elements that were found are those that lie nearest, by brute force.
  struct Found {
    std::int64_t there = 0;  // judged voxels
    std::int64_t right = 0;
    std::int64_t wrong = 0;   // another is nearer
    std::int64_t missed = 0;  // none found
    double right_share() const {
      return there == 0 ? 1.0 : static_cast<double>(right) / static_cast<double>(there);
    }
  };
  struct Row {
    std::string way;     // "maille", "walk_6", "walk_26" or "fixed_point"
    std::string method;  // "nearest", "linear", "barycentric" or "rbf"
    int iterations = 0;  // of fixed_point
    int threads = 1;
    Timing timing;
    std::int64_t voxels = 0;  // that something lies in, of those that were resampled meanwhile
    std::optional<ResampleDeviation> deviation;  // none: the truth is not known
    std::optional<Found> found;                  // of nearest

    double nanoseconds_a_voxel() const;
    double million_voxels_per_second() const;
  };
  struct Scene {
    std::string name;
    std::string title;
    bool moves = true;
    bool folds = false;
    Size3 size{0};
    std::int64_t folded_cells = 0;  // of the lattice
    // Of the truth.
    std::int64_t judged_voxels = 0;
    std::int64_t lost_voxels = 0;
    double worst_forward_voxels = 0.0;
    VoxelBox reference_voxels;        // what the others were measured in
    std::int64_t nearest_stride = 1;  // every so manieth voxel was held against brute force
    std::vector<Row> rows;

    bool truth_found() const { return lost_voxels == 0; }
  };
  Machine machine;
  int runs = 0;
  std::vector<Scene> scenes;
  std::vector<ConstantBricks> constant_bricks;  // by number of threads

  // Of the bytes a second that the triad moves on as many threads.
  double triad_share(const ConstantBricks& bricks) const;
};

ResampleError measure_resample_error(const ResampleErrorOptions& options);

// The paper's own, on one thread of its machine (2007): million voxels/s. None: it has no such
// method.
std::optional<double> paper_million_voxels_per_second(const std::string& method);

}  // namespace maille
