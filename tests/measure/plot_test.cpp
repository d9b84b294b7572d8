#include "measure/plot.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/measure/xml.h"

namespace maille::plot {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++found;
  return found;
}

Page page_of(Axis x, Axis y, std::vector<glm::dvec2> points) {
  Page page;
  page.title = "a < b & \"c\" > d";
  page.notes = {"µs, 8³ & more"};
  page.panels = {{"panel",
                  std::move(x),
                  std::move(y),
                  {{{"#123456", Marker::circle, Line::solid, false}, std::move(points), {}, ""}}}};
  page.legend = {{"entry", {"#abcdef", Marker::square, Line::dashed, true}}, {"", {}}};
  return page;
}

TEST(Plot, IsWellFormedWhateverTheTextsHold) {
  for (const Marker marker : {Marker::none, Marker::circle, Marker::square, Marker::triangle,
                              Marker::diamond, Marker::cross, Marker::plus}) {
    Page page = page_of({"x", Scale::log, 1, 1000, {}}, {"y", Scale::linear, 0, 1, {}},
                        {{1, 0}, {10, 0.5}, {1000, 1}});
    page.panels[0].series[0].style.marker = marker;
    const std::string svg = to_svg(page);
    EXPECT_EQ(test::xml_fault(svg), "");
    EXPECT_NE(svg.find("a &lt; b &amp; &quot;c&quot; &gt; d"), svg.npos);
    EXPECT_NE(svg.find("µs, 8³ &amp; more"), svg.npos);
  }
  EXPECT_EQ(test::xml_fault(to_svg({})), "");
}

TEST(Plot, LeavesOutWhatDoesNotFit) {
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Axis log{"x", Scale::log, 1, 100, {}};
  const std::string svg = to_svg(page_of(
      log, log, {{10, 10}, {0, 10}, {10, -1}, {1e5, 10}, {nan, 10}, {10, infinity}, {100, 1}}));
  EXPECT_EQ(test::xml_fault(svg), "");
  EXPECT_EQ(count(svg, "<circle"), 2u);
  EXPECT_EQ(svg.find("nan"), svg.npos);
  EXPECT_EQ(svg.find("inf"), svg.npos);
}

TEST(Plot, ZeroHasAPlaceOnALogScaleThatSaysSo) {
  const Axis x{"x", Scale::log, 1, 100, {}};
  const Axis y{"y", Scale::log_with_zero, 0.01, 1, {}};
  const std::string svg = to_svg(page_of(x, y, {{1, 0}, {10, 0.1}}));
  EXPECT_EQ(count(svg, "<circle"), 2u);
  EXPECT_EQ(count(svg, ">0</text>"), 1u);
  EXPECT_EQ(count(svg, ">0.01</text>"), 1u);
}

TEST(Plot, AnAxisWritesItsDecadesOneWay) {
  const Axis y{"y", Scale::linear, 0, 1, {}};
  const std::string few = to_svg(page_of({"x", Scale::log, 0.1, 1000, {}}, y, {}));
  EXPECT_EQ(count(few, ">0.1</text>"), 1u);
  EXPECT_EQ(count(few, ">1000</text>"), 1u);
  const std::string many = to_svg(page_of({"x", Scale::log, 0.1, 1e5, {}}, y, {}));
  EXPECT_EQ(count(many, ">10⁻¹</text>"), 1u);
  EXPECT_EQ(count(many, ">10³</text>"), 1u);
  EXPECT_EQ(count(many, ">10⁵</text>"), 1u);
}

TEST(Plot, ALabelStandsAtTheLastPointThatIsThere) {
  const Axis axis{"a", Scale::linear, 0, 10, {}};
  Page page = page_of(axis, axis, {{1, 1}, {5, 5}, {50, 50}});
  page.panels[0].series[0].label = "a <label>";
  const std::string svg = to_svg(page);
  EXPECT_EQ(test::xml_fault(svg), "");
  EXPECT_GE(count(svg, "a &lt;label&gt;"), 1u);
}

TEST(Plot, DecadesHoldTheValues) {
  const Decades some = decades_around({0.03, 7.0, 0.0, -1.0});
  EXPECT_DOUBLE_EQ(some.low, 0.01);
  EXPECT_DOUBLE_EQ(some.high, 10.0);
  const Decades one = decades_around({100.0});
  EXPECT_DOUBLE_EQ(one.low, 100.0);
  EXPECT_DOUBLE_EQ(one.high, 1000.0);
  EXPECT_DOUBLE_EQ(decades_around({}).high, 10.0);
}

}  // namespace
}  // namespace maille::plot
