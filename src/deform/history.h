// Undo and redo, keeping of each step only what it changed: the lattice and cut bricks that others
// took the place of (what material keeps among them), the handles and the material table if they
// changed.
//
// Bytes of a step: the displacement planes of its bricks that the bricks in their place do not
// share (whether in memory or put aside), its cut bricks, the handles and the table that are not
// those in their place. Whatever is kept for undo alone is so counted by exactly one step, the one
// that took it away, and is freed when that step is dropped. What the present state holds is not
// counted.
//
// Whole snapshots are the road not taken: they keep no more (bricks are shared), but nobody could
// say what dropping one of them frees.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "deform/deformation.h"

namespace maille {

class History {
 public:
  // Holds after every call; the oldest steps are dropped first, and of those undone already the
  // last ones to be redone.
  explicit History(std::int64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  // A step led from one state to the present one. What had been undone is forgotten.
  void record(const Deformation& before, const Deformation& now);
  // The lattice went on by itself, and material flew (relaxation): that belongs to the step before,
  // and redoing leads to where it would have led.
  void extend(const Deformation& before, const Deformation& now);

  // Takes the present state one step back or forth. False: there is none.
  bool undo(Deformation& now);
  bool redo(Deformation& now);

  std::int64_t undo_steps() const { return static_cast<std::int64_t>(undo_.size()); }
  std::int64_t redo_steps() const { return static_cast<std::int64_t>(redo_.size()); }
  std::int64_t bytes() const { return bytes_; }
  std::int64_t budget_bytes() const { return budget_bytes_; }
  std::int64_t dropped_steps() const { return dropped_steps_; }  // for the budget, so far

 private:
  // What the present state gets back.
  struct Step {
    std::vector<Lattice::Change> lattice;  // by rising index
    std::vector<Cuts::Change> cuts;
    std::vector<Lattice::Change> kept;
    std::optional<Handles> handles;
    std::optional<Handles> released;
    std::shared_ptr<const MaterialTable> materials;  // null: the same
    Disturbance disturbance;
    std::int64_t bytes = 0;
  };

  static void count_bytes(Step& step, const Deformation& now);
  static Step take(const Step& step, Deformation& now);  // returns the way back
  void extend(Step& step, const Deformation& before, const Deformation& now);
  bool move(std::deque<Step>& from, std::deque<Step>& to, Deformation& now);
  void push(std::deque<Step>& steps, Step step);
  void hold_budget();

  std::int64_t budget_bytes_;
  std::int64_t bytes_ = 0;
  std::int64_t dropped_steps_ = 0;
  std::deque<Step> undo_;  // the next one at the back, of both
  std::deque<Step> redo_;
};

}  // namespace maille
