#include "app/plan.h"

#include <algorithm>

namespace maille {
namespace {

template <class T>
bool any_action(const Scene& scene) {
  return std::any_of(scene.actions.begin(), scene.actions.end(),
                     [](const Action& action) { return std::holds_alternative<T>(action); });
}

bool any_picked_drag(const Scene& scene) {
  return std::any_of(scene.actions.begin(), scene.actions.end(), [](const Action& action) {
    const auto* const drag = std::get_if<DragAction>(&action);
    return drag != nullptr && std::holds_alternative<FromPixel>(drag->from);
  });
}

}  // namespace

Plan plan_of(const Scene& scene, const Purpose& purpose) {
  Plan plan;
  plan.window = purpose.window;
  plan.vulkan = purpose.pictures || purpose.window;
  // Nothing leaves its place but by a drag, so without one there is nothing to relax either.
  plan.chainmail = purpose.window || any_action<DragAction>(scene);
  // The window has no tools for these yet.
  plan.cut = !purpose.window && any_action<CutAction>(scene);
  plan.carve =
      !purpose.window && (any_action<CarveAction>(scene) || any_action<RestoreAction>(scene));
  plan.undo = plan.deforms() &&
              (purpose.window || any_action<UndoAction>(scene) || any_action<RedoAction>(scene));
  plan.resampling = plan.deforms();
  plan.relaxation = plan.chainmail && scene.relaxation.enabled &&
                    (purpose.window || any_action<RelaxAction>(scene));
  plan.anchors = plan.chainmail && scene.anchors.faces != 0;
  plan.pick_pass = plan.vulkan && (purpose.window || purpose.picks || any_picked_drag(scene));
  plan.render_actions = plan.vulkan || !any_action<RenderAction>(scene);
  plan.shading = plan.vulkan && scene.render.shading;
  const RenderMode mode = scene.render.mode;
  plan.composite = plan.vulkan && (purpose.window || composites(mode));
  plan.iso = plan.vulkan && (purpose.window || shows_iso(mode));
  plan.mip = plan.vulkan && mode == RenderMode::mip;
  plan.average = plan.vulkan && mode == RenderMode::average;
  return plan;
}

void Plan::use(const MaterialTable& materials) {
  material_lookup = chainmail && materials.count() > 1;
  anchors = anchors || (chainmail && materials.any_fixed());
}

std::vector<std::string> Plan::left_out() const {
  std::vector<std::string> names;
  const auto add = [&](bool kept, const char* name) {
    if (!kept) names.emplace_back(name);
  };
  add(chainmail, "chainmail");
  add(cut, "cut");
  add(carve, "carve");
  add(undo, "undo");
  add(relaxation, "relaxation");
  add(resampling, "resampling");
  add(material_lookup, "material_lookup");
  add(anchors, "anchors");
  add(vulkan, "vulkan");
  add(pick_pass, "pick_pass");
  add(render_actions, "render_actions");
  add(shading, "shading");
  add(composite, "composite");
  add(iso, "iso");
  add(mip, "mip");
  add(average, "average");
  add(window, "window");
  return names;
}

}  // namespace maille
