#include "app/commands.h"
#include "app/run_options.h"

namespace maille {

Result<void> run_deform(const DeformOptions& options, const GlobalOptions& global) {
  auto scene = open_scene(options.input);
  if (!scene) return scene.error();
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
