// ChainMail, exactly: the least movement that keeps every link within its limits.
//
// For each component alone the limits are a system of difference constraints, and moving a handle
// by D asks for its longest-path (max-plus) closure: with delta the amount an element has to move,
//
//     delta_j = max(0, max over neighbours i of (delta_i - slack_ij)),   delta_handle = D,
//
// where slack_ij >= 0 is how far i may move before it pushes j. The operator is monotone and its
// fixed point unique, so bricks may be closed in any order and by any number of workers and give
// the same bits. Enhanced ChainMail (Schill 1998) is Dijkstra's algorithm on the three components
// together and stops each element after one visit, which leaves violated links in mixed material;
// first in first out (Gibson 1997) leaves many more.
//
// A fixed element is an upper bound on delta: since every label falls by the same amount as D does,
// the overshoot at the worst anchor is exactly what the drag has to give up.
#pragma once

#include <cstdint>
#include <limits>

#include "core/parallel.h"
#include "deform/anchors.h"
#include "deform/lattice.h"
#include "deform/stroke_bricks.h"

namespace maille {

struct ChainMailProblem {
  const Lattice& start;      // within the limits, or as relaxation left it: a link outside
                             // its limits counts as having no slack and gets no worse
  StrokeBricks& bricks;      // materials, cuts and anchors
  const ElementSet& handle;  // moves as one
  // 0: bricks with the highest labels first. Else any order, of this seed: it changes the time and
  // no bit, which is a test.
  std::uint32_t brick_order = 0;
  // What the labels of one component may take at once.
  std::int64_t most_label_bytes = std::numeric_limits<std::int64_t>::max();
};

struct ChainMailAnswer {
  Lattice lattice;
  glm::ivec3 moved_by{0};  // fixed point: the drag, less what anchors held back
  bool clamped = false;
  std::int64_t elements_moved = 0;  // elements with a label above 0 in some component
  std::int64_t bricks_swept = 0;    // how often a brick was closed; depends on the workers
  // Labels, and what is there of the answer, at most at once; beside it each worker has half a
  // megabyte, however much moves.
  std::int64_t working_bytes = 0;
};

// by: fixed point, each component within +-2^29. Throws std::bad_alloc and Failure (out_of_memory:
// more labels than allowed; file_system: the start could not be read back from its scratch file).
ChainMailAnswer solve_chainmail(const ChainMailProblem& problem, glm::ivec3 by, WorkerPool& pool);

}  // namespace maille
