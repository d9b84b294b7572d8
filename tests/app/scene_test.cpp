#include "app/scene.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace maille {
namespace {

std::string refusal(const std::string& text) {
  const auto scene = parse_scene(text, "dir/scene.json");
  if (scene.ok()) return "accepted";
  EXPECT_EQ(scene.error().kind, ErrorKind::bad_input);
  return scene.error().message;
}

std::string with(const std::string& members) {
  return R"({"volume": {"phantom": "head"}, )" + members + "}";
}

std::string with_action(const std::string& action) {
  return with(R"("actions": [{"undo": 1}, )" + action + "]");
}

TEST(Scene, OnlyTheVolumeIsNeeded) {
  const auto scene = parse_scene(R"({"volume": {"file": "head.nrrd"}})", "dir/scene.json");
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(std::get<std::filesystem::path>(scene.value().volume), "dir/head.nrrd");
  EXPECT_TRUE(scene.value().actions.empty());
  EXPECT_EQ(scene.value().resampling, ResampleMethod::linear);
  EXPECT_EQ(refusal("{}"), "dir/scene.json: volume: missing");
}

TEST(Scene, ReadsEveryKey) {
  const auto parsed = parse_scene(R"({
    "maille_scene": 1,
    "volume": {"phantom": "spheres", "size": [10, 20, 30], "seed": 7},
    "materials": {"interpolation": "step", "table": [
      {"name": "air", "values": [-2000, -300], "compress": 0.2, "stretch": 3.0, "shear": [1, 2, 3],
       "stiffness": 0.001, "rest_vector_blend": 0.5, "yield_strain": 0.125},
      {"name": "bone", "values": [200, 4000], "compress": 1.0, "stretch": 1.0, "shear": 0.0,
       "stiffness": 1000.0, "fixed": true}]},
    "anchors": {"faces": ["-z", "+x"]},
    "relaxation": {"enabled": false, "tolerance_voxels": 0.5},
    "resampling": "nearest",
    "transfer_function": {"points": [[-100, 0, 0, 0, 0], [100, 1, 0.5, 0.25, 1]]},
    "render": {"mode": "iso", "iso_value": -300, "step_voxels": 0.5, "shading": false,
               "background": [0, 0.5, 1]},
    "camera": {"eye_mm": [0, -600, 0], "target_mm": [1, 2, 3], "up": [0, 0, 1],
               "vertical_fov_degrees": 20},
    "actions": [
      {"drag": {"from": {"voxel": [1, 2, 3]}, "radius_voxels": 2, "by_voxels": [0, -5, 0],
                "steps": 9, "name": "nose"}},
      {"drag": {"from": {"pixel": [100, 50.5]}, "by_mm": [1, 0, 0]}},
      {"relax": {"until_voxels": 0.02, "at_most_seconds": 1}},
      {"render": {"to": "a/after.png"}}, {"release": {"name": "nose"}}, {"undo": 2}, {"redo": 1},
      {"save": {"volume": "/tmp/v.nrrd", "field": "f.nrrd"}},
      {"cut": {"polygon_mm": [[0, 0, 0], [10, 0, 0], [10, 10, 0]]}},
      {"cut": {"disc": {"center_voxel": [1, 2, 3], "normal": [0, 0, 2], "radius_mm": 4}}},
      {"cut": {"sweep": {"path_voxel": [[1, 2, 3], [4, 5, 6]], "direction": [0, 1, 0],
                         "depth_mm": 7}}},
      {"carve": {"center_mm": [1, 2, 3], "radius_voxels": 4}},
      {"restore": {"center_voxel": [1, 2, 3], "radius_voxels": 5}}]})",
                                  "dir/scene.json");
  ASSERT_TRUE(parsed.ok()) << parsed.error().message;
  const Scene& scene = *parsed;
  const auto& phantom = std::get<PhantomSource>(scene.volume);
  EXPECT_EQ(phantom.name, "spheres");
  EXPECT_EQ(phantom.size, Size3(10, 20, 30));
  EXPECT_EQ(phantom.seed, 7u);
  const auto& table = std::get<MaterialTable>(scene.materials);
  ASSERT_EQ(table.count(), 2);
  EXPECT_EQ(table.materials()[0].shear, glm::dvec3(1, 2, 3));
  EXPECT_TRUE(table.materials()[1].fixed);
  EXPECT_EQ(table.materials()[0].rest_vector_blend, 0.5);
  EXPECT_EQ(table.materials()[0].yield_strain, 0.125);
  EXPECT_DOUBLE_EQ(table.materials()[1].rest_vector_blend.value(), 0.25 * 0.001 / 1000);
  EXPECT_EQ(table.materials()[1].yield_strain, std::nullopt);
  EXPECT_EQ(scene.anchors.faces, face_low_z | face_high_x);
  EXPECT_FALSE(scene.anchors.free_border);
  EXPECT_FALSE(scene.relaxation.enabled);
  EXPECT_EQ(scene.relaxation.tolerance_voxels, 0.5);
  EXPECT_EQ(scene.resampling, ResampleMethod::nearest);
  EXPECT_EQ(std::get<TransferFunction>(scene.transfer_function).points().size(), 2u);
  EXPECT_EQ(scene.render.mode, RenderMode::iso);
  EXPECT_EQ(scene.render.iso_value, -300.0);
  EXPECT_FALSE(scene.render.shading);
  EXPECT_EQ(scene.camera.target_mm, glm::dvec3(1, 2, 3));
  ASSERT_EQ(scene.actions.size(), 13u);
  const auto& drag = std::get<DragAction>(scene.actions[0]);
  EXPECT_EQ(std::get<FromVoxel>(drag.from).voxel, glm::dvec3(1, 2, 3));
  EXPECT_EQ(drag.by, glm::dvec3(0, -5, 0));
  EXPECT_FALSE(drag.by_is_mm);
  EXPECT_EQ(drag.steps, 9);
  EXPECT_EQ(drag.name, "nose");
  const auto& picked = std::get<DragAction>(scene.actions[1]);
  EXPECT_EQ(std::get<FromPixel>(picked.from).pixel, glm::dvec2(100, 50.5));
  EXPECT_TRUE(picked.by_is_mm);
  EXPECT_EQ(std::get<RelaxAction>(scene.actions[2]).until_voxels, 0.02);
  EXPECT_EQ(std::get<RenderAction>(scene.actions[3]).to, "dir/a/after.png");
  EXPECT_EQ(std::get<UndoAction>(scene.actions[5]).count, 2);
  EXPECT_EQ(std::get<SaveAction>(scene.actions[7]).volume, "/tmp/v.nrrd");
  EXPECT_EQ(std::get<SaveAction>(scene.actions[7]).field, "dir/f.nrrd");
  const auto surface = [&](std::size_t i) { return std::get<CutAction>(scene.actions[i]).surface; };
  const auto polygon = std::get<CutPolygon>(surface(8));
  ASSERT_EQ(polygon.corners.size(), 3u);
  EXPECT_TRUE(polygon.corners[2].is_mm);
  EXPECT_EQ(polygon.corners[2].at, glm::dvec3(10, 10, 0));
  const auto disc = std::get<CutDisc>(surface(9));
  EXPECT_FALSE(disc.center.is_mm);
  EXPECT_EQ(disc.normal, glm::dvec3(0, 0, 2));
  EXPECT_EQ(disc.radius_mm, 4);
  const auto sweep = std::get<CutSweep>(surface(10));
  EXPECT_EQ(sweep.path.size(), 2u);
  EXPECT_EQ(sweep.depth_mm, 7);
  EXPECT_TRUE(std::get<CarveAction>(scene.actions[11]).ball.center.is_mm);
  EXPECT_EQ(std::get<RestoreAction>(scene.actions[12]).ball.radius_voxels, 5);
  EXPECT_EQ(name_of(scene.actions[8]), "cut");
  EXPECT_EQ(name_of(scene.actions[11]), "carve");
  EXPECT_EQ(name_of(scene.actions[12]), "restore");
}

