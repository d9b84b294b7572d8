// The references of resampling at work on a scene: what they show, and their time on one thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "measure/timing.h"
#include "references/paper_values.h"
#include "references/paper_walk.h"
#include "volume/brick.h"

namespace maille {

// Of voxels of a box, x fastest.
struct ReferenceAnswer {
  Timing timing;
  std::vector<float> values;           // NaN where it has none
  std::vector<glm::vec3> rest_voxels;  // empty: not what it is about
};

struct PaperAnswer {
  PaperMethod method;
  ReferenceAnswer answer;
};
struct PaperAnswers {
  std::vector<WalkedVoxel> walked;
  std::vector<PaperAnswer> values;  // by the three methods; their time is the walk's and their own
};

// values: of each element.
PaperAnswers run_paper(const DeformedElements& elements, std::span<const double> values,
                       const VoxelBox& voxels, PaperWalkOptions::Neighbours neighbours,
                       const RunLimit& limit);

// Its value is the volume's, trilinear; beyond the border elements theirs.
ReferenceAnswer run_fixed_point(const DeformedElements& elements, std::span<const double> values,
                                const VoxelBox& voxels, int iterations, const RunLimit& limit);

}  // namespace maille
