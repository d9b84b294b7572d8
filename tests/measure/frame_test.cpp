#include "measure/frame.h"

#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "measure/frame_page.h"
#include "tests/measure/xml.h"

namespace maille {
namespace {

TEST(Frame, ItsNumbersAreConsistent) {
  FrameOptions options;
  if (const char* name = std::getenv("MAILLE_TEST_DEVICE")) options.renderer.device = name;
  options.renderer.validation_log = std::make_shared<gpu::ValidationLog>();
  options.picture = {40, 30};
  options.runs = 3;
  options.volumes = {{40, 48, 40}, {70, 64, 33}};
  const auto report = measure_frame(options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_TRUE(options.renderer.validation_log->take().empty());
  const MeasurePage page = page_of(*report);
  EXPECT_EQ(test::xml_fault(page.svg), "");
  const auto json = nlohmann::json::parse(page.json);
  EXPECT_EQ(json["what"], "frame");
  EXPECT_NE(json["device"]["name"], "");
  ASSERT_EQ(json["frames"].size(), 8u);
  for (const auto& frame : json["frames"]) {
    const double ms = frame["milliseconds"]["median"];
    EXPECT_GT(ms, 0.0);
    EXPECT_LE(frame["milliseconds"]["least"], ms);
    EXPECT_EQ(frame["milliseconds"]["runs"], 3);
    EXPECT_GT(frame["raycast_milliseconds"], 0.0);
    EXPECT_LE(frame["raycast_milliseconds"], frame["milliseconds"]["most"]);
  }
  ASSERT_EQ(json["changes"].size(), 8u);
  EXPECT_EQ(std::count(page.csv.begin(), page.csv.end(), '\n'), 1 + 8 + 8);
  // Bars of changes hold for any volume, those of pictures for the two that they were set for.
  EXPECT_EQ(json["bars"].size(), 8u);
}

TEST(Frame, BarsAreOfShadedPicturesOfTheirVolumes) {
  FrameReport report;
  const auto row = [](Size3 volume, RenderMode mode, bool shading, double ms) {
    FrameReport::Row made;
    made.volume = volume;
    made.mode = mode;
    made.shading = shading;
    made.frame.median_seconds = 1e-3 * ms;
    return made;
  };
  report.rows = {row({256, 256, 256}, RenderMode::composite, true, 141),
                 row({256, 256, 256}, RenderMode::composite, false, 1),
                 row({512, 512, 333}, RenderMode::iso, true, 34),
                 row({300, 256, 256}, RenderMode::iso, true, 1)};
  report.changes = {{"a pick", {8, 8, 8}, {0.0011, 0, 0, 1}}};
  const auto bars = bars_of(report);
  ASSERT_EQ(bars.size(), 3u);
  EXPECT_FALSE(bars[0].met());
  EXPECT_TRUE(bars[1].met());
  EXPECT_FALSE(bars[2].met());
  EXPECT_NE(page_of(report).table.find("NOT MET"), std::string::npos);
}

}  // namespace
}  // namespace maille
