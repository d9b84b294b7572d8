#include "measure/stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "measure/stability_case.h"
#include "measure/stability_page.h"
#include "references/dense_checks.h"
#include "tests/measure/xml.h"

namespace maille {
namespace {

using Row = StabilityReport::Row;
using Verdict = StabilityReport::Verdict;

Row good_row() {
  Row row;
  row.group = "group";
  row.title = "title";
  row.converged = true;
  row.estimate_voxels = 0.008;
  row.distance_voxels = 0.009;
  row.folded_first = row.folded_most = row.folded_last = 3;
  return row;
}

TEST(Stability, EveryPartOfThePromiseCanBreakIt) {
  EXPECT_EQ(good_row().fault(0.01), "");
  EXPECT_EQ(good_row().verdict(0.01), Verdict::holds);
  const auto fault = [](auto&& breaks) {
    Row row = good_row();
    breaks(row);
    EXPECT_EQ(row.verdict(0.01), Verdict::fails);
    return row.fault(0.01);
  };
  EXPECT_EQ(fault([](Row& row) { row.failure = "x"; }), "gave up: x");
  EXPECT_EQ(fault([](Row& row) { row.finite = false; }), "not finite");
  EXPECT_EQ(fault([](Row& row) { row.violated_links = 2; }), "2 violated links");
  EXPECT_EQ(fault([](Row& row) { row.energy_rises = 1; }), "energy rose 1 times");
  EXPECT_EQ(fault([](Row& row) { row.energy_said_to_rise = true; }),
            "energy is said to have risen");
  EXPECT_EQ(fault([](Row& row) { row.folded_most = 5; }), "2 more folded cells");
  EXPECT_EQ(fault([](Row& row) { row.newly_folded = 1; }), "1 newly folded cells")
      << "also where others have unfolded";
  EXPECT_EQ(fault([](Row& row) { row.converged = false; }), "never ends");
  EXPECT_EQ(fault([](Row& row) { row.distance_voxels = 0.011; }), "0.011 voxels off");
  EXPECT_EQ(fault([](Row& row) { row.distance_voxels = std::nan(""); }), "nan voxels off");

  // A million voxels from rest no float is nearer.
  Row far = good_row();
  far.distance_voxels = 0.1;
  far.float_step_voxels = 0.06;
  EXPECT_EQ(far.verdict(0.01), Verdict::fails) << "it says that it is there";
  far.converged = false;
  far.no_nearer = true;
  EXPECT_EQ(far.verdict(0.01), Verdict::holds);
  far.float_step_voxels = 0.01;
  far.estimate_voxels = 0.09;
  EXPECT_EQ(far.verdict(0.01), Verdict::fails) << "it says that it is nearer";
  far.estimate_voxels = 0.11;
  EXPECT_EQ(far.verdict(0.01), Verdict::says_so);

  Row unknown = good_row();
  unknown.reference_converged = false;
  unknown.distance_voxels = 5.0;
  EXPECT_EQ(unknown.verdict(0.01), Verdict::undecided);
  unknown.finite = false;
  EXPECT_EQ(unknown.verdict(0.01), Verdict::fails) << "known without a reference";

  StabilityReport report;
  report.rows = {good_row(), far, unknown};
  EXPECT_EQ(report.summary(),
            "holds in 1 of 3 cases, says that it comes no nearer in 1, does NOT hold in 1");
}

TEST(Stability, TheSweepReachesTheEndsThatItNames) {
  const auto cases = stability_cases(12, 1, {});
  for (const std::string& group : stability_groups()) {
    EXPECT_TRUE(std::any_of(cases.begin(), cases.end(), [&](const StabilityCase& c) {
      return c.group == group;
    })) << group;
  }
  double stiffest_ratio = 1.0;
  double shortest = 1e9;
  double furthest = 0.0;
  double flattest = 1.0;
  int thinnest = 100;
  for (const StabilityCase& c : cases) {
    SCOPED_TRACE(c.group + ": " + c.title);
    EXPECT_TRUE(MaterialTable::create(c.materials).ok());
    EXPECT_LE(voxel_count(c.volume.size()), 20'000) << "the reference is slow";
    double soft = 1e30;
    double stiff = 0.0;
    for (const Material& m : c.materials) {
      soft = std::min(soft, m.stiffness);
      stiff = std::max(stiff, m.stiffness);
    }
    stiffest_ratio = std::max(stiffest_ratio, stiff / soft);
    for (const Grab& grab : c.grabs) {
      EXPECT_TRUE(contains(c.volume.size(), grab.element));
      if (const double length = glm::length(grab.by_voxels); length > 0.0) {
        shortest = std::min(shortest, length);
        furthest = std::max(furthest, length);
      }
    }
    const glm::dvec3 h = c.volume.spacing_mm();
    flattest = std::max(flattest, std::max({h.x, h.y, h.z}) / std::min({h.x, h.y, h.z}));
    thinnest = std::min({thinnest, c.volume.size().x, c.volume.size().y, c.volume.size().z});
    if (!c.start.empty()) {
      EXPECT_EQ(c.start.size(), static_cast<std::size_t>(voxel_count(c.volume.size())));
    }
  }
  EXPECT_GE(stiffest_ratio, 1e9);
  EXPECT_NEAR(shortest, 1e-6, 1e-7);
  EXPECT_NEAR(furthest, 1e6, 1.0);
  EXPECT_DOUBLE_EQ(flattest, 10.0);
  EXPECT_EQ(thinnest, 1);

  EXPECT_EQ(stability_cases(12, 1, {"few"}).size(), 7u);
}

// A mirrored block is folded in every cell; a cut through a corner's links leaves it out.
TEST(Stability, FoldsAreOfCornersThatHangTogether) {
  const Size3 size(2, 2, 2);
  std::vector<glm::ivec3> u(8, glm::ivec3(0));
  for (std::size_t i = 1; i < 8; i += 2) u[i].x = -2 * kUnitsPerVoxel;
  EXPECT_EQ(dense_folds(size, u, {})[0], 1);
  EXPECT_EQ(dense_folded_cells(size, u), 1);
  std::vector<std::uint8_t> removed(8, 0);
  for (std::size_t i = 0; i < 8; i += 2) removed[i] = 1;  // all links along x
  EXPECT_EQ(dense_folds(size, u, removed)[0], 0);
  removed[0] = 0;  // three of them: the corners at the fourth are whole
  EXPECT_EQ(dense_folds(size, u, removed)[0], 1);
}

StabilityReport measured(std::vector<std::string> groups) {
  StabilityOptions options;
  options.edge = 10;
  options.groups = std::move(groups);
  auto report = measure_stability(options);
  EXPECT_TRUE(report.ok());
  return *std::move(report);
}

TEST(Stability, NothingRisesFoldsOrEndsBeyondNumbers) {
  const StabilityReport report =
      measured({"limits", "thin", "opposed", "coincident", "cut", "anchors", "few"});
  ASSERT_GT(report.rows.size(), 40u);
  for (const Row& row : report.rows) {
    SCOPED_TRACE(row.group + ": " + row.title);
    EXPECT_EQ(row.failure, "");
    EXPECT_TRUE(row.finite);
    EXPECT_EQ(row.violated_links, 0);
    EXPECT_EQ(row.energy_rises, 0);
    EXPECT_FALSE(row.energy_said_to_rise);
    EXPECT_LE(row.energy_last, row.energy_first * (1.0 + 1e-6));
    EXPECT_LE(row.folded_most, row.folded_first);
    EXPECT_EQ(row.newly_folded, 0);
    EXPECT_GE(row.distance_voxels, row.distance_rms_voxels);
    // Folded cells leave several equilibria, and ways to each that are long.
    if (row.folded_first > 0) continue;
    EXPECT_TRUE(row.converged);
    EXPECT_TRUE(row.reference_converged);
    EXPECT_LE(row.estimate_voxels, 0.01);
    EXPECT_LE(row.distance_voxels, 0.3) << "it is not far off";
  }
}

TEST(StabilityPage, SaysEveryCase) {
  StabilityReport report = measured({"few", "coincident"});
  Row bad = good_row();
  bad.finite = false;
  bad.energy_last = bad.estimate_voxels = std::numeric_limits<double>::infinity();
  report.rows.push_back(bad);
  const MeasurePage page = page_of(report);
  EXPECT_EQ(test::xml_fault(page.svg), "");
  const auto json = nlohmann::json::parse(page.json);
  EXPECT_EQ(json["what"], "stability");
  ASSERT_EQ(json["cases"].size(), report.rows.size());
  EXPECT_EQ(std::size_t{json["holds"]} + std::size_t{json["says_so"]} + std::size_t{json["fails"]} +
                std::size_t{json["undecided"]},
            report.rows.size());
  for (std::size_t i = 0; i < report.rows.size(); ++i) {
    const auto& one = json["cases"][i];
    EXPECT_EQ(one["title"], report.rows[i].title);
    EXPECT_EQ(one["verdict"] == "fails", one["fault"] != "");
    EXPECT_NE(page.table.find(report.rows[i].title), std::string::npos);
  }
  const auto& last = json["cases"].back();
  EXPECT_EQ(last["verdict"], "fails");
  EXPECT_TRUE(last["relaxation"]["estimate_voxels"].is_null());
  EXPECT_EQ(std::count(page.csv.begin(), page.csv.end(), '\n'),
            1 + static_cast<std::ptrdiff_t>(report.rows.size()));
  EXPECT_NE(page.table.find("NO: not finite"), std::string::npos);
}

}  // namespace
}  // namespace maille
