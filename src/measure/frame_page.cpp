#include "measure/frame_page.h"

#include <algorithm>

#include "measure/json_parts.h"
#include "measure/plot.h"
#include "measure/text_table.h"

namespace maille {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of_size(Size3 size) {
  return std::to_string(size.x) + "x" + std::to_string(size.y) + "x" + std::to_string(size.z);
}

std::string title_of(const FrameReport::Row& row) {
  return std::string(name_of(row.mode)) + (row.shading ? ", shaded" : "");
}

std::string ms(double seconds) { return fixed_number(1e3 * seconds, 2); }

std::string json_text(const FrameReport& report) {
  Json out = {
      {"maille_measure", 1},
      {"version", MAILLE_VERSION},
      {"what", "frame"},
      {"machine", json_of(report.machine)},
      {"device", {{"name", report.device}, {"driver", report.driver}, {"sparse", report.sparse}}},
      {"picture", {report.picture.x, report.picture.y}},
      {"bars", Json::array()},
      {"frames", Json::array()},
      {"changes", Json::array()},
      {"peers", Json::array()}};
  for (const FrameBar& bar : bars_of(report)) {
    out["bars"].push_back(Json{{"what", bar.what},
                               {"measured", bar.measured_ms},
                               {"at_most", bar.at_most_ms},
                               {"unit", "ms"},
                               {"met", bar.met()}});
  }
  for (const FrameReport::Row& row : report.rows) {
    out["frames"].push_back(Json{{"volume", json_of(row.volume)},
                                 {"mode", name_of(row.mode)},
                                 {"shading", row.shading},
                                 {"milliseconds", json_of(row.frame)},
                                 {"raycast_milliseconds", row.raycast_ms}});
  }
  for (const FrameReport::Change& change : report.changes) {
    out["changes"].push_back(Json{{"what", change.what},
                                  {"volume", json_of(change.volume)},
                                  {"extra_milliseconds", json_of(change.extra)}});
  }
  for (const FramePeer& peer : frame_peers()) {
    out["peers"].push_back(Json{{"program", peer.program},
                                {"volume", json_of(peer.volume)},
                                {"mode", name_of(peer.mode)},
                                {"milliseconds", peer.ms}});
  }
  return text_of(out);
}

std::string csv_text(const FrameReport& report) {
  std::vector<std::vector<std::string>> rows = {
      {"what", "volume", "median_ms", "least_ms", "most_ms", "runs", "raycast_ms"}};
  const auto add = [&](const std::string& what, Size3 volume, const Timing& timing,
                       const std::string& raycast) {
    rows.push_back({what, text_of_size(volume), ms(timing.median_seconds), ms(timing.least_seconds),
                    ms(timing.most_seconds), std::to_string(timing.runs), raycast});
  };
  for (const FrameReport::Row& row : report.rows) {
    add(title_of(row), row.volume, row.frame, fixed_number(row.raycast_ms, 3));
  }
  for (const FrameReport::Change& change : report.changes) {
    add(change.what, change.volume, change.extra, "");
  }
  return csv(rows);
}

std::string svg_text(const FrameReport& report) {
  plot::Panel panel;
  panel.title = "Until the picture is there";
  std::vector<double> times;
  const plot::Style shaded{plot::color::kBlue, plot::Marker::circle, plot::Line::none, false};
  const plot::Style plain{plot::color::kSky, plot::Marker::circle, plot::Line::none, true};
  const plot::Style change{plot::color::kOrange, plot::Marker::diamond, plot::Line::none, false};
  const plot::Style peer{plot::color::kGrey, plot::Marker::tick, plot::Line::none, false};
  double y = 0.0;
  const auto add = [&](const std::string& name, const Timing& timing, const plot::Style& style) {
    panel.y.names.push_back(name);
    const double median = 1e3 * std::max(timing.median_seconds, 1e-6);
    times.push_back(median);
    panel.series.push_back(
        {style,
         {{median, y}},
         {{1e3 * std::max(timing.least_seconds, 1e-6), 1e3 * std::max(timing.most_seconds, 1e-6)}},
         ""});
    y += 1.0;
  };
  for (const FrameReport::Row& row : report.rows) {
    for (const FramePeer& other : frame_peers()) {
      if (other.volume != row.volume || other.mode != row.mode || !row.shading) continue;
      times.push_back(other.ms);
      panel.series.push_back({peer, {{other.ms, y}}, {}, ""});
    }
    add(title_of(row) + ", " + text_of_size(row.volume), row.frame, row.shading ? shaded : plain);
  }
  for (const FrameReport::Change& row : report.changes) {
    add(row.what + ", " + text_of_size(row.volume), row.extra, change);
  }
  const auto x = plot::decades_around(times);
  panel.x = {"time [ms]", plot::Scale::log, x.low, x.high, {}};
  panel.y.scale = plot::Scale::names;
  plot::Page page;
  page.title = "Pictures of " + std::to_string(report.picture.x) + " x " +
               std::to_string(report.picture.y) + " pixels";
  page.notes = {report.device + ", " + report.driver, text_of(report.machine)};
  page.panels = {std::move(panel)};
  page.legend = {{"with a gradient at each sample", shaded},
                 {"without", plain},
                 {"more than a picture without the change", change},
                 {"other programs, measured once", peer}};
  return plot::to_svg(page);
}

std::string table_text(const FrameReport& report) {
  std::vector<std::vector<std::string>> rows = {
      {"picture of a head", "volume", "ms", "least", "most", "raycast", "others' least"}};
  for (const FrameReport::Row& row : report.rows) {
    double least = 0.0;
    for (const FramePeer& peer : frame_peers()) {
      const bool same = peer.volume == row.volume && peer.mode == row.mode && row.shading;
      if (same && (least == 0.0 || peer.ms < least)) least = peer.ms;
    }
    rows.push_back({title_of(row), text_of_size(row.volume), ms(row.frame.median_seconds),
                    ms(row.frame.least_seconds), ms(row.frame.most_seconds),
                    fixed_number(row.raycast_ms, 2), least > 0 ? fixed_number(least, 0) : "-"});
  }
  std::vector<std::vector<std::string>> changes = {
      {"more for the picture after", "volume", "ms", "least", "most"}};
  for (const FrameReport::Change& change : report.changes) {
    changes.push_back({change.what, text_of_size(change.volume), ms(change.extra.median_seconds),
                       ms(change.extra.least_seconds), ms(change.extra.most_seconds)});
  }
  std::vector<std::vector<std::string>> bars = {{"what it answers to", "ms", "", "bar", ""}};
  for (const FrameBar& bar : bars_of(report)) {
    bars.push_back({bar.what, fixed_number(bar.measured_ms, 2),
                    "<=", fixed_number(bar.at_most_ms, 0), bar.met() ? "met" : "NOT MET"});
  }
  return "Pictures of " + std::to_string(report.picture.x) + " x " +
         std::to_string(report.picture.y) + " pixels, " + report.device + " (" +
         (report.sparse ? "sparse" : "dense") + ")\n" + text_of(report.machine) + "\n\n" +
         text_table(rows) + "\n" + text_table(changes) + "\n" + text_table(bars);
}

}  // namespace

MeasurePage page_of(const FrameReport& report) {
  return {json_text(report), csv_text(report), svg_text(report), table_text(report)};
}

}  // namespace maille
