#include "app/statistics.h"

#include <algorithm>

#include <sys/resource.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "core/stopwatch.h"

namespace maille {
namespace {

using Json = nlohmann::ordered_json;

// Before main(). The kernel's own start of the process is that of the shell that called exec.
const Stopwatch program_start;

double rate(std::int64_t count, double seconds) {
  return seconds > 0.0 ? static_cast<double>(count) / seconds : 0.0;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double per_element(std::int64_t bytes, std::int64_t elements) {
  return elements == 0 ? 0.0 : static_cast<double>(bytes) / static_cast<double>(elements);
}

Json section(const RunStatistics::ChainMail& s) {
  return {{"drags", s.drags},
          {"elements_moved", s.elements_moved},
          {"working_bytes", s.working_bytes},
          {"seconds", s.seconds},
          {"elements_per_second", rate(s.elements_moved, s.seconds)},
          {"violated_links", s.violated_links},
          {"worst_violation_voxels", s.worst_violation_voxels},
          {"drag_clamped", s.drag_clamped}};
}

Json section(const RunStatistics::Relaxation& s) {
  Json out = {{"iterations", s.iterations},
              {"element_updates", s.element_updates},
              {"seconds", s.seconds},
              {"element_updates_per_second", rate(s.element_updates, s.seconds)},
              {"converged", s.converged},
              {"residual_known", s.residual_voxels.has_value()},
              {"free_elements", s.free_elements},
              {"folded_corners", s.folded_corners},
              {"region_limited", s.region_limited},
              {"energy_first", s.energy_first},
              {"energy_last", s.energy_last},
              {"energy_ever_rose", s.energy_ever_rose}};
  if (s.residual_voxels) out["residual_voxels"] = *s.residual_voxels;
  if (s.residual_rms_voxels) out["residual_rms_voxels"] = *s.residual_rms_voxels;
  if (s.stiffness_clamped) out["stiffness_clamped"] = *s.stiffness_clamped;
  return out;
}

Json section(const RunStatistics::Cuts& s) {
  return {{"links_removed", s.links_removed},
          {"elements_carved", s.elements_carved},
          {"seconds", s.seconds}};
}

Json section(const RunStatistics::Undo& s) {
  return {{"steps", s.steps},
          {"redo_steps", s.redo_steps},
          {"bytes", s.bytes},
          {"budget_bytes", s.budget_bytes},
          {"dropped_steps", s.dropped_steps}};
}

Json section(const RunStatistics::Resample& s) {
  return {{"method", s.method},
          {"voxels", s.voxels},
          {"moved_voxels", s.moved_voxels},
          {"seconds", s.seconds},
          {"voxels_per_second", rate(s.voxels, s.seconds)},
          {"folded_cells", s.folded_cells},
          {"unfilled_voxels", s.unfilled_voxels},
          {"copied_voxels", s.copied_voxels},
          {"copy_seconds", s.copy_seconds}};
}

Json section(const VolumeKept& s) {
  return {{"cells", s.cells}, {"ratio", s.ratio}, {"change_rms", s.change_rms}};
}

Json section(const RunStatistics::CellVolumes& s) {
  Json out = section(s.all);
  Json& materials = out["materials"] = Json::object();
  for (const auto& [material, kept] : s.by_material) materials[material] = section(kept);
  return out;
}

Json section(const RunStatistics::Frames& s) {
  Json out = {
      {"count", s.milliseconds.size()},
      {"median_ms", median(s.milliseconds)},
      {"gpu_ms", {{"raycast", s.raycast_ms}, {"upload", s.upload_ms}, {"pick", s.pick_ms}}}};
  if (s.first_picture_seconds) out["first_picture_seconds"] = *s.first_picture_seconds;
  return out;
}

}  // namespace

void RunStatistics::Resample::add(const ResampleCounts& counts) {
  voxels += counts.voxels - counts.copied_voxels;
  moved_voxels += counts.moved_voxels;
  seconds += counts.resample_seconds;
  unfilled_voxels = std::max(unfilled_voxels, counts.unfilled_voxels);
  copied_voxels += counts.copied_voxels;
  copy_seconds += counts.copy_seconds;
}

void RunStatistics::Resample::add(const Resample& other) {
  voxels += other.voxels;
  moved_voxels += other.moved_voxels;
  seconds += other.seconds;
  unfilled_voxels = std::max(unfilled_voxels, other.unfilled_voxels);
  copied_voxels += other.copied_voxels;
  copy_seconds += other.copy_seconds;
}

void RunStatistics::Memory::add_stroke(std::int64_t bytes, std::int64_t elements) {
  if (bytes <= stroke_bytes_peak) return;
  stroke_bytes_peak = bytes;
  stroke_elements = elements;
}

std::int64_t peak_rss_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

std::string to_json(const RunStatistics& s) {
  Json out = {{"maille_stats", 1}, {"version", MAILLE_VERSION}, {"command", s.command}};
  out["machine"] = {{"threads", s.machine.threads}};
  if (s.machine.triad_gb_per_s) out["machine"]["triad_gb_per_s"] = *s.machine.triad_gb_per_s;
  if (s.device) {
    out["device"] = {
        {"name", s.device->name}, {"driver", s.device->driver}, {"sparse", s.device->sparse}};
  }
  out["volume"] = {{"size", {s.volume.size.x, s.volume.size.y, s.volume.size.z}},
                   {"type", s.volume.type},
                   {"bytes", s.volume.bytes},
                   {"load_seconds", s.volume.load_seconds},
                   {"analyse_seconds", s.volume.analyse_seconds}};
  if (s.chainmail) out["chainmail"] = section(*s.chainmail);
  if (s.cuts) out["cuts"] = section(*s.cuts);
  if (s.undo) out["undo"] = section(*s.undo);
  if (s.relaxation) out["relaxation"] = section(*s.relaxation);
  if (s.volume_kept) out["volume_kept"] = section(*s.volume_kept);
  if (s.resample) out["resample"] = section(*s.resample);
  if (s.upload) {
    out["upload"] = {
        {"bricks", s.upload->bricks}, {"bytes", s.upload->bytes}, {"seconds", s.upload->seconds}};
  }
  if (s.frames) out["frames"] = section(*s.frames);
  if (s.pick) out["pick"] = {{"count", s.pick->count}, {"seconds", s.pick->seconds}};
  out["memory"] = {
      {"peak_rss_bytes", s.memory.peak_rss_bytes},
      {"lattice_bricks", s.memory.lattice_bricks},
      {"lattice_bytes", s.memory.lattice_bytes},
      {"lattice_bytes_per_element", per_element(s.memory.lattice_bytes, s.memory.lattice_elements)},
      {"stroke_bytes_peak", s.memory.stroke_bytes_peak},
      {"stroke_bytes_per_element",
       per_element(s.memory.stroke_bytes_peak, s.memory.stroke_elements)},
      {"gpu_pages_resident", s.memory.gpu_pages_resident},
      {"gpu_pages_total", s.memory.gpu_pages_total},
      {"gpu_bytes", s.memory.gpu_bytes}};
  if (const auto& budget = s.memory.budget) {
    out["memory"]["lattice_budget_bytes"] = budget->bytes;
    out["memory"]["lattice_peak_bytes"] = budget->peak_bytes;
    out["memory"]["scratch_planes_written"] = budget->planes_written;
    out["memory"]["scratch_bytes_written"] = budget->bytes_written;
    out["memory"]["scratch_planes_read"] = budget->planes_read;
  }
  out["left_out"] = s.left_out;
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

double seconds_since_program_start() { return program_start.seconds(); }

}  // namespace maille
