#include "deform/rim_pull.h"

#include <algorithm>
#include <cmath>

namespace maille {
namespace {

// Calls f(element) for the rim beyond which the volume goes on.
template <class F>
void for_each_rim_element(const SpringBox& box, const VoxelBox& whole, F&& f) {
  const Size3 extent = box.extent();
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (const bool high : {false, true}) {
      const bool goes_on = high ? box.free_box().hi[axis] < whole.hi[axis]
                                : box.free_box().lo[axis] > whole.lo[axis];
      if (!goes_on) continue;
      glm::ivec3 at(0);
      at[axis] = high ? extent[axis] - 1 : 0;
      for (at[v] = 1; at[v] < extent[v] - 1; ++at[v]) {
        for (at[u] = 1; at[u] < extent[u] - 1; ++at[u]) f(at);
      }
    }
  }
}

}  // namespace

std::vector<glm::dvec3> rim_forces(const SpringBox& box, const VoxelBox& whole) {
  std::vector<glm::dvec3> forces;
  for_each_rim_element(box, whole, [&](glm::ivec3 at) {
    const std::int64_t e = box.element(at.x, at.y, at.z);
    glm::dvec3 force(0.0);
    for (int s = 0; s < kSprings; ++s) {
      const Spring& spring = box.springs()[static_cast<std::size_t>(s)];
      const glm::ivec3 there = at + spring.offset;
      if (glm::any(glm::lessThan(there, glm::ivec3(0))) ||
          glm::any(glm::greaterThanEqual(there, box.extent()))) {
        continue;
      }
      const std::int64_t other = e + box.step(s);
      if (!box.is_free(other)) continue;
      glm::dvec3 du;
      for (std::size_t c = 0; c < 3; ++c) {
        du[static_cast<int>(c)] = double{box.u_mm()[c][e]} - double{box.u_mm()[c][other]};
      }
      const glm::dvec3 p = glm::dvec3(spring.rest_mm) + du;
      const double length = std::sqrt(glm::dot(p, p) + 1e-30);
      double rest_length = double{spring.length_mm};
      if (box.keeps()) {
        const glm::dvec3 kept = box.kept_mm(e, s);
        rest_length = glm::length(glm::dvec3(spring.rest_mm) + kept);
        du -= kept;
      }
      const double blend = 0.5 * (double{box.blend(e)} + double{box.blend(other)});
      force -= double{box.stiffness(e, s)} *
               ((1.0 - blend) * (1.0 - rest_length / length) * p + blend * du);
    }
    forces.push_back(force);
  });
  return forces;
}

double rim_pull_voxels(const SpringBox& box, const VoxelBox& whole,
                       const std::vector<glm::dvec3>& before) {
  const std::vector<glm::dvec3> now = rim_forces(box, whole);
  double furthest = 0.0;
  std::size_t i = 0;
  for_each_rim_element(box, whole, [&](glm::ivec3 at) {
    const std::int64_t e = box.element(at.x, at.y, at.z);
    const glm::dvec3 force = now[i] - before[i];
    ++i;
    // All its springs are as stiff as its own material, near enough.
    const double stiffness = kSprings / double{box.compliance(e)};
    if (!(stiffness > 0.0)) return;
    furthest = std::max(furthest, glm::length(force / stiffness / box.spacing_mm()));
  });
  const Size3 extent = box.extent();
  return furthest * std::max({extent.x, extent.y, extent.z});
}

}  // namespace maille
