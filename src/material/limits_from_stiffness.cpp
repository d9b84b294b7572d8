#include "material/limits_from_stiffness.h"

#include <algorithm>
#include <limits>

namespace maille {
namespace {

double softest_stiffness(const std::vector<Material>& materials) {
  double of_all = std::numeric_limits<double>::infinity();
  double of_deformable = of_all;
  for (const Material& m : materials) {
    of_all = std::min(of_all, m.stiffness);
    if (!m.fixed && !m.rigid) of_deformable = std::min(of_deformable, m.stiffness);
  }
  return of_deformable < std::numeric_limits<double>::infinity() ? of_deformable : of_all;
}

}  // namespace

Result<std::vector<Material>> limits_from_stiffness(std::vector<Material> materials,
                                                    const SoftestLimits& softest) {
  const auto expectation = expectation_of_limits(softest.compress, softest.stretch, softest.shear);
  if (expectation) {
    return Error{ErrorKind::bad_input, "limits of the softest material: " + *expectation};
  }
  if (component_that_may_fold(softest.compress, softest.shear)) {
    return Error{ErrorKind::bad_input,
                 "limits of the softest material: expected compress above twice shear"};
  }
  for (Material& m : materials) {
    m.compress = softest.compress;
    m.stretch = softest.stretch;
    m.shear = softest.shear;
    if (auto refusal = refusal_of(m)) return *std::move(refusal);
  }
  const double reference = softest_stiffness(materials);
  for (Material& m : materials) {
    const double share = m.rigid ? 0.0 : std::min(1.0, reference / m.stiffness);
    m.compress = 1.0 - share * (1.0 - softest.compress);
    m.stretch = 1.0 + share * (softest.stretch - 1.0);
    m.shear = share * softest.shear;
  }
  return materials;
}

}  // namespace maille
