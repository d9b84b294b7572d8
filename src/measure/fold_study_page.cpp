#include "measure/fold_study_page.h"

#include "measure/text_table.h"

namespace maille {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const FoldStudy::Way& way) {
  return {{"way", way.name},
          {"title", way.title},
          {"rms_voxels", way.rms_voxels},
          {"max_voxels", way.max_voxels},
          {"folded_cells", way.folded_cells},
          {"least_determinant", way.least_determinant},
          {"energy_excess", way.energy_excess},
          {"steps", way.steps},
          {"inner_steps", way.inner_steps},
          {"seconds", way.seconds},
          {"finished", way.finished}};
}

Json json_of(const FoldStudy::Scene& scene) {
  Json ways = Json::array();
  for (const FoldStudy::Way& way : scene.ways) ways.push_back(json_of(way));
  return {{"scene", scene.name},
          {"title", scene.title},
          {"rest_vector_blend", scene.blend},
          {"free_elements", scene.free_elements},
          {"folded_at_start", scene.folded_at_start},
          {"start_rms_voxels", scene.start_rms_voxels},
          {"start_max_voxels", scene.start_max_voxels},
          {"ways", std::move(ways)}};
}

Json json_of(const FoldStudy::Blend& blend) {
  return {{"rest_vector_blend", blend.blend},
          {"folded_cells", blend.folded_cells},
          {"converged", blend.converged},
          {"stable", blend.stable},
          {"detour_apart_voxels", blend.detour_apart_voxels},
          {"rest_apart_voxels", blend.rest_apart_voxels},
          {"rest_folded_cells", blend.rest_folded_cells},
          {"guarded_detour_apart_voxels", blend.guarded_detour_apart_voxels},
          {"guarded_folded_cells", blend.guarded_folded_cells},
          {"ball_turn", blend.ball_turn},
          {"ball_turn_blend_in_soft", blend.ball_turn_blend_in_soft},
          {"seconds", blend.seconds}};
}

}  // namespace

Json json_of(const FoldStudy& study) {
  Json scenes = Json::array();
  for (const FoldStudy::Scene& scene : study.scenes) scenes.push_back(json_of(scene));
  Json blends = Json::array();
  for (const FoldStudy::Blend& blend : study.blends) blends.push_back(json_of(blend));
  return {{"scenes", std::move(scenes)}, {"blends", std::move(blends)}};
}

std::string text_of(const FoldStudy& study) {
  std::string out =
      "Ways to keep cells from folding (reference code, double precision)\n"
      "RMS, max: voxels from the equilibrium of the springs alone; excess: energy of the springs "
      "above it, of what the start has\n";
  for (const FoldStudy::Scene& scene : study.scenes) {
    std::vector<std::vector<std::string>> rows = {
        {"way", "RMS", "max", "folded", "least J", "excess", "steps", "inner", "s", "finished"}};
    for (const FoldStudy::Way& way : scene.ways) {
      rows.push_back({way.title, fixed_number(way.rms_voxels, 4), fixed_number(way.max_voxels, 3),
                      std::to_string(way.folded_cells), fixed_number(way.least_determinant, 3),
                      fixed_number(way.energy_excess, 5), std::to_string(way.steps),
                      std::to_string(way.inner_steps), fixed_number(way.seconds, 2),
                      way.finished ? "yes" : "no"});
    }
    out += "\n" + scene.title + ": " + std::to_string(scene.free_elements) +
           " free elements; the start: RMS " + fixed_number(scene.start_rms_voxels, 4) + ", max " +
           fixed_number(scene.start_max_voxels, 3) + ", " + std::to_string(scene.folded_at_start) +
           " folded\n" + text_table(rows);
  }
  std::vector<std::vector<std::string>> rows = {{"blend", "folded", "detour apart", "rest apart",
                                                 "rest folded", "barrier: detour apart", "folded",
                                                 "ball turns", "same b k"}};
  for (const FoldStudy::Blend& blend : study.blends) {
    rows.push_back({fixed_number(blend.blend, 3), std::to_string(blend.folded_cells),
                    fixed_number(blend.detour_apart_voxels, 6),
                    fixed_number(blend.rest_apart_voxels, 6),
                    std::to_string(blend.rest_folded_cells),
                    fixed_number(blend.guarded_detour_apart_voxels, 6),
                    std::to_string(blend.guarded_folded_cells), fixed_number(blend.ball_turn, 3),
                    fixed_number(blend.ball_turn_blend_in_soft, 3)});
  }
  out +=
      "\nThe rest-vector blend: how far apart equilibria from different starts are (voxels, "
      "largest), and how far a ball 1000 times\nstiffer turns in a sheared medium, of what it "
      "should: with the blend in both, and with blend times stiffness the same in both\n" +
      text_table(rows);
  return out;
}

}  // namespace maille
