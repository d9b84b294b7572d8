// Moves the elements of a box along a direction without folding a cell.
//
// The step is right for nearly all elements and far too bold for a few around a hard pull. There it
// is taken back, by halves, until no corner of a cell that was open comes near folding; then the
// elements around corners near folding are moved one by one to where their own energy is least
// (Newton's method on three unknowns, springs and corners, never across J = 0), again and again,
// and those of a small cluster then all together (fold_cluster.h). So the few do not rule the step
// of all, and what is stiff in them is gone before the next one.
//
// A start found at half the resolution is far away, and on a straight way there many cells fold
// that are open at its end: a leap does not mind the way (2.8 million elements: 0.05 s where six
// guarded steps take 0.32).
#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "deform/fold_energy.h"

namespace maille {

class FoldGuard {
 public:
  // Finds the corners near folding of the state the box is in. Throws std::bad_alloc.
  FoldGuard(SpringBox& box, WorkerPool& pool);

  // Adds `step` times a direction to the state. furthest_voxels: no element moves further by a step
  // of 1. Elements near folding are settled until they move by less than enough_voxels. Returns the
  // step that was added: half of it, or less, where all of it would close not a few corners but
  // many, and none further than a few times the largest displacement, of which floats would lose
  // the digits that corners need.
  template <class Vectors>
  double advance(const Vectors& direction, double step, double furthest_voxels,
                 double enough_voxels);

  // Adds a direction to the state as a whole, however many corners that folds, and opens those from
  // there. False where one that was open stays folded: the state is what it was. scratch: of the
  // box's extent.
  bool leap(const BoxVectors& direction, double furthest_voxels, double enough_voxels,
            BoxVectors& scratch);

  // Corners with an energy, by rising element.
  const std::vector<CellCorner>& bent() const { return bent_; }
  double energy() const;
  void add_forces(BoxVectors& forces) const;
  double curvature(const BoxDirection& direction) const;

  // Of the elements in the wall of a corner, by rising element: the root of the share that springs
  // have of their stiffness, the wall the rest.
  struct SpringShare {
    std::int64_t element = 0;
    float root = 1.0f;
  };
  std::vector<SpringShare> spring_shares() const;

  // Of the state that the guard was made with.
  double largest_u_voxels() const { return folds_.largest_u_voxels(); }

  // Corners that are folded, as they were when the guard was made.
  std::int64_t folded() const { return folded_; }

 private:
  struct RowMeasure {
    float least = 0.0f;         // J of its cells
    float longest_edge = 0.0f;  // in voxels
    double travelled = -1.0;    // when it was measured; -1: never
  };

  template <class Vectors>
  void add(const Vectors& direction, double step);
  // After no element has moved further than that since the last time.
  std::vector<CellCorner> find_near(double furthest_voxels);
  template <class Vectors>
  std::size_t closed_by(const std::vector<CellCorner>& near, const Vectors& direction,
                        double step) const;
  template <class Vectors>
  std::vector<std::int64_t> take_back(const std::vector<CellCorner>& near, const Vectors& direction,
                                      double step);
  bool open_folded(std::vector<CellCorner> near, double enough_voxels);
  std::vector<std::int64_t> free_elements_of(const std::vector<CellCorner>& corners) const;
  void add_neighbours(std::vector<std::int64_t>& elements) const;
  void settle(const std::vector<std::int64_t>& elements, double enough_voxels);
  void settle_clusters(const std::vector<std::int64_t>& elements);
  void note_moved(const std::vector<std::int64_t>& elements);
  void find_bent(const std::vector<CellCorner>& near, const std::vector<std::int64_t>& moved);

  SpringBox& box_;
  WorkerPool& pool_;
  FoldEnergy folds_;
  std::vector<RowMeasure> rows_;  // of cells, by the row of their lowest corners
  double travelled_voxels_ = 0.0;
  std::vector<CellCorner> bent_;
  std::int64_t folded_ = 0;
};

}  // namespace maille
