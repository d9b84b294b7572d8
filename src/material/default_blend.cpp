#include "material/default_blend.h"

#include <algorithm>

namespace maille {

void give_default_blends(std::vector<Material>& materials) {
  constexpr double kOfTheMedium = 0.25;
  std::vector<double> deforming;
  for (const Material& m : materials) {
    if (!m.fixed && !m.rigid) deforming.push_back(m.stiffness);
  }
  std::sort(deforming.begin(), deforming.end());
  // Where nothing deforms any number will do.
  const double medium = deforming.empty() ? 1.0 : deforming[(deforming.size() - 1) / 2];
  double stiffest = medium;
  if (!deforming.empty()) stiffest = deforming.back();
  for (Material& m : materials) {
    if (m.rest_vector_blend) continue;
    // Springs take a rigid material as 1000 times as stiff as the stiffest that is not.
    const double stiffness = m.rigid ? 1000.0 * stiffest : m.stiffness;
    m.rest_vector_blend = kOfTheMedium * std::min(1.0, medium / stiffness);
  }
}

}  // namespace maille
