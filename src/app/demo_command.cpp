#include <chrono>
#include <cstdio>

#include "app/commands.h"
#include "app/demo_scene.h"
#include "app/paths.h"
#include "app/run_options.h"

namespace maille {
namespace {

double million_a_second(double count, double seconds) {
  return seconds > 0.0 ? 1e-6 * count / seconds : 0.0;
}

double as_double(std::int64_t count) { return static_cast<double>(count); }

void print_measured(const RunStatistics& s) {
  std::printf("load        %6.2f s   %dx%dx%d %s\n", s.volume.load_seconds, s.volume.size.x,
              s.volume.size.y, s.volume.size.z, s.volume.type.c_str());
  if (s.chainmail) {
    std::printf("ChainMail   %6.2f s   %lld positions, %.1f million elements/s\n",
                s.chainmail->seconds, static_cast<long long>(s.chainmail->drags),
                million_a_second(as_double(s.chainmail->elements_moved), s.chainmail->seconds));
  }
  if (s.relaxation) {
    std::printf("relaxation  %6.2f s   %lld iterations, %.1f million updates/s, %s\n",
                s.relaxation->seconds, static_cast<long long>(s.relaxation->iterations),
                million_a_second(as_double(s.relaxation->element_updates), s.relaxation->seconds),
                s.relaxation->converged ? "converged" : "not converged yet");
  }
  if (s.resample) {
    std::printf("resample    %6.2f s   %.1f million voxels/s a thread\n", s.resample->seconds,
                million_a_second(as_double(s.resample->voxels), s.resample->seconds));
  }
  if (s.upload) {
    std::printf("upload      %6.2f s   %lld bricks, %.0f MB\n", s.upload->seconds,
                static_cast<long long>(s.upload->bricks), 1e-6 * as_double(s.upload->bytes));
  }
  if (s.frames) {
    std::printf("ray cast    %6.1f ms  a frame on %s, %zu frames\n", s.frames->raycast_ms,
                s.device ? s.device->name.c_str() : "?", s.frames->milliseconds.size());
    std::printf("first       %6.2f s   from the start of the program to the first picture\n",
                s.frames->first_picture_seconds.value_or(0.0));
  }
  if (s.pick && s.pick->count > 0) {
    std::printf("pick        %6.1f ms\n", 1e3 * s.pick->seconds / as_double(s.pick->count));
  }
}

// The pixel where the scene's first drag begins, as a person would press there; the middle of the
// picture where there is none.
glm::dvec2 first_press(const Document& document, const View& view) {
  glm::dvec2 pixel = glm::dvec2(view.size()) / 2.0;
  for (const Action& action : document.scene().actions) {
    const auto* const drag = std::get_if<DragAction>(&action);
    if (drag == nullptr) continue;
    if (const auto* const from = std::get_if<FromPixel>(&drag->from)) {
      pixel = from->pixel;
    } else {
      const auto place = transform_point(document.volume().world_from_voxel(),
                                         std::get<FromVoxel>(drag->from).voxel);
      pixel = project(view.camera(), view.size(), place).value_or(pixel);
    }
    break;
  }
  return glm::clamp(pixel, glm::dvec2(0.0), glm::dvec2(view.size() - 1));
}

}  // namespace

Result<void> run_demo(const DemoOptions& options, const GlobalOptions& global) {
  auto scene = options.input.empty() ? Result<Scene>(built_in_scene()) : open_scene(options.input);
  if (!scene) return scene.error();
  if (auto checked = check_action_outputs(*scene, true); !checked) return checked;
  if (auto made = make_folder(options.output); !made) return made;
  auto loaded = load_volume(*scene, global.seed);
  if (!loaded) return loaded.error();
  if (scene->actions.empty()) {
    loaded->range = statistics_of(loaded->volume, 1);
    add_demonstration(*scene, loaded->volume, *loaded->range);
  }

  auto headless = headless_options("demo", global);
  headless.document.purpose.pictures = true;
  headless.document.purpose.picks = true;
  headless.view = view_options(options.size, global);
  headless.frames = options.output / "frames";
  headless.stats = options.output / "stats.json";
  auto run = Headless::open(*std::move(scene), *std::move(loaded), headless);
  if (!run) return run.error();
  View& view = *run->view();
  if (auto written = run->write_picture(options.output / "before.png"); !written) return written;
  const auto pixel = first_press(run->document(), view);
  if (auto hit = run->pick(glm::ivec2(pixel)); !hit) return hit.error();
  if (auto played = run->play(); !played) return played;
  if (auto written = run->write_picture(options.output / "after.png"); !written) return written;
  if (auto finished = run->finish(); !finished) return finished;

  if (global.quiet) return {};
  const auto folder = options.output.string();
  print_measured(run->document().statistics());
  std::printf(
      "before      %s/before.png\nafter       %s/after.png\nframes      %s/frames\n"
      "statistics  %s/stats.json\n",
      folder.c_str(), folder.c_str(), folder.c_str(), folder.c_str());
  return {};
}

}  // namespace maille
