#include "app/plan.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace maille {
namespace {

Scene scene_of(const std::string& members) {
  auto scene = parse_scene(R"({"volume": {"phantom": "head"}, )" + members + "}", "s.json");
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  return *std::move(scene);
}

bool left_out(const Plan& plan, const std::string& name) {
  const auto names = plan.left_out();
  return std::find(names.begin(), names.end(), name) != names.end();
}

const std::string kDrag = R"({"drag": {"from": {"voxel": [1, 2, 3]}, "by_voxels": [1, 0, 0]}})";

TEST(Plan, AStillPictureNeedsNeitherLatticeNorMaterials) {
  const auto plan = plan_of(scene_of(R"("actions": [])"), {.pictures = true});
  for (const auto* const name : {"chainmail", "relaxation", "resampling", "material_lookup",
                                 "anchors", "pick_pass", "iso", "mip", "window"}) {
    EXPECT_TRUE(left_out(plan, name)) << name;
  }
  EXPECT_FALSE(left_out(plan, "vulkan"));
  EXPECT_FALSE(left_out(plan, "shading"));
  EXPECT_FALSE(left_out(plan, "composite"));
}

TEST(Plan, CutsCarvingAndUndoStateAreMadeForTheirActionsOnly) {
  const auto plan_with = [](const std::string& actions) {
    return plan_of(scene_of(R"("actions": [)" + actions + "]"), {});
  };
  const std::string ball = R"({"center_voxel": [1, 2, 3], "radius_voxels": 2})";
  const auto dragged = plan_with(kDrag);
  for (const auto* const name : {"cut", "carve", "undo"}) {
    EXPECT_TRUE(left_out(dragged, name)) << name;
  }
  const auto cut = plan_with(R"({"cut": {"polygon_mm": [[0,0,0], [9,0,0], [9,9,0]]}})");
  EXPECT_TRUE(cut.deforms() && cut.resampling && cut.cut);
  EXPECT_FALSE(cut.chainmail || cut.carve || cut.relaxation);
  EXPECT_TRUE(plan_with(R"({"carve": )" + ball + "}").carve);
  EXPECT_TRUE(plan_with(R"({"restore": )" + ball + "}").carve);
  EXPECT_FALSE(left_out(plan_with(kDrag + R"(, {"undo": 1})"), "undo"));
  EXPECT_FALSE(plan_with(R"({"undo": 1})").undo) << "nothing to undo";
}

TEST(Plan, DeformingNeedsNoVulkan) {
  const auto plan = plan_of(scene_of(R"("actions": [)" + kDrag + "]"), {});
  for (const auto* const name :
       {"vulkan", "pick_pass", "shading", "composite", "iso", "window", "relaxation"}) {
    EXPECT_TRUE(left_out(plan, name)) << name;
  }
  EXPECT_TRUE(plan.chainmail);
}

TEST(Plan, MaterialsDecideOfLookUpAndAnchors) {
  const auto with = [](const std::string& members, const MaterialTable& table) {
    auto plan = plan_of(scene_of(members + R"("actions": [)" + kDrag + "]"), {});
    plan.use(table);
    return plan;
  };
  Material material;
  material.value_high = 1.0;
  const auto one = MaterialTable::create({material});
  material.fixed = true;
  const auto fixed = MaterialTable::create({material});
  ASSERT_TRUE(one.ok() && fixed.ok());
  EXPECT_TRUE(left_out(with("", *one), "material_lookup"));
  EXPECT_TRUE(left_out(with("", *one), "anchors"));
  EXPECT_FALSE(left_out(with("", *fixed), "anchors"));
  EXPECT_FALSE(left_out(with(R"("anchors": {"faces": ["-z"]}, )", *one), "anchors"));
  // Its bone is fixed.
  EXPECT_FALSE(left_out(with("", MaterialTable::ct()), "anchors"));
  EXPECT_FALSE(left_out(with("", MaterialTable::ct()), "material_lookup"));
  EXPECT_TRUE(left_out(with("", MaterialTable::relative(0, 1)), "anchors"));
}

TEST(Plan, AStillPictureKeepsNoAnchorsWhateverTheMaterials) {
  auto plan = plan_of(scene_of(R"("actions": [])"), {.pictures = true});
  plan.use(MaterialTable::ct());
  EXPECT_TRUE(left_out(plan, "anchors"));
}

TEST(Plan, RelaxationNeedsAnActionASwitchAndSomethingMoved) {
  EXPECT_TRUE(plan_of(scene_of(R"("actions": [)" + kDrag + R"(, {"relax": {}}])"), {}).relaxation);
  EXPECT_FALSE(plan_of(scene_of(R"("actions": [{"relax": {}}])"), {}).relaxation);
  EXPECT_FALSE(plan_of(scene_of(R"("relaxation": {"enabled": false}, "actions": [)" + kDrag +
                                R"(, {"relax": {}}])"),
                       {})
                   .relaxation);
}

TEST(Plan, PicksAndShadingFollowTheSceneAndTheCommand) {
  const auto picked = scene_of(
      R"("render": {"mode": "iso", "shading": false},
         "actions": [{"drag": {"from": {"pixel": [1, 2]}, "by_voxels": [1, 0, 0]}}])");
  const auto plan = plan_of(picked, {.pictures = true});
  EXPECT_TRUE(plan.pick_pass);
  EXPECT_FALSE(plan.shading);
  EXPECT_TRUE(plan.iso);
  EXPECT_FALSE(plan.composite);
  EXPECT_TRUE(plan_of(scene_of(R"("actions": [])"), {.pictures = true, .picks = true}).pick_pass);
}

TEST(Plan, AWindowMayNeedEverything) {
  const auto plan = plan_of(scene_of(R"("actions": [])"), {.window = true});
  EXPECT_TRUE(plan.chainmail && plan.relaxation && plan.pick_pass && plan.vulkan && plan.window);
}

}  // namespace
}  // namespace maille
