#include "app/commands.h"
#include "app/headless.h"
#include "app/paths.h"
#include "app/run_options.h"

namespace maille {

Result<void> run_render(const RenderOptions& options, const GlobalOptions& global) {
  if (auto checked = check_outputs({{OutputKind::folder, "--frames", options.frames},
                                    {OutputKind::picture, "--output", options.output},
                                    {OutputKind::text, "--stats", options.stats},
                                    {OutputKind::text, "--trace", options.trace}});
      !checked) {
    return checked;
  }
  auto scene = open_scene(options.input);
  if (!scene) return scene.error();
  if (auto checked = check_action_outputs(*scene, true); !checked) return checked;
  auto loaded = load_volume(*scene, global.seed);
  if (!loaded) return loaded.error();
  auto headless = headless_options("render", global);
  headless.document.purpose.pictures = true;
  headless.view = view_options(options.size, global);
  headless.frames = options.frames;
  headless.stats = options.stats;
  headless.trace = options.trace;
  auto run = Headless::open(*std::move(scene), *std::move(loaded), headless);
  if (!run) return run.error();
  if (auto played = run->play(); !played) return played;
  if (auto written = run->write_picture(options.output); !written) return written;
  return run->finish();
}

}  // namespace maille
