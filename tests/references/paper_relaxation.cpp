#include "references/paper_relaxation.h"

#include <algorithm>
#include <bit>

namespace maille {

template <class Real>
PaperRelaxation<Real>::PaperRelaxation(const SpringProblem& problem,
                                       const std::vector<std::uint8_t>& moved, WorkerPool& pool,
                                       const Options& options)
    : problem_(problem),
      springs_(problem, pool),
      epsilon_voxels_(options.epsilon_voxels),
      listed_(springs_.count(), 0) {
  for (std::size_t f = 0; f < DenseSprings::kForward; ++f) {
    const glm::dvec3 rest = glm::dvec3(DenseSprings::kOffsets[f]) * problem.spacing_mm;
    const std::ptrdiff_t step = springs_.step(static_cast<int>(f));
    const Real length = static_cast<Real>(glm::length(rest));
    kinds_[f] = {step, Vector(rest), length};
    kinds_[DenseSprings::kForward + f] = {-step, Vector(-rest), length};
  }
  for (const SpringMaterial& a : problem.materials) {
    for (const SpringMaterial& b : problem.materials) {
      stiffness_.push_back(static_cast<Real>(2.0 / (1.0 / a.stiffness + 1.0 / b.stiffness)));
      blend_.push_back(static_cast<Real>(0.5 * (a.rest_vector_blend + b.rest_vector_blend)));
    }
  }
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
  const std::size_t count = problem_.materials.size();
  const bool one_material = problem_.ids.empty();
  const Vector here = u_mm_[i];
  Vector force(0);
  for (std::uint32_t bits = springs_.springs_of(i); bits != 0; bits &= bits - 1) {
    const Spring& spring = kinds_[static_cast<std::size_t>(std::countr_zero(bits))];
    const std::size_t j = i + static_cast<std::size_t>(spring.step);
    const std::size_t pair =
        one_material ? 0 : std::size_t{problem_.ids[i]} * count + problem_.ids[j];
    const Vector du = u_mm_[j] - here;
    const Vector along = spring.rest_mm + du;
    const Real length = glm::length(along);
    const Real blend = blend_[pair];
    // A pair at zero distance has no direction.
    const Real stretch =
        length > Real(0) ? (Real(1) - blend) * (length - spring.length_mm) / length : Real(0);
    force += stiffness_[pair] * (blend * du + stretch * along);
  }
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
    for (std::uint32_t bits = springs_.springs_of(i); bits != 0; bits &= bits - 1) {
      come_in(i + static_cast<std::size_t>(
                      kinds_[static_cast<std::size_t>(std::countr_zero(bits))].step));
    }
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