TEST(Scene, EveryModeIsReadByItsName) {
  for (const RenderMode mode : kRenderModes) {
    const auto text = R"({"volume": {"phantom": "head"}, "render": {"mode": ")" +
                      std::string(name_of(mode)) + "\"}}";
    const auto scene = parse_scene(text, "dir/scene.json");
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->render.mode, mode);
  }
}

TEST(Scene, RefusalsNameFilePathAndExpectation) {
  const std::string known =
      " (known: drag, relax, cut, carve, restore, render, release, undo, redo, save)";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"[]", "expected an object, got an array of 0"},
      {R"({"volume": {"file": "x"}, "actoins": []})",
       "actoins: unknown key (known: maille_scene, volume, materials, anchors, relaxation, "
       "resampling, transfer_function, render, camera, actions)"},
      {with(R"("maille_scene": 2)"), "maille_scene: expected an integer from 1 to 1, got 2"},
      {R"({"volume": "head.nrrd"})", "volume: expected an object, got \"head.nrrd\""},
      {R"({"volume": {}})", "volume: expected a \"file\" or a \"phantom\""},
      {R"({"volume": {"file": "x", "size": [1,1,1]}})", "volume.size: unknown key (known: file)"},
      {R"({"volume": {"phantom": "head", "size": [0, 1, 1]}})",
       "volume.size[0]: expected an integer from 1 to 65536, got 0"},
      {R"({"volume": {"phantom": "head", "size": [1.5, 1, 1]}})",
       "volume.size[0]: expected an integer from 1 to 65536, got 1.5"},
      {R"({"volume": {"phantom": "head", "size": [1, 1]}})",
       "volume.size: expected an array of 3 integers, got an array of 2"},
      {R"({"volume": {"phantom": "head", "seed": -1}})",
       "volume.seed: expected an integer >= 0, got -1"},
      {with(R"("materials": {"interpolation": "cubic"})"),
       "materials.interpolation: expected \"step\" or \"linear\", got \"cubic\""},
      {with(R"("materials": {"limits": "hard"})"),
       "materials.limits: expected \"given\" or \"from_stiffness\", got \"hard\""},
      {with(R"("materials": {"limits": "from_stiffness", "preset": "ct"})"),
       "materials.limits: \"from_stiffness\" needs a \"table\""},
      {with(R"("materials": {"limits": "given", "softest": {}, "table": []})"),
       "materials.softest: needs \"limits\": \"from_stiffness\""},
      {with(
           R"("materials": {"limits": "from_stiffness", "softest": {"stretch": 0.5}, "table": []})"),
       "materials.softest.stretch: expected a number >= 1, got 0.5"},
      {with(R"("materials": {"limits": "from_stiffness", "softest": {"shear": [0, 0.3, 0]},
                             "table": []})"),
       "materials.softest: expected compress above twice shear, so that no cell folds"},
      {with(R"("materials": {"limits": "from_stiffness",
                             "table": [{"values": [0, 1], "stiffness": 2, "shear": 0}]})"),
       "materials.table[0].shear: given by stiffness, since materials.limits is "
       "\"from_stiffness\""},
      {with(R"("materials": {"limits": "from_stiffness", "table": [{"values": [0, 1]}]})"),
       "materials.table[0].stiffness: missing"},
      {with(R"("materials": {"limits": "from_stiffness",
                             "table": [{"name": "a", "values": [0, 1], "stiffness": 1e13}]})"),
       "materials.table: material \"a\": expected a stiffness within 1e-12 to 1e12"},
      {with(R"("materials": {"table": [{"values": [0, 1], "rigid": 1}]})"),
       "materials.table[0].rigid: expected true or false, got 1"},
      {with(R"("materials": {"table": [{"values": [0, 1], "rigid": true, "stretch": 1}]})"),
       "materials.table[0].stretch: a rigid material has no limits of its own"},
      {with(R"("materials": {"preset": "mri"})"),
       "materials.preset: expected \"ct\" or \"relative\", got \"mri\""},
      {with(R"("materials": {"preset": "ct", "table": []})"),
       "materials: expected a \"preset\" or a \"table\", not both"},
      {with(R"("materials": {"table": [{"values": [0, 1], "compress": 1.5}]})"),
       "materials.table[0].compress: expected a number from 0 to 1, got 1.5"},
      {with(R"("materials": {"table": [{"values": [0, 1], "stretch": [1, 0.5, 1]}]})"),
       "materials.table[0].stretch[1]: expected a number >= 1, got 0.5"},
      {with(R"("materials": {"table": [{"values": [0, 1], "stiffness": 0}]})"),
       "materials.table[0].stiffness: expected a number > 0, got 0"},
      {with(R"("materials": {"table": [{"values": [0, 1], "rest_vector_blend": 1.25}]})"),
       "materials.table[0].rest_vector_blend: expected a number from 0 to 1, got 1.25"},
      {with(R"("materials": {"table": [{"values": [0, 1], "rest_vector_blend": -1}]})"),
       "materials.table[0].rest_vector_blend: expected a number from 0 to 1, got -1"},
      {with(R"("materials": {"table": [{"values": [0, 1]},
                                       {"values": [1, 2], "yield_strain": 0}]})"),
       "materials.table[1].yield_strain: expected a number > 0, got 0"},
      {with(R"("materials": {"table": [{"values": [0, 1], "yield_strain": null}]})"),
       "materials.table[0].yield_strain: expected a number > 0, got null"},
      {with(R"("materials": {"table": [{"values": [1, 1]}]})"),
       "materials.table[0].values: expected [low, high) with low < high"},
      {with(R"("materials": {"table": [{"values": [1]}]})"),
       "materials.table[0].values: expected an array of 2 numbers, got an array of 1"},
      {with(R"("materials": {"table": [{"values": [0, 1], "fixed": 1}]})"),
       "materials.table[0].fixed: expected true or false, got 1"},
      {with(R"("anchors": "all")"),
       "anchors: expected \"none\" or an object with \"faces\", got \"all\""},
      {with(R"("anchors": {"faces": ["z"]})"),
       "anchors.faces[0]: expected \"-x\", \"+x\", \"-y\", \"+y\", \"-z\" or \"+z\", got \"z\""},
      {with(R"("relaxation": {"tolerance_voxels": 0})"),
       "relaxation.tolerance_voxels: expected a number > 0, got 0"},
      {with(R"("resampling": "cubic")"),
       "resampling: expected \"nearest\", \"linear\", \"barycentric\" or \"rbf\", got \"cubic\""},
      {with(R"("transfer_function": {"points": [[0, 1, 1, 1, 2]]})"),
       "transfer_function.points[0][4]: expected a number from 0 to 1, got 2"},
      {with(R"("transfer_function": {"points": [[1, 1, 1, 1, 1], [0, 1, 1, 1, 1]]})"),
       "transfer_function.points[1]: expected values that do not fall from point to point"},
      {with(R"("transfer_function": {"points": []})"),
       "transfer_function.points: a transfer function needs a point"},
      {with(R"("render": {"mode": "slice"})"),
       "render.mode: \"slice\" is not in this version's format yet (known: composite, iso, "
       "composite+iso, mip, average)"},
      {with(R"("render": {"step_voxels": 0})"),
       "render.step_voxels: expected a number from 0.05 to 16, got 0"},
      {with(R"("render": {"background": [0, 0, 1.5]})"),
       "render.background[2]: expected a number from 0 to 1, got 1.5"},
      {with(R"("camera": {"vertical_fov_degrees": 180})"),
       "camera.vertical_fov_degrees: expected a number from 1 to 170, got 180"},
      {with(R"("camera": {"eye_mm": [1, 2, 3], "target_mm": [1, 2, 3]})"),
       "camera: expected an eye away from the target"},
      {with(R"("camera": {"up": [0, 0, 0]})"), "camera.up: expected a direction, got no length"},
      {with_action(R"({"drag": {"from": {"voxel": [1,2,3]}, "by_voxels": [1,0,0],
                                "radius_voxels": "x"}})"),
       "actions[1].drag.radius_voxels: expected a number >= 0, got \"x\""},
      {with_action(R"({"drag": {"from": {"voxel": [1,2,3]}, "by_voxels": [1,0,0],
                                "radius": 1}})"),
       "actions[1].drag.radius: unknown key (known: from, radius_voxels, by_voxels, by_mm, steps, "
       "name)"},
      {with_action(R"({"drag": {"from": {"voxel": [1,2,3]}, "by_voxels": [1e7,0,0]}})"),
       "actions[1].drag.by_voxels[0]: expected a number from -1000000 to 1000000, got 10000000.0"},
      {with_action(R"({"drag": {"from": {"voxel": [1,2,3]}}})"),
       "actions[1].drag: expected \"by_voxels\" or \"by_mm\""},
      {with_action(R"({"drag": {"by_mm": [1,2,3]}})"), "actions[1].drag.from: missing"},
      {with_action(R"({"drag": {"from": {}, "by_mm": [1,2,3]}})"),
       "actions[1].drag.from: expected a \"voxel\" or a \"pixel\""},
      {with_action(R"({"drag": {"from": {"voxel": [1,2,null]}, "by_mm": [1,2,3]}})"),
       "actions[1].drag.from.voxel[2]: expected a number, got null"},
      {with_action(R"({"drag": {"from": {"pixel": [1]}, "by_mm": [1,2,3]}})"),
       "actions[1].drag.from.pixel: expected an array of 2 numbers, got an array of 1"},
      {with_action(R"({"drag": {"from": {"voxel": [1,2,3]}, "by_mm": [1,2,3], "steps": 0}})"),
       "actions[1].drag.steps: expected an integer from 1 to 100000, got 0"},
      {with_action(R"({"drag": {"from": {"voxel": [1,2,3]}, "by_mm": [1,2,1e999]}})"),
       "actions[1].drag.by_mm[2]: expected a finite number"},
      {with_action(R"({"relax": {"until_voxels": -1}})"),
       "actions[1].relax.until_voxels: expected a number > 0, got -1"},
      {with_action(R"({"render": {}})"), "actions[1].render.to: missing"},
      {with_action(R"({"render": {"to": ""}})"),
       "actions[1].render.to: expected a string that is not empty, got \"\""},
      {with_action(R"({"save": {}})"), "actions[1].save: expected a \"volume\" or a \"field\""},
      {with_action(R"({"save": {"volume": "a.nhdr"}})"),
       "actions[1].save.volume: expected a name ending in .nrrd or .mha, got \"a.nhdr\""},
      {with_action(R"({"save": {"field": "a"}})"),
       "actions[1].save.field: expected a name ending in .nrrd or .mha, got \"a\""},
      {with_action(R"({"render": {"to": "a.jpg"}})"),
       "actions[1].render.to: expected a name ending in .png, got \"a.jpg\""},
      {with_action(R"({"undo": 0})"),
       "actions[1].undo: expected an integer from 1 to 1000000, got 0"},
      {with_action(R"({"cut": {"polygon_mm": [[0,0,0],[1,0,0]]}})"),
       "actions[1].cut.polygon_mm: expected an array of at least 3 points, got an array of 2"},
      {with_action(R"({"cut": {"polygon_voxel": [[0,0,0],[1,0],[1,1,0]]}})"),
       "actions[1].cut.polygon_voxel[1]: expected an array of 3 numbers, got an array of 2"},
      {with_action(R"({"cut": {"polygon_voxel": [[0,0,0],[1e9,0,0],[1,1,0]]}})"),
       "actions[1].cut.polygon_voxel[1][0]: expected a number from -8000000 to 8000000, got "
       "1000000000.0"},
      {with_action(R"({"cut": {}})"),
       "actions[1].cut: expected one of \"polygon_voxel\", \"polygon_mm\", \"disc\" and \"sweep\""},
      {with_action(R"({"cut": {"disc": {}, "sweep": {}}})"),
       "actions[1].cut: expected one of \"polygon_voxel\", \"polygon_mm\", \"disc\" and \"sweep\""},
      {with_action(R"({"cut": {"plane": 1}})"),
       "actions[1].cut.plane: unknown key (known: polygon_voxel, polygon_mm, disc, sweep)"},
      {with_action(R"({"cut": {"disc": {"center_mm": [0,0,0], "radius_mm": 1}}})"),
       "actions[1].cut.disc.normal: missing"},
      {with_action(R"({"cut": {"disc": {"center_mm": [0,0,0], "normal": [0,0,0],
                                        "radius_mm": 1}}})"),
       "actions[1].cut.disc.normal: expected a direction, got no length"},
      {with_action(R"({"cut": {"disc": {"center_mm": [0,0,0], "center_voxel": [0,0,0],
                                        "normal": [0,0,1], "radius_mm": 1}}})"),
       "actions[1].cut.disc: expected \"center_voxel\" or \"center_mm\""},
      {with_action(R"({"cut": {"disc": {"center_mm": [0,0,0], "normal": [0,0,1],
                                        "radius_mm": 0}}})"),
       "actions[1].cut.disc.radius_mm: expected a number > 0, got 0"},
      {with_action(R"({"cut": {"sweep": {"path_mm": [[0,0,0]], "direction": [0,0,1],
                                         "depth_mm": 1}}})"),
       "actions[1].cut.sweep.path_mm: expected an array of at least 2 points, got an array of 1"},
      {with_action(R"({"cut": {"sweep": {"path_mm": 1, "direction": [0,0,1], "depth_mm": 1}}})"),
       "actions[1].cut.sweep.path_mm: expected an array of at least 2 points, got 1"},
      {with_action(R"({"carve": {"center_voxel": [1,2,3]}})"),
       "actions[1].carve.radius_voxels: missing"},
      {with_action(R"({"carve": {"radius_voxels": 3}})"),
       "actions[1].carve: expected \"center_voxel\" or \"center_mm\""},
      {with_action(R"({"carve": {"center_voxel": [1,2,3], "radius_voxels": -1}})"),
       "actions[1].carve.radius_voxels: expected a number >= 0, got -1"},
      {with_action(R"({"restore": {"center_voxel": [1,2,3], "radius": 1}})"),
       "actions[1].restore.radius: unknown key (known: center_voxel, center_mm, radius_voxels)"},
      {with_action(R"({"explode": {}})"), "actions[1].explode: unknown action" + known},
      {with_action(R"({"undo": 1, "redo": 1})"),
       "actions[1]: expected an object of one action (drag, relax, cut, carve, restore, render, "
       "release, undo, redo, save), got an object"},
      {with_action("3"),
       "actions[1]: expected an object of one action (drag, relax, cut, carve, restore, render, "
       "release, undo, redo, save), got 3"},
      {with(R"("actions": [], "actions": [])"), "actions: the key is there twice"},
      {with(R"("actions": {})"), "actions: expected an array of actions, got an empty object"},
  };
  for (const auto& [text, message] : cases) {
    EXPECT_EQ(refusal(text), "dir/scene.json: " + message) << text;
  }
}

