#include "app/headless.h"

#include <algorithm>
#include <cstdio>
#include <string_view>
#include <utility>
#include <vector>

#include "app/byte_size.h"
#include "app/png.h"
#include "core/atomic_file.h"
#include "core/trace.h"
#include "measure/triad.h"

namespace maille {
namespace {

constexpr std::string_view kFramePrefix = "frame_";

// How many pictures a step the scene makes.
std::int64_t count_frames(const Scene& scene, const Plan& plan) {
  std::int64_t count = 1;  // before the first action
  for (const Action& action : scene.actions) {
    if (const auto* const drag = std::get_if<DragAction>(&action)) {
      count += drag->steps;
    } else if (std::holds_alternative<RelaxAction>(action)) {
      count += plan.relaxation ? 1 : 0;
    } else if (!std::holds_alternative<RenderAction>(action) &&
               !std::holds_alternative<SaveAction>(action)) {
      ++count;
    }
  }
  return count;
}

// frame_000.png and longer numbers, and nothing else.
bool is_frame(const std::filesystem::path& path) {
  const auto stem = path.stem().string();
  return path.extension() == ".png" && stem.starts_with(kFramePrefix) &&
         stem.size() >= kFramePrefix.size() + 3 &&
         std::all_of(stem.begin() + kFramePrefix.size(), stem.end(),
                     [](char c) { return c >= '0' && c <= '9'; });
}

// An earlier run's pictures would pass for this one's.
Result<void> remove_frames(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> frames;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    if (is_frame(at->path())) frames.push_back(at->path());
  }
  for (const auto& frame : frames) {
    if (!error) std::filesystem::remove(frame, error);
  }
  if (!error) return {};
  return Error{ErrorKind::file_system, folder.string() + ": removing the pictures of an earlier " +
                                           "run failed: " + error.message()};
}

}  // namespace

Result<void> make_folder(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!error && std::filesystem::is_directory(path, error)) return {};
  const auto reason = error ? error.message() : std::string("it is there and is no folder");
  return Error{ErrorKind::file_system, path.string() + ": making the folder failed: " + reason};
}

Result<Headless> Headless::open(Scene scene, LoadedVolume loaded, const HeadlessOptions& options) {
  Headless run(options);
  if (!options.frames.empty()) {
    if (auto made = make_folder(options.frames); !made) return made.error();
    if (auto removed = remove_frames(options.frames); !removed) return removed.error();
  }
  run.options_.document.measure = !options.stats.empty();
  auto document = Document::open(std::move(scene), std::move(loaded), run.options_.document);
  if (!document) return document.error();
  run.document_ = *std::move(document);
  const auto last_frame = count_frames(run.document_->scene(), run.document_->plan()) - 1;
  run.frame_digits_ = std::max<std::size_t>(3, std::to_string(last_frame).size());
  if (options.view) {
    run.progress_.show("preparing the device");
    auto view = View::create(*run.document_, *options.view);
    if (!view) return view.error();
    run.view_ = *std::move(view);
  }
  if (options.verbose) run.note_what_is_used();
  run.note_warnings();
  return run;
}

void Headless::note(const std::string& sentence) {
  if (options_.quiet) return;
  progress_.clear();
  std::fprintf(stderr, "maille: note: %s\n", sentence.c_str());
}

void Headless::note_what_is_used() {
  const auto& statistics = document_->statistics();
  note("threads: " + std::to_string(statistics.machine.threads));
  if (view_) {
    const auto& info = view_->renderer().device().info();
    note("device: " + info.name + ", " + info.driver +
         (view_->renderer().sparse_store() ? ", sparse image" : ", dense image"));
  }
  std::string left_out;
  for (const auto& name : statistics.left_out) left_out += (left_out.empty() ? "" : ", ") + name;
  note("left out: " + left_out);
}

void Headless::note_warnings() {
  const auto* table = std::get_if<MaterialTable>(&document_->scene().materials);
  // A preset is meant as it is: only who wants to know everything hears of it.
  if (table == nullptr && options_.verbose && document_->plan().chainmail) {
    table = &document_->deformer().materials().table();
  }
  if (table == nullptr) return;
  for (const auto& warning : table->warnings()) note(warning);
  const auto& relaxation = document_->statistics().relaxation;
  if (relaxation && relaxation->stiffness_clamped) note(*relaxation->stiffness_clamped);
}

void Headless::note_dropped_steps() {
  if (noted_dropped_steps_ || document_->undo_steps_dropped() == 0) return;
  noted_dropped_steps_ = true;
  note("the oldest undo steps are dropped to hold --undo-memory " +
       text_of_bytes(options_.document.undo_memory_bytes));
}

void Headless::note_limited_relaxation() {
  const auto& relaxation = document_->statistics().relaxation;
  if (noted_limited_relaxation_ || !relaxation || !relaxation->region_limited) return;
  noted_limited_relaxation_ = true;
  const auto budget = options_.document.lattice_memory_bytes;
  note("relaxation moves " + std::to_string(relaxation->free_elements) + " of " +
       std::to_string(voxel_count(document_->volume().size())) +
       " elements, those around what was disturbed, and holds the others: " +
       (budget ? "--lattice-memory " + text_of_bytes(*budget) + " leaves memory for no more"
               : "a quarter of the machine's memory is enough for no more (--lattice-memory)"));
}

