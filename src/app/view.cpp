#include "app/view.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/stopwatch.h"
#include "core/trace.h"

namespace maille {
namespace {

std::vector<std::int64_t> merged(const std::vector<std::int64_t>& a,
                                 const std::vector<std::int64_t>& b) {
  std::vector<std::int64_t> out;
  out.reserve(a.size() + b.size());
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
  return out;
}

// What one worker did; summed when the loop is over.
struct alignas(64) Share {
  ResampleCounts counts;
};

}  // namespace

Camera camera_of(const CameraSettings& settings, const Volume& volume, PictureSize size) {
  Camera camera = framing(volume.size(), volume.world_from_voxel(), size);
  auto offset = camera.eye_mm - camera.target_mm;
  // A narrower view frames the same from farther away.
  const double half = std::tan(glm::radians(camera.vertical_fov_degrees) / 2);
  offset *= half / std::tan(glm::radians(settings.vertical_fov_degrees) / 2);
  camera.vertical_fov_degrees = settings.vertical_fov_degrees;
  camera.up = settings.up;
  if (settings.target_mm) camera.target_mm = *settings.target_mm;
  camera.eye_mm = settings.eye_mm.value_or(camera.target_mm + offset);
  return camera;
}

View::View(Document& document, const ViewOptions& options)
    : volume_(document.volume()),
      extent_(document.shown_extent()),
      pool_(document.pool()),
      picks_(document.plan().pick_pass),
      size_(options.size),
      camera_(camera_of(document.scene().camera, volume_, options.size)) {}

Result<std::unique_ptr<View>> View::create(Document& document, const ViewOptions& options) {
  const trace::Span span("make renderer");
  std::unique_ptr<View> view(new View(document, options));
  auto renderer = Renderer::create(options.renderer);
  if (!renderer) return renderer.error();
  view->renderer_ = *std::move(renderer);
  const auto transfer = document.transfer_function();
  if (!transfer) return transfer.error();
  const auto& scene = document.scene().render;
  RenderSettings settings;
  settings.mode = scene.mode;
  settings.iso_value = scene.iso_value.value_or(transfer->surface_value());
  settings.step_voxels = scene.step_voxels;
  settings.shading = scene.shading;
  settings.preintegration = scene.preintegration;
  settings.background = scene.background;
  // Settings first: what is visible is then decided once, and nothing is wanted that is not seen.
  if (auto set = view->renderer_->set_settings(settings); !set) return set.error();
  if (auto set = view->renderer_->set_transfer_function(*transfer); !set) return set.error();
  const glm::dmat4 place = world_from_voxel_of(view->volume_, view->extent_);
  if (auto set = view->renderer_->set_volume(view->extent_.size(), view->volume_.type(), place,
                                             lowest_value_of(view->volume_));
      !set) {
    return set.error();
  }
  // Beyond the volume there is nothing to copy.
  if (view->extent_ != VoxelBox{VoxelIndex(0), view->volume_.size()}) {
    view->resampler_ = std::make_shared<const Resampler>(document.resampler());
  }
  return view;
}

Result<void> View::show(ViewUpdate update) {
  resampler_ = std::move(update.resampler);
  return stream(merged(update.bricks, renderer_->bricks_wanted()));
}

Result<void> View::show_wanted() { return stream(renderer_->bricks_wanted()); }

Result<void> View::stream(const std::vector<std::int64_t>& bricks) {
  const trace::Span span("show");
  const Stopwatch start;
  std::vector<Share> shares(static_cast<std::size_t>(pool_.thread_count()));
  const FillBrick fill = [&](std::int64_t, VoxelBox box, std::span<std::byte> voxels,
                             bool flip_sign_bit, int worker) {
    if (!resampler_) return copy_brick(volume_, box, voxels);
    const trace::Span brick_span("resample brick");
    const Stopwatch brick_start;
    auto counts = resampler_->resample(shifted(box, extent_.lo), voxels, flip_sign_bit);
    counts.timed(brick_start.seconds());
    shares[static_cast<std::size_t>(worker)].counts += counts;
  };
  if (auto streamed = renderer_->stream(bricks, pool_, fill); !streamed) return streamed;

  ResampleCounts counts;
  for (const Share& share : shares) counts += share.counts;
  resample_.add(counts);
  const double busy = counts.resample_seconds + counts.copy_seconds;
  upload_.seconds += std::max(0.0, start.seconds() - busy / pool_.thread_count());
  return {};
}

Result<Picture> View::picture() {
  const trace::Span span("picture");
  const Stopwatch start;
  if (auto rendered = renderer_->render(camera_, size_); !rendered) return rendered.error();
  auto picture = renderer_->read_picture();
  if (!picture) return picture;
  frames_.milliseconds.push_back(1e3 * start.seconds());
  if (!frames_.first_picture_seconds) {
    frames_.first_picture_seconds = seconds_since_program_start();
  }
  return picture;
}

Result<std::optional<PickHit>> View::pick(glm::ivec2 pixel, PictureSize size) {
  const trace::Span span("pick");
  const Stopwatch start;
  auto hit = renderer_->pick(camera_, size, pixel);
  if (hit && *hit) (*hit)->voxel += glm::dvec3(extent_.lo);
  ++pick_.count;
  pick_.seconds += start.seconds();
  return hit;
}

glm::dvec3 View::rest_voxel(glm::dvec3 voxel) const {
  if (!resampler_) return voxel;
  return resampler_->rest_position(voxel).value_or(voxel);
}

void View::report(RunStatistics& statistics) {
  const auto counters = renderer_->counters();
  const auto& info = renderer_->device().info();
  statistics.device = {info.name, info.driver, renderer_->sparse_store()};
  if (statistics.resample) {
    statistics.resample->add(resample_);
  }
  upload_.bricks = counters.bricks_uploaded;
  upload_.bytes = static_cast<std::int64_t>(counters.bytes_uploaded);
  statistics.upload = upload_;
  const auto passes = renderer_->gpu_times();
  const auto mean_ms = [&](std::string_view pass) {
    const auto found = passes.find(pass);
    if (found == passes.end() || found->second.count == 0) return 0.0;
    return found->second.total_ms / static_cast<double>(found->second.count);
  };
  frames_.raycast_ms = mean_ms("raycast");
  frames_.upload_ms = mean_ms("upload");
  frames_.pick_ms = mean_ms("pick");
  statistics.frames = frames_;
  if (picks_) statistics.pick = pick_;
  statistics.memory.gpu_pages_resident = counters.pages_resident;
  statistics.memory.gpu_pages_total = counters.pages_total;
  statistics.memory.gpu_bytes = static_cast<std::int64_t>(counters.gpu_bytes);
}

}  // namespace maille
