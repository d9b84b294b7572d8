#include "measure/stability_page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "measure/json_parts.h"
#include "measure/plot.h"
#include "measure/text_table.h"

namespace maille {
namespace {

using Json = nlohmann::ordered_json;
using Row = StabilityReport::Row;
using Verdict = StabilityReport::Verdict;

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::holds: return "holds";
    case Verdict::says_so: return "says_so";
    case Verdict::fails: return "fails";
    case Verdict::undecided: break;
  }
  return "undecided";
}

const char* end_of(const Row& row) {
  if (!row.failure.empty()) return "gave up";
  if (row.converged) return "converged";
  return row.no_nearer ? "no nearer" : "never ends";
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", value);
  return text;
}

// JSON knows no infinity.
Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(); }

std::string json_text(const StabilityReport& report) {
  Json out = {{"maille_measure", 1},
              {"version", MAILLE_VERSION},
              {"what", "stability"},
              {"machine", json_of(report.machine)},
              {"seed", report.seed},
              {"threads", report.threads},
              {"tolerance_voxels", report.tolerance_voxels},
              {"holds", report.count(Verdict::holds)},
              {"says_so", report.count(Verdict::says_so)},
              {"fails", report.count(Verdict::fails)},
              {"undecided", report.count(Verdict::undecided)},
              {"cases", Json::array()}};
  for (const Row& row : report.rows) {
    Json relaxation = {{"free_elements", row.free_elements},
                       {"iterations", row.iterations},
                       {"milliseconds", 1e3 * row.relax_seconds},
                       {"end", end_of(row)},
                       {"failure", row.failure},
                       {"finite", row.finite},
                       {"energy_first", number_or_null(row.energy_first)},
                       {"energy_last", number_or_null(row.energy_last)},
                       {"energy_rises", row.energy_rises},
                       {"largest_rise", number_or_null(row.largest_rise)},
                       {"energy_said_to_rise", row.energy_said_to_rise},
                       {"largest_unrounded_rise", number_or_null(row.largest_unrounded_rise)},
                       {"folded_cells_first", row.folded_first},
                       {"folded_cells_last", row.folded_last},
                       {"folded_cells_most", row.folded_most},
                       {"newly_folded_cells", row.newly_folded},
                       {"estimate_voxels", number_or_null(row.estimate_voxels)}};
    Json reference = {{"converged", row.reference_converged},
                      {"stable", row.reference_stable},
                      {"max_voxels", number_or_null(row.distance_voxels)},
                      {"rms_voxels", number_or_null(row.distance_rms_voxels)},
                      {"float_step_voxels", row.float_step_voxels}};
    out["cases"].push_back(Json{{"group", row.group},
                                {"title", row.title},
                                {"size", json_of(row.size)},
                                {"spacing_mm", json_of(row.spacing_mm)},
                                {"chainmail",
                                 {{"elements_moved", row.elements_moved},
                                  {"violated_links", row.violated_links},
                                  {"clamped", row.clamped},
                                  {"milliseconds", 1e3 * row.drag_seconds}}},
                                {"relaxation", std::move(relaxation)},
                                {"distance_to_reference", std::move(reference)},
                                {"verdict", name_of(row.verdict(report.tolerance_voxels))},
                                {"fault", row.fault(report.tolerance_voxels)}});
  }
  return text_of(out);
}

std::string csv_text(const StabilityReport& report) {
  std::vector<std::vector<std::string>> rows = {{"group",
                                                 "title",
                                                 "size",
                                                 "elements_moved",
                                                 "violated_links",
                                                 "drag_ms",
                                                 "free_elements",
                                                 "iterations",
                                                 "relax_ms",
                                                 "end",
                                                 "finite",
                                                 "energy_first",
                                                 "energy_last",
                                                 "energy_rises",
                                                 "largest_rise",
                                                 "largest_unrounded_rise",
                                                 "folded_first",
                                                 "folded_last",
                                                 "folded_most",
                                                 "newly_folded",
                                                 "estimate_voxels",
                                                 "distance_voxels",
                                                 "distance_rms_voxels",
                                                 "reference_converged",
                                                 "reference_stable",
                                                 "verdict",
                                                 "fault"}};
  const auto exact = [](double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return std::string(text);
  };
  for (const Row& row : report.rows) {
    rows.push_back({row.group,
                    row.title,
                    std::to_string(row.size.x) + "x" + std::to_string(row.size.y) + "x" +
                        std::to_string(row.size.z),
                    std::to_string(row.elements_moved),
                    std::to_string(row.violated_links),
                    fixed_number(1e3 * row.drag_seconds, 4),
                    std::to_string(row.free_elements),
                    std::to_string(row.iterations),
                    fixed_number(1e3 * row.relax_seconds, 4),
                    end_of(row),
                    row.finite ? "yes" : "no",
                    exact(row.energy_first),
                    exact(row.energy_last),
                    std::to_string(row.energy_rises),
                    exact(row.largest_rise),
                    exact(row.largest_unrounded_rise),
                    std::to_string(row.folded_first),
                    std::to_string(row.folded_last),
                    std::to_string(row.folded_most),
                    std::to_string(row.newly_folded),
                    exact(row.estimate_voxels),
                    exact(row.distance_voxels),
                    exact(row.distance_rms_voxels),
                    row.reference_converged ? "yes" : "no",
                    row.reference_stable ? "yes" : "no",
                    name_of(row.verdict(report.tolerance_voxels)),
                    row.fault(report.tolerance_voxels)});
  }
  return csv(rows);
}

