#include "material/material.h"

namespace maille {
namespace {

// Keeps limits, and sums of them, far inside what 32-bit displacements can hold.
constexpr double kLargestLimit = 1e5;

bool all_within(const glm::dvec3& v, double low, double high) {
  for (int c = 0; c < 3; ++c) {
    if (!(v[c] >= low && v[c] <= high)) return false;  // a NaN is not within
  }
  return true;
}

}  // namespace

std::optional<std::string> expectation_of_limits(const glm::dvec3& compress,
                                                 const glm::dvec3& stretch,
                                                 const glm::dvec3& shear) {
  if (!all_within(compress, 0.0, 1.0)) return "expected compress within 0 to 1";
  if (!all_within(stretch, 1.0, kLargestLimit)) return "expected stretch within 1 to 100000";
  if (!all_within(shear, 0.0, kLargestLimit)) return "expected shear within 0 to 100000";
  return std::nullopt;
}

std::optional<Error> refusal_of(const Material& material) {
  const auto refuse = [&](const std::string& expected) {
    return Error{ErrorKind::bad_input, "material \"" + material.name + "\": " + expected};
  };
  if (!(material.value_low < material.value_high)) {
    return refuse("expected a value range [low, high) with low < high");
  }
  const auto limits = expectation_of_limits(material.compress, material.stretch, material.shear);
  if (limits) return refuse(*limits);
  if (!(material.stiffness >= 1e-12 && material.stiffness <= 1e12)) {
    return refuse("expected a stiffness within 1e-12 to 1e12");
  }
  const double blend = material.rest_vector_blend.value_or(0.0);
  if (!(blend >= 0.0 && blend <= 1.0)) {
    return refuse("expected a rest-vector blend within 0 to 1");
  }
  if (material.yield_strain && !(*material.yield_strain > 0.0)) {
    return refuse("expected a yield strain above 0, or none");
  }
  return std::nullopt;
}

std::optional<int> component_that_may_fold(const glm::dvec3& compress, const glm::dvec3& shear) {
  for (int c = 0; c < 3; ++c) {
    if (!(compress[c] > 2.0 * shear[c] || shear[c] == 0.0)) return c;
  }
  return std::nullopt;
}

}  // namespace maille
