// A pinhole camera in the world.
//
// Picture positions are in pixels: (0,0) is the top left corner of the picture, the centre of pixel
// (i,j) is (i + 0.5, j + 0.5). World is LPS in mm.
#pragma once

#include <optional>

#include <glm/glm.hpp>

#include "core/spaces.h"

namespace maille {

using PictureSize = glm::ivec2;  // width, height in pixels, both >= 1

struct Camera {
  glm::dvec3 eye_mm{0, -600, 0};
  glm::dvec3 target_mm{0, 0, 0};
  glm::dvec3 up{0, 0, 1};              // any length, not along the view
  double vertical_fov_degrees = 30.0;  // 0 < f < 180
  bool operator==(const Camera&) const = default;
};

// Unit vectors of the picture in the world. A camera that looks along its own up, or at its own
// eye, gets some basis rather than none.
struct CameraBasis {
  glm::dvec3 right, down, forward;
};
CameraBasis basis_of(const Camera& camera);

struct Ray {
  glm::dvec3 origin_mm;
  glm::dvec3 direction;  // unit
};

Ray ray_through(const Camera& camera, PictureSize size, glm::dvec2 position);
inline Ray ray_through_pixel(const Camera& camera, PictureSize size, glm::ivec2 pixel) {
  return ray_through(camera, size, glm::dvec2(pixel) + 0.5);
}

// The unnormalised ray direction is linear in the picture position:
// direction(position) = corner + position.x * across + position.y * along. What shaders are given.
struct RayFan {
  glm::dvec3 eye_mm, corner, across, along;
};
RayFan fan_of(const Camera& camera, PictureSize size);

// Where a world point appears; nullopt on and behind the plane of the eye.
std::optional<glm::dvec2> project(const Camera& camera, PictureSize size, glm::dvec3 point_mm);

// The point seen at a picture position on the plane that faces the camera and holds `anchor_mm`: a
// drag keeps what it grabbed at its depth. nullopt if the anchor is not in front of the eye.
std::optional<glm::dvec3> point_on_facing_plane(const Camera& camera, PictureSize size,
                                                glm::dvec2 position, glm::dvec3 anchor_mm);

// The whole volume from the front: looking along +y (towards the back of a patient), +z up.
Camera framing(Size3 volume_size, const glm::dmat4& world_from_voxel, PictureSize size);

// Pointer moves in pixels -> the camera they lead to. The target stays in orbit, roll and zoom.
// Half a turn a picture height; what is in front of the target follows the pointer.
Camera orbited(const Camera& camera, PictureSize size, glm::dvec2 move);
// The target follows the pointer.
Camera panned(const Camera& camera, PictureSize size, glm::dvec2 move);
// Factor 2: half as far.
Camera zoomed(const Camera& camera, double factor);
// The picture turns clockwise.
Camera rolled(const Camera& camera, double degrees);

}  // namespace maille
