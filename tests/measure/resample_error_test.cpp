#include "measure/resample_error.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "measure/resample_bars.h"
#include "measure/resample_error_page.h"
#include "resample/resample_method.h"
#include "tests/measure/xml.h"

namespace maille {
namespace {

using Row = ResampleError::Row;
using Scene = ResampleError::Scene;

// The same as a person's run, of sizes that take no time.
const ResampleError& small() {
  static const ResampleError report = [] {
    ResampleErrorOptions options;
    options.edge = 40;
    options.runs = 2;
    options.reference_runs = 1;
    options.reference_layers = 6;
    options.copy_edge = 40;
    return measure_resample_error(options);
  }();
  return report;
}

const Scene& scene_of(const std::string& name) {
  for (const Scene& scene : small().scenes) {
    if (scene.name == name) return scene;
  }
  throw std::out_of_range(name);
}

const Row& row_of(const std::string& scene, const std::string& way, const std::string& method,
                  int iterations = 0) {
  for (const Row& row : scene_of(scene).rows) {
    if (row.way == way && row.method == method && row.iterations == iterations) return row;
  }
  throw std::out_of_range(scene + " " + way + " " + method);
}

const std::size_t kProductRows = 2 * kResampleMethods.size();  // on 1 thread and on 2
constexpr std::size_t kReferenceRows = 2 * 3 + 8;

TEST(ResampleError, EverySceneIsMeasuredEveryWay) {
  ASSERT_EQ(small().scenes.size(), 9u);
  for (const Scene& scene : small().scenes) {
    SCOPED_TRACE(scene.name);
    EXPECT_EQ(scene.rows.size(), kProductRows + kReferenceRows);
    EXPECT_EQ(scene.lost_voxels, 0);
    EXPECT_LE(scene.worst_forward_voxels, kTruth_voxels);
    EXPECT_GT(scene.judged_voxels, 5000);
    EXPECT_EQ(scene.folded_cells > 0, scene.folds);
    EXPECT_EQ(scene.reference_voxels.size().z, 6);
    for (const Row& row : scene.rows) {
      SCOPED_TRACE(way_of(row) + " " + row.method);
      ASSERT_TRUE(row.deviation);
      EXPECT_GT(row.voxels, 0);
      EXPECT_LE(row.voxels, 40 * 40 * 40);
      if (row.way == "maille") {
        EXPECT_EQ(row.deviation->value.count() + row.deviation->unfilled_voxels,
                  scene.judged_voxels);
        EXPECT_GE(row.voxels, scene.judged_voxels) << "the border elements' outer halves too";
      }
      EXPECT_GE(row.deviation->value.max(), row.deviation->value.rms());
      EXPECT_GT(row.timing.median_seconds, 0.0);
      EXPECT_EQ(row.found.has_value(), row.method == "nearest");
      EXPECT_EQ(row.deviation->rest_voxels.count() > 0, row.method == "linear");
    }
  }
}

TEST(ResampleError, WholeVoxelsLeaveNoneButForTheSmoothing) {
  for (const char* const scene : {"rest", "shifted"}) {
    for (const Row& row : scene_of(scene).rows) {
      SCOPED_TRACE(scene + (" " + way_of(row)) + " " + row.method);
      if (row.method == "rbf") {
        // What rests or moves as a whole Maille may copy; the walk smooths whatever it finds.
        EXPECT_LT(row.deviation->value.rms(), 1e-2);
        if (row.way != "maille") {
          EXPECT_GT(row.deviation->value.rms(), 1e-3);
        }
      } else {
        EXPECT_EQ(row.deviation->value.max(), 0.0);
      }
      EXPECT_EQ(row.deviation->unfilled_voxels, 0);
      EXPECT_FALSE(row.deviation->times_floor()) << "the grid has no error there";
      if (row.found) {
        EXPECT_EQ(row.found->right, row.found->there);
      }
    }
  }
}

TEST(ResampleError, LinearHasTheGridsErrorWhereTheMapIsAffine) {
  for (const char* const scene : {"stretched", "squeezed", "sheared"}) {
    SCOPED_TRACE(scene);
    const Row& linear = row_of(scene, "maille", "linear");
    EXPECT_NEAR(*linear.deviation->times_floor(), 1.0, 1e-4);
    EXPECT_GT(linear.deviation->floor.rms(), 1e-3) << "there is an error to have";
    EXPECT_LT(linear.deviation->floor.rms(), 1e-2);
    EXPECT_LT(linear.deviation->rest_voxels.max(), 1e-3);
    EXPECT_EQ(linear.deviation->unfilled_voxels, 0);
    const auto& found = *row_of(scene, "maille", "nearest").found;
    EXPECT_EQ(found.right, found.there);
    EXPECT_EQ(found.there, scene_of(scene).judged_voxels);
    EXPECT_GT(row_of(scene, "maille", "nearest").deviation->value.rms(),
              3.0 * linear.deviation->value.rms());
  }
}

// u = -3/4 X along x: each iteration leaves three quarters of the error before. Sheared, the
// gradient's square is that of one component alone and its cube is none at all.
TEST(ResampleError, FixedPointShrinksItsErrorByTheGradient) {
  const auto rms = [](const std::string& scene, int iterations) {
    return row_of(scene, "fixed_point", "linear", iterations).deviation->rest_voxels.rms();
  };
  for (int iterations = 2; iterations <= 8; ++iterations) {
    EXPECT_NEAR(rms("squeezed", iterations) / rms("squeezed", iterations - 1), 0.75, 1e-5);
  }
  EXPECT_GT(rms("sheared", 1), 0.1);
  EXPECT_LT(rms("sheared", 3), 1e-5);
  EXPECT_GT(rms("stretched", 8), 10.0) << "where the gradient is 3 it does not converge";
}

TEST(ResampleError, TheWalkFindsNearlyAllAndLosesItsWayAtFolds) {
  for (const char* const way : {"walk_6", "walk_26"}) {
    SCOPED_TRACE(way);
    const auto& smooth = *row_of("squeezed", way, "nearest").found;
    EXPECT_EQ(smooth.right, smooth.there);
    const auto& folded = *row_of("folded", way, "nearest").found;
    EXPECT_GT(folded.missed, 0);
    EXPECT_GT(folded.wrong, 0);
    EXPECT_EQ(folded.right + folded.wrong + folded.missed, folded.there);
    EXPECT_EQ(folded.missed, row_of("folded", way, "rbf").deviation->unfilled_voxels);
  }
  EXPECT_GT(row_of("mild", "walk_26", "nearest").found->right_share(), 0.99);
  EXPECT_LT(row_of("mild", "walk_6", "nearest").found->right_share(), 1.0);
}

TEST(ResampleError, ReferencesAreMeasuredInTheMiddleLayers) {
  EXPECT_EQ(scene_of("rest").reference_voxels, (VoxelBox{{0, 0, 17}, {40, 40, 23}}));
  EXPECT_EQ(scene_of("shifted").reference_voxels, (VoxelBox{{5, 0, 18}, {40, 37, 24}}));
}

TEST(ResampleError, BruteForceMayTakeASample) {
  ResampleErrorOptions options;
  options.edge = 32;
  options.threads = {1};
  options.runs = 1;
  options.reference_runs = 1;
  options.reference_layers = 1;
  options.copy_edge = 32;
  options.nearest_voxels = 32 * 32 * 32 / 7;
  const ResampleError report = measure_resample_error(options);
  const Scene& rest = report.scenes.front();
  EXPECT_EQ(rest.nearest_stride, 8);
  EXPECT_EQ(rest.rows.front().found->there, 32 * 32 * 32 / 8);
  EXPECT_NE(page_of(report).table.find("in one voxel of 8"), std::string::npos);
}

TEST(ResampleErrorPage, SaysWhatWasMeasured) {
  const MeasurePage page = page_of(small());
  EXPECT_EQ(test::xml_fault(page.svg), "");
  const auto json = nlohmann::json::parse(page.json);
  EXPECT_EQ(json["maille_measure"], 1);
  EXPECT_EQ(json["what"], "error");
  EXPECT_EQ(json["stage"], "resample");
  EXPECT_EQ(json["runs"], 2);
  EXPECT_EQ(json["paper_million_voxels_per_second"]["barycentric"], 2.46);
  ASSERT_EQ(json["scenes"].size(), 9u);
  std::size_t rows = 0;
  for (const auto& scene : json["scenes"]) {
    SCOPED_TRACE(scene["title"]);
    EXPECT_EQ(scene["truth"]["found"], true);
    EXPECT_EQ(scene["size"], nlohmann::json({40, 40, 40}));
    for (const auto& row : scene["rows"]) {
      SCOPED_TRACE(row.dump());
      ++rows;
      const double ms = row["milliseconds"]["median"];
      EXPECT_NEAR(row["nanoseconds_per_voxel"], 1e6 * ms / double{row["voxels"]}, 1e-6 * 1e6 * ms);
      EXPECT_NEAR(double{row["nanoseconds_per_voxel"]} * double{row["million_voxels_per_second"]},
                  1e3, 1e-6);
      EXPECT_EQ(row["ratio_to_paper"].is_null(), row["method"] == "linear");
      EXPECT_EQ(row["nearest_elements"].is_null(), row["method"] != "nearest");
      EXPECT_EQ(row["rest_position_error_voxels"].is_null(), row["method"] != "linear");
      EXPECT_EQ(row["iterations"].is_null(), row["way"] != "fixed_point");
      if (!row["rms_to_grid_rms"].is_null()) {
        EXPECT_NEAR(row["rms_to_grid_rms"],
                    double{row["value_error"]["rms"]} / double{row["grid_error"]["rms"]}, 1e-9);
      }
    }
  }
  EXPECT_EQ(rows, 9 * (kProductRows + kReferenceRows));
  EXPECT_EQ(static_cast<std::size_t>(std::count(page.csv.begin(), page.csv.end(), '\n')), 1 + rows);
  ASSERT_EQ(json["constant_bricks"].size(), 2u);
  for (const auto& bricks : json["constant_bricks"]) {
    EXPECT_EQ(bricks["bytes"], 2 * 4 * 40 * 40 * 40);
    EXPECT_NEAR(bricks["share_of_copy"],
                double{bricks["gb_per_s"]} / double{bricks["copy_gb_per_s"]}, 1e-9);
    EXPECT_NEAR(bricks["share_of_rows"],
                double{bricks["gb_per_s"]} / double{bricks["rows_gb_per_s"]}, 1e-9);
  }
  for (const char* const said : {"4.41", "2.46", "1.48", "99 %", "walk, 26", "fixed point, 8",
                                 "constant bricks", "nearest answer"}) {
    EXPECT_NE(page.table.find(said), std::string::npos) << said;
  }
}

TEST(ResampleErrorPage, WithoutATruthThereAreNoErrors) {
  ResampleError report;
  report.machine.triad_gb_per_s[1] = 1.0;
  Scene scene;
  scene.name = scene.title = "lost";
  scene.lost_voxels = 12;
  Row row;
  row.way = "maille";
  row.method = "linear";
  row.timing = {0.001, 0.001, 0.001, 1};
  row.voxels = 1000;
  scene.rows = {row};
  report.scenes = {scene};
  const MeasurePage page = page_of(report);
  EXPECT_EQ(test::xml_fault(page.svg), "");
  EXPECT_NE(page.svg.find("the truth was not found"), std::string::npos);
  EXPECT_NE(page.table.find("NOT found in 12 voxels"), std::string::npos);
  const auto json = nlohmann::json::parse(page.json);
  EXPECT_TRUE(json["scenes"][0]["rows"][0]["value_error"].is_null());
  EXPECT_TRUE(json["bars"].empty());
}

TEST(ResampleBars, StandBesideWhatWasMeasured) {
  ResampleError report;
  Scene scene;
  scene.name = scene.title = "moved";
  const auto add = [&](const std::string& method, int threads, double million_per_second) {
    Row row;
    row.way = "maille";
    row.method = method;
    row.threads = threads;
    row.voxels = 1'000'000;
    row.timing = {1.0 / million_per_second, 0.0, 1.0, 1};
    scene.rows.push_back(row);
  };
  add("nearest", 1, 60);
  add("nearest", 2, 119);
  add("linear", 1, 61);
  add("linear", 2, 121);
  add("barycentric", 2, 80.5);
  add("rbf", 2, 34);
  ResampleDeviation deviation;
  deviation.value.add(1.06);
  deviation.floor.add(1.0);
  deviation.unfilled_voxels = 3;
  scene.rows[2].deviation = scene.rows[3].deviation = deviation;
  report.scenes.push_back(scene);
  scene.moves = false;  // has no bars for its speed and error, but nothing may be left open
  report.scenes.push_back(scene);
  report.constant_bricks = {{2, 1000, {2.0, 2.0, 2.0, 1}, {1.5, 1.5, 1.5, 1}, {3.0, 3.0, 3.0, 1}}};

  const auto bars = bars_of(report);
  const auto met = [&](const std::string& what) {
    for (const ResampleBar& bar : bars) {
      if (bar.what == what) return bar.met();
    }
    throw std::out_of_range(what);
  };
  ASSERT_EQ(bars.size(), 4u + 1u + 1u + 1u);
  EXPECT_FALSE(met("nearest"));
  EXPECT_TRUE(met("linear"));
  EXPECT_TRUE(met("barycentric"));
  EXPECT_FALSE(met("rbf"));
  EXPECT_TRUE(met("constant bricks"));
  EXPECT_FALSE(met("linear, RMS error"));
  EXPECT_FALSE(met("linear, nothing shown"));
  EXPECT_EQ(bars[0].bar, 120.0);
  EXPECT_NEAR(bars[0].measured, 119.0, 1e-9);
  EXPECT_EQ(bars[4].measured, 75.0);
  EXPECT_EQ(bars[6].measured, 6.0) << "of both scenes, and of any number of threads once";
}

}  // namespace
}  // namespace maille
