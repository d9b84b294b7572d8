#include "app/document.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <unistd.h>

#include "app/field.h"
#include "app/paths.h"
#include "core/stopwatch.h"
#include "core/trace.h"
#include "deform/cut_counts.h"
#include "deform/violations.h"
#include "material/spring_table.h"
#include "volume/phantom.h"
#include "volume/volume_file.h"

namespace maille {
namespace {

std::string text_of(Size3 size) {
  return std::to_string(size.x) + "x" + std::to_string(size.y) + "x" + std::to_string(size.z);
}

std::string in_file(const Scene& scene, const std::string& message) {
  return scene.file.empty() ? message : scene.file.string() + ": " + message;
}

constexpr std::int64_t kLeastForRelaxation_bytes = std::int64_t{256} << 20;

std::int64_t physical_memory_bytes() {
  return std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
}

}  // namespace

Error in_action(const Scene& scene, std::size_t index, const Error& error) {
  if (error.kind != ErrorKind::usage) return error;
  const auto name = std::string(name_of(scene.actions[index])) + ": ";
  // What the deformer says begins with the action's name already.
  const auto sentence = error.message.starts_with(name) ? error.message : name + error.message;
  return {ErrorKind::bad_input,
          in_file(scene, "actions[" + std::to_string(index) + "]." + sentence)};
}

Result<LoadedVolume> load_volume(const Scene& scene, std::uint64_t seed) {
  const trace::Span span("load");
  const Stopwatch start;
  if (const auto* const file = std::get_if<std::filesystem::path>(&scene.volume)) {
    if (auto checked = check_input(*file); !checked) return checked.error();
    auto volume = read_volume(*file);
    if (!volume) return volume.error();
    return LoadedVolume{*std::move(volume), start.seconds(), std::nullopt};
  }
  const auto& phantom = std::get<PhantomSource>(scene.volume);
  auto volume = make_phantom(phantom.name, phantom.size, phantom.seed.value_or(seed));
  if (!volume) {
    return Error{ErrorKind::bad_input, in_file(scene, "volume: " + volume.error().message)};
  }
  return LoadedVolume{*std::move(volume), start.seconds(), std::nullopt};
}

Document::Document(Scene scene, LoadedVolume loaded, const DocumentOptions& options)
    : scene_(std::move(scene)),
      options_(options),
      plan_(plan_of(scene_, options.purpose)),
      pool_(options.threads),
      volume_(std::move(loaded.volume)),
      range_(std::move(loaded.range)) {
  statistics_.command = options.command;
  statistics_.machine.threads = pool_.thread_count();
  auto& s = statistics_.volume;
  s.load_seconds = loaded.seconds;
  s.size = volume_.size();
  s.type = maille::name_of(volume_.type());
  s.bytes = static_cast<std::int64_t>(volume_.bytes().size());
}

Result<std::unique_ptr<Document>> Document::open(Scene scene, LoadedVolume loaded,
                                                 const DocumentOptions& options) {
  std::unique_ptr<Document> document(new Document(std::move(scene), std::move(loaded), options));
  if (auto checked = document->check_drags(); !checked) return checked.error();
  const Plan& plan = document->plan_;
  if (plan.deforms()) document->make_deformer();
  if (plan.chainmail) document->statistics_.chainmail.emplace();
  if (plan.cut || plan.carve) document->statistics_.cuts.emplace();
  if (plan.undo) document->statistics_.undo.emplace();
  if (plan.relaxation) {
    const MaterialTable& table = document->deformer_->materials().table();
    document->statistics_.relaxation.emplace().stiffness_clamped = SpringTable::of(table).clamped();
  }
  if (plan.resampling) {
    document->statistics_.resample.emplace().method = name_of(document->scene_.resampling);
  }
  document->statistics_.left_out = plan.left_out();
  return document;
}

void Document::make_deformer() {
  auto materials = material_table();
  plan_.use(materials);
  DeformerOptions options;
  options.lattice_memory_bytes = options_.lattice_memory_bytes;
  options.undo_memory_bytes.reset();
  if (plan_.undo) options.undo_memory_bytes = options_.undo_memory_bytes;
  deformer_.emplace(volume_, std::move(materials), scene_.anchors, options);
  shown_ = Lattice(volume_.size());
  shown_cuts_ = Cuts(volume_.size());
}

Result<void> Document::check_drags() const {
  const auto refuse = [&](std::size_t action, const std::string& message) {
    return Error{ErrorKind::bad_input,
                 in_file(scene_, "actions[" + std::to_string(action) + "].drag.from." + message)};
  };
  for (std::size_t i = 0; i < scene_.actions.size(); ++i) {
    const auto* const drag = std::get_if<DragAction>(&scene_.actions[i]);
    if (drag == nullptr) continue;
    const auto* const from = std::get_if<FromVoxel>(&drag->from);
    if (from == nullptr) {
      if (plan_.vulkan) continue;
      return refuse(i, "pixel: maille " + options_.command +
                           " draws no picture to pick from; expected \"voxel\"");
    }
    const auto inside = glm::all(glm::greaterThanEqual(from->voxel, glm::dvec3(-0.5))) &&
                        glm::all(glm::lessThanEqual(from->voxel, glm::dvec3(volume_.size()) - 0.5));
    if (!inside) {
      return refuse(i, "voxel: expected a voxel inside the volume of " + text_of(volume_.size()) +
                           ", got one outside");
    }
  }
  return {};
}

const VolumeStatistics& Document::range() {
  if (!range_) {
    const trace::Span span("value range");
    const Stopwatch start;
    range_ = statistics_of(volume_, 1);
    statistics_.volume.analyse_seconds += start.seconds();
  }
  return *range_;
}

bool looks_like_hounsfield(const Volume& volume, const VolumeStatistics& range) {
  const bool is_signed = volume.type() == VoxelType::int16 || volume.type() == VoxelType::float32;
  return is_signed && range.lowest <= -500.0;
}

MaterialTable Document::material_table() {
  if (const auto* const table = std::get_if<MaterialTable>(&scene_.materials)) return *table;
  auto [preset, interpolation] = std::get<PresetMaterials>(scene_.materials);
  if (preset == MaterialPreset::automatic) {
    preset =
        looks_like_hounsfield(volume_, range()) ? MaterialPreset::ct : MaterialPreset::relative;
  }
  if (preset == MaterialPreset::ct) return MaterialTable::ct(interpolation);
  return MaterialTable::relative(range().lowest, range().highest, interpolation);
}

Result<TransferFunction> Document::transfer_function() {
  if (const auto* const own = std::get_if<TransferFunction>(&scene_.transfer_function)) return *own;
  auto name = std::get<TransferPreset>(scene_.transfer_function).name;
  if (name.empty()) name = looks_like_hounsfield(volume_, range()) ? "ct-skin" : "relative";
  if (name != "relative") return TransferFunction::preset(name, 0.0, 0.0);
  return TransferFunction::preset(name, range().lowest, range().highest);
}

std::int64_t Document::relaxation_memory_bytes() const {
  if (const auto budget = options_.lattice_memory_bytes) {
    return std::max<std::int64_t>(
        0, *budget - lattice().displacement_bytes() - deformer_->kept().displacement_bytes());
  }
  return std::max(kLeastForRelaxation_bytes, physical_memory_bytes() / 4);
}

VoxelBox Document::shown_extent() const {
  const int margin = plan_.resampling ? scene_.render.margin_voxels : 0;
  // So that its bricks are the lattice's, which go on beyond the volume.
  const int below = (margin + kBrickEdge - 1) / kBrickEdge * kBrickEdge;
  return {VoxelIndex(-below), volume_.size() + margin};
}

ViewUpdate Document::take_view() {
  ViewUpdate update;
  if (!plan_.resampling) return update;
  const trace::Span span("prepare view");
  update.bricks = dirty_bricks(shown_, shown_cuts_, lattice(), cuts(), volume_.spacing_mm(),
                               shown_extent(), scene_.resampling);
  shown_ = lattice();
  shown_cuts_ = cuts();
  update.resampler = std::make_shared<const Resampler>(resampler());
  return update;
}

Result<void> Document::drag(const DragAction& action, VoxelIndex element, const Step& step) {
  // A ball that holds the whole volume needs to grow no further.
  const double radius =
      std::min(action.radius_voxels, 2.0 * glm::length(glm::dvec3(volume_.size())));
  const glm::dvec3 by = action.by_is_mm
                            ? glm::inverse(glm::dmat3(volume_.world_from_voxel())) * action.by
                            : action.by;
  if (auto begun = deformer_->begin_stroke(element, radius, action.name); !begun) return begun;
  auto& s = *statistics_.chainmail;
  for (int i = 1; i <= action.steps; ++i) {
    const double share = i == action.steps ? 1.0 : static_cast<double>(i) / action.steps;
    const auto report = deformer_->drag_to(by * share, pool_);
    if (!report) {
      deformer_->cancel_stroke();
      return report.error();
    }
    ++s.drags;
    s.elements_moved += report->elements_moved;
    s.working_bytes = std::max(s.working_bytes, report->working_bytes);
    s.seconds += report->seconds;
    s.drag_clamped = s.drag_clamped || report->clamped;
    if (options_.measure) {
      const auto peak = peak_of(*report, deformer_->stroke_memory());
      statistics_.memory.add_stroke(peak.bytes(), peak.elements);
    }
    if (auto shown = step(*report); !shown) return shown;
  }
  deformer_->end_stroke();
  if (options_.measure) {
    const auto violations = violations_of(lattice(), deformer_->materials(), cuts());
    s.violated_links = std::max(s.violated_links, violations.links);
    s.worst_violation_voxels = std::max(s.worst_violation_voxels, violations.worst_voxels);
  }
  return {};
}

Result<void> Document::relax(const RelaxAction& action) {
  if (!plan_.relaxation) return {};
  const trace::Span span("relaxation");
  const Stopwatch start;
  RelaxationOptions options;
  options.tolerance_voxels = action.until_voxels.value_or(scene_.relaxation.tolerance_voxels);
  options.memory_bytes = relaxation_memory_bytes();
  Relaxation relaxation = deformer_->relax(pool_, options);
  const auto time_left = [&](std::int64_t iterations) {
    if (options_.deterministic) return iterations < kDeterministicIterations;
    return start.seconds() < action.at_most_seconds;
  };
  while (!relaxation.progress().finished() && time_left(relaxation.progress().iterations)) {
    relaxation.iterate();
  }
  const RelaxationProgress& progress = relaxation.progress();
  std::optional<double> finished_within_voxels;
  if (progress.finished()) finished_within_voxels = options.tolerance_voxels;
  Lattice relaxed = relaxation.lattice();
  const Lattice* const kept = relaxation.kept_by_flow();
  if (kept || !same_displacements(relaxed, lattice())) deformer_->mark_undo_step();
  deformer_->adopt(std::move(relaxed), finished_within_voxels, kept);

  auto& s = *statistics_.relaxation;
  if (s.iterations == 0) s.energy_first = progress.energy_first;
  s.iterations += progress.iterations;
  s.element_updates += progress.element_updates;
  s.seconds += start.seconds();
  s.converged = s.converged && progress.converged;
  s.residual_voxels.reset();
  s.residual_rms_voxels.reset();
  if (std::isfinite(progress.residual_voxels)) {
    s.residual_voxels = progress.residual_voxels;
    s.residual_rms_voxels = progress.residual_rms_voxels;
  }
  s.free_elements = std::max(s.free_elements, progress.free_elements);
  s.folded_corners = progress.folded_corners;
  s.region_limited = s.region_limited || progress.region_limited;
  s.energy_last = progress.energy_last;
  s.energy_ever_rose = s.energy_ever_rose || progress.energy_ever_rose;
  return {};
}

glm::dvec3 Document::to_voxel(const ScenePoint& point) const {
  if (!point.is_mm) return point.at;
  return transform_point(glm::inverse(volume_.world_from_voxel()), point.at);
}

Result<CutSurface> Document::surface_of(const CutAction& action) const {
  const auto to_voxels = [&](const std::vector<ScenePoint>& points) {
    std::vector<glm::dvec3> voxels;
    for (const auto& point : points) voxels.push_back(to_voxel(point));
    return voxels;
  };
  const glm::dmat3 world_from_voxel(volume_.world_from_voxel());
  if (const auto* const disc = std::get_if<CutDisc>(&action.surface)) {
    // CutSurface takes the normal along the volume's own axes.
    const glm::dvec3 spacing = volume_.spacing_mm();
    const glm::dmat3 axes(world_from_voxel[0] / spacing.x, world_from_voxel[1] / spacing.y,
                          world_from_voxel[2] / spacing.z);
    return CutSurface::disc(to_voxel(disc->center), glm::inverse(axes) * disc->normal,
                            disc->radius_mm, spacing);
  }
  if (const auto* const sweep = std::get_if<CutSweep>(&action.surface)) {
    const auto depth_mm = sweep->depth_mm * glm::normalize(sweep->direction);
    return CutSurface::sweep(to_voxels(sweep->path), glm::inverse(world_from_voxel) * depth_mm);
  }
  return CutSurface::polygon(to_voxels(std::get<CutPolygon>(action.surface).corners));
}

Result<void> Document::cut(const CutAction& action) {
  const trace::Span span("cut");
  const Stopwatch start;
  const auto surface = surface_of(action);
  if (!surface) return surface.error();
  auto done = deformer_->cut(*surface);
  statistics_.cuts->seconds += start.seconds();
  return done;
}

Result<void> Document::carve(const CarveAction& action) {
  const trace::Span span("carve");
  const Stopwatch start;
  auto done = deformer_->carve(to_voxel(action.ball.center), action.ball.radius_voxels);
  statistics_.cuts->seconds += start.seconds();
  return done;
}

Result<void> Document::restore(const RestoreAction& action) {
  const trace::Span span("restore");
  const Stopwatch start;
  auto done = deformer_->restore(to_voxel(action.ball.center), action.ball.radius_voxels);
  statistics_.cuts->seconds += start.seconds();
  return done;
}

Result<void> Document::release(const ReleaseAction& action) {
  if (!deformer_) return Error{ErrorKind::usage, "nothing has been dragged"};
  return deformer_->release(action.name);
}

Result<void> Document::undo(int count) {
  for (int i = 0; i < count; ++i) {
    if (!deformer_ || !deformer_->undo()) return too_few_steps("undo", i, count);
  }
  return {};
}

Result<void> Document::redo(int count) {
  for (int i = 0; i < count; ++i) {
    if (!deformer_ || !deformer_->redo()) return too_few_steps("redo", i, count);
  }
  return {};
}

Error Document::too_few_steps(const std::string& action, int there, int wanted) const {
  auto message = "only " + std::to_string(there) + " of " + std::to_string(wanted) +
                 " steps are there to " + action;
  if (const auto dropped = undo_steps_dropped(); dropped > 0) {
    message += "; " + std::to_string(dropped) + " were dropped to hold --undo-memory";
  }
  return {ErrorKind::usage, std::move(message)};
}

Resampler Document::resampler() {
  return {volume_, lattice(), cuts(), scene_.resampling, range().lowest};
}

Result<VoxelBox> Document::extent_of(const SaveAction& action, const Resampler& resampler) const {
  const VoxelBox own{VoxelIndex(0), volume_.size()};
  if (action.extent == SavedExtent::keep) return own;
  const VoxelBox extent = resampler.extent();
  if (extent == own) return own;
  double bytes = action.field ? sizeof(glm::vec3) : 0.0;
  if (action.volume) bytes += static_cast<double>(bytes_per_voxel(volume_.type()));
  for (int c = 0; c < 3; ++c) bytes *= extent.size()[c];
  if (bytes > 0.5 * static_cast<double>(physical_memory_bytes())) {
    return Error{ErrorKind::out_of_memory,
                 "what was pulled out of the volume reaches so far that the saved one would have " +
                     text_of(extent.size()) +
                     " voxels; \"extent\": \"keep\" in a save action, or "
                     "--extent keep, saves the volume's own " +
                     text_of(volume_.size())};
  }
  return extent;
}

Result<void> Document::save(const SaveAction& action) {
  if (!plan_.resampling) return save_at_rest(action);
  const Resampler now = resampler();
  const auto extent = extent_of(action, now);
  if (!extent) return extent.error();
  if (action.volume) {
    ResampleCounts counts;
    const Volume deformed = resample_volume(now, *extent, pool_, counts);
    statistics_.resample->add(counts);
    if (auto written = write_volume(*action.volume, deformed); !written) return written;
  }
  if (!action.field) return {};
  return write_vector_field(*action.field, extent->size(), world_from_voxel_of(volume_, *extent),
                            inverse_field_mm(now, *extent, pool_));
}

Result<void> Document::save_at_rest(const SaveAction& action) {
  if (action.volume) {
    if (auto written = write_volume(*action.volume, volume_); !written) return written;
  }
  if (!action.field) return {};
  const std::vector<glm::vec3> field(static_cast<std::size_t>(voxel_count(volume_.size())));
  return write_vector_field(*action.field, volume_.size(), volume_.world_from_voxel(), field);
}

Result<void> Document::save_forward_field(const std::filesystem::path& path) {
  const Lattice rest(volume_.size());
  const auto field = forward_field_mm(volume_, deformer_ ? lattice() : rest, pool_);
  return write_vector_field(path, volume_.size(), volume_.world_from_voxel(), field);
}

std::int64_t Document::undo_steps_dropped() const {
  return deformer_ && deformer_->history() ? deformer_->history()->dropped_steps() : 0;
}

void Document::measure_volume() {
  const MaterialTable& table = deformer_->materials().table();
  const auto kept = volume_kept(lattice(), cuts(), deformer_->materials(), pool_);
  auto& out = statistics_.volume_kept.emplace();
  out.all = sum_of(kept);
  if (static_cast<std::size_t>(table.count()) != table.materials().size()) return;
  for (std::size_t id = 0; id < kept.size(); ++id) {
    if (kept[id].cells == 0) continue;
    const bool mixed = id + 1 == kept.size();
    out.by_material.push_back({mixed ? "mixed" : table.materials()[id].name, kept[id]});
  }
}

void Document::measure_state() {
  statistics_.memory.peak_rss_bytes = peak_rss_bytes();
  if (!deformer_) return;
  if (options_.measure) {
    statistics_.resample->folded_cells = count_folded_cells(lattice(), cuts(), pool_);
    measure_volume();
  }
  if (statistics_.cuts) {
    const auto counts = count_removed(cuts());
    statistics_.cuts->links_removed = counts.links_removed;
    statistics_.cuts->elements_carved = counts.elements_carved;
  }
  if (const History* const history = deformer_->history()) {
    statistics_.undo = {history->undo_steps(), history->redo_steps(), history->bytes(),
                        history->budget_bytes(), history->dropped_steps()};
  }
  auto& memory = statistics_.memory;
  memory.lattice_bricks = lattice().brick_count();
  memory.lattice_bytes = lattice().bytes() + deformer_->kept().bytes();
  lattice().for_each_brick([&](std::int64_t linear, const LatticeBrick&) {
    const auto& grid = lattice().grid();
    memory.lattice_elements += voxel_count(grid.box(grid.brick(linear)).size());
  });
  if (const LatticeMemory* const limited = deformer_->memory()) {
    const auto counters = limited->store().counters();
    memory.budget = {limited->store().budget_bytes(), counters.peak_bytes_in_memory,
                     counters.planes_written, counters.bytes_written, counters.planes_read};
  }
}

}  // namespace maille
