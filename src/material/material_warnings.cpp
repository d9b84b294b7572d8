#include "material/material_warnings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace maille {
namespace {

constexpr double kAgreement = 4.0;
constexpr double kSmallestStrain = 1.0 / 512.0;  // one fixed-point unit, in voxels

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

// Nobody minds the digits of a large one.
std::string ratio(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), value < 10.0 ? "%.3g" : "%.0f", value);
  return text.data();
}

std::string quoted(const Material& m) { return "\"" + m.name + "\""; }

// One of the nine ways in which a link may give way.
struct Direction {
  glm::dvec3 Material::*limit;
  double at_rest;  // what the limit is where there is no room
  const char* name;
  const char* further;
  int axis;

  double strain(const Material& m) const { return std::abs((m.*limit)[axis] - at_rest); }
  // Only where the axes of one of the two differ is it worth saying which.
  std::string along(const Material& a, const Material& b) const {
    const auto uniform = [&](const Material& m) {
      return m.*limit == glm::dvec3((m.*limit)[axis]);
    };
    return uniform(a) && uniform(b) ? "" : std::string(" along ") + "xyz"[axis];
  }
};

std::vector<Direction> directions() {
  std::vector<Direction> all;
  for (int axis = 0; axis < 3; ++axis) {
    all.push_back({&Material::compress, 1.0, "compress", "be compressed further", axis});
    all.push_back({&Material::stretch, 1.0, "stretch", "stretch further", axis});
    all.push_back({&Material::shear, 0.0, "shear", "shear further", axis});
  }
  return all;
}

void add_folds(const std::vector<Material>& materials, std::vector<std::string>& sentences) {
  for (const Material& m : materials) {
    const auto c = component_that_may_fold(m.compress, m.shear);
    if (!c) continue;
    sentences.push_back("material " + quoted(m) + ": compress " + number(m.compress[*c]) +
                        " is not above twice shear " + number(m.shear[*c]) +
                        ": a drag may fold its cells");
  }
}

void add_unnoticeable(const std::vector<const Material*>& deformable,
                      std::vector<std::string>& sentences) {
  for (const Material* m : deformable) {
    double most = 0.0;
    for (const Direction& d : directions()) most = std::max(most, d.strain(*m));
    if (most == 0.0 || most >= kSmallestStrain) continue;
    sentences.push_back("material " + quoted(*m) +
                        ": its limits are below 1/512 voxel: it acts as rigid");
  }
}

using Pair = std::pair<const Material*, const Material*>;

// deformable: by rising stiffness. Returns the pairs it named, the stiffer one first.
std::vector<Pair> add_wider_though_stiffer(const std::vector<const Material*>& deformable,
                                           std::vector<std::string>& sentences) {
  std::vector<Pair> named;
  for (const Material* stiff : deformable) {
    const Material* narrower = nullptr;
    Direction worst{};
    double worst_difference = 0.0;
    for (const Material* soft : deformable) {
      if (soft->stiffness >= stiff->stiffness) break;
      for (const Direction& d : directions()) {
        const double difference = d.strain(*stiff) - d.strain(*soft);
        if (difference <= worst_difference) continue;
        worst_difference = difference;
        worst = d;
        narrower = soft;
      }
    }
    if (!narrower) continue;
    named.emplace_back(stiff, narrower);
    sentences.push_back("material " + quoted(*stiff) + ": is stiffer than " + quoted(*narrower) +
                        " (" + number(stiff->stiffness) + " against " +
                        number(narrower->stiffness) + ") but may " + worst.further +
                        worst.along(*stiff, *narrower) + " (" +
                        number((stiff->*worst.limit)[worst.axis]) + " against " +
                        number((narrower->*worst.limit)[worst.axis]) + ")");
  }
  return named;
}

void add_disagreement(const std::vector<const Material*>& deformable,
                      const std::vector<Pair>& named, std::vector<std::string>& sentences) {
  const Material* strongest = nullptr;
  const Material* weakest = nullptr;
  Direction worst{};
  double worst_ratio = kAgreement;
  for (const Direction& d : directions()) {
    const auto force = [&](const Material* m) { return m->stiffness * d.strain(*m); };
    std::vector<const Material*> giving;
    std::copy_if(deformable.begin(), deformable.end(), std::back_inserter(giving),
                 [&](const Material* m) { return d.strain(*m) > 0.0; });
    if (giving.empty()) continue;
    const auto [least, most] = std::minmax_element(
        giving.begin(), giving.end(),
        [&](const Material* a, const Material* b) { return force(a) < force(b); });
    const double times = force(*most) / force(*least);
    if (times <= worst_ratio) continue;
    worst_ratio = times;
    worst = d;
    weakest = *least;
    strongest = *most;
  }
  if (!strongest) return;
  if (std::find(named.begin(), named.end(), Pair{strongest, weakest}) != named.end()) return;
  sentences.push_back("limits and stiffness disagree: it takes " + ratio(worst_ratio) +
                      " times the force to bring " + quoted(*strongest) + " to its " + worst.name +
                      " limit" + worst.along(*strongest, *weakest) + " that it takes with " +
                      quoted(*weakest));
}

void add_disagreement_between(const std::vector<Material>& materials,
                              std::vector<std::string>& sentences) {
  const Material* lower = nullptr;
  double worst_ratio = kAgreement;
  for (std::size_t i = 1; i < materials.size(); ++i) {
    const Material& a = materials[i - 1];
    const Material& b = materials[i];
    if (a.fixed || a.rigid || b.fixed || b.rigid) continue;
    for (const Direction& d : directions()) {
      const double at_ends = std::max(a.stiffness * d.strain(a), b.stiffness * d.strain(b));
      const double halfway =
          std::sqrt(a.stiffness * b.stiffness) * 0.5 * (d.strain(a) + d.strain(b));
      if (halfway <= worst_ratio * at_ends) continue;
      worst_ratio = halfway / at_ends;
      lower = &a;
    }
  }
  if (!lower) return;
  sentences.push_back("limits and stiffness disagree between " + quoted(*lower) + " and " +
                      quoted(*(lower + 1)) + ", where they are interpolated: halfway it takes " +
                      ratio(worst_ratio) + " times the force to come to the limits");
}

}  // namespace

std::vector<std::string> warnings_of(const std::vector<Material>& materials,
                                     Interpolation interpolation) {
  std::vector<const Material*> deformable;
  for (const Material& m : materials) {
    if (!m.fixed && !m.rigid) deformable.push_back(&m);
  }
  std::stable_sort(deformable.begin(), deformable.end(), [](const Material* a, const Material* b) {
    return a->stiffness < b->stiffness;
  });
  std::vector<std::string> sentences;
  add_folds(materials, sentences);
  const auto named = add_wider_though_stiffer(deformable, sentences);
  add_unnoticeable(deformable, sentences);
  add_disagreement(deformable, named, sentences);
  if (interpolation == Interpolation::linear) add_disagreement_between(materials, sentences);
  return sentences;
}

}  // namespace maille
