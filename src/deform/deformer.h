// Everything done to a lattice, as a person does it: grab, drag, let go, cut, carve, relax, undo.
//
// A stroke is a function of the lattice at button-down and the total drag: moving the pointer back
// un-deforms, cancelling restores to the bit. Letting go leaves the handle pinned until released.
// Owned by one thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "core/result.h"
#include "deform/anchors.h"
#include "deform/chainmail.h"
#include "deform/cut_surface.h"
#include "deform/deformation.h"
#include "deform/history.h"
#include "deform/lattice_memory.h"
#include "deform/relaxation.h"
#include "material/material_field.h"

namespace maille {

struct DragReport {
  glm::dvec3 moved_by_voxels{0};  // less than asked where an anchor held
  bool clamped = false;
  std::int64_t elements_moved = 0;
  std::int64_t working_bytes = 0;  // of the solver, the answer included, at most at once
  double seconds = 0.0;            // of solving
};

// What a stroke has in memory between two positions of the pointer.
struct StrokeMemory {
  std::int64_t lattice_bytes = 0;   // of the lattice now and at button-down, what they share once
  std::int64_t start_bytes = 0;     // of the lattice at button-down alone
  std::int64_t gathered_bytes = 0;  // StrokeBricks
  std::int64_t elements = 0;        // of the bricks that either lattice holds
};
// And at most at once while a position was answered.
struct StrokePeak {
  std::int64_t lattice_bytes = 0;  // at button-down
  std::int64_t gathered_bytes = 0;
  std::int64_t working_bytes = 0;
  std::int64_t elements = 0;  // of the bricks touched

  std::int64_t bytes() const { return lattice_bytes + gathered_bytes + working_bytes; }
};
StrokePeak peak_of(const DragReport& answer, const StrokeMemory& after);

struct DeformerOptions {
  // What undo and redo may hold, as History counts it. None: no step is kept.
  std::optional<std::int64_t> undo_memory_bytes = std::int64_t{1} << 30;
  // What displacements may take in memory, undo steps included; the rest goes to a scratch file.
  // None: as much as they need.
  std::optional<std::int64_t> lattice_memory_bytes = std::nullopt;
};

// All that a relaxation starts from. Its own copy (pointers, but for what is held), so that the
// deformer may go on while another thread relaxes.
struct RelaxationStart {
  Lattice lattice;
  MaterialField materials;
  Cuts cuts;
  ElementSet held;
  AnchorRules anchors;
  std::optional<VoxelBox> disturbed;  // none: all that has moved
  Yielding yielding = {};

  // This must outlive it.
  Relaxation relax(WorkerPool& pool, const RelaxationOptions& options) const {
    return Relaxation(lattice, materials, cuts, held, anchors, pool, options, disturbed, yielding);
  }
};

class Deformer {
 public:
  Deformer(Volume volume, MaterialTable materials, AnchorRules anchors,
           const DeformerOptions& options = {});
  Deformer(const Deformer&) = delete;  // a stroke's bricks point into it
  Deformer& operator=(const Deformer&) = delete;

  const Lattice& lattice() const { return now_.lattice; }
  const Cuts& cuts() const { return now_.cuts; }
  // What material that has yielded keeps: displacements of its state of rest.
  const Lattice& kept() const { return now_.kept; }
  const MaterialField& materials() const { return materials_; }
  // Acts on the running scene: the next drag or relaxation uses it. One undo step. Errors: usage (a
  // stroke is on).
  Result<void> set_materials(MaterialTable table);

  // Grabs the elements within radius_voxels (rest space) of an element, without carved ones; pinned
  // handles that the ball touches are grabbed along, and the handle answers to their names too.
  // Errors: usage (outside the volume, radius not a number >= 0, all of it carved, a name that
  // another handle has, a stroke already on).
  Result<void> begin_stroke(VoxelIndex element, double radius_voxels, std::string name = "");
  bool in_stroke() const { return stroke_.has_value(); }
  // by_voxels: the total drag since begin_stroke. Errors: usage (no stroke, not finite, or further
  // than 10^6 voxels from rest together with the drags before); out_of_memory (what moves takes
  // more than the lattice's memory: it lies as it did before), file_system (the scratch file).
  Result<DragReport> drag_to(glm::dvec3 by_voxels, WorkerPool& pool);
  StrokeMemory stroke_memory() const;  // all 0 where no stroke is on
  void end_stroke();                   // the handle stays pinned; one undo step
  void cancel_stroke();                // back to the bit

  // What a cut severs, or a ball takes out and puts back, in the lattice as it lies now
  // (cutting.h, carving.h); each one undo step, unless nothing was there to change. Errors: usage
  // (a stroke is on; the radius is no number >= 0, the centre not finite; a volume too long to
  // cut).
  Result<void> cut(const CutSurface& surface);
  Result<void> carve(glm::dvec3 center_voxel, double radius_voxels);
  Result<void> restore(glm::dvec3 center_voxel, double radius_voxels);

  // Unpins; one undo step. Of material that yields the next relaxation keeps a part. Errors: usage
  // (a stroke is on; no handle of that name: the message lists the names).
  Result<void> release(const std::string& name);
  void release_all();
  std::vector<std::string> handle_names() const;

  // Starts relaxing the lattice as it is now, where it has been disturbed since it was last that
  // near to equilibrium; the first form goes on while this is used otherwise, the second may not.
  RelaxationStart relaxation_start(double tolerance_voxels) const;
  Relaxation relax(WorkerPool& pool, const RelaxationOptions& options) const;
  // Takes a state of such a relaxation over, as a part of the undo step before. finished_within:
  // the relaxation's tolerance, once it has finished; kept: its kept_by_flow(). Throws Failure
  // where the scratch file fails.
  void adopt(Lattice relaxed, std::optional<double> finished_within_voxels = std::nullopt,
             const Lattice* kept = nullptr);
  // Call before the first adopt() of a relaxation that should be an undo step of its own.
  void mark_undo_step();

  bool undo();  // false: nothing to undo, or a stroke is on
  bool redo();
  const History* history() const { return history_ ? &*history_ : nullptr; }
  const LatticeMemory* memory() const { return memory_ ? &*memory_ : nullptr; }

 private:
  struct Stroke {
    Deformation before;
    Handle handle;
    std::unique_ptr<ElementSet> pinned;  // by the other handles
    glm::ivec3 by{0};                    // the last drag answered, fixed point
    double furthest_voxels = 0.0;        // from rest, of any element when the stroke began
    std::unique_ptr<StrokeBricks> bricks;
  };

  ElementSet pinned_elements() const;
  ElementSet held_elements() const;
  std::optional<VoxelBox> disturbed(double tolerance_voxels) const;
  Yielding yielding() const;
  void prefer_present(const Deformation& before);
  ChainMailAnswer solve(glm::ivec3 by, WorkerPool& pool);
  Result<void> check_ball(const char* action, glm::dvec3 center, double radius) const;
  void take_over(Cuts cuts);
  void let_loose(const std::shared_ptr<const Handle>& handle);
  void record_step(const Deformation& before);
  bool walk(bool (History::*step)(Deformation&));
  void use_materials();  // of the present state

  Volume volume_;
  AnchorRules anchors_;
  Deformation now_;
  MaterialField materials_;
  std::optional<Stroke> stroke_;
  std::optional<History> history_;
  std::optional<LatticeMemory> memory_;
};

}  // namespace maille
