#include "measure/relaxation_error.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "measure/relaxation_error_page.h"
#include "tests/measure/xml.h"

namespace maille {
namespace {

RelaxationErrorOptions small() {
  RelaxationErrorOptions options;
  options.threads = {1};
  options.elements = {6000};
  options.runs = 2;
  options.most_seconds = 0.5;
  options.folds.ball_radius = 3;
  options.folds.scene_blends = {0.25};
  options.folds.energies = {{FoldRule::limits, 0.0, 4.0, 0.3},
                            {FoldRule::determinant, 0.2, 1.0, 0.3}};
  options.folds.blends = {0.25};
  return options;
}

TEST(RelaxationError, EveryCurveEndsNearerThanItBeganAndThePageSaysIt) {
  const auto report = measure_relaxation_error(small());
  ASSERT_TRUE(report.ok());
  ASSERT_EQ((*report).scenes.size(), 5u);
  for (const auto& scene : (*report).scenes) {
    SCOPED_TRACE(scene.name);
    EXPECT_TRUE(scene.equilibrium_converged);
    EXPECT_LE(scene.equilibrium_distance_voxels, 1e-7);
    EXPECT_GT(scene.start_max_voxels, 0.05) << "there is something to relax";
    EXPECT_GE(scene.start_max_voxels, scene.start_rms_voxels);
    ASSERT_EQ(scene.curves.size(), 3u);
    for (const auto& curve : scene.curves) {
      SCOPED_TRACE(curve.solver);
      ASSERT_GE(curve.samples.size(), 2u);
      const auto& first = curve.samples.front();
      const auto& last = curve.samples.back();
      EXPECT_NEAR(first.rms_voxels, scene.start_rms_voxels, 2e-3);
      EXPECT_NEAR(first.energy_excess, 1.0, 1e-2);
      EXPECT_LT(last.rms_voxels, first.rms_voxels);
      // The energy counts corners; the paper's ways know springs alone, and may fold cells.
      if (curve.solver == "product" || last.folded_cells <= first.folded_cells) {
        EXPECT_LT(last.energy_excess, first.energy_excess);
      }
      EXPECT_GE(last.energy_excess, -1e-6) << "nothing lies below the minimum";
      for (std::size_t s = 1; s < curve.samples.size(); ++s) {
        EXPECT_GT(curve.samples[s].iterations, curve.samples[s - 1].iterations);
        EXPECT_GT(curve.samples[s].seconds, 0.0);
      }
      for (std::size_t t = 0; t < RelaxationError::kTargets_voxels.size(); ++t) {
        if (curve.seconds_to_max[t]) {
          ASSERT_TRUE(curve.seconds_to_rms[t]);
          EXPECT_LE(*curve.seconds_to_rms[t], *curve.seconds_to_max[t]);
        }
        if (curve.claims[t]) {
          EXPECT_EQ(curve.solver, "product");
          EXPECT_LE(curve.claims[t]->said_voxels, RelaxationError::kTargets_voxels[t]);
        }
      }
    }
  }

  // The study of the rules against folding is a part of it.
  ASSERT_EQ((*report).folds.scenes.size(), 3u);
  const auto& ball = (*report).folds.scenes.front();
  ASSERT_EQ(ball.ways.front().name, "none");
  EXPECT_GT(ball.ways.front().folded_cells, 0) << "the scene does fold";
  EXPECT_EQ(ball.ways.front().max_voxels, 0.0);
  for (const auto& way : ball.ways) {
    SCOPED_TRACE(way.name);
    if (way.name == "none") continue;
    EXPECT_EQ(way.folded_cells, 0);
    EXPECT_GT(way.least_determinant, 0.0);
    EXPECT_GT(way.max_voxels, 0.0);
    EXPECT_GT(way.energy_excess, 0.0);
    EXPECT_LT(way.energy_excess, 1.0);
  }
  ASSERT_EQ((*report).folds.blends.size(), 1u);
  EXPECT_LT((*report).folds.blends[0].detour_apart_voxels, 1e-5);
  EXPECT_LT((*report).folds.blends[0].ball_turn, 0.1);
  EXPECT_GT((*report).folds.blends[0].ball_turn_blend_in_soft, 0.9);

  const MeasurePage page = page_of(*report);
  EXPECT_EQ(test::xml_fault(page.svg), "");
  const auto json = nlohmann::json::parse(page.json);
  EXPECT_EQ(json["stage"], "relaxation");
  ASSERT_EQ(json["scenes"].size(), 5u);
  std::size_t samples = 0;
  for (const auto& scene : json["scenes"]) {
    for (const auto& curve : scene["curves"]) samples += curve["samples"].size();
  }
  EXPECT_EQ(static_cast<std::size_t>(std::count(page.csv.begin(), page.csv.end(), '\n')),
            1 + samples);
  EXPECT_EQ(json["ways_to_keep_cells_from_folding"]["scenes"].size(), 3u);
  EXPECT_NE(page.table.find("the paper's Jacobi"), std::string::npos);
}

TEST(RelaxationScenes, HangBetweenWhatTheySay) {
  const RelaxationScene sheet = sheet_relaxation(6000);
  EXPECT_EQ(sheet.drag.volume.size().z, 8);
  EXPECT_EQ(sheet.anchors.faces, face_low_x | face_high_x);
  EXPECT_EQ(homogeneous_relaxation(100'000).drag.volume.size(), Size3(46));
  WorkerPool pool(2);
  const auto nose = nose_relaxation(6000, 1, std::nullopt, pool);
  ASSERT_TRUE(nose.ok());
  const Volume& volume = (*nose).drag.volume;
  EXPECT_EQ(volume.size(), Size3(18));
  EXPECT_GE(volume.value_at((*nose).drag.grab.element), -300.0) << "skin, not air";
}

}  // namespace
}  // namespace maille
