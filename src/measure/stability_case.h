// The sweep that stability answers for: everything that a person, a scan or a table of materials
// can do to ChainMail and relaxation, each pushed to its ends (design: numbers we answer to).
//
// Small problems, since each is held against an equilibrium in double precision.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "measure/stroke.h"

namespace maille {

struct StabilityCase {
  std::string group;  // what is swept: small letters and underscores
  std::string title;  // what this one is, within its group
  Volume volume;
  std::vector<Material> materials;
  AnchorRules anchors;
  std::function<Result<void>(Deformer&)> before;  // cuts and carves; none: nothing
  std::vector<Grab> grabs;  // dragged one after the other; all stay pinned where they end
  // Where the elements are put in place of ChainMail's answer, 1/512 voxel, x fastest; empty: they
  // are not. For starts that no drag leads to.
  std::vector<glm::ivec3> start;
};

// The groups there are, in the order of the sweep.
const std::vector<std::string>& stability_groups();

// The cases of these groups (none: of all). edge: of the blocks, voxels, at least 8.
std::vector<StabilityCase> stability_cases(int edge, std::uint64_t seed,
                                           const std::vector<std::string>& groups);

}  // namespace maille
