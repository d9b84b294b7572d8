#include "volume/solid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille {
namespace {

constexpr float kFar = 1e6f;

float smooth_min(float a, float b, float blend, float quarter_over_blend) {
  const float h = std::max(blend - std::abs(a - b), 0.0f);
  return std::min(a, b) - h * h * quarter_over_blend;
}

// The distance to an ellipsoid to first order: exact on its surface and of unit slope there. Away
// from it an estimate. The small constants keep the centre, where it is 0/0, at -smallest radius.
struct EllipsoidDistance {
  glm::vec3 c, inverse, inverse_squared;
  glm::mat3 m;
  float tiny0, tiny1;

  float operator()(float x, float y, float z) const {
    const float dx = x - c.x, dy = y - c.y, dz = z - c.z;
    const float px = m[0].x * dx + m[1].x * dy + m[2].x * dz;
    const float py = m[0].y * dx + m[1].y * dy + m[2].y * dz;
    const float pz = m[0].z * dx + m[1].z * dy + m[2].z * dz;
    const float ax = px * inverse.x, ay = py * inverse.y, az = pz * inverse.z;
    const float bx = px * inverse_squared.x, by = py * inverse_squared.y,
                bz = pz * inverse_squared.z;
    const float k0 = std::sqrt(ax * ax + ay * ay + az * az + tiny0);
    const float k1 = std::sqrt(bx * bx + by * by + bz * bz + tiny1);
    return k0 * (k0 - 1.0f) / k1;
  }
};

struct ConeDistance {
  glm::vec3 a, axis;
  float inverse_length_squared, from_radius, radius_change;

  float operator()(float x, float y, float z) const {
    const float dx = x - a.x, dy = y - a.y, dz = z - a.z;
    const float along = (dx * axis.x + dy * axis.y + dz * axis.z) * inverse_length_squared;
    const float t = std::min(std::max(along, 0.0f), 1.0f);
    const float ex = dx - t * axis.x, ey = dy - t * axis.y, ez = dz - t * axis.z;
    return std::sqrt(ex * ex + ey * ey + ez * ez) - (from_radius + t * radius_change);
  }
};

struct RingDistance {
  glm::vec3 c;
  glm::mat3 m;
  float inverse_y, inverse_z, mean, tube;

  float operator()(float x, float y, float z) const {
    const float dx = x - c.x, dy = y - c.y, dz = z - c.z;
    const float px = m[0].x * dx + m[1].x * dy + m[2].x * dz;
    const float py = m[0].y * dx + m[1].y * dy + m[2].y * dz;
    const float pz = m[0].z * dx + m[1].z * dy + m[2].z * dz;
    const float ay = py * inverse_y, az = pz * inverse_z;
    const float in_plane = (std::sqrt(ay * ay + az * az) - 1.0f) * mean;
    return std::sqrt(in_plane * in_plane + px * px) - tube;
  }
};

struct DiscDistance {
  glm::vec3 c;
  glm::mat3 m;
  float flat_radius, half_thickness;  // of the part that is not rounded

  float operator()(float x, float y, float z) const {
    const float dx = x - c.x, dy = y - c.y, dz = z - c.z;
    const float px = m[0].x * dx + m[1].x * dy + m[2].x * dz;
    const float py = m[0].y * dx + m[1].y * dy + m[2].y * dz;
    const float pz = m[0].z * dx + m[1].z * dy + m[2].z * dz;
    const float beyond = std::max(std::sqrt(py * py + pz * pz) - flat_radius, 0.0f);
    return std::sqrt(px * px + beyond * beyond) - half_thickness;
  }
};

glm::dvec3 unit(glm::dvec3 v) { return v / std::sqrt(glm::dot(v, v)); }

}  // namespace

PointBlock::PointBlock(glm::dvec3 first, glm::dvec3 spacing)
    : center(first + spacing * (0.5 * (kEdge - 1))),
      radius(0.5 * (kEdge - 1) * std::sqrt(glm::dot(spacing, spacing))) {
  for (std::size_t i = 0; i < kCount; ++i) {
    x[i] = static_cast<float>(first.x + spacing.x * static_cast<double>(i % kEdge));
    y[i] = static_cast<float>(first.y + spacing.y * static_cast<double>(i / kEdge % kEdge));
    z[i] = static_cast<float>(first.z + spacing.z * static_cast<double>(i / kEdge / kEdge));
    abs_x[i] = std::abs(x[i]);
  }
}

Primitive ellipsoid(glm::dvec3 center, glm::dvec3 radii) {
  Primitive p;
  p.center = center;
  p.radii = radii;
  return p;
}

Primitive ball(glm::dvec3 center, double radius) { return ellipsoid(center, glm::dvec3(radius)); }

Primitive cone(glm::dvec3 from, double from_radius, glm::dvec3 to, double to_radius) {
  Primitive p;
  p.kind = Primitive::Kind::cone;
  p.center = from;
  p.end = to;
  p.radii = {from_radius, to_radius, 0};
  return p;
}

Primitive ring(glm::dvec3 center, double half_y, double half_z, double tube_radius) {
  Primitive p;
  p.kind = Primitive::Kind::ring;
  p.center = center;
  p.radii = {half_y, half_z, tube_radius};
  return p;
}

Primitive disc(glm::dvec3 center, double radius, double half_thickness) {
  Primitive p;
  p.kind = Primitive::Kind::disc;
  p.center = center;
  p.radii = {radius, half_thickness, 0};
  return p;
}

