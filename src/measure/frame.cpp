#include "measure/frame.h"

#include <algorithm>
#include <array>

#include "core/stopwatch.h"
#include "volume/phantom.h"

namespace maille {
namespace {

struct Picturing {
  RenderMode mode;
  bool shading;
};

constexpr std::array<Picturing, 4> kPicturings{{{RenderMode::composite, true},
                                                {RenderMode::composite, false},
                                                {RenderMode::iso, true},
                                                {RenderMode::mip, false}}};

// One renderer with one volume in it.
class Stage {
 public:
  Stage(const FrameOptions& options, Volume volume)
      : options_(options), volume_(std::move(volume)), pool_(options.threads) {}

  Result<void> open() {
    auto renderer = Renderer::create(options_.renderer);
    if (!renderer) return renderer.error();
    renderer_ = *std::move(renderer);
    const auto transfer = TransferFunction::preset("ct-skin", 0.0, 1.0);
    if (!transfer) return transfer.error();
    if (auto set = renderer_->set_transfer_function(*transfer); !set) return set;
    if (auto set = renderer_->set_settings(settings_of(kPicturings[0])); !set) return set;
    if (auto set = renderer_->set_volume(volume_); !set) return set;
    camera_ = framing(volume_.size(), volume_.world_from_voxel(), options_.picture);
    return stream(renderer_->bricks_wanted());
  }

  Renderer& renderer() { return *renderer_; }
  const Volume& volume() const { return volume_; }

  Result<void> stream(std::span<const std::int64_t> bricks) {
    return renderer_->stream(
        bricks, pool_, [&](std::int64_t, VoxelBox box, std::span<std::byte> voxels, bool, int) {
          copy_brick(volume_, box, voxels);
        });
  }
  // Seconds until it is there.
  Result<double> frame() {
    const Stopwatch start;
    if (auto done = renderer_->render(camera_, options_.picture); !done) return done.error();
    if (auto done = renderer_->wait_idle(); !done) return done.error();
    return start.seconds();
  }
  Result<double> pick() {
    const Stopwatch start;
    if (auto hit = renderer_->pick(camera_, options_.picture, options_.picture / 2); !hit) {
      return hit.error();
    }
    return start.seconds();
  }
  static RenderSettings settings_of(const Picturing& picturing) {
    RenderSettings settings;
    settings.mode = picturing.mode;
    settings.shading = picturing.shading;
    settings.iso_value = -300.0;
    return settings;
  }