TEST(Scene, SyntaxErrorsNameFileLineAndColumn) {
  EXPECT_EQ(refusal("{\n\"volume\": }").rfind("dir/scene.json: line 2, column 11: ", 0), 0u)
      << refusal("{\n\"volume\": }");
}

TEST(Scene, OverlappingMaterialsAreRefusedInTheTable) {
  const auto message = refusal(with(
      R"("materials": {"table": [{"name": "a", "values": [0, 10]}, {"name": "b", "values": [5, 20]}]})"));
  EXPECT_EQ(message.rfind("dir/scene.json: materials.table: ", 0), 0u) << message;
}

TEST(Scene, ReadsInterpolationOfTablesAndPresets) {
  const auto materials = [](const std::string& body) {
    return std::move(parse_scene(with(R"("materials": {)" + body + "}"), "s.json"))
        .value()
        .materials;
  };
  const std::string table =
      R"("table": [{"values": [0, 10], "stretch": 2}, {"values": [10, 20], "stretch": 3}])";
  EXPECT_EQ(std::get<MaterialTable>(materials(table)).count(), 2);
  const auto linear = std::get<MaterialTable>(materials(R"("interpolation": "linear", )" + table));
  EXPECT_EQ(linear.interpolation(), Interpolation::linear);
  EXPECT_EQ(linear.materials().size(), 2u);
  EXPECT_EQ(linear.limits(linear.id_of(5)).stretch.x, 512);
  EXPECT_NEAR(linear.limits(linear.id_of(10)).stretch.x, 768, 3);
  EXPECT_EQ(linear.limits(linear.id_of(15)).stretch.x, 1024);
  const auto ct =
      std::get<PresetMaterials>(materials(R"("interpolation": "linear", "preset": "ct")"));
  EXPECT_EQ(ct.preset, MaterialPreset::ct);
  EXPECT_EQ(ct.interpolation, Interpolation::linear);
  EXPECT_EQ(std::get<PresetMaterials>(materials(R"("preset": "ct")")).interpolation,
            Interpolation::step);
}