Result<void> Headless::show() {
  if (shown_) return {};
  shown_ = true;
  return view_->show(document_->take_view());
}

Result<void> Headless::write_picture(const std::filesystem::path& path) {
  if (auto shown = show(); !shown) return shown;
  const auto picture = view_->picture();
  if (!picture) return picture.error();
  return write_png(path, *picture);
}

Result<std::optional<PickHit>> Headless::pick(glm::ivec2 pixel) {
  if (auto shown = show(); !shown) return shown.error();
  return view_->pick(pixel, view_->size());
}

Result<void> Headless::write_frame() {
  if (!view_ || options_.frames.empty()) return {};
  auto number = std::to_string(frames_written_++);
  number.insert(0, frame_digits_ - std::min(frame_digits_, number.size()), '0');
  return write_picture(options_.frames / (std::string(kFramePrefix) + number + ".png"));
}

Result<void> Headless::drag(const DragAction& action) {
  glm::dvec3 from(0.0);
  if (const auto* const voxel = std::get_if<FromVoxel>(&action.from)) {
    from = voxel->voxel;
  } else {
    const glm::dvec2 at = std::get<FromPixel>(action.from).pixel;
    const auto size = view_->size();
    const auto place = "(" + std::to_string(static_cast<std::int64_t>(at.x)) + ", " +
                       std::to_string(static_cast<std::int64_t>(at.y)) + ")";
    if (!(at.x < size.x && at.y < size.y)) {
      return Error{ErrorKind::usage, "from.pixel: " + place + " lies outside the picture of " +
                                         std::to_string(size.x) + "x" + std::to_string(size.y)};
    }
    const auto hit = pick(glm::ivec2(glm::floor(at)));
    if (!hit) return hit.error();
    if (!hit.value()) {
      return Error{ErrorKind::usage, "from.pixel: nothing is to be seen at " + place};
    }
    from = view_->rest_voxel(hit.value()->voxel);
  }
  const glm::dvec3 last(document_->volume().size() - 1);
  const VoxelIndex element(glm::clamp(glm::round(from), glm::dvec3(0.0), last));
  int step = 0;
  DragReport reached;
  auto dragged = document_->drag(action, element, [&](const DragReport& report) -> Result<void> {
    shown_ = false;
    reached = report;
    progress_.show("drag " + std::to_string(++step) + " of " + std::to_string(action.steps));
    return write_frame();
  });
  if (reached.clamped) {
    char sentence[96];
    std::snprintf(sentence, sizeof sentence, "an anchor let the drag go %.1f voxels far",
                  glm::length(reached.moved_by_voxels));
    note(sentence + (action.name.empty() ? "" : ": " + action.name));
  }
  return dragged;
}

Result<void> Headless::play(std::size_t index) {
  const Action& action = document_->scene().actions[index];
  if (const auto* const drag_action = std::get_if<DragAction>(&action)) return drag(*drag_action);
  if (const auto* const render = std::get_if<RenderAction>(&action)) {
    return view_ ? write_picture(render->to) : Result<void>();
  }
  if (const auto* const save = std::get_if<SaveAction>(&action)) return document_->save(*save);

  shown_ = false;
  Result<void> done;
  if (const auto* const relax = std::get_if<RelaxAction>(&action)) {
    if (!document_->plan().relaxation) return {};
    progress_.show("relaxing");
    done = document_->relax(*relax);
  } else if (const auto* const release = std::get_if<ReleaseAction>(&action)) {
    done = document_->release(*release);
  } else if (const auto* const cut = std::get_if<CutAction>(&action)) {
    done = document_->cut(*cut);
  } else if (const auto* const carve = std::get_if<CarveAction>(&action)) {
    done = document_->carve(*carve);
  } else if (const auto* const restore = std::get_if<RestoreAction>(&action)) {
    done = document_->restore(*restore);
  } else if (const auto* const undo = std::get_if<UndoAction>(&action)) {
    done = document_->undo(undo->count);
  } else {
    done = document_->redo(std::get<RedoAction>(action).count);
  }
  return done ? write_frame() : done;
}

Result<void> Headless::play() {
  if (auto written = write_frame(); !written) return written;
  const Scene& scene = document_->scene();
  for (std::size_t i = 0; i < scene.actions.size(); ++i) {
    if (auto done = play(i); !done) return in_action(scene, i, done.error());
    note_dropped_steps();
    note_limited_relaxation();
  }
  return {};
}

Result<void> Headless::finish() {
  progress_.clear();
  auto& statistics = document_->statistics();
  document_->measure_state();
  if (view_) view_->report(statistics);
  if (!options_.stats.empty()) {
    statistics.machine.triad_gb_per_s = measure_triad_gb_per_s(statistics.machine.threads);
    if (auto written = write_text_file(options_.stats, to_json(statistics)); !written) {
      return written;
    }
  }
  if (!options_.trace.empty()) {
    if (auto written = trace::write(options_.trace); !written) return written;
  }
  if (!view_) return {};
  const auto messages = view_->renderer().take_validation_messages();
  if (messages.empty()) return {};
  std::string all = "the validation layer has " + std::to_string(messages.size()) + " complaints:";
  for (const auto& message : messages) all += "\n" + message;
  return Error{ErrorKind::failed, all};
}

}  // namespace maille