 private:
  const FrameOptions& options_;
  Volume volume_;
  WorkerPool pool_;
  std::unique_ptr<Renderer> renderer_;
  Camera camera_;
};

Result<FrameReport::Row> measure_row(Stage& stage, const Picturing& picturing, int runs) {
  FrameReport::Row row;
  row.volume = stage.volume().size();
  row.mode = picturing.mode;
  row.shading = picturing.shading;
  Renderer& renderer = stage.renderer();
  if (auto set = renderer.set_settings(Stage::settings_of(picturing)); !set) return set.error();
  if (auto done = stage.stream(renderer.bricks_wanted()); !done) return done.error();
  std::vector<double> seconds, raycast;
  // The first compiles the pipeline.
  for (int run = -1; run < runs; ++run) {
    const auto took = stage.frame();
    if (!took) return took.error();
    if (run < 0) continue;
    seconds.push_back(*took);
    const auto times = renderer.gpu_times();
    if (const auto found = times.find("raycast"); found != times.end()) {
      raycast.push_back(found->second.last_ms);
    }
  }
  row.frame = timing_of(std::move(seconds));
  if (!raycast.empty()) row.raycast_ms = timing_of(std::move(raycast)).median_seconds;
  return row;
}

// change() is made before every other picture.
template <class F>
Result<Timing> extra_of(Stage& stage, int runs, F&& change) {
  std::vector<double> seconds;
  if (auto warm = stage.frame(); !warm) return warm.error();
  for (int run = 0; run < runs; ++run) {
    const auto plain = stage.frame();
    if (!plain) return plain.error();
    const Stopwatch start;
    if (Result<void> changed = change(run); !changed) return changed.error();
    const double change_seconds = start.seconds();
    const auto after = stage.frame();
    if (!after) return after.error();
    seconds.push_back(change_seconds + *after - *plain);
  }
  return timing_of(std::move(seconds));
}

Result<void> measure_changes(Stage& stage, int runs, FrameReport& report) {
  const Size3 volume = stage.volume().size();
  Renderer& renderer = stage.renderer();
  if (auto set = renderer.set_settings(Stage::settings_of(kPicturings[0])); !set) return set;
  const BrickGrid grid(volume);
  // Around where a nose is: in the middle of the face.
  const auto bricks_around = [&](int count) {
    const glm::dvec3 nose = glm::dvec3(volume) / double{kBrickEdge} * glm::dvec3(0.5, 0.1, 0.5);
    std::vector<std::int64_t> bricks(static_cast<std::size_t>(grid.count()));
    for (std::size_t i = 0; i < bricks.size(); ++i) bricks[i] = static_cast<std::int64_t>(i);
    const auto away = [&](std::int64_t b) {
      return glm::length(glm::dvec3(grid.brick(b)) + 0.5 - nose);
    };
    std::stable_sort(bricks.begin(), bricks.end(),
                     [&](std::int64_t a, std::int64_t b) { return away(a) < away(b); });
    bricks.resize(static_cast<std::size_t>(std::min<std::int64_t>(count, grid.count())));
    std::sort(bricks.begin(), bricks.end());
    return bricks;
  };
  constexpr int kMillionVoxels = 31;  // bricks
  for (const int count : {8, kMillionVoxels}) {
    const auto bricks = bricks_around(count);
    const auto extra = extra_of(stage, runs, [&](int) { return stage.stream(bricks); });
    if (!extra) return extra.error();
    report.changes.push_back(
        {count == 8 ? "8 bricks changed" : "a million voxels changed", volume, *extra});
  }
  const TransferFunction before = renderer.transfer_function();
  const auto extra = extra_of(stage, runs, [&](int run) -> Result<void> {
    auto points = std::vector<TransferPoint>(before.points().begin(), before.points().end());
    points[1].value += 10.0 * (run % 2 + 1);
    const auto edited = TransferFunction::of(std::move(points));
    if (!edited) return edited.error();
    if (auto set = renderer.set_transfer_function(*edited); !set) return set;
    return stage.stream(renderer.bricks_wanted());
  });
  if (!extra) return extra.error();
  report.changes.push_back({"transfer function edited", volume, *extra});
  if (auto set = renderer.set_transfer_function(before); !set) return set;
  if (auto done = stage.stream(renderer.bricks_wanted()); !done) return done;
  std::vector<double> picks;
  for (int run = -1; run < runs; ++run) {
    const auto took = stage.pick();
    if (!took) return took.error();
    if (run >= 0) picks.push_back(*took);
  }
  report.changes.push_back({"a pick", volume, timing_of(std::move(picks))});
  return {};
}

}  // namespace

Result<FrameReport> measure_frame(const FrameOptions& options) {
  FrameReport report;
  options.progress("memory bandwidth");
  const std::array threads{1, options.threads};
  report.machine = this_machine(threads);
  report.picture = options.picture;
  for (const Size3 size : options.volumes) {
    options.progress("a head of " + std::to_string(size.x) + " x " + std::to_string(size.y) +
                     " x " + std::to_string(size.z) + " voxels");
    WorkerPool pool(options.threads);
    auto volume = make_phantom("head", size, options.seed, pool);
    if (!volume) return volume.error();
    Stage stage(options, *std::move(volume));
    if (auto opened = stage.open(); !opened) return opened.error();
    const auto& info = stage.renderer().device().info();
    report.device = info.name;
    report.driver = info.driver;
    report.sparse = stage.renderer().sparse_store();
    for (const Picturing& picturing : kPicturings) {
      auto row = measure_row(stage, picturing, options.runs);
      if (!row) return row.error();
      report.rows.push_back(*std::move(row));
    }
    if (auto done = measure_changes(stage, options.runs, report); !done) return done.error();
  }
  return report;
}

std::vector<FrameBar> bars_of(const FrameReport& report) {
  constexpr Size3 kSmall{256, 256, 256};
  constexpr Size3 kLarge{512, 512, 333};
  struct RowBar {
    const char* what;
    Size3 volume;
    RenderMode mode;
    double at_most_ms;
  };
  static constexpr RowBar kRows[] = {{"composite 256³", kSmall, RenderMode::composite, 140},
                                     {"composite 512x512x333", kLarge, RenderMode::composite, 180},
                                     {"iso-surface 256³", kSmall, RenderMode::iso, 20},
                                     {"iso-surface 512x512x333", kLarge, RenderMode::iso, 35}};
  struct ChangeBar {
    const char* what;
    double at_most_ms;
  };
  static constexpr ChangeBar kChanges[] = {{"8 bricks changed", 2},
                                           {"a million voxels changed", 25},
                                           {"transfer function edited", 40},
                                           {"a pick", 1}};
  std::vector<FrameBar> bars;
  for (const RowBar& bar : kRows) {
    for (const FrameReport::Row& row : report.rows) {
      if (row.volume != bar.volume || row.mode != bar.mode || !row.shading) continue;
      bars.push_back({bar.what, 1e3 * row.frame.median_seconds, bar.at_most_ms});
    }
  }
  for (const ChangeBar& bar : kChanges) {
    for (const FrameReport::Change& change : report.changes) {
      if (change.what != bar.what) continue;
      bars.push_back({change.what + ", " + std::to_string(change.volume.x) + "x" +
                          std::to_string(change.volume.y) + "x" + std::to_string(change.volume.z),
                      1e3 * change.extra.median_seconds, bar.at_most_ms});
    }
  }
  return bars;
}

std::span<const FramePeer> frame_peers() {
  constexpr Size3 kSmall{256, 256, 256};
  constexpr Size3 kLarge{512, 512, 333};
  static constexpr FramePeer kPeers[] = {
      {"VTK 9.1, GPU mapper on llvmpipe", kSmall, RenderMode::composite, 438},
      {"VTK 9.1, GPU mapper on llvmpipe", kLarge, RenderMode::composite, 568},
      {"VTK 9.1, GPU mapper on llvmpipe", kSmall, RenderMode::iso, 153},
      {"VTK 9.1, GPU mapper on llvmpipe", kLarge, RenderMode::iso, 275},
      {"VTK 9.1, fixed point, 2 threads", kSmall, RenderMode::composite, 380},
      {"VTK 9.1, fixed point, 2 threads", kLarge, RenderMode::composite, 311},
      {"VTK 9.1, fixed point, 2 threads", kSmall, RenderMode::iso, 87},
      {"VTK 9.1, fixed point, 2 threads", kLarge, RenderMode::iso, 97},
      {"Open VKL 2.0.1, 2 threads, AVX-512", kSmall, RenderMode::composite, 208},
      {"Open VKL 2.0.1, 2 threads, AVX-512", kLarge, RenderMode::composite, 237},
      {"Open VKL 2.0.1, 2 threads, AVX-512", kSmall, RenderMode::iso, 77},
      {"Open VKL 2.0.1, 2 threads, AVX-512", kLarge, RenderMode::iso, 79}};
  return kPeers;
}

}  // namespace maille
