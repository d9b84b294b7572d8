// What a run did and what it took: stats.json. Keys are a contract (units in names); a section that
// the scene left out is absent and named in left_out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/spaces.h"
#include "resample/resampler.h"
#include "resample/volume_kept.h"

namespace maille {

struct RunStatistics {
  std::string command;

  struct Machine {
    int threads = 1;
    std::optional<double> triad_gb_per_s;  // measured only when statistics were asked for
  } machine;

  struct Device {
    std::string name;
    std::string driver;
    bool sparse = false;  // the volume lies in a sparse image
  };
  std::optional<Device> device;

  struct Volume {
    Size3 size{0};
    std::string type;
    std::int64_t bytes = 0;
    double load_seconds = 0.0;     // until every sample is in memory, decoded or mapped
    double analyse_seconds = 0.0;  // finding the range, where a default needs it
  } volume;

  struct ChainMail {
    std::int64_t drags = 0;  // positions that a handle was dragged to
    std::int64_t elements_moved = 0;
    std::int64_t working_bytes = 0;  // beside the lattice, at most at once in a drag
    double seconds = 0.0;
    std::int64_t violated_links = 0;  // the most after a drag
    double worst_violation_voxels = 0.0;
    bool drag_clamped = false;
  };
  std::optional<ChainMail> chainmail;

  struct Relaxation {
    std::int64_t iterations = 0;
    std::int64_t element_updates = 0;
    double seconds = 0.0;
    bool converged = true;
    // Estimated distance to equilibrium at the end, the largest and RMS. nullopt when it is not
    // known: both are then absent and residual_known is false.
    std::optional<double> residual_voxels = 0.0;
    std::optional<double> residual_rms_voxels = 0.0;
    std::int64_t free_elements = 0;   // the most at once
    std::int64_t folded_corners = 0;  // at the end of the last: ChainMail left them
    bool region_limited = false;      // memory did not allow for all that would move
    std::optional<std::string>
        stiffness_clamped;  // a sentence: springs are not what the table says
    double energy_first = 0.0;
    double energy_last = 0.0;
    bool energy_ever_rose = false;
  };
  std::optional<Relaxation> relaxation;

  struct Cuts {
    std::int64_t links_removed = 0;    // at the end, those of carved elements included
    std::int64_t elements_carved = 0;  // at the end
    double seconds = 0.0;              // of cutting, carving and restoring
  };
  std::optional<Cuts> cuts;

  struct Undo {
    std::int64_t steps = 0;  // that could be undone at the end
    std::int64_t redo_steps = 0;
    std::int64_t bytes = 0;  // that both hold
    std::int64_t budget_bytes = 0;
    std::int64_t dropped_steps = 0;  // for the budget
  };
  std::optional<Undo> undo;

  // Bricks whose voxels differ from the volume's; the untouched ones are copies.
  struct Resample {
    std::string method;
    std::int64_t voxels = 0;
    std::int64_t moved_voxels = 0;  // of these, not owned by an element at rest
    double seconds = 0.0;
    std::int64_t folded_cells = 0;
    std::int64_t unfilled_voxels = 0;
    std::int64_t copied_voxels = 0;  // of untouched bricks, for the first picture or for saving
    double copy_seconds = 0.0;

    // Seconds are of one worker after the other; unfilled voxels are of the worst time.
    void add(const ResampleCounts& counts);
    void add(const Resample& other);
  };
  std::optional<Resample> resample;

  // resample/volume_kept.h; materials where each element has one of those stated.
  struct VolumeKeptBy {
    std::string material;  // "mixed": cells at the border of two
    VolumeKept kept;
  };
  struct CellVolumes {
    VolumeKept all;
    std::vector<VolumeKeptBy> by_material;
  };
  std::optional<CellVolumes> volume_kept;

  struct Upload {
    std::int64_t bricks = 0;
    std::int64_t bytes = 0;
    double seconds = 0.0;  // waiting for memory and for the device, not filling
  };
  std::optional<Upload> upload;

  struct Frames {
    std::vector<double> milliseconds;  // of each frame, as the caller waits for it
    double raycast_ms = 0.0;           // on the device, mean of each pass
    double upload_ms = 0.0;
    double pick_ms = 0.0;
    std::optional<double> first_picture_seconds;  // from the start of the program
  };
  std::optional<Frames> frames;

  struct Pick {
    std::int64_t count = 0;
    double seconds = 0.0;
  };
  std::optional<Pick> pick;

  struct Memory {
    std::int64_t peak_rss_bytes = 0;
    std::int64_t lattice_bricks = 0;
    std::int64_t lattice_bytes = 0;     // in memory, not in the scratch file
    std::int64_t lattice_elements = 0;  // of these bricks, moved or not
    // At most at once while a stroke was on, where statistics are wanted: the lattice, what of its
    // state at button-down is no longer the same, materials gathered, the solver's work.
    std::int64_t stroke_bytes_peak = 0;
    std::int64_t stroke_elements = 0;  // of the bricks touched then, moved or not
    void add_stroke(std::int64_t bytes, std::int64_t elements);

    struct Budget {
      std::int64_t bytes = 0;           // --lattice-memory
      std::int64_t peak_bytes = 0;      // of displacements in memory, undo steps included
      std::int64_t planes_written = 0;  // to the scratch file: a component of a brick is a plane
      std::int64_t bytes_written = 0;
      std::int64_t planes_read = 0;
    };
    std::optional<Budget> budget;  // none: no limit

    std::int64_t gpu_pages_resident = 0;
    std::int64_t gpu_pages_total = 0;
    std::int64_t gpu_bytes = 0;
  } memory;

  std::vector<std::string> left_out;
};

std::int64_t peak_rss_bytes();  // of this process, up to now

// JSON text, indented.
std::string to_json(const RunStatistics& statistics);

// Seconds since the program was loaded, before main() ran.
double seconds_since_program_start();

}  // namespace maille
