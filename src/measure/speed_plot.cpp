#include "measure/speed_plot.h"

#include <algorithm>
#include <cmath>

#include "measure/plot.h"
#include "measure/speed_bars.h"
#include "measure/text_table.h"

namespace maille {
namespace {

using Row = SpeedReport::Row;
using plot::Line;
using plot::Marker;

const char* const kBlack = "#222222";
const plot::Style kPaper{plot::color::kGrey, Marker::none, Line::dashed, false};
const plot::Style kLinear{kBlack, Marker::none, Line::dotted, false};
const plot::Style kFrame{plot::color::kOrange, Marker::none, Line::dotted, false};
const plot::Style kBar{kBlack, Marker::tick, Line::none, false};
const plot::Style kBound{plot::color::kGrey, Marker::tick, Line::none, false};
constexpr double kFrame_ms = 33.0;  // what a position of the pointer may take

double million(double count) { return 1e-6 * count; }
double milliseconds(const Row& row) { return 1e3 * row.next.median_seconds; }

// Groups tell colour and shape, threads the fill.
plot::Style style_of(const std::string& group, int threads) {
  plot::Style style{plot::color::kGrey, Marker::circle, Line::none, threads == 1};
  if (group == "one_axis") style.color = plot::color::kBlue;
  if (group == "general") {
    style.color = plot::color::kOrange;
    style.marker = Marker::square;
  }
  if (group == "stiff_ball" || group == "random_blocks") style.color = plot::color::kGreen;
  if (group == "stiff_ball") style.marker = Marker::diamond;
  if (group == "random_blocks") style.marker = Marker::triangle;
  if (group == "again_one_axis" || group == "again_general" || group == "moved_again") {
    style.color = plot::color::kPurple;
    style.marker = Marker::diamond;
  }
  return style;
}

const char* label_of(const std::string& group) {
  if (group == "one_axis") return "one axis";
  return group == "general" ? "general" : "";
}

bool grows(const std::string& group) { return group == "one_axis" || group == "general"; }

std::vector<std::string> groups_of(const SpeedReport& report) {
  std::vector<std::string> groups;
  for (const Row& row : report.rows) {
    // The row of single elements is about bricks, not about elements.
    if (row.group != "single_row" &&
        std::find(groups.begin(), groups.end(), row.group) == groups.end()) {
      groups.push_back(row.group);
    }
  }
  return groups;
}

plot::Panel time_panel(const SpeedReport& report) {
  plot::Panel panel;
  panel.title = "Time against elements";
  std::vector<double> elements, times;
  for (const Row& row : report.rows) {
    elements.push_back(static_cast<double>(row.elements));
    times.push_back(milliseconds(row));
  }
  const auto x = plot::decades_around(elements);
  const auto paper_ms = [](double count) { return 1e3 * count / kPaperElementsPerSecond; };
  times.push_back(paper_ms(x.low));
  const auto y = plot::decades_around(times);
  panel.x = {"elements moved", plot::Scale::log, x.low, x.high, {}};
  panel.y = {"time of a position [ms]", plot::Scale::log, y.low, y.high, {}};
  const double paper_end = std::min(x.high, y.high / paper_ms(1.0));
  panel.series.push_back(
      {kPaper, {{x.low, paper_ms(x.low)}, {paper_end, paper_ms(paper_end)}}, {}, ""});
  // Linear through the drag that is nearest to a million elements.
  const Row* anchor = nullptr;
  for (const Row& row : report.rows) {
    const auto away = [](const Row& r) {
      return std::abs(std::log(1e-6 * static_cast<double>(r.elements)));
    };
    if (row.group == "one_axis" && (!anchor || away(row) < away(*anchor))) anchor = &row;
  }
  if (anchor) {
    const double ms_each = milliseconds(*anchor) / static_cast<double>(anchor->elements);
    const double begin = std::max(x.low, y.low / ms_each);
    const double end = std::min(x.high, y.high / ms_each);
    panel.series.push_back({kLinear, {{begin, ms_each * begin}, {end, ms_each * end}}, {}, ""});
  }
  for (const auto& [threads, triad] : report.machine.triad_gb_per_s) {
    const bool last = threads == report.machine.triad_gb_per_s.rbegin()->first;
    for (const std::string& group : groups_of(report)) {
      plot::Series series;
      series.style = style_of(group, threads);
      if (grows(group)) series.style.line = last ? Line::solid : Line::dashed;
      if (last) series.label = label_of(group);
      for (const Row& row : report.rows) {
        if (row.group != group || row.threads != threads) continue;
        series.points.push_back({static_cast<double>(row.elements), milliseconds(row)});
      }
      panel.series.push_back(std::move(series));
    }
  }
  return panel;
}

std::string name_of(const Row& row) {
  const double count = static_cast<double>(row.elements);
  return row.title + ", " +
         (count < 1e6 ? fixed_number(1e-3 * count, 0) + " k"
                      : fixed_number(1e-6 * count, count < 9.95e6 ? 1 : 0) + " M");
}

plot::Panel rate_panel(const SpeedReport& report) {
  plot::Panel panel;
  panel.title = "Elements a second (line: range of all runs)";
  std::vector<double> rates{million(kPaperElementsPerSecond)};
  std::vector<std::string>& names = panel.y.names;
  const auto add = [&](const plot::Style& style, double rate, double place,
                       std::vector<glm::dvec2> ranges) {
    rates.push_back(rate);
    for (const glm::dvec2 range : ranges) rates.insert(rates.end(), {range.x, range.y});
    panel.series.push_back({style, {{rate, place}}, std::move(ranges), ""});
  };
  for (const Row& row : report.rows) {
    const double count = static_cast<double>(row.elements);
    const std::string name = name_of(row);
    auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) at = names.insert(names.end(), name);
    const auto place = static_cast<double>(at - names.begin());
    const double triad = report.machine.triad_gb_per_s.at(row.threads);
    add(kBound, 1e3 * triad / row.least_bytes_per_element, place, {});
    for (const SpeedBar& bar : bars_of(report)) {
      if (bar.row == &row) add(kBar, bar.bar, place, {});
    }
    add(style_of(row.group, row.threads), million(row.elements_per_second()), place,
        {{million(count / row.next.most_seconds), million(count / row.next.least_seconds)}});
  }
  const auto x = plot::decades_around(rates);
  panel.x = {"million elements/s", plot::Scale::log, x.low, x.high, {}};
  panel.y.scale = plot::Scale::names;
  const double bottom = static_cast<double>(names.size()) - 0.5;
  const double paper = million(kPaperElementsPerSecond);
  panel.series.insert(panel.series.begin(), {kPaper, {{paper, -0.5}, {paper, bottom}}, {}, ""});
  return panel;
}

plot::Panel pointer_panel(const SpeedReport& report) {
  plot::Panel panel;
  std::vector<double> times{kFrame_ms};
  std::size_t positions = 1;
  std::int64_t elements = 0;
  for (const SpeedReport::Pointer& pointer : report.pointers) {
    plot::Series median, worst;
    median.style = style_of("one_axis", pointer.threads);
    median.style.marker = Marker::none;
    median.style.line = pointer.threads == 1 ? Line::dashed : Line::solid;
    worst.style = style_of("one_axis", pointer.threads);
    for (std::size_t i = 0; i < pointer.positions.size(); ++i) {
      const auto position = static_cast<double>(i + 1);
      const Timing& timing = pointer.positions[i];
      median.points.push_back({position, 1e3 * timing.median_seconds});
      worst.points.push_back({position, 1e3 * timing.most_seconds});
      times.insert(times.end(), {1e3 * timing.median_seconds, 1e3 * timing.most_seconds});
      elements = std::max(elements, pointer.elements[i]);
    }
    positions = std::max(positions, pointer.positions.size());
    panel.series.push_back(std::move(median));
    panel.series.push_back(std::move(worst));
  }
  panel.title = "A pointer's drag over " + fixed_number(million(static_cast<double>(elements)), 2) +
                " million elements";
  const auto right = static_cast<double>(positions);
  panel.series.push_back({kFrame, {{0, kFrame_ms}, {right, kFrame_ms}}, {}, "33 ms"});
  const auto y = plot::decades_around(times);
  panel.x = {"position of the pointer", plot::Scale::linear, 0.0, right, {}};
  panel.y = {"time of the position [ms]", plot::Scale::log, y.low, y.high, {}};
  return panel;
}

}  // namespace

