#include "measure/resample_error_page.h"

#include "measure/json_parts.h"
#include "measure/resample_bars.h"
#include "measure/resample_error_plot.h"
#include "measure/text_table.h"

namespace maille {
namespace {

using Json = nlohmann::ordered_json;
using Found = ResampleError::Found;
using Row = ResampleError::Row;
using Scene = ResampleError::Scene;

// Where nothing was measured.
const char* const kNone = "-";

std::optional<double> times_paper(const Row& row) {
  const auto paper = paper_million_voxels_per_second(row.method);
  if (!paper) return std::nullopt;
  return row.million_voxels_per_second() / *paper;
}

// Rest positions of the methods that have one.
const Deviation* rest_of(const Row& row) {
  if (!row.deviation || row.deviation->rest_voxels.count() == 0) return nullptr;
  return &row.deviation->rest_voxels;
}

Json deviation_json(const Deviation& deviation) {
  return {{"rms", deviation.rms()}, {"max", deviation.max()}, {"voxels", deviation.count()}};
}

Json json_or_null(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

Json row_json(const Row& row) {
  Json out = {{"way", row.way},
              {"method", row.method},
              {"iterations", row.way == "fixed_point" ? Json(row.iterations) : Json()},
              {"threads", row.threads},
              {"voxels", row.voxels},
              {"milliseconds", json_of(row.timing)},
              {"nanoseconds_per_voxel", row.nanoseconds_a_voxel()},
              {"million_voxels_per_second", row.million_voxels_per_second()},
              {"ratio_to_paper", json_or_null(times_paper(row))},
              {"value_error", Json()},
              {"grid_error", Json()},
              {"rms_to_grid_rms", Json()},
              {"unfilled_voxels", Json()},
              {"rest_position_error_voxels", Json()},
              {"nearest_elements", Json()}};
  if (row.deviation) {
    out["value_error"] = deviation_json(row.deviation->value);
    out["grid_error"] = deviation_json(row.deviation->floor);
    out["rms_to_grid_rms"] = json_or_null(row.deviation->times_floor());
    out["unfilled_voxels"] = row.deviation->unfilled_voxels;
  }
  if (const Deviation* const rest = rest_of(row))
    out["rest_position_error_voxels"] = deviation_json(*rest);
  if (row.found) {
    out["nearest_elements"] = {{"voxels", row.found->there},
                               {"right", row.found->right},
                               {"wrong", row.found->wrong},
                               {"missed", row.found->missed},
                               {"right_share", row.found->right_share()}};
  }
  return out;
}

Json bars_json(const ResampleError& report) {
  Json out = Json::array();
  for (const ResampleBar& bar : bars_of(report)) {
    out.push_back(Json{{"what", bar.what},
                       {"scene", bar.scene},
                       {"threads", bar.threads},
                       {"measured", bar.measured},
                       {"bar", bar.bar},
                       {"at_least", bar.at_least},
                       {"unit", bar.unit},
                       {"met", bar.met()}});
  }
  return out;
}

std::string json_text(const ResampleError& report) {
  Json paper = Json::object();
  for (const char* const method : {"nearest", "barycentric", "rbf"}) {
    paper[method] = *paper_million_voxels_per_second(method);
  }
  Json out = {{"maille_measure", 1},
              {"version", MAILLE_VERSION},
              {"what", "error"},
              {"stage", "resample"},
              {"machine", json_of(report.machine)},
              {"runs", report.runs},
              {"paper_million_voxels_per_second", std::move(paper)},
              {"bars", bars_json(report)},
              {"constant_bricks", Json::array()},
              {"scenes", Json::array()}};
  for (const ConstantBricks& bricks : report.constant_bricks) {
    out["constant_bricks"].push_back(Json{{"threads", bricks.threads},
                                          {"bytes", bricks.bytes},
                                          {"milliseconds", json_of(bricks.resampled)},
                                          {"copy_milliseconds", json_of(bricks.copied)},
                                          {"rows_milliseconds", json_of(bricks.copied_by_rows)},
                                          {"gb_per_s", bricks.gb_per_s()},
                                          {"copy_gb_per_s", bricks.copy_gb_per_s()},
                                          {"rows_gb_per_s", bricks.rows_gb_per_s()},
                                          {"share_of_copy", bricks.share_of_copy()},
                                          {"share_of_rows", bricks.share_of_rows()},
                                          {"triad_share", report.triad_share(bricks)}});
  }
  for (const Scene& scene : report.scenes) {
    Json rows = Json::array();
    for (const Row& row : scene.rows) rows.push_back(row_json(row));
    out["scenes"].push_back(Json{{"scene", scene.name},
                                 {"title", scene.title},
                                 {"size", json_of(scene.size)},
                                 {"folded_cells", scene.folded_cells},
                                 {"truth",
                                  {{"found", scene.truth_found()},
                                   {"judged_voxels", scene.judged_voxels},
                                   {"lost_voxels", scene.lost_voxels},
                                   {"worst_forward_voxels", scene.worst_forward_voxels}}},
                                 {"reference_voxels",
                                  {{"lowest", json_of(scene.reference_voxels.lo)},
                                   {"end", json_of(scene.reference_voxels.hi)}}},
                                 {"nearest_stride", scene.nearest_stride},
                                 {"rows", std::move(rows)}});
  }
  return text_of(out);
}

std::string csv_text(const ResampleError& report) {
  std::vector<std::vector<std::string>> rows = {{"scene",
                                                 "way",
                                                 "method",
                                                 "iterations",
                                                 "threads",
                                                 "voxels",
                                                 "median_ms",
                                                 "least_ms",
                                                 "most_ms",
                                                 "runs",
                                                 "nanoseconds_per_voxel",
                                                 "million_voxels_per_second",
                                                 "ratio_to_paper",
                                                 "rms_error",
                                                 "max_error",
                                                 "grid_rms_error",
                                                 "grid_max_error",
                                                 "rms_to_grid_rms",
                                                 "unfilled_voxels",
                                                 "rest_rms_voxels",
                                                 "rest_max_voxels",
                                                 "nearest_voxels",
                                                 "nearest_right",
                                                 "nearest_wrong",
                                                 "nearest_missed"}};
  const auto number = [](const std::optional<double>& value) {
    return value ? short_number(*value) : std::string();
  };
  for (const Scene& scene : report.scenes) {
    for (const Row& row : scene.rows) {
      std::vector<std::string> cells = {
          scene.name,
          row.way,
          row.method,
          row.way == "fixed_point" ? std::to_string(row.iterations) : "",
          std::to_string(row.threads),
          std::to_string(row.voxels),
          fixed_number(1e3 * row.timing.median_seconds, 4),
          fixed_number(1e3 * row.timing.least_seconds, 4),
          fixed_number(1e3 * row.timing.most_seconds, 4),
          std::to_string(row.timing.runs),
          fixed_number(row.nanoseconds_a_voxel(), 4),
          fixed_number(row.million_voxels_per_second(), 3),
          number(times_paper(row))};
      const auto& deviation = row.deviation;
      for (const double value :
           {deviation ? deviation->value.rms() : 0.0, deviation ? deviation->value.max() : 0.0,
            deviation ? deviation->floor.rms() : 0.0, deviation ? deviation->floor.max() : 0.0}) {
        cells.push_back(deviation ? short_number(value) : "");
      }
      cells.push_back(deviation ? number(deviation->times_floor()) : "");
      cells.push_back(deviation ? std::to_string(deviation->unfilled_voxels) : "");
      const Deviation* const rest = rest_of(row);
      cells.push_back(rest ? short_number(rest->rms()) : "");
      cells.push_back(rest ? short_number(rest->max()) : "");
      const Found found = row.found.value_or(Found());
      for (const std::int64_t count : {found.there, found.right, found.wrong, found.missed}) {
        cells.push_back(row.found ? std::to_string(count) : "");
      }
      rows.push_back(std::move(cells));
    }
  }
  return csv(rows);
}

std::string scene_text(const Scene& scene) {
  std::vector<std::vector<std::string>> rows = {
      {"way", "method", "thr", "ns/voxel", "least", "most", "M voxels/s", "x paper", "RMS error",
       "max", "x grid's", "rest RMS", "rest max", "right", "wrong", "missed"}};
  for (const Row& row : scene.rows) {
    const double voxels = static_cast<double>(row.voxels);
    const auto paper = times_paper(row);
    const auto& deviation = row.deviation;
    const auto times_floor = deviation ? deviation->times_floor() : std::nullopt;
    const Deviation* const rest = rest_of(row);
    // Of the judged voxels, what is not shown is missed by any method.
    const std::string missed = row.found   ? std::to_string(row.found->missed)
                               : deviation ? std::to_string(deviation->unfilled_voxels)
                                           : kNone;
    rows.push_back(
        {way_of(row), row.method, std::to_string(row.threads),
         fixed_number(row.nanoseconds_a_voxel(), 2),
         fixed_number(1e9 * row.timing.least_seconds / voxels, 2),
         fixed_number(1e9 * row.timing.most_seconds / voxels, 2),
         fixed_number(row.million_voxels_per_second(), 1), paper ? fixed_number(*paper, 1) : kNone,
         deviation ? fixed_number(deviation->value.rms(), 6) : kNone,
         deviation ? fixed_number(deviation->value.max(), 4) : kNone,
         times_floor ? fixed_number(*times_floor, 3) : kNone,
         rest ? fixed_number(rest->rms(), 5) : kNone, rest ? fixed_number(rest->max(), 4) : kNone,
         row.found ? fixed_number(100.0 * row.found->right_share(), 3) + " %" : kNone,
         row.found ? std::to_string(row.found->wrong) : kNone, missed});
  }
  const std::int64_t layers = scene.reference_voxels.size().z;
  std::string out = "\n" + scene.title + ", " + std::to_string(scene.size.x) + "x" +
                    std::to_string(scene.size.y) + "x" + std::to_string(scene.size.z) + ", " +
                    std::to_string(scene.folded_cells) + " folded cells\n";
  if (scene.truth_found()) {
    out += std::to_string(scene.judged_voxels) + " voxels judged, their true rest positions to " +
           short_number(scene.worst_forward_voxels, 1) + " voxel" +
           (scene.folds ? "; the error is that to the nearest answer" : "");
  } else {
    out += "the truth was NOT found in " + std::to_string(scene.lost_voxels) +
           " voxels: no error can be told";
  }
  out += "; walk and fixed point in " + std::to_string(layers) + " layers";
  if (scene.nearest_stride > 1) {
    out += "; nearest elements in one voxel of " + std::to_string(scene.nearest_stride);
  }
  return out + "\n" + text_table(rows);
}

std::string bars_text(const ResampleError& report) {
  std::vector<std::vector<std::string>> rows = {
      {"what it answers to", "thr", "measured", "", "bar", "unit", ""}};
  for (const ResampleBar& bar : bars_of(report)) {
    const bool voxels = std::string(bar.unit) == "voxels";
    const int decimals = voxels ? 0 : bar.bar < 10 ? 4 : 1;
    rows.push_back(
        {bar.what, bar.scene, std::to_string(bar.threads), fixed_number(bar.measured, decimals),
         bar.at_least ? ">=" : "<=", fixed_number(bar.bar, !voxels && bar.bar < 2 ? 2 : 0),
         bar.unit, bar.met() ? "met" : "NOT MET"});
  }
  return text_table(rows);
}

std::string constant_text(const ResampleError& report) {
  std::string out;
  for (const ConstantBricks& bricks : report.constant_bricks) {
    out += "bricks moved by whole voxels, " + std::to_string(bricks.threads) +
           (bricks.threads == 1 ? " thread" : " threads") + ": " +
           fixed_number(bricks.gb_per_s(), 1) + " GB/s read and written; a plain copy " +
           fixed_number(bricks.copy_gb_per_s(), 1) + " GB/s, " +
           fixed_number(100.0 * bricks.share_of_copy(), 0) + " % of it; a copy row by row " +
           fixed_number(bricks.rows_gb_per_s(), 1) + " GB/s, " +
           fixed_number(100.0 * bricks.share_of_rows(), 0) + " % of it; " +
           fixed_number(100.0 * report.triad_share(bricks), 0) + " % of the triad\n";
  }
  return out;
}

std::string table_text(const ResampleError& report) {
  std::string out =
      "Resampling: error against time\n" + text_of(report.machine) + "; median of up to " +
      std::to_string(report.runs) +
      " runs, set-up counted (walk and fixed point: fewer)\n"
      "error: of a value in 0..1, to the formula; x grid's: RMS, by that of the undeformed grid, "
      "trilinear, at the same\nrest positions; rest: of the rest position, voxels; right: nearest "
      "elements, by brute force. walk: the paper's,\nby its two heuristics (6 and 26 neighbours), "
      "of which it says \"more than 99 %\"; its own speeds, one thread\n(2007): nearest 4.41, "
      "barycentric 2.46, rbf 1.48 million voxels/s, x paper\n";
  for (const Scene& scene : report.scenes) out += scene_text(scene);
  return out + "\n" + constant_text(report) + "\n" + bars_text(report);
}

}  // namespace

std::string way_of(const Row& row) {
  if (row.way == "walk_6") return "walk, 6";
  if (row.way == "walk_26") return "walk, 26";
  if (row.way == "fixed_point") return "fixed point, " + std::to_string(row.iterations);
  return "Maille";
}

MeasurePage page_of(const ResampleError& report) {
  return {json_text(report), csv_text(report), svg_of(report), table_text(report)};
}

}  // namespace maille
