#include "deform/spring_forces.h"

#include <cmath>

#include "core/several_widths.h"

namespace maille {

Springs springs_of(glm::dvec3 spacing_mm) {
  constexpr std::array<glm::ivec3, 18> kOffsets = {{
      {1, 0, 0},
      {-1, 0, 0},
      {0, 1, 0},
      {0, -1, 0},
      {0, 0, 1},
      {0, 0, -1},
      {1, 1, 0},
      {-1, -1, 0},
      {1, -1, 0},
      {-1, 1, 0},
      {1, 0, 1},
      {-1, 0, -1},
      {1, 0, -1},
      {-1, 0, 1},
      {0, 1, 1},
      {0, -1, -1},
      {0, 1, -1},
      {0, -1, 1},
  }};
  Springs springs;
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const glm::ivec3 o = kOffsets[s];
    const glm::vec3 rest_mm = -glm::vec3(glm::dvec3(o) * spacing_mm);
    springs[s] = {o, (o.z * kSpringHaloEdge + o.y) * kSpringHaloEdge + o.x, rest_mm,
                  glm::length(rest_mm)};
  }
  return springs;
}

namespace {

template <bool kSomeMissing>
[[gnu::always_inline]] inline void add_up(const HaloRow& row, const Springs& springs,
                                          float rest_vector_blend, const std::uint32_t* missing,
                                          RowForces& forces) {
  // By value: through the references the compiler must fear that a force overwrites its inputs.
  const HaloRow in = row;
  float force_x[kBrickEdge] = {};
  float force_y[kBrickEdge] = {};
  float force_z[kBrickEdge] = {};
  const float plain = 1.0f - rest_vector_blend;
  [[maybe_unused]] std::uint32_t bit = 1;
  for (const Spring& spring : springs) {
    const int j = spring.halo_step;
    const float rest_x = spring.rest_mm.x;
    const float rest_y = spring.rest_mm.y;
    const float rest_z = spring.rest_mm.z;
    const float rest_length = spring.length_mm;
    for (int x = 0; x < kBrickEdge; ++x) {
      const float du_x = in.u_x_mm[x] - in.u_x_mm[x + j];
      const float du_y = in.u_y_mm[x] - in.u_y_mm[x + j];
      const float du_z = in.u_z_mm[x] - in.u_z_mm[x + j];
      const float p_x = rest_x + du_x;
      const float p_y = rest_y + du_y;
      const float p_z = rest_z + du_z;
      float k = 2.0f / (in.compliance[x] + in.compliance[x + j]);
      if constexpr (kSomeMissing) k = missing[x] & bit ? 0.0f : k;
      // A pair at zero distance has no direction: p is 0, and so is its force.
      const float length = std::sqrt(p_x * p_x + p_y * p_y + p_z * p_z + 1e-30f);
      const float along = plain * k * (1.0f - rest_length / length);
      const float straight = rest_vector_blend * k;
      force_x[x] -= along * p_x + straight * du_x;
      force_y[x] -= along * p_y + straight * du_y;
      force_z[x] -= along * p_z + straight * du_z;
    }
    if constexpr (kSomeMissing) bit <<= 1;
  }
  for (int x = 0; x < kBrickEdge; ++x) {
    forces.x[x] = force_x[x];
    forces.y[x] = force_y[x];
    forces.z[x] = force_z[x];
  }
}

}  // namespace

MAILLE_FOR_SEVERAL_WIDTHS
void add_up_forces(const HaloRow& row, const Springs& springs, float rest_vector_blend,
                   RowForces& forces) {
  add_up<false>(row, springs, rest_vector_blend, nullptr, forces);
}

MAILLE_FOR_SEVERAL_WIDTHS
void add_up_forces_left(const HaloRow& row, const Springs& springs, float rest_vector_blend,
                        const std::uint32_t* missing, RowForces& forces) {
  add_up<true>(row, springs, rest_vector_blend, missing, forces);
}

}  // namespace maille
