// What is open: a volume, what deforms it, and what of its state has been shown.
//
// Owned by one thread (the simulation thread, where there is a window). The picture's side gets
// ViewUpdates: immutable, handed over whole, so that a picture never shows half a step. Knows
// nothing of Vulkan.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/plan.h"
#include "app/scene.h"
#include "app/statistics.h"
#include "core/parallel.h"
#include "deform/deformer.h"
#include "resample/resampler.h"
#include "resample/volume_kept.h"
#include "volume/statistics.h"
#include "volume/volume.h"

namespace maille {

struct DocumentOptions {
  std::string command;  // as statistics name it
  Purpose purpose;
  int threads = 0;  // 0: one a hardware thread
  bool deterministic = false;
  bool measure = false;  // statistics are wanted: count violated links too
  std::int64_t undo_memory_bytes = std::int64_t{1} << 30;
  std::optional<std::int64_t> lattice_memory_bytes;
};

// In deterministic mode time decides nothing: a relax action ends when it has converged or after so
// many iterations.
inline constexpr std::int64_t kDeterministicIterations = 500;

// One state of the lattice and what is cut from it, as the picture's side needs it.
struct ViewUpdate {
  std::shared_ptr<const Resampler> resampler;  // null: the volume as it is
  std::vector<std::int64_t> bricks;            // whose voxels differ from the update before
};

struct LoadedVolume {
  Volume volume;
  double seconds = 0.0;                   // that it took
  std::optional<VolumeStatistics> range;  // where somebody has looked for it already
};

// Reads or makes the scene's volume. seed: of phantoms whose scene names none.
Result<LoadedVolume> load_volume(const Scene& scene, std::uint64_t seed);

// A signed type whose lowest value is at most -500.
bool looks_like_hounsfield(const Volume& volume, const VolumeStatistics& range);

class Document {
 public:
  // Decides what is left out; makes what is not. Errors: bad_input (a drag from where nothing can
  // be grabbed, with the key's path).
  static Result<std::unique_ptr<Document>> open(Scene scene, LoadedVolume loaded,
                                                const DocumentOptions& options);

  const Scene& scene() const { return scene_; }
  const Plan& plan() const { return plan_; }
  const Volume& volume() const { return volume_; }
  WorkerPool& pool() { return pool_; }
  RunStatistics& statistics() { return statistics_; }
  bool deterministic() const { return options_.deterministic; }

  // Range of the values; looked for at the first call.
  const VolumeStatistics& range();
  // The scene's, or the default for such a volume. Errors: none that parse_scene lets through.
  Result<TransferFunction> transfer_function();

  // Only where plan().deforms().
  Deformer& deformer() { return *deformer_; }
  const Lattice& lattice() const { return deformer_->lattice(); }
  const Cuts& cuts() const { return deformer_->cuts(); }

  // What a relaxation from the present state may take: what the lattice leaves of --lattice-memory;
  // without one a quarter of the machine's memory.
  std::int64_t relaxation_memory_bytes() const;

  // The state now, against the one handed out before (at first: against the untouched volume).
  ViewUpdate take_view();
  // The voxels that pictures show, which a ViewUpdate's bricks are counted of: the volume's and a
  // margin of what was pulled out of it. Begins at a brick of the lattice's grid as it goes on.
  VoxelBox shown_extent() const;
  // The state now.
  Resampler resampler();

  // Called at each position of a drag, with the lattice as it is there.
  using Step = std::function<Result<void>(const DragReport&)>;
  // Errors of all: usage (what in_action() makes bad input of).
  Result<void> drag(const DragAction& action, VoxelIndex element, const Step& step);
  // Nothing where the plan leaves it out. An undo step only if it moved anything.
  Result<void> relax(const RelaxAction& action);
  Result<void> cut(const CutAction& action);
  Result<void> carve(const CarveAction& action);
  Result<void> restore(const RestoreAction& action);
  Result<void> release(const ReleaseAction& action);
  Result<void> undo(int count);
  Result<void> redo(int count);

  // Writes what is asked for, as the lattice is now. Errors: file_system, usage (format),
  // out_of_memory (material was pulled so far that a volume around it all would not fit).
  Result<void> save(const SaveAction& action);
  Result<void> save_forward_field(const std::filesystem::path& path);

  // Sizes as they are now (and folded cells, where statistics are wanted) go into statistics().
  void measure_state();
  void measure_volume();

  // Undo steps dropped for --undo-memory so far.
  std::int64_t undo_steps_dropped() const;

 private:
  Document(Scene scene, LoadedVolume loaded, const DocumentOptions& options);
  Result<void> check_drags() const;
  MaterialTable material_table();
  void make_deformer();
  glm::dvec3 to_voxel(const ScenePoint& point) const;
  Result<CutSurface> surface_of(const CutAction& action) const;
  Error too_few_steps(const std::string& action, int there, int wanted) const;

  Result<VoxelBox> extent_of(const SaveAction& action, const Resampler& resampler) const;
  Result<void> save_at_rest(const SaveAction& action);

  Scene scene_;
  DocumentOptions options_;
  Plan plan_;
  WorkerPool pool_;
  RunStatistics statistics_;
  Volume volume_;
  std::optional<VolumeStatistics> range_;
  std::optional<Deformer> deformer_;
  Lattice shown_;  // of the last take_view()
  Cuts shown_cuts_;
};

// "FILE: actions[3].drag: MESSAGE": an action that parsed and yet cannot be done is bad input.
Error in_action(const Scene& scene, std::size_t index, const Error& error);

}  // namespace maille
