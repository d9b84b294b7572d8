// A scene played without a window: its actions in order, pictures into files, statistics at the
// end.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "app/document.h"
#include "app/progress.h"
#include "app/view.h"

namespace maille {

struct HeadlessOptions {
  DocumentOptions document;
  std::optional<ViewOptions> view;  // none: no Vulkan
  // A picture a step goes there, in place of an earlier run's; empty: none.
  std::filesystem::path frames;
  std::filesystem::path stats;  // empty: not written, and nothing measured for them
  std::filesystem::path trace;
  bool quiet = false;    // no progress, no notes
  bool verbose = false;  // what is used and what is left out
};

class Headless {
 public:
  // Errors: of the volume, the scene and the device.
  static Result<Headless> open(Scene scene, LoadedVolume loaded, const HeadlessOptions& options);

  Document& document() { return *document_; }
  View* view() { return view_.get(); }  // null without Vulkan

  // All actions of the scene. Errors: bad_input (an action that cannot be done, with its path) and
  // whatever writing and drawing meet.
  Result<void> play();
  // The state now, into a file. Needs a view.
  Result<void> write_picture(const std::filesystem::path& path);
  // What is seen at a pixel of the state now. Needs a view.
  Result<std::optional<PickHit>> pick(glm::ivec2 pixel);

  // Statistics and trace, if wanted. Errors: file_system; failed (the validation layer spoke).
  Result<void> finish();

 private:
  explicit Headless(const HeadlessOptions& options)
      : options_(options), progress_(!options.quiet) {}

  void note(const std::string& sentence);  // on stderr
  void note_what_is_used();
  void note_warnings();  // of the materials

  Result<void> show();
  Result<void> write_frame();
  Result<void> play(std::size_t index);
  void note_dropped_steps();       // once
  void note_limited_relaxation();  // once
  Result<void> drag(const DragAction& action);

  HeadlessOptions options_;
  Progress progress_;
  std::unique_ptr<Document> document_;
  std::unique_ptr<View> view_;
  std::int64_t frames_written_ = 0;
  std::size_t frame_digits_ = 3;
  bool shown_ = false;  // the view shows the state now
  bool noted_dropped_steps_ = false;
  bool noted_limited_relaxation_ = false;
};

// Makes a folder and those above it. Errors: file_system.
Result<void> make_folder(const std::filesystem::path& path);

}  // namespace maille
