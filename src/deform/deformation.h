// All that has been done to a volume: what a person sees, saves and undoes. A copy costs pointers:
// bricks, handles and the table are shared and never change.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deform/anchors.h"
#include "deform/cuts.h"
#include "deform/disturbance.h"
#include "deform/lattice.h"
#include "material/material_table.h"

namespace maille {

// Elements that were grabbed as one and stay where they were left.
struct Handle {
  std::vector<std::string> names;  // more than one where grabs have merged
  ElementSet elements;

  bool has(const std::string& name) const;
  std::int64_t bytes() const;
};
using Handles = std::vector<std::shared_ptr<const Handle>>;

struct Deformation {
  Lattice lattice;
  Cuts cuts;
  Handles handles;
  // Of material that yields: what it keeps (P of springs.h), and the handles released since it has
  // last flown, for relaxation to let it flow.
  Lattice kept;
  Handles released;
  std::shared_ptr<const MaterialTable> materials;
  Disturbance disturbance;
};

}  // namespace maille