TEST(Scene, ReadsRigidMaterialsAndLimitsFromStiffness) {
  const auto parsed = parse_scene(with(R"("materials": {
    "limits": "from_stiffness", "softest": {"compress": 0.5, "stretch": [3, 2, 2], "shear": 0.125},
    "table": [{"name": "bone", "values": [20, 30], "rigid": true},
              {"name": "fat", "values": [0, 10], "stiffness": 0.5},
              {"name": "muscle", "values": [10, 20], "stiffness": 2, "rigid": false}]})"),
                                  "s.json");
  ASSERT_TRUE(parsed.ok()) << parsed.error().message;
  const auto& table = std::get<MaterialTable>(parsed->materials);
  EXPECT_EQ(table.materials()[0].compress, glm::dvec3(0.5));
  EXPECT_EQ(table.materials()[0].stretch, glm::dvec3(3, 2, 2));
  EXPECT_EQ(table.materials()[1].compress, glm::dvec3(0.875));
  EXPECT_EQ(table.materials()[1].stretch, glm::dvec3(1.5, 1.25, 1.25));
  EXPECT_EQ(table.materials()[1].shear, glm::dvec3(0.03125));
  EXPECT_TRUE(table.materials()[2].rigid);
  EXPECT_EQ(table.limits(2).stretch, glm::ivec3(0));
  EXPECT_TRUE(table.warnings().empty());
}

