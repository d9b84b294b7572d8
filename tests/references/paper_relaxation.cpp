#include "references/paper_relaxation.h"

#include <algorithm>

namespace maille {

template <class Real>
PaperRelaxation<Real>::PaperRelaxation(const SpringProblem& problem,
                                       const std::vector<std::uint8_t>& moved, WorkerPool& pool,
                                       const Options& options)
    : problem_(problem),
      springs_(problem, pool),
      epsilon_voxels_(options.epsilon_voxels),
      listed_(springs_.count(), 0) {
  double stiffest = 0.0;
  for (std::size_t i = 0; i < springs_.count(); ++i) {
    u_mm_.push_back(Vector(problem.start_voxels[i] * problem.spacing_mm));
    if (springs_.held(i)) continue;
    stiffest = std::max(stiffest, springs_.stiffness_sum(i));
    if (!moved[i]) continue;
    listed_[i] = 1;
    list_.push_back(static_cast<std::uint32_t>(i));
  }
  alpha_ = stiffest > 0.0 ? options.alpha / stiffest : 0.0;
}

template <class Real>
typename PaperRelaxation<Real>::Vector PaperRelaxation<Real>::force_on(std::size_t i) const {
  Vector force(0);
  springs_.for_each_spring_of(i, [&](std::size_t j, const DenseSprings::SpringView& spring) {
    const Vector du = u_mm_[j] - u_mm_[i];
    const Vector along = Vector(spring.rest_mm) + du;
    const Real length = glm::length(along);
    Vector pull = Real(spring.blend) * du;
    if (length > Real(0)) {
      pull += Real(1.0 - spring.blend) * (length - Real(spring.length_mm)) / length * along;
    }
    force += Real(spring.stiffness) * pull;
  });
  return force;
}

template <class Real>
void PaperRelaxation<Real>::iterate() {
  ++iterations_;
  element_updates_ += static_cast<std::int64_t>(list_.size());
  move_mm_.resize(list_.size());
  for (std::size_t n = 0; n < list_.size(); ++n) move_mm_[n] = Real(alpha_) * force_on(list_[n]);
  std::vector<std::uint32_t> next;
  const auto come_in = [&](std::size_t i) {
    if (listed_[i] || springs_.held(i)) return;
    listed_[i] = 1;
    next.push_back(static_cast<std::uint32_t>(i));
  };
  for (const std::uint32_t i : list_) listed_[i] = 0;
  for (std::size_t n = 0; n < list_.size(); ++n) {
    const std::size_t i = list_[n];
    u_mm_[i] += move_mm_[n];
    const glm::dvec3 move_voxels = glm::dvec3(move_mm_[n]) / problem_.spacing_mm;
    if (glm::length(move_voxels) < epsilon_voxels_) continue;
    come_in(i);
    springs_.for_each_spring_of(
        i, [&](std::size_t j, const DenseSprings::SpringView&) { come_in(j); });
  }
  list_ = std::move(next);
}

template <class Real>
DisplacementField PaperRelaxation<Real>::displacements_voxels() const {
  DisplacementField u;
  u.reserve(u_mm_.size());
  for (const Vector& v : u_mm_) u.push_back(glm::dvec3(v) / problem_.spacing_mm);
  return u;
}

template class PaperRelaxation<float>;
template class PaperRelaxation<double>;

}  // namespace maille
