#include <cstdio>

#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/paths.h"
#include "app/run_options.h"

namespace maille {
namespace {

nlohmann::ordered_json numbers(glm::dvec3 v) { return {v.x, v.y, v.z}; }

}  // namespace

Result<void> run_pick(const PickOptions& options, const GlobalOptions& global) {
  const glm::dvec2 at = options.pixel;
  if (!(at.x >= 0 && at.y >= 0 && at.x < options.size.x && at.y < options.size.y)) {
    return Error{ErrorKind::usage, "pick: expected a pixel inside the picture of " +
                                       std::to_string(options.size.x) + "x" +
                                       std::to_string(options.size.y)};
  }
  auto scene = open_scene(options.input);
  if (!scene) return scene.error();
  if (auto checked = check_action_outputs(*scene, true); !checked) return checked;
  auto loaded = load_volume(*scene, global.seed);
  if (!loaded) return loaded.error();
  auto headless = headless_options("pick", global);
  headless.document.purpose.pictures = true;
  headless.document.purpose.picks = true;
  headless.view = view_options(options.size, global);
  auto run = Headless::open(*std::move(scene), *std::move(loaded), headless);
  if (!run) return run.error();
  if (auto played = run->play(); !played) return played;
  const auto hit = run->pick(glm::ivec2(glm::floor(at)));
  if (!hit) return hit.error();
  nlohmann::ordered_json out;
  if (hit.value()) {
    const PickHit& found = *hit.value();
    out = {{"voxel", numbers(found.voxel)},
           {"world_mm", numbers(found.world_mm)},
           {"rest_voxel", numbers(run->view()->rest_voxel(found.voxel))},
           {"value", found.value},
           {"normal", numbers(found.normal)}};
  }
  if (auto finished = run->finish(); !finished) return finished;
  std::printf("%s\n", out.dump(2).c_str());
  return {};
}

}  // namespace maille
