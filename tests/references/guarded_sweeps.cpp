#include "references/guarded_sweeps.h"

#include <algorithm>
#include <cmath>

#include "core/stopwatch.h"

namespace maille {
namespace {

// The part of a move after which value_before + part * change is not below least, or no lower than
// it was.
double part_allowed(double before, double after, double least) {
  if (after >= least || after >= before) return 1.0;
  if (before <= least) return 0.0;
  return (before - least) / (before - after);
}

// A little less than what is allowed, so that rounding does not step over.
constexpr double kShort = 1.0 - 1e-9;

// The determinant of each corner is linear in the place of any one of its elements.
glm::dvec3 guarded_by_determinant(const DenseSprings& springs, DisplacementField& u_mm,
                                  std::size_t i, const glm::dvec3& move, double least) {
  double before[32];
  int count = 0;
  springs.for_each_determinant_around(i, u_mm, [&](double j) { before[count++] = j; });
  const glm::dvec3 here = u_mm[i];
  u_mm[i] = here + move;
  double part = 1.0;
  int index = 0;
  springs.for_each_determinant_around(
      i, u_mm, [&](double j) { part = std::min(part, part_allowed(before[index++], j, least)); });
  u_mm[i] = here;
  return part < 1.0 ? part * kShort * move : move;
}

}  // namespace

GuardedAnswer relax_guarded(const SpringProblem& problem, WorkerPool& pool,
                            const GuardedOptions& options) {
  const Stopwatch start;
  const DenseSprings springs(problem, pool);
  DisplacementField u = mm_of(problem.start_voxels, problem.spacing_mm);
  GuardedAnswer answer;
  while (!answer.still && answer.sweeps < options.most_sweeps) {
    ++answer.sweeps;
    double longest = 0.0;
    answer.stopped = 0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      if (springs.held(i)) continue;
      const glm::dvec3 asked =
          -options.step / springs.stiffness_sum(i) * springs.spring_gradient_of(i, u);
      const glm::dvec3 move =
          options.guard == StepGuard::limits
              ? springs.within_limits(i, u, u[i] + asked) - u[i]
              : guarded_by_determinant(springs, u, i, asked, options.least_determinant);
      answer.stopped += move != asked;
      u[i] += move;
      longest = std::max(longest, glm::length(move / problem.spacing_mm));
    }
    answer.still = longest <= options.still_voxels;
  }
  answer.spring_energy = springs.spring_energy(u);
  answer.u_voxels = voxels_of(u, problem.spacing_mm);
  answer.seconds = start.seconds();
  return answer;
}

}  // namespace maille
