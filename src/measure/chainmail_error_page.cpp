#include "measure/chainmail_error_page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "measure/json_parts.h"
#include "measure/plot.h"
#include "measure/text_table.h"

namespace maille {
namespace {

using Json = nlohmann::ordered_json;
using Order = ChainMailError::Order;
using Scene = ChainMailError::Scene;

double violated_share(const Scene& scene, const Order& order) {
  if (scene.affected_links == 0) return 0.0;
  return static_cast<double>(order.violated_links) / static_cast<double>(scene.affected_links);
}

Json order_json(const Scene& scene, const Order& order) {
  return {{"order", order.name},
          {"threads", order.threads},
          {"milliseconds", json_of(order.timing)},
          {"elements_moved", order.elements_moved},
          {"violated_links", order.violated_links},
          {"violated_share", violated_share(scene, order)},
          {"worst_violation_voxels", order.worst_violation_voxels},
          {"folded_cells", order.folded_cells},
          {"rms_to_exact_voxels", order.rms_to_exact_voxels},
          {"max_to_exact_voxels", order.max_to_exact_voxels},
          {"rms_to_relaxed_voxels", order.rms_to_relaxed_voxels},
          {"max_to_relaxed_voxels", order.max_to_relaxed_voxels}};
}

std::string json_text(const ChainMailError& report) {
  Json out = {{"maille_measure", 1},    {"version", MAILLE_VERSION},          {"what", "error"},
              {"stage", "chainmail"},   {"machine", json_of(report.machine)}, {"seed", report.seed},
              {"scenes", Json::array()}};
  for (const Scene& scene : report.scenes) {
    Json relaxed = {{"iterations", scene.relaxed.iterations},
                    {"converged", scene.relaxed.converged},
                    {"seconds", scene.relaxed.seconds},
                    {"folded_cells", scene.relaxed.folded_cells},
                    {"residual_voxels", scene.relaxed.residual_voxels}};
    Json orders = Json::array();
    for (const Order& order : scene.orders) orders.push_back(order_json(scene, order));
    out["scenes"].push_back(Json{{"scene", scene.name},
                                 {"title", scene.title},
                                 {"size", json_of(scene.size)},
                                 {"asked_voxels", json_of(scene.asked_voxels)},
                                 {"moved_voxels", json_of(scene.moved_voxels)},
                                 {"affected_elements", scene.affected_elements},
                                 {"affected_links", scene.affected_links},
                                 {"relaxed", std::move(relaxed)},
                                 {"orders", std::move(orders)}});
  }
  return text_of(out);
}

std::string csv_text(const ChainMailError& report) {
  std::vector<std::vector<std::string>> rows = {
      {"scene", "order", "threads", "median_ms", "least_ms", "most_ms", "runs", "elements_moved",
       "violated_links", "violated_share", "worst_violation_voxels", "folded_cells",
       "rms_to_exact_voxels", "max_to_exact_voxels", "rms_to_relaxed_voxels",
       "max_to_relaxed_voxels"}};
  for (const Scene& scene : report.scenes) {
    for (const Order& order : scene.orders) {
      rows.push_back(
          {scene.name, order.name, std::to_string(order.threads),
           fixed_number(1e3 * order.timing.median_seconds, 4),
           fixed_number(1e3 * order.timing.least_seconds, 4),
           fixed_number(1e3 * order.timing.most_seconds, 4), std::to_string(order.timing.runs),
           std::to_string(order.elements_moved), std::to_string(order.violated_links),
           fixed_number(violated_share(scene, order), 6),
           fixed_number(order.worst_violation_voxels, 6), std::to_string(order.folded_cells),
           fixed_number(order.rms_to_exact_voxels, 6), fixed_number(order.max_to_exact_voxels, 6),
           fixed_number(order.rms_to_relaxed_voxels, 6),
           fixed_number(order.max_to_relaxed_voxels, 6)});
    }
  }
  return csv(rows);
}

std::string name_of(const Order& order) {
  if (order.name == "exact") return "exact, " + std::to_string(order.threads) + " thr";
  if (order.name == "heap") return "heap";
  if (order.name == "fifo") return "FIFO";
  return "Dijkstra";
}

std::string table_text(const ChainMailError& report) {
  std::string out = "ChainMail by four orders of work: time against error\n" +
                    text_of(report.machine) + "; median of runs\n";
  for (const Scene& scene : report.scenes) {
    std::vector<std::vector<std::string>> rows = {{"order", "ms", "moved", "violated", "worst",
                                                   "folded", "RMS exact", "max exact",
                                                   "RMS relaxed", "max relaxed"}};
    for (const Order& order : scene.orders) {
      rows.push_back(
          {name_of(order), fixed_number(1e3 * order.timing.median_seconds, 2),
           std::to_string(order.elements_moved), std::to_string(order.violated_links),
           fixed_number(order.worst_violation_voxels, 3), std::to_string(order.folded_cells),
           fixed_number(order.rms_to_exact_voxels, 4), fixed_number(order.max_to_exact_voxels, 3),
           fixed_number(order.rms_to_relaxed_voxels, 3),
           fixed_number(order.max_to_relaxed_voxels, 3)});
    }
    char heading[256];
    std::snprintf(heading, sizeof heading, ", %dx%dx%d, drag (%g, %g, %g) voxels\n", scene.size.x,
                  scene.size.y, scene.size.z, scene.moved_voxels.x, scene.moved_voxels.y,
                  scene.moved_voxels.z);
    const auto& relaxed = scene.relaxed;
    out += "\n" + scene.title + heading + text_table(rows) +
           "relaxed: " + std::to_string(relaxed.iterations) + " cycles from the exact answer, " +
           (relaxed.converged ? "converged" : "coming no nearer") +
           ", by its own estimate within " + fixed_number(relaxed.residual_voxels, 4) +
           " voxels, " + std::to_string(relaxed.folded_cells) + " folded cells\n";
  }
  return out;
}

// --- the plot

constexpr plot::Marker kMarkers[] = {plot::Marker::circle,  plot::Marker::square,
                                     plot::Marker::diamond, plot::Marker::triangle,
                                     plot::Marker::plus,    plot::Marker::cross};

const char* color_of(const Order& order) {
  if (order.name == "exact") return order.threads == 1 ? plot::color::kSky : plot::color::kBlue;
  if (order.name == "heap") return plot::color::kOrange;
  if (order.name == "fifo") return plot::color::kPurple;
  return plot::color::kGrey;
}

struct Measure {
  const char* title;
  const char* axis;
  double (*value)(const Scene&, const Order&);
};

plot::Panel panel_of(const ChainMailError& report, const Measure& measure) {
  plot::Panel panel;
  panel.title = measure.title;
  std::vector<double> times, values;
  for (std::size_t s = 0; s < report.scenes.size(); ++s) {
    const Scene& scene = report.scenes[s];
    for (const Order& order : scene.orders) {
      const double ms = 1e3 * order.timing.median_seconds;
      const double value = measure.value(scene, order);
      times.push_back(ms);
      values.push_back(value);
      plot::Series series;
      series.style = {color_of(order), kMarkers[s % std::size(kMarkers)], plot::Line::none, false};
      series.points = {{ms, value}};
      series.x_ranges = {{1e3 * order.timing.least_seconds, 1e3 * order.timing.most_seconds}};
      times.insert(times.end(), {series.x_ranges[0].x, series.x_ranges[0].y});
      panel.series.push_back(std::move(series));
    }
  }
  const auto x = plot::decades_around(times);
  const auto y = plot::decades_around(values);
  panel.x = {"time of the drag [ms]", plot::Scale::log, x.low, x.high, {}};
  const bool any_zero = std::any_of(values.begin(), values.end(), [](double v) { return v == 0; });
  panel.y = {
      measure.axis, any_zero ? plot::Scale::log_with_zero : plot::Scale::log, y.low, y.high, {}};
  return panel;
}

// How much the last panel is worth.
std::string relaxation_note(const ChainMailError& report) {
  std::size_t converged = 0;
  std::int64_t cycles = 0;
  double most = 0.0;
  for (const Scene& scene : report.scenes) {
    converged += scene.relaxed.converged;
    cycles = std::max(cycles, scene.relaxed.iterations);
    most = std::max(most, scene.relaxed.residual_voxels);
  }
  return "relaxation: at most " + std::to_string(cycles) +
         " cycles from the exact answer, converged in " + std::to_string(converged) + " of " +
         std::to_string(report.scenes.size()) + " scenes, by its own estimate within " +
         fixed_number(most, 4) + " voxels of equilibrium";
}

std::string svg_text(const ChainMailError& report) {
  plot::Page page;
  page.title = "ChainMail by four orders of work: error against time";
  page.notes = {text_of(report.machine),
                "left and low is good; a mark is the median, its line the range of all runs; "
                "distances are over all elements that any order moved"};
  const Measure measures[] = {
      {"Links outside their limits", "violated links [% of the affected]",
       [](const Scene& s, const Order& o) { return 100.0 * violated_share(s, o); }},
      {"Distance to the exact answer", "RMS distance [voxels]",
       [](const Scene&, const Order& o) { return o.rms_to_exact_voxels; }},
      {"Distance to the equilibrium of the springs", "RMS distance [voxels]",
       [](const Scene&, const Order& o) { return o.rms_to_relaxed_voxels; }}};
  for (const Measure& measure : measures) page.panels.push_back(panel_of(report, measure));
  page.notes.push_back(relaxation_note(report));
  // One column tells the colours, the next ones the shapes.
  if (!report.scenes.empty()) {
    for (const Order& order : report.scenes.front().orders) {
      static const std::pair<const char*, const char*> kLong[] = {
          {"heap", "Enhanced ChainMail, heap (Schill 1998)"},
          {"fifo", "first in, first out (Gibson 1997)"},
          {"dijkstra", "plain Dijkstra, the exact answer"}};
      std::string text = "Maille, " + std::to_string(order.threads) +
                         (order.threads == 1 ? " thread" : " threads");
      for (const auto& [name, longer] : kLong) {
        if (order.name == name) text = longer;
      }
      page.legend.push_back(
          {text, {color_of(order), plot::Marker::none, plot::Line::solid, false}});
    }
    const std::size_t rows = std::max(page.legend.size(), report.scenes.size());
    page.legend.resize(rows);
    for (std::size_t s = 0; s < report.scenes.size(); ++s) {
      page.legend.push_back(
          {report.scenes[s].title,
           {"#444444", kMarkers[s % std::size(kMarkers)], plot::Line::none, false}});
    }
    page.legend.resize(4 * rows);  // two columns stay free: the others keep near their panels
  }
  page.legend_columns = 4;
  return plot::to_svg(page);
}

}  // namespace

MeasurePage page_of(const ChainMailError& report) {
  return {json_text(report), csv_text(report), svg_text(report), table_text(report)};
}

}  // namespace maille
