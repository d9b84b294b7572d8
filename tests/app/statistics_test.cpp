#include "app/statistics.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace maille {
namespace {

void expect_keys(const nlohmann::json& object, const std::vector<std::string>& keys) {
  for (const auto& key : keys) EXPECT_TRUE(object.contains(key)) << key << " in " << object.dump();
}

TEST(Statistics, EverySectionHasTheKeysOfTheContract) {
  RunStatistics s;
  s.machine.triad_gb_per_s = 1.0;
  s.device.emplace();
  s.chainmail.emplace();
  s.relaxation.emplace();
  s.cuts.emplace();
  s.undo.emplace();
  s.memory.budget.emplace();
  s.resample.emplace();
  s.volume_kept.emplace().by_material = {{"bone", {10, 1.0, 0.0}}};
  s.upload.emplace();
  s.frames.emplace().milliseconds = {3.0, 1.0, 2.0};
  s.pick.emplace();
  const auto json = nlohmann::json::parse(to_json(s));
  expect_keys(json, {"maille_stats", "version", "command", "machine", "device", "volume",
                     "chainmail", "cuts", "undo", "relaxation", "volume_kept", "resample", "upload",
                     "frames", "memory", "left_out"});
  expect_keys(json["machine"], {"threads", "triad_gb_per_s"});
  expect_keys(json["device"], {"name", "driver", "sparse"});
  expect_keys(json["volume"], {"size", "type", "bytes", "load_seconds"});
  expect_keys(json["chainmail"], {"drags", "elements_moved", "working_bytes", "seconds",
                                  "violated_links", "worst_violation_voxels", "drag_clamped"});
  expect_keys(json["relaxation"],
              {"iterations", "element_updates", "seconds", "converged", "residual_voxels",
               "residual_known", "residual_rms_voxels", "free_elements", "folded_corners",
               "region_limited", "energy_first", "energy_last", "energy_ever_rose"});
  EXPECT_FALSE(json["relaxation"].contains("stiffness_clamped"));
  expect_keys(json["resample"], {"method", "voxels", "seconds", "folded_cells", "unfilled_voxels"});
  expect_keys(json["volume_kept"], {"cells", "ratio", "change_rms", "materials"});
  EXPECT_EQ(json["volume_kept"]["materials"]["bone"]["cells"], 10);
  expect_keys(json["upload"], {"bricks", "bytes", "seconds"});
  expect_keys(json["frames"], {"count", "median_ms", "gpu_ms"});
  expect_keys(json["frames"]["gpu_ms"], {"raycast", "upload", "pick"});
  expect_keys(json["cuts"], {"links_removed", "elements_carved", "seconds"});
  expect_keys(json["undo"], {"steps", "redo_steps", "bytes", "budget_bytes", "dropped_steps"});
  expect_keys(json["memory"],
              {"lattice_bytes_per_element", "stroke_bytes_peak", "stroke_bytes_per_element",
               "lattice_budget_bytes", "lattice_peak_bytes", "scratch_planes_written",
               "scratch_bytes_written", "scratch_planes_read"});
  expect_keys(json["memory"], {"peak_rss_bytes", "lattice_bricks", "lattice_bytes",
                               "gpu_pages_resident", "gpu_pages_total", "gpu_bytes"});
  EXPECT_EQ(json["maille_stats"], 1);
  EXPECT_EQ(json["frames"]["count"], 3);
  EXPECT_EQ(json["frames"]["median_ms"], 2.0);
}

TEST(Statistics, WhatWasLeftOutIsAbsentAndNamed) {
  RunStatistics s;
  s.left_out = {"relaxation", "window"};
  const auto json = nlohmann::json::parse(to_json(s));
  for (const auto* const section : {"device", "chainmail", "cuts", "undo", "relaxation", "resample",
                                    "upload", "frames", "pick"}) {
    EXPECT_FALSE(json.contains(section)) << section;
  }
  EXPECT_FALSE(json["machine"].contains("triad_gb_per_s"));
  EXPECT_EQ(json["left_out"], nlohmann::json({"relaxation", "window"}));
}

TEST(Statistics, AResidualThatNobodyCouldEstimateIsNotInvented) {
  RunStatistics s;
  s.relaxation.emplace().residual_voxels = 0.25;
  auto relaxation = nlohmann::json::parse(to_json(s))["relaxation"];
  EXPECT_EQ(relaxation["residual_known"], true);
  EXPECT_EQ(relaxation["residual_voxels"], 0.25);
  s.relaxation->residual_voxels.reset();
  s.relaxation->residual_rms_voxels.reset();
  relaxation = nlohmann::json::parse(to_json(s))["relaxation"];
  EXPECT_EQ(relaxation["residual_known"], false);
  EXPECT_FALSE(relaxation.contains("residual_voxels"));
  EXPECT_FALSE(relaxation.contains("residual_rms_voxels"));
}

TEST(Statistics, TheStrokeThatTookMostIsTheOneThatCounts) {
  RunStatistics s;
  s.memory.add_stroke(600, 100);
  s.memory.add_stroke(900, 200);
  s.memory.add_stroke(800, 10);
  const auto memory = nlohmann::json::parse(to_json(s))["memory"];
  EXPECT_EQ(memory["stroke_bytes_peak"], 900);
  EXPECT_EQ(memory["stroke_bytes_per_element"], 4.5);
}

TEST(Statistics, CopiesAreCountedApart) {
  ResampleCounts untouched;
  untouched.voxels = 100;
  untouched.timed(2.0);
  ResampleCounts moved;
  moved.voxels = 10;
  moved.moved_voxels = 4;
  moved.timed(3.0);
  ResampleCounts all;
  all += untouched;
  all += moved;
  RunStatistics::Resample s;
  s.add(all);
  s.add(RunStatistics::Resample(s));
  EXPECT_EQ(s.voxels, 20);
  EXPECT_EQ(s.moved_voxels, 8);
  EXPECT_EQ(s.copied_voxels, 200);
  EXPECT_EQ(s.seconds, 6.0);
  EXPECT_EQ(s.copy_seconds, 4.0);
}

TEST(Statistics, ProgramStartAndPeakMemoryAreKnown) {
  const double running = seconds_since_program_start();
  EXPECT_GT(running, 0.0);
  EXPECT_LT(running, 3600.0);
  EXPECT_GT(peak_rss_bytes(), std::int64_t{1} << 20);
}

}  // namespace
}  // namespace maille