TEST(Scene, AVolumeGetsADefaultSceneAndAMissingSceneIsNoFile) {
  const auto scene = open_scene("somewhere/head.nrrd");
  ASSERT_TRUE(scene.ok());
  EXPECT_EQ(std::get<std::filesystem::path>(scene.value().volume), "somewhere/head.nrrd");
  const auto missing = open_scene("somewhere/that/is/not/there.json");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().kind, ErrorKind::file_system);
}

TEST(Scene, TheExamplesParse) {
  int count = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(MAILLE_SOURCE_DIR "/assets/scenes")) {
    const auto scene = open_scene(entry.path());
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    ++count;
  }
  EXPECT_GE(count, 3);
}

// The schema's objects have the keys that the reader says it knows.
TEST(Scene, SchemaAndReaderKnowTheSameKeys) {
  std::ifstream file(MAILLE_SOURCE_DIR "/assets/scene.schema.json");
  const auto schema =
      nlohmann::json::parse(std::string((std::istreambuf_iterator<char>(file)), {}));
  const auto action = [](const std::string& body) {
    return with(R"("actions": [{)" + body + "}]");
  };
  const std::vector<std::pair<std::string, std::string>> objects = {
      {"", with(R"("zzz": 1)")},
      {"/$defs/volume_file", R"({"volume": {"file": "x", "zzz": 1}})"},
      {"/$defs/volume_phantom", R"({"volume": {"phantom": "x", "zzz": 1}})"},
      {"/properties/materials", with(R"("materials": {"zzz": 1})")},
      {"/$defs/softest",
       with(R"("materials": {"limits": "from_stiffness", "softest": {"zzz": 1}})")},
      {"/$defs/material", with(R"("materials": {"table": [{"zzz": 1}]})")},
      {"/properties/anchors/anyOf/1", with(R"("anchors": {"zzz": 1})")},
      {"/properties/relaxation", with(R"("relaxation": {"zzz": 1})")},
      {"/properties/transfer_function", with(R"("transfer_function": {"zzz": 1})")},
      {"/properties/render", with(R"("render": {"zzz": 1})")},
      {"/properties/camera", with(R"("camera": {"zzz": 1})")},
      {"/$defs/action", action(R"("zzz": 1)")},
      {"/$defs/action/properties/drag", action(R"("drag": {"zzz": 1})")},
      {"/$defs/action/properties/drag/properties/from", action(R"("drag": {"from": {"zzz": 1}})")},
      {"/$defs/action/properties/relax", action(R"("relax": {"zzz": 1})")},
      {"/$defs/action/properties/render", action(R"("render": {"zzz": 1})")},
      {"/$defs/action/properties/release", action(R"("release": {"zzz": 1})")},
      {"/$defs/action/properties/cut", action(R"("cut": {"zzz": 1})")},
      {"/$defs/action/properties/cut/properties/disc", action(R"("cut": {"disc": {"zzz": 1}})")},
      {"/$defs/action/properties/cut/properties/sweep", action(R"("cut": {"sweep": {"zzz": 1}})")},
      {"/$defs/ball", action(R"("carve": {"zzz": 1})")},
      {"/$defs/action/properties/save", action(R"("save": {"zzz": 1})")},
  };
  for (const auto& [pointer, text] : objects) {
    const nlohmann::json::json_pointer place(pointer);
    ASSERT_TRUE(schema.contains(place)) << pointer;
    EXPECT_EQ(schema[place]["additionalProperties"], false) << pointer;
    std::set<std::string> in_schema;
    for (const auto& [key, ignored] : schema[place]["properties"].items()) in_schema.insert(key);
    auto message = refusal(text);
    const auto begin = message.find("(known: ");
    ASSERT_NE(begin, std::string::npos) << message;
    message = message.substr(begin + 8);
    std::set<std::string> in_reader;
    std::string name;
    for (const char c : message) {
      if (c == ',' || c == ')') {
        in_reader.insert(name);
        name.clear();
      } else if (c != ' ') {
        name += c;
      }
    }
    EXPECT_EQ(in_schema, in_reader) << pointer;
  }
}

}  // namespace
}  // namespace maille
