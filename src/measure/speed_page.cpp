#include "measure/speed_page.h"

#include <algorithm>

#include "measure/json_parts.h"
#include "measure/speed_bars.h"
#include "measure/speed_plot.h"
#include "measure/text_table.h"

namespace maille {
namespace {

using Json = nlohmann::ordered_json;
using Row = SpeedReport::Row;
using Pointer = SpeedReport::Pointer;

double million(double count) { return 1e-6 * count; }
double paper_ratio(const Row& row) { return row.elements_per_second() / kPaperElementsPerSecond; }

Json memory_json(const LatticeUse& memory) {
  return {{"bricks", memory.bricks},
          {"elements", memory.elements},
          {"bytes", memory.bytes},
          {"bytes_per_element", memory.bytes_per_element()}};
}

Json stroke_json(const StrokeMemory& between, const StrokePeak& peak) {
  return {{"between_positions_bytes", between.lattice_bytes + between.gathered_bytes},
          {"between_positions_bytes_per_element", bytes_per_element(between)},
          {"bytes", peak.bytes()},
          {"bytes_per_element", bytes_per_element(peak)},
          {"lattice_bytes", peak.lattice_bytes},
          {"gathered_bytes", peak.gathered_bytes},
          {"working_bytes", peak.working_bytes}};
}

Json bars_json(const SpeedReport& report) {
  Json bars = Json::array();
  for (const SpeedBar& bar : bars_of(report)) {
    bars.push_back(Json{{"what", bar.what},
                        {"threads", bar.threads},
                        {"measured", bar.measured},
                        {bar.at_least ? "at_least" : "at_most", bar.bar},
                        {"unit", bar.unit},
                        {"met", bar.met()}});
  }
  return bars;
}

std::string json_text(const SpeedReport& report) {
  Json out = {
      {"maille_measure", 1},
      {"version", MAILLE_VERSION},
      {"what", "speed"},
      {"machine", json_of(report.machine)},
      {"seed", report.seed},
      {"paper_elements_per_second", kPaperElementsPerSecond},
      {"bandwidth_model",
       "least_bytes_per_element: 2 bytes written for each component that moves, 2 more read "
       "where tissue has moved before, 1 read where materials differ. triad_share: these "
       "bytes of the elements moved, a second, of what the triad moves on as many threads. "
       "bricks_triad_share: of all elements of the bricks touched, which are stored whole"},
      {"timing_model",
       "milliseconds: a later position of a stroke, solved from the state at button-down, "
       "the position before as far; first_position_milliseconds: button-down and the first "
       "position, which gathers materials and meets fresh memory"},
      {"bars", bars_json(report)},
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
                                {"bricks_triad_share", report.bricks_triad_share(row)},
                                {"microseconds_per_brick", row.microseconds_per_brick()},
                                {"stroke_memory", stroke_json(row.in_stroke, row.at_most)},
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
  std::vector<std::vector<std::string>> rows = {{"group",
                                                 "title",
                                                 "size",
                                                 "threads",
                                                 "elements",
                                                 "median_ms",
                                                 "least_ms",
                                                 "most_ms",
                                                 "runs",
                                                 "first_position_median_ms",
                                                 "elements_per_second",
                                                 "ratio_to_paper",
                                                 "least_bytes_per_element",
                                                 "triad_share",
                                                 "bricks_triad_share",
                                                 "bricks",
                                                 "lattice_bytes_at_rest",
                                                 "lattice_bytes_per_element",
                                                 "stroke_bytes",
                                                 "stroke_bytes_per_element"}};
  for (const Row& row : report.rows) {
    rows.push_back({row.group,
                    row.title,
                    std::to_string(row.size.x) + "x" + std::to_string(row.size.y) + "x" +
                        std::to_string(row.size.z),
                    std::to_string(row.threads),
                    std::to_string(row.elements),
                    fixed_number(1e3 * row.next.median_seconds, 4),
                    fixed_number(1e3 * row.next.least_seconds, 4),
                    fixed_number(1e3 * row.next.most_seconds, 4),
                    std::to_string(row.next.runs),
                    fixed_number(1e3 * row.first.median_seconds, 4),
                    fixed_number(row.elements_per_second(), 0),
                    fixed_number(paper_ratio(row), 3),
                    fixed_number(row.least_bytes_per_element, 0),
                    fixed_number(report.triad_share(row), 5),
                    fixed_number(report.bricks_triad_share(row), 5),
                    std::to_string(row.at_rest.bricks),
                    std::to_string(row.at_rest.bytes),
                    fixed_number(row.at_rest.bytes_per_element(), 3),
                    std::to_string(row.at_most.bytes()),
                    fixed_number(bytes_per_element(row.at_most), 3)});
  }
  return csv(rows);
}

std::string drags_text(const SpeedReport& report) {
  std::vector<std::vector<std::string>> rows = {{"scene", "elements", "thr", "ms", "least", "most",
                                                 "first ms", "M elem/s", "x paper", "of triad",
                                                 "bricks'", "MB", "B/elem", "stroke", "solving"}};
  for (const Row& row : report.rows) {
    rows.push_back({row.title, std::to_string(row.elements), std::to_string(row.threads),
                    fixed_number(1e3 * row.next.median_seconds, 3),
                    fixed_number(1e3 * row.next.least_seconds, 3),
                    fixed_number(1e3 * row.next.most_seconds, 3),
                    fixed_number(1e3 * row.first.median_seconds, 3),
                    fixed_number(million(row.elements_per_second()), 1),
                    fixed_number(paper_ratio(row), 1),
                    fixed_number(100.0 * report.triad_share(row), 1) + " %",
                    fixed_number(100.0 * report.bricks_triad_share(row), 1) + " %",
                    fixed_number(million(static_cast<double>(row.at_rest.bytes)), 1),
                    fixed_number(row.at_rest.bytes_per_element(), 1),
                    fixed_number(bytes_per_element(row.in_stroke), 1),
                    fixed_number(bytes_per_element(row.at_most), 1)});
  }
  const int runs = report.rows.empty() ? 0 : report.rows.front().next.runs;
  return text_table(rows) + "\nms: a later position of a stroke, median of " +
         std::to_string(runs) +
         "; first ms: button-down and the first position. x paper: 2.34 M elements/s.\n"
         "of triad: 2 bytes written for each component an element moves in, 2 read where it has "
         "moved before, 1 read\nwhere materials differ, of what the triad moves on as many "
         "threads; bricks': the same for every element of\nthe bricks touched. MB, B/elem: of "
         "lattice after button-up, by element of these bricks; stroke: with\nthe state at "
         "button-down "
         "and materials gathered; solving: at most, with the solver's work and the answer "
         "before.\n";
}

std::string bars_text(const SpeedReport& report) {
  std::vector<std::vector<std::string>> rows = {
      {"what it answers to", "thr", "measured", "", "bar", "unit", ""}};
  for (const SpeedBar& bar : bars_of(report)) {
    const int decimals = bar.bar < 10 ? 3 : 1;
    rows.push_back({bar.what, std::to_string(bar.threads), fixed_number(bar.measured, decimals),
                    bar.at_least ? ">=" : "<=", fixed_number(bar.bar, bar.bar < 2 ? 2 : 0),
                    bar.unit, bar.met() ? "met" : "NOT MET"});
  }
  return text_table(rows);
}

std::string table_text(const SpeedReport& report) {
  std::string out = "Speed of a drag\n" + text_of(report.machine) + "\n\n" + drags_text(report) +
                    "\n" + bars_text(report) + "\n";
  for (const Row& row : report.rows) {
    if (row.group != "single_row") continue;
    out += "a brick in which 32 elements move, " + std::to_string(row.threads) +
           (row.threads == 1 ? " thread" : " threads") + ": " +
           fixed_number(row.microseconds_per_brick(), 2) + " microseconds\n";
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

}  // namespace

MeasurePage page_of(const SpeedReport& report) {
  return {json_text(report), csv_text(report), svg_of(report), table_text(report)};
}

}  // namespace maille
