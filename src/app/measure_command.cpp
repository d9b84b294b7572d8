#include <cstdio>

#include "app/commands.h"
#include "app/progress.h"
#include "app/run_options.h"
#include "measure/chainmail_error_page.h"
#include "measure/frame_page.h"
#include "measure/page.h"
#include "measure/relaxation_error_page.h"
#include "measure/resample_error_page.h"
#include "measure/speed_page.h"
#include "measure/stability_page.h"

namespace maille {
namespace {

std::vector<int> thread_counts(const GlobalOptions& global) {
  if (global.threads > 0) return {global.threads};
  return {1, 2};
}

// What is left to do once the numbers are there.
Result<void> hand_over(const MeasurePage& page, const MeasureOptions& options,
                       const std::string& name, const GlobalOptions& global) {
  if (auto written = write_page(page, options.output, name); !written) return written;
  if (global.quiet) return {};
  const auto path = (options.output / name).string();
  std::printf("%s\n%s.json, .csv and .svg\n", page.table.c_str(), path.c_str());
  return {};
}

}  // namespace

Result<void> run_measure_speed(const MeasureOptions& options, const GlobalOptions& global) {
  if (auto prepared = prepare_folder(options.output); !prepared) return prepared;
  Progress progress(!global.quiet);
  SpeedOptions speed;
  speed.threads = thread_counts(global);
  speed.seed = global.seed;
  speed.progress = [&](const std::string& line) { progress.show(line); };
  const auto report = measure_speed(speed);
  progress.clear();
  if (!report) return report.error();
  return hand_over(page_of(*report), options, "speed", global);
}

Result<void> run_measure_error(const MeasureOptions& options, const GlobalOptions& global) {
  const std::string& stage = options.stage;
  if (stage != "chainmail" && stage != "relaxation" && stage != "resample") {
    return Error{ErrorKind::usage,
                 "--stage: expected a stage that has a page, chainmail, relaxation or resample, "
                 "got " +
                     stage};
  }
  if (stage != "relaxation" && (!options.elements.empty() || !options.head.empty())) {
    return Error{
        ErrorKind::usage,
        "--elements and --head: expected with --stage relaxation only, its scenes are what "
        "they choose"};
  }
  if (stage != "resample" && options.volume_edge) {
    return Error{ErrorKind::usage,
                 "--edge: expected with --stage resample only, its volumes are what it chooses"};
  }
  if (auto prepared = prepare_folder(options.output); !prepared) return prepared;
  Progress progress(!global.quiet);
  const auto show = [&](const std::string& line) { progress.show(line); };
  if (stage == "chainmail") {
    ChainMailErrorOptions error;
    error.threads = thread_counts(global);
    error.seed = global.seed;
    error.progress = show;
    const auto report = measure_chainmail_error(error);
    progress.clear();
    if (!report) return report.error();
    return hand_over(page_of(*report), options, "error_chainmail", global);
  }
  if (stage == "resample") {
    ResampleErrorOptions error;
    error.threads = thread_counts(global);
    if (options.volume_edge) error.edge = *options.volume_edge;
    error.progress = show;
    const ResampleError report = measure_resample_error(error);
    progress.clear();
    return hand_over(page_of(report), options, "error_resample", global);
  }
  RelaxationErrorOptions error;
  error.threads = thread_counts(global);
  error.seed = global.seed;
  error.progress = error.folds.progress = show;
  if (!options.elements.empty()) error.elements = options.elements;
  if (!options.head.empty()) error.head = options.head;
  const auto report = measure_relaxation_error(error);
  progress.clear();
  if (!report) return report.error();
  return hand_over(page_of(*report), options, "error_relaxation", global);
}

Result<void> run_measure_frame(const MeasureOptions& options, const GlobalOptions& global) {
  if (auto prepared = prepare_folder(options.output); !prepared) return prepared;
  Progress progress(!global.quiet);
  FrameOptions frame;
  frame.renderer = view_options(options.picture, global).renderer;
  frame.picture = options.picture;
  if (global.threads > 0) frame.threads = global.threads;
  frame.seed = global.seed;
  frame.progress = [&](const std::string& line) { progress.show(line); };
  const auto report = measure_frame(frame);
  progress.clear();
  if (!report) return report.error();
  return hand_over(page_of(*report), options, "frame", global);
}

Result<void> run_measure_stability(const MeasureOptions& options, const GlobalOptions& global) {
  if (auto prepared = prepare_folder(options.output); !prepared) return prepared;
  Progress progress(!global.quiet);
  StabilityOptions stability;
  if (global.threads > 0) stability.threads = global.threads;
  stability.seed = global.seed;
  stability.edge = options.edge;
  stability.groups = options.groups;
  stability.progress = [&](const std::string& line) { progress.show(line); };
  const auto report = measure_stability(stability);
  progress.clear();
  if (!report) return report.error();
  if (auto done = hand_over(page_of(*report), options, "stability", global); !done) return done;
  using Verdict = StabilityReport::Verdict;
  if ((*report).count(Verdict::fails) + (*report).count(Verdict::says_so) == 0) return {};
  return Error{ErrorKind::failed, "stability: " + (*report).summary()};
}

}  // namespace maille
