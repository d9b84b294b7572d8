// What the command line says: one struct a command, and what they share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/scene.h"
#include "core/result.h"
#include "core/spaces.h"
#include "gpu/device.h"
#include "render/camera.h"

namespace maille {

struct GlobalOptions {
  std::string device;  // index or part of a name; empty: the best
  gpu::Store store = gpu::Store::automatic;
  int threads = 0;  // 0: one a hardware thread
  std::uint64_t seed = 1;
  bool deterministic = false;
  std::int64_t undo_memory_bytes = std::int64_t{1} << 30;
  std::optional<std::int64_t> lattice_memory_bytes;  // else as much as it needs
  bool quiet = false;
  bool verbose = false;
};

struct RenderOptions {
  std::filesystem::path input;
  std::filesystem::path output;
  PictureSize size{512, 512};
  std::filesystem::path stats;
  std::filesystem::path trace;
  std::filesystem::path frames;
};

struct DeformOptions {
  std::filesystem::path input;
  std::filesystem::path output;
  std::filesystem::path field;
  std::filesystem::path forward_field;
  SavedExtent extent = SavedExtent::grow;
  std::filesystem::path stats;
  std::filesystem::path trace;
};

struct PickOptions {
  std::filesystem::path input;
  glm::dvec2 pixel{0};
  PictureSize size{512, 512};
};

struct InfoOptions {
  std::filesystem::path file;
  bool json = false;
};

struct PhantomOptions {
  std::string name;
  Size3 size{128};
  std::filesystem::path output;
};

struct DemoOptions {
  std::filesystem::path input;  // a volume or a scene; empty: the built-in head
  std::filesystem::path output = "out/demo";
  PictureSize size{512, 512};
};

struct MeasureOptions {
  std::string stage;                   // of measure error
  std::vector<std::int64_t> elements;  // of its scenes; empty: the stage's own choice
  std::filesystem::path head;          // a scan with a nose; empty: the built-in head
  std::vector<std::string> groups;     // of measure stability; empty: all
  int edge = 12;                       // of its blocks, voxels
  std::optional<int> volume_edge;      // of the volumes of measure error; none: 128
  PictureSize picture{512, 512};       // of measure frame
  std::filesystem::path output;
};

struct WindowCommandOptions {
  std::filesystem::path input;  // a volume or a scene; empty: the built-in head
};

// One file a command. Results go to stdout.
Result<void> run_render(const RenderOptions& options, const GlobalOptions& global);
Result<void> run_deform(const DeformOptions& options, const GlobalOptions& global);
Result<void> run_pick(const PickOptions& options, const GlobalOptions& global);
Result<void> run_info(const InfoOptions& options, const GlobalOptions& global);
Result<void> run_phantom(const PhantomOptions& options, const GlobalOptions& global);
Result<void> run_demo(const DemoOptions& options, const GlobalOptions& global);
Result<void> run_measure_speed(const MeasureOptions& options, const GlobalOptions& global);
// Errors: usage (a stage that has no page, the message lists those that have).
Result<void> run_measure_error(const MeasureOptions& options, const GlobalOptions& global);
Result<void> run_measure_frame(const MeasureOptions& options, const GlobalOptions& global);
// Errors: failed where the promise does not hold, when all is written.
Result<void> run_measure_stability(const MeasureOptions& options, const GlobalOptions& global);
Result<void> run_window_command(const WindowCommandOptions& options, const GlobalOptions& global);
Result<void> list_devices();

}  // namespace maille
