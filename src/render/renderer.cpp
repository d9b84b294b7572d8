#include "render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/trace.h"
#include "gpu/readback.h"
#include "render/pass_inputs.h"
#include "render/pick_pass.h"
#include "render/raycast_pass.h"

namespace maille {

struct Renderer::State {
  // In the order of construction: what is below uses what is above.
  RendererOptions options;
  std::unique_ptr<gpu::Instance> instance;
  gpu::Surface surface;
  std::unique_ptr<gpu::Device> device;
  std::unique_ptr<gpu::WorkQueue> queue;
  std::unique_ptr<gpu::GpuTimers> timers;
  std::optional<PassInputs> inputs;
  std::optional<gpu::Readback> readback;
  std::unique_ptr<gpu::Swapchain> swapchain;

  std::unique_ptr<VolumeTexture> texture;
  glm::dmat4 world_from_voxel{1.0};
  std::optional<TransferFunction> transfer;
  RenderSettings settings;
  std::vector<glm::vec4> table;

  gpu::Image2D picture;
  RaycastPass raycast;
  std::optional<PickPass> pick;
  bool raycast_bound = false;
  bool pick_bound = false;

  std::int64_t frames = 0;
  std::int64_t bricks_before = 0;  // of textures that are gone
  std::uint64_t bytes_before = 0;

  Result<void> show_what_is_visible() {
    if (!texture) return {};
    return texture->set_visibility({settings.mode, settings.iso_value, *transfer, halo_blocks()});
  }
  void rebuild_table() {
    table = integrates()
                ? transfer->integrated_table(shader::k_transfer_entries, settings.step_voxels)
                : transfer->table(shader::k_transfer_entries, settings.step_voxels);
  }
  bool integrates() const { return settings.preintegration && composites(settings.mode); }
  // Blocks that the way from a sample in one that shows something may lead through.
  int halo_blocks() const {
    if (!integrates()) return 0;
    return static_cast<int>(std::ceil(settings.step_voxels / kBlockEdge));
  }
  Result<void> fit_picture(PictureSize size);
  shader::PassConstants constants(const RayFan& fan) const {
    return pass_constants(
        {fan, world_from_voxel, settings.step_voxels, settings.iso_value, settings.background},
        *texture, *transfer);
  }
};

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}

Renderer::~Renderer() {
  if (state_->queue) (void)state_->queue->wait_all();
}

Result<std::unique_ptr<Renderer>> Renderer::create(const RendererOptions& options) {
  auto state = std::make_unique<State>();
  state->options = options;
  const bool window = options.window != nullptr;
  auto instance = gpu::Instance::create({.window = window,
                                         .print_messages = options.print_validation,
                                         .log = options.validation_log});
  if (!instance) return instance.error();
  state->instance = std::move(*instance);
  if (window) {
    auto surface = gpu::Surface::create(*state->instance, options.window);
    if (!surface) return surface.error();
    state->surface = std::move(*surface);
  }
  auto device = gpu::Device::create(
      *state->instance, {.name = options.device, .store = options.store, .window = window});
  if (!device) return device.error();
  state->device = std::move(*device);
  auto queue = gpu::WorkQueue::create(*state->device);
  if (!queue) return queue.error();
  state->queue = std::move(*queue);
  auto timers = gpu::GpuTimers::create(*state->queue);
  if (!timers) return timers.error();
  state->timers = std::move(*timers);
  auto inputs = PassInputs::create(*state->queue);
  if (!inputs) return inputs.error();
  state->inputs = std::move(*inputs);
  state->readback.emplace(*state->queue);
  if (window) {
    auto swapchain = gpu::Swapchain::create(*state->queue, state->surface.get(), options.vsync);
    if (!swapchain) return swapchain.error();
    state->swapchain = std::move(*swapchain);
  }
  auto transfer = TransferFunction::preset("relative", 0.0, 1.0);
  if (!transfer) return transfer.error();
  state->transfer = std::move(*transfer);
  state->rebuild_table();
  return std::unique_ptr<Renderer>(new Renderer(std::move(state)));
}

Result<void> Renderer::set_volume(Size3 size, VoxelType type, const glm::dmat4& world_from_voxel,
                                  std::optional<double> lowest_value) {
  State& s = *state_;
  if (auto idle = s.queue->wait_all(); !idle) return idle.error();
  if (s.texture) {
    s.bricks_before += s.texture->bricks_uploaded();
    s.bytes_before += s.texture->bytes_uploaded();
    s.texture.reset();  // before the new one, so that both need never fit at once
  }
  s.raycast_bound = s.pick_bound = false;
  auto texture = VolumeTexture::create(*s.queue, size, type, s.options.staging_slots, lowest_value,
                                       s.timers.get());
  if (!texture) return texture.error();
  if (auto fitted = s.inputs->fit(**texture); !fitted) return fitted.error();
  s.texture = std::move(*texture);
  s.world_from_voxel = world_from_voxel;
  return s.show_what_is_visible();
}

