#include "measure/resample_error_plot.h"

#include <algorithm>

#include "measure/plot.h"
#include "measure/resample_bars.h"

namespace maille {
namespace {

using plot::Line;
using plot::Marker;
using Row = ResampleError::Row;
using Scene = ResampleError::Scene;

const char* const kBlack = "#222222";
const plot::Style kGrid{kBlack, Marker::none, Line::dotted, false};
const plot::Style kBar{kBlack, Marker::tick, Line::none, false};
const plot::Style kPaper{plot::color::kGrey, Marker::tick, Line::none, false};
const plot::Style kFixedPoint{plot::color::kGrey, Marker::plus, Line::solid, false};

const char* color_of(const std::string& method) {
  if (method == "nearest") return plot::color::kOrange;
  if (method == "linear") return plot::color::kBlue;
  return method == "barycentric" ? plot::color::kGreen : plot::color::kPurple;
}

// Methods tell the colour, ways the shape, and threads the fill.
plot::Style style_of(const Row& row) {
  if (row.way == "fixed_point") return kFixedPoint;
  plot::Style style{color_of(row.method), Marker::circle, Line::none, row.threads == 1};
  if (row.way == "walk_6") style.marker = Marker::triangle;
  if (row.way == "walk_26") style.marker = Marker::square;
  return style;
}

glm::dvec2 range_of(const Row& row) {
  const double each = 1e9 / static_cast<double>(row.voxels);
  return {each * row.timing.least_seconds, each * row.timing.most_seconds};
}

// One for all scenes, so that they can be compared; but what moves by whole voxels alone takes so
// much less that it has an axis of its own.
plot::Axis time_axis(const ResampleError& report, bool moves) {
  std::vector<double> times;
  for (const Scene& scene : report.scenes) {
    if (scene.moves != moves) continue;
    for (const Row& row : scene.rows) {
      times.insert(times.end(), {range_of(row).x, range_of(row).y});
    }
  }
  const auto range = plot::decades_around(times);
  return {"time of a voxel [ns]", plot::Scale::log, range.low, range.high, {}};
}

plot::Axis error_axis(const ResampleError& report) {
  std::vector<double> errors;
  for (const Scene& scene : report.scenes) {
    for (const Row& row : scene.rows) {
      if (row.deviation) errors.push_back(row.deviation->value.rms());
    }
  }
  const auto range = plot::decades_around(errors);
  return {"RMS error of the value (0..1)", plot::Scale::log_with_zero, range.low, range.high, {}};
}

plot::Panel panel_of(const Scene& scene, const plot::Axis& x, const plot::Axis& y) {
  plot::Panel panel{scene.title, x, y, {}};
  if (!scene.truth_found()) panel.title += " (the truth was not found)";
  plot::Series fixed_point;
  fixed_point.style = kFixedPoint;
  fixed_point.label = "8";
  std::vector<plot::Series> marks;
  for (const Row& row : scene.rows) {
    if (!row.deviation) continue;
    const double error = row.deviation->value.rms();
    const glm::dvec2 point(row.nanoseconds_a_voxel(), error);
    if (row.way == "maille" && row.method == "linear" && panel.series.empty()) {
      const double grid = row.deviation->floor.rms();
      panel.series.push_back({kGrid, {{x.low, grid}, {x.high, grid}}, {}, ""});
    }
    if (row.way == "fixed_point") {
      fixed_point.points.push_back(point);
      continue;
    }
    marks.push_back({style_of(row), {point}, {range_of(row)}, ""});
  }
  panel.series.push_back(std::move(fixed_point));
  // What is measured last lies on top: the product.
  panel.series.insert(panel.series.end(), marks.rbegin(), marks.rend());
  return panel;
}

std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

plot::Panel speed_panel(const ResampleError& report) {
  plot::Panel panel;
  panel.title = "Voxels a second, and what they have to reach";
  panel.y.scale = plot::Scale::names;
  std::vector<std::string>& names = panel.y.names;
  std::vector<double> rates;
  const auto add = [&](const plot::Style& style, double rate, std::vector<glm::dvec2> ranges) {
    rates.push_back(rate);
    for (const glm::dvec2 range : ranges) rates.insert(rates.end(), {range.x, range.y});
    const double place = static_cast<double>(names.size()) - 1.0;
    panel.series.push_back({style, {{rate, place}}, std::move(ranges), ""});
  };
  for (const Scene& scene : report.scenes) {
    if (!has_bars(scene)) continue;
    for (const Row& row : scene.rows) {
      if (row.way != "maille") continue;
      const std::string name = spaced(scene.name) + ", " + row.method;
      if (names.empty() || names.back() != name) {
        names.push_back(name);
        if (const auto bar = million_voxels_bar(row.method)) add(kBar, *bar, {});
        if (const auto paper = paper_million_voxels_per_second(row.method)) {
          add(kPaper, *paper, {});
        }
      }
      const double voxels = 1e-6 * static_cast<double>(row.voxels);
      add(style_of(row), row.million_voxels_per_second(),
          {{voxels / row.timing.most_seconds, voxels / row.timing.least_seconds}});
    }
  }
  const auto x = plot::decades_around(rates);
  panel.x = {"million voxels/s", plot::Scale::log, x.low, x.high, {}};
  return panel;
}

}  // namespace

std::string svg_of(const ResampleError& report) {
  plot::Page page;
  page.title = "Resampling: error against time";
  page.notes = {text_of(report.machine),
                "left and low is good; a mark is the median, its line the range of all runs; error "
                "to the formula, over all judged voxels that a way has a value for; hollow marks: "
                "1 thread, full circles: more; the walk and fixed point: 1 thread"};
  const plot::Axis errors = error_axis(report);
  for (const Scene& scene : report.scenes) {
    page.panels.push_back(panel_of(scene, time_axis(report, scene.moves), errors));
  }
  page.panels.push_back(speed_panel(report));
  page.panels_in_row = 5;
  const auto colored = [](const char* method) {
    return plot::LegendEntry{method, {color_of(method), Marker::none, Line::solid, false}};
  };
  const auto shaped = [](const char* text, Marker marker, bool hollow) {
    return plot::LegendEntry{text, {kBlack, marker, Line::none, hollow}};
  };
  page.legend = {colored("nearest"),
                 colored("linear"),
                 colored("barycentric"),
                 colored("rbf"),
                 shaped("Maille, 1 thread", Marker::circle, true),
                 shaped("Maille, more threads", Marker::circle, false),
                 shaped("the paper's walk, 6 neighbours", Marker::triangle, true),
                 shaped("the paper's walk, 26 neighbours", Marker::square, true),
                 {"fixed-point inversion, 1 to 8 iterations, linear", kFixedPoint},
                 {"the undeformed grid, trilinear, at the same rest positions", kGrid},
                 {"what it has to reach, on 2 threads", kBar},
                 {"the paper (2007), 1 thread of its machine", kPaper}};
  page.legend_columns = 3;
  return plot::to_svg(page);
}

}  // namespace maille
