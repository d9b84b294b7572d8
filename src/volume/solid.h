// A solid made of blended primitives, as a signed distance in mm (negative inside): what the
// formula volumes are built from.
//
// Primitives are joined and carved in order with the polynomial smooth minimum, which changes
// nothing where two distances differ by more than its blend length. So for a block of points most
// primitives can be dropped beforehand without changing one bit of the result, and a head of 150
// primitives costs about ten a voxel. Only + - * / and square root are used, which IEEE 754 rounds
// alike everywhere.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace maille {

// 8^3 sample positions in mm, x fastest, and a ball around them.
struct PointBlock {
  static constexpr int kEdge = 8;
  static constexpr int kCount = kEdge * kEdge * kEdge;
  using Values = std::array<float, kCount>;

  PointBlock(glm::dvec3 first, glm::dvec3 spacing);

  alignas(64) Values x, y, z, abs_x;
  glm::dvec3 center;
  double radius;
};

struct Primitive {
  enum class Kind { ellipsoid, cone, ring, disc };
  Kind kind = Kind::ellipsoid;
  bool is_mirrored = false;  // stands at +x and, as its mirror image, at -x
  glm::dvec3 center{0};      // cone: one end
  glm::dvec3 end{0};         // cone: the other end
  glm::dvec3 radii{1};  // ellipsoid: half axes; cone: the radii at both ends; ring: the y and z
                        // half axes of its middle line, the radius of its tube; disc: its radius
                        // and half thickness
  glm::dmat3 local_from_mm{1.0};  // rotation about the center (not for a cone)
};

Primitive ellipsoid(glm::dvec3 center, glm::dvec3 radii);
Primitive ball(glm::dvec3 center, double radius);
// A segment thickened to a radius that changes along it, with round ends.
Primitive cone(glm::dvec3 from, double from_radius, glm::dvec3 to, double to_radius);
// A tube along an ellipse in the plane through center at right angles to local x.
Primitive ring(glm::dvec3 center, double half_y, double half_z, double tube_radius);
// A round plate with rounded rim in that plane.
Primitive disc(glm::dvec3 center, double radius, double half_thickness);
Primitive mirrored(Primitive primitive);
// Turns local x towards the direction; local z stays as upright as it can.
Primitive facing(Primitive primitive, glm::dvec3 direction);

class Solid {
 public:
  void join(const Primitive& primitive, double blend_mm) { add(primitive, blend_mm, false); }
  void carve(const Primitive& primitive, double blend_mm) { add(primitive, blend_mm, true); }

  struct Range {
    float lowest, highest;  // bounds of the distance over a block
  };

  // The primitives that matter in the block. which is overwritten.
  Range select(const PointBlock& block, std::vector<std::uint16_t>& which) const;
  void evaluate(const PointBlock& block, std::span<const std::uint16_t> which,
                PointBlock::Values& distances) const;
  std::size_t primitive_count() const { return parts_.size(); }

 private:
  void add(const Primitive& primitive, double blend_mm, bool is_carved);

  struct Part {
    Primitive::Kind kind;
    bool is_mirrored;
    bool is_carved;
    float blend;       // mm
    glm::vec3 center;  // mm, as are the others
    glm::vec3 axis;    // cone: end - center
    glm::vec3 radii;
    glm::mat3 local_from_mm;

    // Bounds of the distance over a ball.
    Range range_over(glm::vec3 ball_center, float ball_radius) const;
  };
  template <class F>
  static void with_distance(const Part& part, F&& f);

  std::vector<Part> parts_;
};

}  // namespace maille
