// How fast pictures come: of a volume at rest by mode, and of one that has just changed, beside
// what other programs took for the same kind of work.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/result.h"
#include "measure/machine.h"
#include "measure/timing.h"
#include "render/renderer.h"

namespace maille {

struct FrameOptions {
  RendererOptions renderer;
  PictureSize picture{512, 512};
  int runs = 7;  // of which the median counts
  // Head phantoms, framed from the front, at a step of one voxel.
  std::vector<Size3> volumes{{256, 256, 256}, {512, 512, 333}};
  int threads = 2;
  std::uint64_t seed = 1;
  std::function<void(const std::string&)> progress = [](const std::string&) {};
};

struct FrameReport {
  // A picture of a volume at rest, once its pipeline is warm.
  struct Row {
    Size3 volume{0};
    RenderMode mode = RenderMode::composite;
    bool shading = true;
    Timing frame;           // submitted until done
    double raycast_ms = 0;  // of it on the device, median
  };
  // What the next picture takes more after a change, resampling apart.
  struct Change {
    std::string what;
    Size3 volume{0};
    Timing extra;  // of the change and the picture, less a picture of the same run without it
  };
  Machine machine;
  std::string device;
  std::string driver;
  bool sparse = false;
  PictureSize picture{0};
  std::vector<Row> rows;
  std::vector<Change> changes;
};

// Errors: device, out_of_memory.
Result<FrameReport> measure_frame(const FrameOptions& options);

// What pictures have to reach on lavapipe with two cores, 512 x 512 pixels.
struct FrameBar {
  std::string what;
  double measured_ms = 0.0;
  double at_most_ms = 0.0;
  bool met() const { return measured_ms <= at_most_ms; }
};
std::vector<FrameBar> bars_of(const FrameReport& report);

// Of the same kind of work, measured once on a machine of two such cores: what stands beside it.
struct FramePeer {
  const char* program;
  Size3 volume;
  RenderMode mode;
  double ms;
};
std::span<const FramePeer> frame_peers();

}  // namespace maille