Result<void> Renderer::set_volume(const Volume& volume) {
  return set_volume(volume.size(), volume.type(), volume.world_from_voxel(),
                    lowest_value_of(volume));
}

std::optional<double> lowest_value_of(const Volume& volume) {
  if (volume.type() != VoxelType::float32) return 0.0;
  const VolumeStatistics statistics = statistics_of(volume, 1);
  if (statistics.nan_count == voxel_count(volume.size())) return std::nullopt;
  return statistics.lowest;
}

Result<void> Renderer::set_transfer_function(const TransferFunction& transfer) {
  State& s = *state_;
  if (transfer == *s.transfer) return {};
  s.transfer = transfer;
  s.rebuild_table();
  return s.show_what_is_visible();
}

Result<void> Renderer::set_settings(const RenderSettings& settings) {
  State& s = *state_;
  const RenderSettings before = s.settings;
  s.settings = settings;
  const bool same_steps = settings.step_voxels == before.step_voxels &&
                          settings.preintegration == before.preintegration;
  const bool same_mode = settings.mode == before.mode && settings.iso_value == before.iso_value;
  if (same_steps && same_mode) return {};
  s.rebuild_table();
  return s.show_what_is_visible();
}

const TransferFunction& Renderer::transfer_function() const { return *state_->transfer; }
const RenderSettings& Renderer::settings() const { return state_->settings; }

std::vector<std::int64_t> Renderer::bricks_wanted() const {
  return state_->texture ? state_->texture->bricks_wanted() : std::vector<std::int64_t>();
}

Result<void> Renderer::stream(std::span<const std::int64_t> bricks, WorkerPool& pool,
                              const FillBrick& fill) {
  const trace::Span span("stream bricks");
  State& s = *state_;
  if (!s.texture) return Error{ErrorKind::failed, "no volume to stream bricks of"};
  VolumeTexture& texture = *s.texture;
  // Half of the ring: while one half is copied, the other is filled.
  const auto chunk = static_cast<std::size_t>(std::max(1, texture.staging_slots() / 2));
  std::vector<std::int64_t> pending(bricks.begin(), bricks.end());
  while (!pending.empty()) {
    for (std::size_t begin = 0; begin < pending.size(); begin += chunk) {
      std::vector<VolumeTexture::StagedBrick> staged;
      for (std::size_t i = begin; i < std::min(begin + chunk, pending.size()); ++i) {
        auto lent = texture.lend(pending[i]);
        if (!lent) return lent.error();
        staged.push_back(std::move(*lent));
      }
      pool.for_each(static_cast<std::int64_t>(staged.size()), [&](std::int64_t index, int worker) {
        auto& brick = staged[static_cast<std::size_t>(index)];
        fill(brick.brick, brick.box, brick.voxels, texture.flips_sign_bit(), worker);
        texture.finish(std::move(brick));
      });
      auto submitted = texture.submit();
      if (!submitted) return submitted.error();
    }
    // Pages that came with these bricks may reach into bricks that were left out before.
    pending = texture.bricks_wanted_again();
  }
  return {};
}

Result<void> Renderer::State::fit_picture(PictureSize size) {
  const VkExtent2D extent{static_cast<std::uint32_t>(std::max(size.x, 0)),
                          static_cast<std::uint32_t>(std::max(size.y, 0))};
  const bool fits =
      picture && picture.extent().width == extent.width && picture.extent().height == extent.height;
  if (fits && raycast_bound) return {};
  if (auto idle = queue->wait_all(); !idle) return idle.error();
  if (!fits) {
    auto made = gpu::Image2D::create(*queue, extent, "picture");
    if (!made) return made.error();
    picture = std::move(*made);
  }
  raycast.bind(*inputs, *texture, picture);
  raycast_bound = true;
  return {};
}

Result<void> Renderer::render(const Camera& camera, PictureSize size) {
  const trace::Span span("render");
  State& s = *state_;
  if (!s.texture) return Error{ErrorKind::failed, "no volume to render"};
  if (auto fitted = s.fit_picture(size); !fitted) return fitted.error();
  // Unbound pages hold anything, so a sparse volume is never marched through without skipping.
  const RaycastVariant variant{s.settings.mode, s.settings.shading,
                               s.settings.skip_empty || sparse_store(), s.integrates()};
  if (auto made = s.raycast.prepare(*s.device, variant); !made) return made.error();
  auto commands = s.queue->begin();
  if (!commands) return commands.error();
  if (auto recorded =
          s.inputs->record(*commands, *s.texture, s.constants(fan_of(camera, size)), s.table);
      !recorded) {
    s.queue->abandon(*commands);
    return recorded.error();
  }
  const int timer = s.timers->start(*commands, "raycast");
  s.raycast.record(*commands, variant);
  s.timers->stop(*commands, timer);
  auto value = s.queue->submit(*commands);
  if (!value) return value.error();
  s.timers->submitted(*value);
  s.inputs->submitted(*value);
  ++s.frames;
  return {};
}

