// Keeps the displacements of all states of a lattice within a budget: the present one, those that
// undo would bring back, and those that somebody still looks at.
//
// Bricks that are back at rest are none. Of the others, planes held for undo alone are put aside
// first, then those not read for longest. What one step moves has to fit by itself.
#pragma once

#include <memory>

#include "core/result.h"
#include "deform/lattice.h"
#include "deform/plane_store.h"

namespace maille {

class LatticeMemory {
 public:
  explicit LatticeMemory(std::int64_t budget_bytes)
      : store_(std::make_shared<PlaneStore>(budget_bytes)) {}

  // Whether what a step has just made fits. Errors: out_of_memory.
  Result<void> check(const Lattice& before, const Lattice& now) const;
  // Takes it in, before any other thread sees it. Throws Failure (file_system): nothing is lost,
  // but the budget does not hold.
  void take_in(const Lattice& before, const Lattice& now);
  // What of a state is no part of another one is held for undo alone.
  void prefer(const Lattice& now, const Lattice& before);

  const PlaneStore& store() const { return *store_; }

 private:
  std::shared_ptr<PlaneStore> store_;
};

}  // namespace maille
