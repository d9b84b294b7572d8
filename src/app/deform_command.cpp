#include "app/commands.h"
#include "app/paths.h"
#include "app/run_options.h"

namespace maille {

Result<void> run_deform(const DeformOptions& options, const GlobalOptions& global) {
  if (auto checked = check_outputs({{OutputKind::volume, "--output", options.output},
                                    {OutputKind::volume, "--field", options.field},
                                    {OutputKind::volume, "--forward-field", options.forward_field},
                                    {OutputKind::text, "--stats", options.stats},
                                    {OutputKind::text, "--trace", options.trace}});
      !checked) {
    return checked;
  }
  auto scene = open_scene(options.input);
  if (!scene) return scene.error();
  if (auto checked = check_action_outputs(*scene, false); !checked) return checked;
  auto loaded = load_volume(*scene, global.seed);
  if (!loaded) return loaded.error();
  auto headless = headless_options("deform", global);
  headless.stats = options.stats;
  headless.trace = options.trace;
  auto run = Headless::open(*std::move(scene), *std::move(loaded), headless);
  if (!run) return run.error();
  if (auto played = run->play(); !played) return played;
  SaveAction save;
  save.volume = options.output;
  save.extent = options.extent;
  if (!options.field.empty()) save.field = options.field;
  if (auto saved = run->document().save(save); !saved) return saved;
  if (!options.forward_field.empty()) {
    if (auto saved = run->document().save_forward_field(options.forward_field); !saved) {
      return saved;
    }
  }
  return run->finish();
}

}  // namespace maille
