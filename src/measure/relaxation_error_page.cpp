#include "measure/relaxation_error_page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "measure/fold_study_page.h"
#include "measure/json_parts.h"
#include "measure/plot.h"
#include "measure/text_table.h"

namespace maille {
namespace {

using Json = nlohmann::ordered_json;
using Curve = RelaxationError::Curve;
using Sample = RelaxationError::Sample;
using Scene = RelaxationError::Scene;

template <class T>
Json json_or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

Json curve_json(const Curve& curve) {
  Json samples = Json::array();
  for (const Sample& s : curve.samples) {
    samples.push_back(Json{{"milliseconds", 1e3 * s.seconds},
                           {"iterations", s.iterations},
                           {"rms_voxels", s.rms_voxels},
                           {"max_voxels", s.max_voxels},
                           {"energy_excess", s.energy_excess},
                           {"folded_cells", s.folded_cells},
                           {"estimate_voxels", json_or_null(s.estimate_voxels)}});
  }
  Json targets = Json::array();
  for (std::size_t t = 0; t < RelaxationError::kTargets_voxels.size(); ++t) {
    const auto ms = [](const std::optional<double>& seconds) {
      return seconds ? Json(1e3 * *seconds) : Json();
    };
    Json target = {{"voxels", RelaxationError::kTargets_voxels[t]},
                   {"milliseconds_rms", ms(curve.seconds_to_rms[t])},
                   {"milliseconds_max", ms(curve.seconds_to_max[t])},
                   {"said_voxels", Json()},
                   {"true_voxels", Json()}};
    if (curve.claims[t]) {
      target["said_voxels"] = curve.claims[t]->said_voxels;
      target["true_voxels"] = curve.claims[t]->true_voxels;
    }
    targets.push_back(std::move(target));
  }
  return {{"solver", curve.solver},
          {"threads", curve.threads},
          {"setup_milliseconds", 1e3 * curve.setup_seconds},
          {"finished", curve.finished},
          {"most_folded_cells", curve.most_folded_cells},
          {"targets", std::move(targets)},
          {"samples", std::move(samples)}};
}

std::string json_text(const RelaxationError& report) {
  Json out = {{"maille_measure", 1},
              {"version", MAILLE_VERSION},
              {"what", "error"},
              {"stage", "relaxation"},
              {"machine", json_of(report.machine)},
              {"seed", report.seed},
              {"runs", report.runs},
              {"scenes", Json::array()}};
  for (const Scene& scene : report.scenes) {
    Json curves = Json::array();
    for (const Curve& curve : scene.curves) curves.push_back(curve_json(curve));
    out["scenes"].push_back(Json{{"scene", scene.name},
                                 {"title", scene.title},
                                 {"size", json_of(scene.size)},
                                 {"elements", scene.elements},
                                 {"free_elements", scene.free_elements},
                                 {"moved_voxels", json_of(scene.moved_voxels)},
                                 {"folded_at_start", scene.folded_at_start},
                                 {"start_rms_voxels", scene.start_rms_voxels},
                                 {"start_max_voxels", scene.start_max_voxels},
                                 {"equilibrium",
                                  {{"converged", scene.equilibrium_converged},
                                   {"stable", scene.equilibrium_stable},
                                   {"distance_voxels", scene.equilibrium_distance_voxels},
                                   {"folded_cells", scene.equilibrium_folded_cells},
                                   {"seconds", scene.equilibrium_seconds}}},
                                 {"curves", std::move(curves)}});
  }
  out["ways_to_keep_cells_from_folding"] = json_of(report.folds);
  return text_of(out);
}

std::string csv_text(const RelaxationError& report) {
  std::vector<std::vector<std::string>> rows = {
      {"scene", "elements", "solver", "threads", "milliseconds", "iterations", "rms_voxels",
       "max_voxels", "energy_excess", "folded_cells", "estimate_voxels"}};
  for (const Scene& scene : report.scenes) {
    for (const Curve& curve : scene.curves) {
      for (const Sample& s : curve.samples) {
        rows.push_back({scene.name, std::to_string(scene.elements), curve.solver,
                        std::to_string(curve.threads), fixed_number(1e3 * s.seconds, 4),
                        std::to_string(s.iterations), short_number(s.rms_voxels),
                        short_number(s.max_voxels), short_number(s.energy_excess),
                        std::to_string(s.folded_cells),
                        s.estimate_voxels ? short_number(*s.estimate_voxels) : ""});
      }
    }
  }
  return csv(rows);
}

std::string name_of(const Curve& curve) {
  if (curve.solver == "paper") return "the paper's Jacobi";
  if (curve.solver == "paper_list") return "its list, 0.01";
  return "Maille, " + std::to_string(curve.threads) + " thr";
}

std::string heading_of(const Scene& scene) {
  char numbers[160];
  std::snprintf(numbers, sizeof numbers, ", %dx%dx%d, drag (%.3g, %.3g, %.3g) voxels", scene.size.x,
                scene.size.y, scene.size.z, scene.moved_voxels.x, scene.moved_voxels.y,
                scene.moved_voxels.z);
  return scene.title + numbers;
}

std::string table_text(const RelaxationError& report) {
  std::string out =
      "Relaxation: milliseconds (set-up counted) to a distance from the true equilibrium\n" +
      text_of(report.machine) + "; median of up to " + std::to_string(report.runs) +
      " runs (the paper's: one)\n"
      "says: the largest distance that the solver says, and / the true one then\n";
  const auto ms = [](const std::optional<double>& seconds) {
    return seconds ? fixed_number(1e3 * *seconds, 1) : std::string("-");
  };
  for (const Scene& scene : report.scenes) {
    std::vector<std::vector<std::string>> rows = {
        {"solver", "set-up", "RMS 0.1", "0.01", "0.001", "max 0.1", "0.01", "0.001", "says 0.1",
         "says 0.01", "says 0.001", "last RMS", "last max", "excess", "folded"}};
    for (const Curve& curve : scene.curves) {
      std::vector<std::string> row = {name_of(curve), fixed_number(1e3 * curve.setup_seconds, 1)};
      for (const auto& seconds : curve.seconds_to_rms) row.push_back(ms(seconds));
      for (const auto& seconds : curve.seconds_to_max) row.push_back(ms(seconds));
      for (const auto& claim : curve.claims) {
        row.push_back(claim ? fixed_number(claim->said_voxels, 4) + " / " +
                                  fixed_number(claim->true_voxels, 4)
                            : "-");
      }
      const Sample& last = curve.samples.back();
      row.push_back(fixed_number(last.rms_voxels, 5));
      row.push_back(fixed_number(last.max_voxels, 4));
      row.push_back(short_number(last.energy_excess, 2));
      row.push_back(std::to_string(curve.most_folded_cells));
      rows.push_back(std::move(row));
    }
    const std::string distance = short_number(scene.equilibrium_distance_voxels, 1);
    out +=
        "\n" + heading_of(scene) + "\n" + std::to_string(scene.free_elements) +
        " free elements; the start: RMS " + fixed_number(scene.start_rms_voxels, 3) + ", max " +
        fixed_number(scene.start_max_voxels, 2) + ", " + std::to_string(scene.folded_at_start) +
        " folded cells; the equilibrium: " +
        (scene.equilibrium_converged ? "within " + distance + " voxel"
                                     : "NOT found, by its own word within " + distance + " voxel") +
        ", " + std::to_string(scene.equilibrium_folded_cells) + " folded cells\n" +
        text_table(rows);
  }
  return out + "\n" + text_of(report.folds);
}

// --- the plot

const char* color_of(const Curve& curve) {
  if (curve.solver == "paper") return plot::color::kOrange;
  if (curve.solver == "paper_list") return plot::color::kPurple;
  return curve.threads == 1 ? plot::color::kSky : plot::color::kBlue;
}

plot::Panel panel_of(const Scene& scene) {
  plot::Panel panel;
  panel.title = scene.title + ", " + std::to_string(scene.elements) + " elements";
  std::vector<double> times, values;
  for (const Curve& curve : scene.curves) {
    plot::Series rms, max;
    rms.style = {color_of(curve), plot::Marker::none, plot::Line::solid, false};
    max.style = {color_of(curve), plot::Marker::none, plot::Line::dashed, false};
    for (const Sample& s : curve.samples) {
      const double ms = 1e3 * s.seconds;
      if (!(ms > 0.0)) continue;
      rms.points.emplace_back(ms, s.rms_voxels);
      max.points.emplace_back(ms, s.max_voxels);
      times.push_back(ms);
      values.push_back(s.rms_voxels);
      values.push_back(s.max_voxels);
    }
    panel.series.push_back(std::move(max));
    panel.series.push_back(std::move(rms));
  }
  const auto x = plot::decades_around(times);
  const auto y = plot::decades_around(values);
  panel.x = {"time, set-up counted [ms]", plot::Scale::log, x.low, x.high, {}};
  panel.y = {"distance to the equilibrium [voxels]", plot::Scale::log, y.low, y.high, {}};
  return panel;
}

std::string svg_text(const RelaxationError& report) {
  plot::Page page;
  page.title = "Relaxation: distance to the true equilibrium against time";
  page.notes = {text_of(report.machine),
                "left and low is good; solid: RMS over the free elements, dashed: the largest; the "
                "equilibrium is Newton's, in double precision"};
  for (const Scene& scene : report.scenes) page.panels.push_back(panel_of(scene));
  page.panels_in_row = 5;
  if (!report.scenes.empty()) {
    for (const Curve& curve : report.scenes.front().curves) {
      std::string text = "Maille, " + std::to_string(curve.threads) +
                         (curve.threads == 1 ? " thread" : " threads");
      if (curve.solver == "paper") text = "the paper's Jacobi steps, equation (4) mended";
      if (curve.solver == "paper_list") text = "the same with its list, 0.01 voxel";
      page.legend.push_back(
          {text, {color_of(curve), plot::Marker::none, plot::Line::solid, false}});
    }
  }
  return plot::to_svg(page);
}

}  // namespace

MeasurePage page_of(const RelaxationError& report) {
  return {json_text(report), csv_text(report), svg_text(report), table_text(report)};
}

}  // namespace maille
