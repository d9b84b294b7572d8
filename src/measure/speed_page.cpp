#include "measure/speed_page.h"

#include <algorithm>

#include "measure/json_parts.h"
#include "measure/plot.h"
#include "measure/text_table.h"

namespace maille {
namespace {

using Json = nlohmann::ordered_json;
using Row = SpeedReport::Row;
using Pointer = SpeedReport::Pointer;

constexpr double kFrame_ms = 33.0;  // what a position of the pointer may take

double million(double count) { return 1e-6 * count; }
double paper_ratio(const Row& row) { return row.elements_per_second() / kPaperElementsPerSecond; }

Json memory_json(const LatticeUse& memory) {
  return {{"bricks", memory.bricks},
          {"bytes", memory.bytes},
          {"bytes_per_element", memory.bytes_per_element()}};
}

std::string json_text(const SpeedReport& report) {
  Json out = {{"maille_measure", 1},
              {"version", MAILLE_VERSION},
              {"what", "speed"},
              {"machine", json_of(report.machine)},
              {"seed", report.seed},
              {"paper_elements_per_second", kPaperElementsPerSecond},
              {"bandwidth_model",
               "least_bytes_per_element: 2 bytes written for each component that moves, and 1 read "
               "where materials differ"},
              {"drags", Json::array()},
              {"growth", Json::array()},
              {"pointer", Json::array()}};
  for (const Row& row : report.rows) {
    out["drags"].push_back(Json{{"group", row.group},
                                {"title", row.title},
                                {"size", json_of(row.size)},
                                {"drag_voxels", json_of(row.drag_voxels)},
                                {"threads", row.threads},
                                {"elements", row.elements},
                                {"milliseconds", json_of(row.next)},
                                {"first_position_milliseconds", json_of(row.first)},
                                {"elements_per_second", row.elements_per_second()},
                                {"ratio_to_paper", paper_ratio(row)},
                                {"least_bytes_per_element", row.least_bytes_per_element},
                                {"least_gb_per_s", row.least_gb_per_s()},
                                {"triad_share", report.triad_share(row)},
                                {"lattice_in_stroke", memory_json(row.in_stroke)},
                                {"lattice_at_rest", memory_json(row.at_rest)}});
  }
  for (const char* const group : {"one_axis", "general"}) {
    for (const auto& [threads, triad] : report.machine.triad_gb_per_s) {
      out["growth"].push_back(Json{
          {"group", group}, {"threads", threads}, {"exponent", report.growth(group, threads)}});
    }
  }
  for (const Pointer& pointer : report.pointers) {
    Json positions = Json::array();
    for (std::size_t i = 0; i < pointer.positions.size(); ++i) {
      positions.push_back(
          Json{{"elements", pointer.elements[i]}, {"milliseconds", json_of(pointer.positions[i])}});
    }
    out["pointer"].push_back(
        Json{{"threads", pointer.threads},
             {"milliseconds", json_of(pointer.all)},
             {"percentile_99_milliseconds", 1e3 * pointer.percentile_99_seconds},
             {"positions", std::move(positions)}});
  }
  return text_of(out);
}

std::string csv_text(const SpeedReport& report) {
  std::vector<std::vector<std::string>> rows = {
      {"group", "title", "size", "threads", "elements", "median_ms", "least_ms", "most_ms", "runs",
       "first_position_median_ms", "elements_per_second", "ratio_to_paper",
       "least_bytes_per_element", "triad_share", "lattice_bytes_in_stroke", "lattice_bytes_at_rest",
       "lattice_bytes_per_element"}};
  for (const Row& row : report.rows) {
    rows.push_back({row.group, row.title,
                    std::to_string(row.size.x) + "x" + std::to_string(row.size.y) + "x" +
                        std::to_string(row.size.z),
                    std::to_string(row.threads), std::to_string(row.elements),
                    fixed_number(1e3 * row.next.median_seconds, 4),
                    fixed_number(1e3 * row.next.least_seconds, 4),
                    fixed_number(1e3 * row.next.most_seconds, 4), std::to_string(row.next.runs),
                    fixed_number(1e3 * row.first.median_seconds, 4),
                    fixed_number(row.elements_per_second(), 0), fixed_number(paper_ratio(row), 3),
                    fixed_number(row.least_bytes_per_element, 0),
                    fixed_number(report.triad_share(row), 5), std::to_string(row.in_stroke.bytes),
                    std::to_string(row.at_rest.bytes),
                    fixed_number(row.at_rest.bytes_per_element(), 3)});
  }
  return csv(rows);
}

std::string table_text(const SpeedReport& report) {
  std::string out = "Speed of a drag: a later position of a stroke, from rest\n" +
                    text_of(report.machine) + "\n\n";
  std::vector<std::vector<std::string>> rows = {{"scene", "elements", "thr", "ms", "least", "most",
                                                 "first ms", "M elem/s", "x paper", "of triad",
                                                 "MB", "B/elem"}};
  for (const Row& row : report.rows) {
    rows.push_back({row.title, std::to_string(row.elements), std::to_string(row.threads),
                    fixed_number(1e3 * row.next.median_seconds, 3),
                    fixed_number(1e3 * row.next.least_seconds, 3),
                    fixed_number(1e3 * row.next.most_seconds, 3),
                    fixed_number(1e3 * row.first.median_seconds, 3),
                    fixed_number(million(row.elements_per_second()), 1),
                    fixed_number(paper_ratio(row), 1),
                    fixed_number(100.0 * report.triad_share(row), 1) + " %",
                    fixed_number(million(static_cast<double>(row.at_rest.bytes)), 1),
                    fixed_number(row.at_rest.bytes_per_element(), 1)});
  }
  out += text_table(rows);
  const int runs = report.rows.empty() ? 0 : report.rows.front().next.runs;
  out +=
      "\nms: median of " + std::to_string(runs) +
      " runs. first ms: button-down and the first position. x paper: 2.34 M elements/s.\nof triad: "
      "2 bytes for each component an element moves in, and 1 where materials differ, of what the\n"
      "triad moves on as many threads. MB, B/elem: of lattice, after button-up, of touched "
      "bricks.\n";
  for (const char* const group : {"one_axis", "general"}) {
    for (const auto& [threads, triad] : report.machine.triad_gb_per_s) {
      out += std::string(group[0] == 'o' ? "one axis" : "general direction") + ", " +
             std::to_string(threads) + (threads == 1 ? " thread" : " threads") +
             ": time grows as elements^" + fixed_number(report.growth(group, threads), 2) + "\n";
    }
  }
  for (const Pointer& pointer : report.pointers) {
    const std::int64_t most = *std::max_element(pointer.elements.begin(), pointer.elements.end());
    out += "pointer along " + std::to_string(pointer.positions.size()) + " positions, up to " +
           std::to_string(most) + " elements, " + std::to_string(pointer.threads) +
           (pointer.threads == 1 ? " thread" : " threads") + ": median " +
           fixed_number(1e3 * pointer.all.median_seconds, 2) + " ms, 99th percentile " +
           fixed_number(1e3 * pointer.percentile_99_seconds, 2) + " ms, worst " +
           fixed_number(1e3 * pointer.all.most_seconds, 2) + " ms\n";
  }
  return out;
}

// --- the plot

// Threads tell the fill, groups the colour and shape.
plot::Style style_of(const std::string& group, int threads) {
  plot::Style style{plot::color::kBlue, plot::Marker::circle, plot::Line::none, threads == 1};
  if (group == "general") style = {plot::color::kOrange, plot::Marker::square, {}, threads == 1};
  if (group == "stiff_ball") style = {plot::color::kGreen, plot::Marker::diamond, {}, threads == 1};
  if (group == "random_blocks") {
    style = {plot::color::kPurple, plot::Marker::triangle, {}, threads == 1};
  }
  if (group == "volume_size" || group == "large_volume") style.color = plot::color::kGrey;
  return style;
}

const char* title_of(const std::string& group) {
  if (group == "one_axis") return "one material, one axis";
  if (group == "general") return "one material, general direction";
  if (group == "stiff_ball") return "stiff ball in soft medium";
  if (group == "random_blocks") return "random 8³ blocks";
  return "small and large volume";
}

bool grows(const std::string& group) { return group == "one_axis" || group == "general"; }

plot::Panel time_panel(const SpeedReport& report) {
  plot::Panel panel;
  panel.title = "Time against elements";
  std::vector<double> elements, times;
  for (const Row& row : report.rows) {
    elements.push_back(static_cast<double>(row.elements));
    times.push_back(1e3 * row.next.median_seconds);
  }
  const auto x = plot::decades_around(elements);
  const auto paper_ms = [](double count) { return 1e3 * count / kPaperElementsPerSecond; };
  times.push_back(paper_ms(x.low));
  const auto y = plot::decades_around(times);
  panel.x = {"elements moved", plot::Scale::log, x.low, x.high, {}};
  panel.y = {"time of a position [ms]", plot::Scale::log, y.low, y.high, {}};
  const double paper_end = std::min(x.high, y.high / paper_ms(1.0));
  panel.series.push_back({{plot::color::kGrey, plot::Marker::none, plot::Line::dashed, false},
                          {{x.low, paper_ms(x.low)}, {paper_end, paper_ms(paper_end)}},
                          {}});
  // Linear through the drag of about a million elements on the fewest threads.
  const Row* anchor = nullptr;
  for (const Row& row : report.rows) {
    const auto away = [](const Row& r) {
      return std::abs(std::log(1e-6 * static_cast<double>(r.elements)));
    };
    if (row.group == "one_axis" && (!anchor || away(row) < away(*anchor))) anchor = &row;
  }
  if (anchor) {
    const double ms_each =
        1e3 * anchor->next.median_seconds / static_cast<double>(anchor->elements);
    const double begin = std::max(x.low, y.low / ms_each);
    const double end = std::min(x.high, y.high / ms_each);
    panel.series.push_back({{"#222222", plot::Marker::none, plot::Line::dotted, false},
                            {{begin, ms_each * begin}, {end, ms_each * end}},
                            {}});
  }
  for (const auto& [threads, triad] : report.machine.triad_gb_per_s) {
    std::vector<std::string> groups;
    for (const Row& row : report.rows) {
      if (std::find(groups.begin(), groups.end(), row.group) == groups.end()) {
        groups.push_back(row.group);
      }
    }
    for (const std::string& group : groups) {
      plot::Series series;
      series.style = style_of(group, threads);
      if (grows(group)) series.style.line = plot::Line::solid;
      for (const Row& row : report.rows) {
        if (row.group != group || row.threads != threads) continue;
        series.points.push_back({static_cast<double>(row.elements), 1e3 * row.next.median_seconds});
      }
      panel.series.push_back(std::move(series));
    }
  }
  return panel;
}

plot::Panel rate_panel(const SpeedReport& report) {
  plot::Panel panel;
  panel.title = "Elements a second (line: range of all runs)";
  std::vector<double> rates{million(kPaperElementsPerSecond)};
  std::vector<std::string>& names = panel.y.names;
  for (const Row& row : report.rows) {
    const double count = static_cast<double>(row.elements);
    std::string name = row.title + ", " +
                       (count < 1e6 ? fixed_number(1e-3 * count, 0) + " k"
                                    : fixed_number(1e-6 * count, count < 9.95e6 ? 1 : 0) + " M");
    auto place = std::find(names.begin(), names.end(), name);
    if (place == names.end()) place = names.insert(names.end(), name);
    plot::Series series;
    series.style = style_of(row.group, row.threads);
    series.points = {
        {million(row.elements_per_second()), static_cast<double>(place - names.begin())}};
    series.x_ranges = {
        {million(count / row.next.most_seconds), million(count / row.next.least_seconds)}};
    rates.insert(rates.end(), {series.x_ranges[0].x, series.x_ranges[0].y});
    panel.series.push_back(std::move(series));
  }
  const auto x = plot::decades_around(rates);
  panel.x = {"million elements/s", plot::Scale::log, x.low, x.high, {}};
  panel.y.scale = plot::Scale::names;
  panel.series.insert(
      panel.series.begin(),
      {{plot::color::kGrey, plot::Marker::none, plot::Line::dashed, false},
       {{million(kPaperElementsPerSecond), -0.5},
        {million(kPaperElementsPerSecond), static_cast<double>(names.size()) - 0.5}},
       {}});
  return panel;
}

plot::Panel pointer_panel(const SpeedReport& report) {
  plot::Panel panel;
  panel.title = "A pointer's drag, position by position";
  double most_ms = kFrame_ms * 1.1;
  std::size_t positions = 1;
  std::int64_t elements = 0;
  for (const Pointer& pointer : report.pointers) {
    plot::Series median, worst;
    median.style = style_of("one_axis", pointer.threads);
    median.style.marker = plot::Marker::none;
    median.style.line = pointer.threads == 1 ? plot::Line::dashed : plot::Line::solid;
    worst.style = style_of("one_axis", pointer.threads);
    for (std::size_t i = 0; i < pointer.positions.size(); ++i) {
      const auto position = static_cast<double>(i + 1);
      median.points.push_back({position, 1e3 * pointer.positions[i].median_seconds});
      worst.points.push_back({position, 1e3 * pointer.positions[i].most_seconds});
      most_ms = std::max(most_ms, 1.05e3 * pointer.positions[i].most_seconds);
      elements = std::max(elements, pointer.elements[i]);
    }
    positions = std::max(positions, pointer.positions.size());
    panel.series.push_back(std::move(median));
    panel.series.push_back(std::move(worst));
  }
  panel.series.push_back({{plot::color::kOrange, plot::Marker::none, plot::Line::dotted, false},
                          {{0, kFrame_ms}, {static_cast<double>(positions), kFrame_ms}},
                          {}});
  panel.x = {"position, up to " + fixed_number(million(static_cast<double>(elements)), 2) +
                 " million elements; line: median, marks: worst",
             plot::Scale::linear,
             0.0,
             static_cast<double>(positions),
             {}};
  panel.y = {"time of a position [ms]", plot::Scale::linear, 0.0, most_ms, {}};
  return panel;
}

std::string svg_text(const SpeedReport& report) {
  plot::Page page;
  page.title = "How fast Maille answers a drag";
  const int runs = report.rows.empty() ? 0 : report.rows.front().next.runs;
  page.notes = {text_of(report.machine),
                "medians of " + std::to_string(runs) +
                    " runs of a later position of a stroke; hollow marks: 1 thread, full ones: "
                    "more; slack 0.2 of a voxel unless said otherwise"};
  page.panels = {time_panel(report), rate_panel(report), pointer_panel(report)};
  for (const char* const group :
       {"one_axis", "general", "stiff_ball", "random_blocks", "volume_size"}) {
    page.legend.push_back({title_of(group), style_of(group, 2)});
  }
  page.legend.push_back({"the paper (2007): 2.34 million elements/s",
                         {plot::color::kGrey, plot::Marker::none, plot::Line::dashed, false}});
  page.legend.push_back({"linear, through a million elements",
                         {"#222222", plot::Marker::none, plot::Line::dotted, false}});
  page.legend.push_back(
      {"33 ms", {plot::color::kOrange, plot::Marker::none, plot::Line::dotted, false}});
  page.legend_columns = 4;
  return plot::to_svg(page);
}

}  // namespace

MeasurePage page_of(const SpeedReport& report) {
  return {json_text(report), csv_text(report), svg_text(report), table_text(report)};
}

}  // namespace maille
