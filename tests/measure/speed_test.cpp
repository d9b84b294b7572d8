#include "measure/speed.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "measure/speed_bars.h"
#include "measure/speed_page.h"
#include "tests/measure/xml.h"

namespace maille {
namespace {

// The same as a person's run, of sizes that take no time.
SpeedOptions small() {
  SpeedOptions options;
  options.threads = {1, 2};
  options.runs = 3;
  options.element_counts = {1'000, 20'000};
  options.small_count = 1'000;
  options.small_volume = Size3(64);
  options.large_volume = {832, 832, 494};
  options.large_count = 20'000;
  options.mixed_edge = 48;
  options.ball_drag_voxels = 3;
  options.block_drag_voxels = 16;
  options.again_count = 20'000;
  options.moved_again_edge = 48;
  options.row_bricks = 4;
  options.pointer_positions = 9;
  options.pointer_count = 20'000;
  return options;
}

TEST(Octahedron, CountsItsElements) {
  EXPECT_EQ(Octahedron{0}.elements(), 1);
  EXPECT_EQ(Octahedron{1}.elements(), 7);
  EXPECT_EQ(Octahedron{2}.elements(), 25);
  EXPECT_EQ(octahedron_of(1).half_axis, 0);
  EXPECT_EQ(octahedron_of(8).half_axis, 1);
  EXPECT_EQ(octahedron_of(20).half_axis, 2);
  for (const std::int64_t count : {10'000, 100'000, 1'000'000, 10'000'000}) {
    EXPECT_NEAR(static_cast<double>(octahedron_of(count).elements()) / static_cast<double>(count),
                1.0, 0.07);
  }
}

TEST(EmptyVolume, IsEmptyHoweverLarge) {
  const Volume volume = empty_volume({5000, 5000, 3000});  // 75 GB of addresses
  EXPECT_EQ(volume.value_at({4999, 4999, 2999}), 0.0);
  EXPECT_EQ(volume.value_at({0, 0, 0}), 0.0);
}

TEST(Speed, ItsNumbersAreConsistent) {
  const auto report = measure_speed(small());
  ASSERT_TRUE(report.ok());
  const MeasurePage page = page_of(*report);
  EXPECT_EQ(test::xml_fault(page.svg), "");
  const auto json = nlohmann::json::parse(page.json);
  EXPECT_EQ(json["maille_measure"], 1);
  EXPECT_EQ(json["what"], "speed");
  ASSERT_EQ(json["drags"].size(), 2u * 13u);
  for (const auto& drag : json["drags"]) {
    SCOPED_TRACE(drag.dump());
    const double ms = drag["milliseconds"]["median"];
    EXPECT_GT(ms, 0.0);
    EXPECT_LE(drag["milliseconds"]["least"], ms);
    EXPECT_GE(drag["milliseconds"]["most"], ms);
    EXPECT_EQ(drag["milliseconds"]["runs"], 3);
    const double elements = drag["elements"];
    EXPECT_NEAR(drag["elements_per_second"], elements / ms * 1e3, 1e-6 * elements / ms * 1e3);
    EXPECT_NEAR(drag["ratio_to_paper"], elements / ms * 1e3 / 2.34e6, 1e-3);
    const double triad = json["machine"]["triad_gb_per_s"][std::to_string(int{drag["threads"]})];
    EXPECT_NEAR(drag["triad_share"],
                elements * double{drag["least_bytes_per_element"]} / ms * 1e-6 / triad, 1e-6);
    const auto& lattice = drag["lattice_at_rest"];
    EXPECT_NEAR(lattice["bytes_per_element"],
                double{lattice["bytes"]} / double{lattice["elements"]}, 1e-9);
    EXPECT_LE(lattice["elements"], 32768.0 * double{lattice["bricks"]});
    EXPECT_LE(elements, lattice["elements"]);
    EXPECT_NEAR(drag["bricks_triad_share"],
                double{drag["triad_share"]} * double{lattice["elements"]} / elements, 1e-9);
    const auto& stroke = drag["stroke_memory"];
    EXPECT_EQ(stroke["bytes"], std::int64_t{stroke["lattice_bytes"]} +
                                   std::int64_t{stroke["gathered_bytes"]} +
                                   std::int64_t{stroke["working_bytes"]});
    EXPECT_GE(stroke["between_positions_bytes"], lattice["bytes"]);
    EXPECT_GT(stroke["bytes"], stroke["between_positions_bytes"]);
    if (drag["group"] == "random_blocks") {
      EXPECT_EQ(elements, 48 * 48 * 48);  // all of it
    }
  }
  // What moves is what was asked for, whatever the volume and the direction.
  const auto expected = octahedron_of(20'000).elements();
  for (const auto& drag : json["drags"]) {
    const std::string group = drag["group"];
    if (group == "large_volume") {
      EXPECT_EQ(drag["elements"], expected);
    }
    if (group == "volume_size") {
      EXPECT_EQ(drag["elements"], octahedron_of(1'000).elements());
    }
    if (group == "general") {
      EXPECT_EQ(drag["least_bytes_per_element"], 6.0);
    }
    if (group == "moved_again") {
      EXPECT_EQ(drag["elements"], 48 * 48 * 48);
      EXPECT_EQ(drag["least_bytes_per_element"], 13.0);
    }
    if (group == "single_row") {
      EXPECT_EQ(drag["elements"], 4 * 32);
      EXPECT_EQ(drag["lattice_at_rest"]["bricks"], 4);
    }
    if (group == "stiff_ball") {
      EXPECT_EQ(drag["least_bytes_per_element"], 3.0);
    }
  }
  for (const auto& bar : json["bars"]) {
    const bool met = bar.contains("at_least") ? bar["measured"] >= bar["at_least"]
                                              : bar["measured"] <= bar["at_most"];
    EXPECT_EQ(bar["met"], met) << bar;
  }
  for (const auto& growth : json["growth"]) EXPECT_TRUE(growth["exponent"].is_number());
  ASSERT_EQ(json["pointer"].size(), 2u);
  for (const auto& pointer : json["pointer"]) {
    ASSERT_EQ(pointer["positions"].size(), 9u);
    EXPECT_GE(pointer["milliseconds"]["most"], pointer["percentile_99_milliseconds"]);
    EXPECT_GE(pointer["percentile_99_milliseconds"], pointer["milliseconds"]["median"]);
    // The last third and more of the path is at full length.
    for (std::size_t i = 3; i < 9; ++i) {
      EXPECT_EQ(pointer["positions"][i]["elements"], expected) << i;
    }
  }
  EXPECT_EQ(std::count(page.csv.begin(), page.csv.end(), '\n'), 1 + 2 * 13);
  EXPECT_NE(page.table.find("stiff ball"), page.table.npos);
}

TEST(Speed, ABarIsThereWhereWhatItIsSetForWasMeasured) {
  SpeedReport report;
  report.machine.triad_gb_per_s = {{1, 10.0}, {2, 15.0}};
  for (const int threads : {1, 2}) {
    SpeedReport::Row row;
    row.group = "one_axis";
    row.threads = threads;
    row.elements = 988'441;
    row.next.median_seconds = 0.004;
    row.at_rest = {80, 80 * 32768, 80 * 32768 * 9};
    report.rows.push_back(row);
    row.elements = 38'000;
    report.rows.push_back(row);
  }
  const auto bars = bars_of(report);
  const auto find = [&](const std::string& what, int threads) {
    for (const SpeedBar& bar : bars) {
      if (bar.what == what && bar.threads == threads) return bar;
    }
    throw std::out_of_range(what);
  };
  const SpeedBar one = find("one axis, 1 M elements", 1);
  EXPECT_NEAR(one.measured, 247.1, 0.1);
  EXPECT_EQ(one.row, &report.rows[0]);
  EXPECT_TRUE(one.met());
  EXPECT_FALSE(find("one axis, 1 M elements", 2).met());
  EXPECT_FALSE(find("lattice at rest, worst drag", 1).met());
  EXPECT_TRUE(find("during a stroke, between positions", 1).met());
  EXPECT_THROW(find("one axis, 100 k elements", 1), std::out_of_range);
  EXPECT_THROW(find("stiff ball", 1), std::out_of_range);
}

TEST(Speed, GrowthIsTheSlopeOfTheLogarithms) {
  SpeedReport report;
  for (const std::int64_t elements : {1000, 10000, 100000}) {
    SpeedReport::Row row;
    row.group = "one_axis";
    row.elements = elements;
    row.next.median_seconds = 1e-6 * std::pow(static_cast<double>(elements), 1.25);
    report.rows.push_back(row);
  }
  EXPECT_NEAR(report.growth("one_axis", 1), 1.25, 1e-9);
  EXPECT_EQ(report.growth("one_axis", 2), 0.0);
  EXPECT_EQ(report.growth("general", 1), 0.0);
}

}  // namespace
}  // namespace maille
