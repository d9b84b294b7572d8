// The same drag for the product and for the references, and the one held against the other.
#pragma once

#include <gtest/gtest.h>

#include "deform/violations.h"
#include "references/exact_dijkstra.h"
#include "tests/deform/lattices.h"
#include "tests/deform/scenes.h"

namespace maille::testing {

inline DenseProblem dense_twin(const Drag& drag, glm::ivec3 by) {
  DenseProblem twin;
  const MaterialTable& table = drag.field.table();
  const bool cut = !drag.cuts.empty();
  twin.size = drag.field.size();
  twin.materials = levels_of(table.materials(), table.interpolation());
  twin.handle = drag.handle;
  twin.held = drag.pinned;
  twin.by = by;
  for_each_voxel(twin.size, [&](VoxelIndex v) {
    twin.ids.push_back(drag.field.at(v));
    twin.start.push_back(drag.start.u(v));
    if (faces_of(v, twin.size) & drag.anchors.faces) twin.held.push_back(v);
    if (!cut) return;
    int removed = 0;
    for (int axis = 0; axis < 3; ++axis) removed |= int{drag.cuts.removed(v, axis)} << axis;
    twin.removed.push_back(static_cast<std::uint8_t>(removed));
  });
  return twin;
}

// Solves a drag and expects of it, in every bit, what Dijkstra's algorithm says, and no link that
// is worse than it was.
inline ChainMailAnswer exactly(const Drag& drag, glm::ivec3 by) {
  const DenseProblem problem = dense_twin(drag, by);
  const DenseAnswer expected = exact_dijkstra(problem);
  ChainMailAnswer answer = drag.by(by);
  EXPECT_EQ(answer.moved_by, expected.moved_by);
  EXPECT_EQ(answer.clamped, expected.moved_by != by);
  std::int64_t differences = 0;
  std::int64_t moved = 0;
  for (std::size_t i = 0; i < expected.u.size(); ++i) {
    differences += answer.lattice.u(voxel_of(i, problem.size)) != expected.u[i];
    moved += expected.u[i] != problem.start[i];
  }
  EXPECT_EQ(differences, 0);
  EXPECT_EQ(answer.elements_moved, moved);
  const Cuts whole(problem.size);
  const Cuts& cuts = drag.cuts.empty() ? whole : drag.cuts;
  const Violations before = violations_of(drag.start, drag.field, cuts);
  const Violations after = violations_of(answer.lattice, drag.field, cuts);
  EXPECT_LE(after.links, before.links);
  EXPECT_LE(after.worst_voxels, before.worst_voxels);
  return answer;
}

// Expects u of every element to be what a formula says.
template <class F>
void expect_displacements(const Lattice& lattice, F&& u_of) {
  std::int64_t differences = 0;
  for_each_voxel(lattice.grid().volume_size(), [&](VoxelIndex v) {
    const glm::ivec3 expected = u_of(v);
    if (lattice.u(v) == expected) return;
    if (differences++ > 0) return;
    EXPECT_EQ(lattice.u(v), expected) << v.x << ' ' << v.y << ' ' << v.z;
  });
  EXPECT_EQ(differences, 0);
}

}  // namespace maille::testing