std::string svg_of(const SpeedReport& report) {
  plot::Page page;
  page.title = "How fast Maille answers a drag";
  const int runs = report.rows.empty() ? 0 : report.rows.front().next.runs;
  page.notes = {text_of(report.machine),
                "a later position of a stroke, median of " + std::to_string(runs) +
                    " runs; hollow marks and dashed lines: 1 thread, full ones: more; slack 0.2 of "
                    "a voxel unless said otherwise"};
  page.panels = {time_panel(report), rate_panel(report), pointer_panel(report)};
  plot::Style pointer = style_of("one_axis", 2);
  plot::Style pointer_line = pointer;
  pointer_line.line = Line::solid;
  pointer_line.marker = Marker::none;
  page.legend = {{"one material, one axis", style_of("one_axis", 2)},
                 {"one material, general direction", style_of("general", 2)},
                 {"stiff ball in soft medium", style_of("stiff_ball", 2)},
                 {"random 8³ blocks", style_of("random_blocks", 2)},
                 {"tissue that has moved before", style_of("again_general", 2)},
                 {"small and large volume, single row", style_of("volume_size", 2)},
                 {"the paper (2007): 2.34 million elements/s", kPaper},
                 {"linear, through a million elements", kLinear},
                 {"what it has to reach", kBar},
                 {"what the memory's bandwidth allows", kBound},
                 {"pointer: median of a position's runs", pointer_line},
                 {"pointer: the slowest of them", pointer}};
  page.legend_columns = 4;
  return plot::to_svg(page);
}

}  // namespace maille