Primitive mirrored(Primitive primitive) {
  primitive.is_mirrored = true;
  return primitive;
}

Primitive facing(Primitive primitive, glm::dvec3 direction) {
  const glm::dvec3 local_x = unit(direction);
  const glm::dvec3 local_y = unit(glm::cross(glm::dvec3(0, 0, 1), local_x));
  primitive.local_from_mm =
      glm::transpose(glm::dmat3(local_x, local_y, glm::cross(local_x, local_y)));
  return primitive;
}

template <class F>
void Solid::with_distance(const Part& part, F&& f) {
  const glm::vec3 r = part.radii;
  switch (part.kind) {
    case Primitive::Kind::ellipsoid: {
      const float least = std::min({r.x, r.y, r.z});
      constexpr float kTiny = 1e-8f;
      return f(EllipsoidDistance{part.center, 1.0f / r, 1.0f / (r * r), part.local_from_mm, kTiny,
                                 kTiny / (least * least)});
    }
    case Primitive::Kind::cone:
      return f(ConeDistance{part.center, part.axis, 1.0f / glm::dot(part.axis, part.axis), r.x,
                            r.y - r.x});
    case Primitive::Kind::ring:
      return f(RingDistance{part.center, part.local_from_mm, 1.0f / r.x, 1.0f / r.y,
                            0.5f * (r.x + r.y), r.z});
    case Primitive::Kind::disc: break;
  }
  f(DiscDistance{part.center, part.local_from_mm, r.x - r.y, r.y});
}

Solid::Range Solid::Part::range_over(glm::vec3 ball_center, float ball_radius) const {
  const glm::vec3 p(is_mirrored ? std::abs(ball_center.x) : ball_center.x, ball_center.y,
                    ball_center.z);
  constexpr float kRounding = 1e-3f;
  if (kind == Primitive::Kind::ellipsoid) {
    // The estimate is (k0 - 1) * k0 / k1 with k0 / k1 between the least and the greatest radius.
    // Its slope has no bound near the centre, but that of k0 has: one over the least radius.
    const float least = std::min({radii.x, radii.y, radii.z});
    const float most = std::max({radii.x, radii.y, radii.z});
    const glm::vec3 scaled = (local_from_mm * (p - center)) / radii;
    const float k0 = std::sqrt(glm::dot(scaled, scaled)), reach = ball_radius / least;
    const auto bound = [&](float outwards, float if_outside, float if_inside) {
      return outwards * (outwards > 0 ? if_outside : if_inside);
    };
    return {bound(std::max(k0 - reach, 0.0f) - 1.0f, least, most) - kRounding,
            bound(k0 + reach - 1.0f, most, least) + kRounding};
  }
  float steepness = 1.0f;
  if (kind == Primitive::Kind::cone) {
    steepness += std::abs(radii.y - radii.x) / std::sqrt(glm::dot(axis, axis));
  } else if (kind == Primitive::Kind::ring) {
    steepness = 0.5f * (radii.x + radii.y) / std::min(radii.x, radii.y);
  }
  float distance = 0;
  with_distance(*this, [&](const auto& f) { distance = f(p.x, p.y, p.z); });
  const float change = steepness * ball_radius + kRounding;
  return {distance - change, distance + change};
}

void Solid::add(const Primitive& p, double blend_mm, bool is_carved) {
  parts_.push_back({p.kind, p.is_mirrored, is_carved, static_cast<float>(blend_mm),
                    glm::vec3(p.center), glm::vec3(p.end - p.center), glm::vec3(p.radii),
                    glm::mat3(p.local_from_mm)});
}

Solid::Range Solid::select(const PointBlock& block, std::vector<std::uint16_t>& which) const {
  which.clear();
  const glm::vec3 center(block.center);
  const auto radius = static_cast<float>(block.radius);
  Range range{kFar, kFar};
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    const auto [lowest, highest] = part.range_over(center, radius);
    const float most_blended = 0.25f * part.blend;
    if (part.is_carved) {
      if (-lowest < range.lowest - part.blend) continue;
      range = {std::max(range.lowest, -highest), std::max(range.highest, -lowest) + most_blended};
    } else {
      if (lowest > range.highest + part.blend) continue;
      if (highest + part.blend < range.lowest) {  // nearer than all that came before
        which.clear();
        range = {kFar, kFar};
      }
      range = {std::min(range.lowest, lowest) - most_blended, std::min(range.highest, highest)};
    }
    which.push_back(static_cast<std::uint16_t>(i));
  }
  return range;
}

void Solid::evaluate(const PointBlock& block, std::span<const std::uint16_t> which,
                     PointBlock::Values& distances) const {
  distances.fill(kFar);
  for (const auto index : which) {
    const Part& part = parts_[index];
    const auto& x = part.is_mirrored ? block.abs_x : block.x;
    const float blend = part.blend, quarter_over_blend = blend > 0 ? 0.25f / blend : 0.0f;
    with_distance(part, [&](const auto& distance) {
      if (part.is_carved) {
        for (std::size_t i = 0; i < distances.size(); ++i) {
          distances[i] = -smooth_min(-distances[i], distance(x[i], block.y[i], block.z[i]), blend,
                                     quarter_over_blend);
        }
      } else {
        for (std::size_t i = 0; i < distances.size(); ++i) {
          distances[i] = smooth_min(distances[i], distance(x[i], block.y[i], block.z[i]), blend,
                                    quarter_over_blend);
        }
      }
    });
  }
}

}  // namespace maille
