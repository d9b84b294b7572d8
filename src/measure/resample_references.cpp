#include "measure/resample_references.h"

#include <limits>

#include "core/stopwatch.h"
#include "references/fixed_point_inverse.h"

namespace maille {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

template <class F>
void for_each_voxel_of(const VoxelBox& voxels, F&& f) {
  std::size_t i = 0;
  for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
    for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
      for (int x = voxels.lo.x; x < voxels.hi.x; ++x, ++i) f(i, glm::dvec3(x, y, z));
    }
  }
}

template <class F>
Timing timed(const RunLimit& limit, F&& f) {
  return timing_of(seconds_of_runs(limit, [&] {
    const Stopwatch clock;
    f();
    return clock.seconds();
  }));
}

}  // namespace

PaperAnswers run_paper(const DeformedElements& elements, std::span<const double> values,
                       const VoxelBox& voxels, PaperWalkOptions::Neighbours neighbours,
                       const RunLimit& limit) {
  PaperAnswers answers;
  const Timing walk = timed(
      limit, [&] { answers.walked = paper_walk(elements, voxels.lo, voxels.hi, {neighbours}); });
  for (const PaperMethod method :
       {PaperMethod::nearest, PaperMethod::barycentric, PaperMethod::rbf}) {
    ReferenceAnswer answer;
    answer.values.assign(answers.walked.size(), kNothing);
    answer.timing = timed(limit, [&] {
      for_each_voxel_of(voxels, [&](std::size_t i, glm::dvec3 point) {
        const WalkedVoxel& walked = answers.walked[i];
        if (!walked.found()) return;
        answer.values[i] =
            static_cast<float>(paper_value(elements, values, walked.element, point, method).value);
      });
    });
    answer.timing.median_seconds += walk.median_seconds;
    answer.timing.least_seconds += walk.least_seconds;
    answer.timing.most_seconds += walk.most_seconds;
    answers.values.push_back({method, std::move(answer)});
  }
  return answers;
}

ReferenceAnswer run_fixed_point(const DeformedElements& elements, std::span<const double> values,
                                const VoxelBox& voxels, int iterations, const RunLimit& limit) {
  ReferenceAnswer answer;
  const auto count = static_cast<std::size_t>(voxel_count(voxels.size()));
  answer.values.resize(count);
  answer.rest_voxels.resize(count);
  answer.timing = timed(limit, [&] {
    for_each_voxel_of(voxels, [&](std::size_t i, glm::dvec3 point) {
      const glm::dvec3 rest = rest_by_fixed_point(elements, point, iterations);
      answer.rest_voxels[i] = glm::vec3(rest);
      answer.values[i] = static_cast<float>(trilinear(elements.size(), values, rest));
    });
  });
  return answer;
}

}  // namespace maille