std::string verdict_text(const StabilityReport& report, const Row& row) {
  switch (row.verdict(report.tolerance_voxels)) {
    case Verdict::holds: return "holds";
    case Verdict::says_so: return "says so";
    case Verdict::fails: return "NO: " + row.fault(report.tolerance_voxels);
    case Verdict::undecided: break;
  }
  return "no reference";
}

std::string cases_text(const StabilityReport& report) {
  std::vector<std::vector<std::string>> rows = {{"case", "moved", "viol.", "drag ms", "free",
                                                 "cycles", "ms", "end", "rises", "unr.", "folded",
                                                 "most", "end", "new", "estimate", "distance", ""}};
  for (const Row& row : report.rows) {
    rows.push_back({row.group + ": " + row.title, std::to_string(row.elements_moved),
                    std::to_string(row.violated_links), fixed_number(1e3 * row.drag_seconds, 1),
                    std::to_string(row.free_elements), std::to_string(row.iterations),
                    fixed_number(1e3 * row.relax_seconds, 0), end_of(row),
                    row.energy_rises > 0 ? short_number(row.largest_rise) : "none",
                    short_number(row.largest_unrounded_rise), std::to_string(row.folded_first),
                    std::to_string(row.folded_most), std::to_string(row.folded_last),
                    std::to_string(row.newly_folded), short_number(row.estimate_voxels),
                    short_number(row.distance_voxels) + (row.reference_converged ? "" : "?"),
                    verdict_text(report, row)});
  }
  return text_table(rows);
}

std::string table_text(const StabilityReport& report) {
  return "Stability of a drag and its relaxation\n" + text_of(report.machine) + "\n\n" +
         cases_text(report) +
         "\nviol.: links outside their limits after the drag. rises: the most that energy rose by "
         "from a "
         "state to the\nnext, as a share, of the lattice in fixed point and in double precision; "
         "unr.: of the states before they\nwere rounded. folded: cells, at the start, at most, at "
         "the end; new: that were not at the start. estimate:\nof the largest distance to "
         "equilibrium in voxels, by relaxation; distance: to the equilibrium by Newton's\nmethod, "
         "?: which did not converge. Tolerance " +
         short_number(report.tolerance_voxels) +
         " voxel; says so: further off, but no further than relaxation says that it is\nand comes "
         "no "
         "nearer.\n\nstability: " +
         report.summary() + "\n";
}

// What relaxation says of itself against what is so.
std::string svg_text(const StabilityReport& report) {
  plot::Page page;
  page.title = "Stability: the distance to equilibrium at the end of each case";
  page.notes = {
      text_of(report.machine), report.summary(),
      "on the dashed line the estimate is the truth; a cross is a case that does not hold"};
  plot::Panel panel;
  panel.title = "Estimated and true distance";
  plot::Series good, bad, even;
  good.style = {plot::color::kBlue, plot::Marker::circle, plot::Line::none, true};
  bad.style = {plot::color::kOrange, plot::Marker::cross, plot::Line::none, false};
  even.style = {plot::color::kGrey, plot::Marker::none, plot::Line::dashed, false};
  std::vector<double> values;
  for (const Row& row : report.rows) {
    if (!std::isfinite(row.estimate_voxels) || !std::isfinite(row.distance_voxels)) continue;
    auto& series = row.verdict(report.tolerance_voxels) == Verdict::fails ? bad : good;
    series.points.emplace_back(row.estimate_voxels, row.distance_voxels);
    values.insert(values.end(), {row.estimate_voxels, row.distance_voxels});
  }
  const auto range = plot::decades_around(values);
  even.points = {{range.low, range.low}, {range.high, range.high}};
  panel.x = {
      "estimate by relaxation [voxels]", plot::Scale::log_with_zero, range.low, range.high, {}};
  panel.y = {
      "distance to the reference [voxels]", plot::Scale::log_with_zero, range.low, range.high, {}};
  panel.series = {even, good, bad};
  page.panels = {panel};
  page.legend = {{"holds", good.style}, {"does not hold", bad.style}};
  page.legend_columns = 2;
  return plot::to_svg(page);
}

}  // namespace

MeasurePage page_of(const StabilityReport& report) {
  return {json_text(report), csv_text(report), svg_text(report), table_text(report)};
}

}  // namespace maille
