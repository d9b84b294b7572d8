// The picture: everything between bricks of voxels and pixels, behind one door.
//
// One thread, the render thread, owns a Renderer and makes every call. Only
// VolumeTexture::lend and finish may be called by others (through texture()).
//
//   auto renderer = Renderer::create({.device = "", .store = gpu::Store::automatic});
//   renderer->set_volume(volume);
//   renderer->set_transfer_function(...), set_settings(...);
//   renderer->stream(renderer->bricks_wanted(), pool, fill);
//   renderer->render(camera, {800, 600});
//   auto pixels = renderer->read_picture();     // or renderer->present(window_pixels, overlay)
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "gpu/device.h"
#include "gpu/gpu_timers.h"
#include "gpu/swapchain.h"
#include "render/camera.h"
#include "render/pick.h"
#include "render/transfer_function.h"
#include "render/volume_texture.h"
#include "volume/statistics.h"
#include "volume/volume.h"

struct GLFWwindow;

namespace maille {

struct RendererOptions {
  std::string device = {};  // index or part of a name; empty: the best
  gpu::Store store = gpu::Store::automatic;
  GLFWwindow* window = nullptr;  // none: headless; GLFW is not touched
  bool vsync = true;
  bool print_validation = false;  // to stderr too, in builds with MAILLE_VALIDATION
  std::shared_ptr<gpu::ValidationLog> validation_log = nullptr;  // see gpu::InstanceOptions::log
  int staging_slots = 64;                                        // 4 MiB of 16-bit bricks
};

struct RenderSettings {
  RenderMode mode = RenderMode::composite;
  double iso_value = 0.0;    // stored units; also what a pick looks for
  double step_voxels = 1.0;  // sampling distance; > 0
  bool shading = true;
  // A composite takes what lies between two samples for all values on the way: without, what is
  // thinner than a step shows rings.
  bool preintegration = true;
  glm::dvec3 background{0.1, 0.11, 0.13};
  // false marches through everything (dense store only): same pixels, for tests and measuring
  bool skip_empty = true;
  bool operator==(const RenderSettings&) const = default;
};

struct Picture {
  PictureSize size{0};
  std::vector<std::uint8_t> rgba;  // rows from the top, sRGB-encoded, alpha 255
};

struct RenderCounters {
  std::int64_t bricks_uploaded = 0;
  std::uint64_t bytes_uploaded = 0;
  std::int64_t pages_resident = 0;
  std::int64_t pages_total = 0;
  std::uint64_t gpu_bytes = 0;
  int pipelines = 0;  // made so far; the pick pipeline only with the first pick
  std::int64_t frames = 0;
};

// What set_volume takes for the lowest value: nothing of integers is not finite. A float volume is
// read for it. None: nothing in it is finite.
std::optional<double> lowest_value_of(const Volume& volume);

// The voxels of one brick in texture encoding (see VolumeTexture); called by several workers at
// once.
using FillBrick = std::function<void(std::int64_t brick, VoxelBox box, std::span<std::byte> voxels,
                                     bool flip_sign_bit, int worker)>;

class Renderer {
 public:
  // Errors: device (none fits, listing those there are; sparse demanded where there is none).
  static Result<std::unique_ptr<Renderer>> create(const RendererOptions& options);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  // Makes the texture for a volume of this size, type and place; nothing is uploaded. The transfer
  // function, settings and counters stay. lowest_value: what is shown where samples of a float
  // volume are not finite (see VolumeTexture::create). Errors: device, out_of_memory.
  Result<void> set_volume(Size3 size, VoxelType type, const glm::dmat4& world_from_voxel,
                          std::optional<double> lowest_value = 0.0);
  // The same of a whole volume; one of floats is read for the lowest value.
  Result<void> set_volume(const Volume& volume);

  // Both may make bricks wanted (sparse store).
  Result<void> set_transfer_function(const TransferFunction& transfer);
  Result<void> set_settings(const RenderSettings& settings);
  const TransferFunction& transfer_function() const;
  const RenderSettings& settings() const;

  std::vector<std::int64_t> bricks_wanted() const;
  // Streams these bricks, and those seen before that become wanted by it (in pages that come). Seen
  // whole by the next render().
  // fill is called within pool; the time it takes overlaps the copies.
  Result<void> stream(std::span<const std::int64_t> bricks, WorkerPool& pool,
                      const FillBrick& fill);

  // Submits; does not wait. Errors: failed (no volume), device, out_of_memory.
  Result<void> render(const Camera& camera, PictureSize size);
  // The last render()'s picture. Waits for it.
  Result<Picture> read_picture();
  // Where the ray through a pixel's centre first meets iso_value with something visible, in every
  // mode, or nullopt. A pick of its own: waits.
  Result<std::optional<PickHit>> pick(const Camera& camera, PictureSize size, glm::ivec2 pixel);
  Result<std::optional<PickHit>> pick(const Ray& ray);

  // --- with a window ---
  // Shows the last render()'s picture (a clear window before the first). See Swapchain::present.
  Result<bool> present(glm::ivec2 window_pixels, const gpu::DrawOverlay& overlay = {});
  gpu::OverlayTarget overlay_target() const;
  // Records, submits and waits: for what an overlay has to upload (its fonts).
  Result<void> run_commands(const std::function<void(VkCommandBuffer)>& record);

  Result<void> wait_idle();
  VolumeTexture* texture();  // null before set_volume
  const gpu::Device& device() const;
  bool sparse_store() const;
  RenderCounters counters() const;
  // By pass: "raycast", "upload", "pick".
  std::map<std::string, gpu::PassTime, std::less<>> gpu_times();
  // What the validation layer said so far, which should be nothing; forgets it. Empty in builds
  // without validation.
  std::vector<std::string> take_validation_messages();

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace maille