Result<Picture> Renderer::read_picture() {
  const trace::Span span("read picture");
  State& s = *state_;
  if (!s.picture) return Error{ErrorKind::failed, "no picture was rendered"};
  auto bytes = s.readback->image(s.picture);
  if (!bytes) return bytes.error();
  Picture picture;
  picture.size = {static_cast<int>(s.picture.extent().width),
                  static_cast<int>(s.picture.extent().height)};
  picture.rgba.resize(bytes->size());
  std::memcpy(picture.rgba.data(), bytes->data(), bytes->size());
  return picture;
}

Result<std::optional<PickHit>> Renderer::pick(const Camera& camera, PictureSize size,
                                              glm::ivec2 pixel) {
  return pick(ray_through_pixel(camera, size, pixel));
}

Result<std::optional<PickHit>> Renderer::pick(const Ray& ray) {
  const trace::Span span("pick");
  State& s = *state_;
  if (!s.texture) return Error{ErrorKind::failed, "no volume to pick from"};
  if (!s.pick) {
    auto made = PickPass::create(*s.queue);
    if (!made) return made.error();
    s.pick = std::move(*made);
  }
  if (!s.pick_bound) {
    if (auto idle = s.queue->wait_all(); !idle) return idle.error();
    s.pick->bind(*s.inputs, *s.texture);
    s.pick_bound = true;
  }
  auto commands = s.queue->begin();
  if (!commands) return commands.error();
  if (auto recorded = s.inputs->record(*commands, *s.texture, s.constants({}), s.table);
      !recorded) {
    s.queue->abandon(*commands);
    return recorded.error();
  }
  const glm::dmat4 voxel_from_world = glm::inverse(s.world_from_voxel);
  const Ray ray_voxel{transform_point(voxel_from_world, ray.origin_mm),
                      transform_vector(voxel_from_world, ray.direction)};
  const int timer = s.timers->start(*commands, "pick");
  s.pick->record(*commands, ray_voxel);
  s.timers->stop(*commands, timer);
  auto value = s.queue->submit(*commands);
  if (!value) return value.error();
  s.timers->submitted(*value);
  s.inputs->submitted(*value);
  if (auto done = s.queue->wait(*value); !done) return done.error();
  return s.pick->read(s.world_from_voxel, s.texture->texel_scale(), ray);
}

Result<bool> Renderer::present(glm::ivec2 window_pixels, const gpu::DrawOverlay& overlay) {
  State& s = *state_;
  if (!s.swapchain) return Error{ErrorKind::failed, "there is no window to present to"};
  return s.swapchain->present(s.picture ? &s.picture : nullptr,
                              {static_cast<std::uint32_t>(std::max(window_pixels.x, 0)),
                               static_cast<std::uint32_t>(std::max(window_pixels.y, 0))},
                              overlay);
}

gpu::OverlayTarget Renderer::overlay_target() const {
  return state_->swapchain ? state_->swapchain->overlay_target() : gpu::OverlayTarget{};
}

Result<void> Renderer::run_commands(const std::function<void(VkCommandBuffer)>& record) {
  return state_->queue->run(record);
}

Result<void> Renderer::wait_idle() { return state_->queue->wait_all(); }
VolumeTexture* Renderer::texture() { return state_->texture.get(); }
const gpu::Device& Renderer::device() const { return *state_->device; }
bool Renderer::sparse_store() const { return state_->device->sparse_store(); }

RenderCounters Renderer::counters() const {
  const State& s = *state_;
  RenderCounters counters;
  counters.bricks_uploaded = s.bricks_before;
  counters.bytes_uploaded = s.bytes_before;
  counters.gpu_bytes = s.inputs->gpu_bytes();
  if (s.texture) {
    const gpu::Footprint footprint = s.texture->footprint();
    counters.bricks_uploaded += s.texture->bricks_uploaded();
    counters.bytes_uploaded += s.texture->bytes_uploaded();
    counters.pages_resident = footprint.pages_resident;
    counters.pages_total = footprint.pages_total;
    counters.gpu_bytes += s.texture->gpu_bytes();
  }
  if (s.picture) {
    counters.gpu_bytes += std::uint64_t{4} * s.picture.extent().width * s.picture.extent().height;
  }
  counters.pipelines = s.raycast.pipelines() + (s.pick ? 1 : 0);
  counters.frames = s.frames;
  return counters;
}

std::map<std::string, gpu::PassTime, std::less<>> Renderer::gpu_times() {
  return state_->timers->times();
}

std::vector<std::string> Renderer::take_validation_messages() {
  return state_->instance->validation_log().take();
}

}  // namespace maille
