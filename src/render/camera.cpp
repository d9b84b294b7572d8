#include "render/camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille {
namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

// Rodrigues' formula; axis is a unit vector.
glm::dvec3 turned(glm::dvec3 v, glm::dvec3 axis, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return v * c + glm::cross(axis, v) * s + axis * glm::dot(axis, v) * (1.0 - c);
}

// Half the picture's height at distance 1.
double half_height(const Camera& camera) {
  return std::tan(0.5 * radians(std::clamp(camera.vertical_fov_degrees, 1e-3, 179.0)));
}

}  // namespace

CameraBasis basis_of(const Camera& camera) {
  CameraBasis basis;
  basis.forward = camera.target_mm - camera.eye_mm;
  const double distance = glm::length(basis.forward);
  basis.forward = distance > 0.0 ? basis.forward / distance : glm::dvec3(0, 1, 0);
  basis.right = glm::cross(basis.forward, camera.up);
  if (glm::length(basis.right) <= 1e-9 * glm::length(camera.up)) {
    // Along up: any direction across will do, the least aligned axis gives a stable one.
    const glm::dvec3 f = glm::abs(basis.forward);
    const glm::dvec3 axis = f.x <= f.y && f.x <= f.z ? glm::dvec3(1, 0, 0)
                            : f.y <= f.z             ? glm::dvec3(0, 1, 0)
                                                     : glm::dvec3(0, 0, 1);
    basis.right = glm::cross(basis.forward, axis);
  }
  basis.right = glm::normalize(basis.right);
  basis.down = glm::cross(basis.forward, basis.right);
  return basis;
}

RayFan fan_of(const Camera& camera, PictureSize size) {
  const CameraBasis basis = basis_of(camera);
  const double pixel = 2.0 * half_height(camera) / size.y;  // height of a pixel at distance 1
  RayFan fan;
  fan.eye_mm = camera.eye_mm;
  fan.across = basis.right * pixel;
  fan.along = basis.down * pixel;
  fan.corner = basis.forward - fan.across * (0.5 * size.x) - fan.along * (0.5 * size.y);
  return fan;
}

Ray ray_through(const Camera& camera, PictureSize size, glm::dvec2 position) {
  const RayFan fan = fan_of(camera, size);
  return {fan.eye_mm,
          glm::normalize(fan.corner + position.x * fan.across + position.y * fan.along)};
}

std::optional<glm::dvec2> project(const Camera& camera, PictureSize size, glm::dvec3 point_mm) {
  const CameraBasis basis = basis_of(camera);
  const glm::dvec3 to_point = point_mm - camera.eye_mm;
  const double depth = glm::dot(to_point, basis.forward);
  if (!(depth > 0.0)) return std::nullopt;
  const double pixels = size.y / (2.0 * half_height(camera) * depth);
  return glm::dvec2(0.5 * size.x + glm::dot(to_point, basis.right) * pixels,
                    0.5 * size.y + glm::dot(to_point, basis.down) * pixels);
}

std::optional<glm::dvec3> point_on_facing_plane(const Camera& camera, PictureSize size,
                                                glm::dvec2 position, glm::dvec3 anchor_mm) {
  const CameraBasis basis = basis_of(camera);
  const double depth = glm::dot(anchor_mm - camera.eye_mm, basis.forward);
  if (!(depth > 0.0)) return std::nullopt;
  const RayFan fan = fan_of(camera, size);
  // The unnormalised direction has depth 1.
  return camera.eye_mm + depth * (fan.corner + position.x * fan.across + position.y * fan.along);
}

Camera framing(Size3 volume_size, const glm::dmat4& world_from_voxel, PictureSize size) {
  Camera camera;
  camera.vertical_fov_degrees = 30.0;
  camera.up = {0, 0, 1};
  const glm::dvec3 last = glm::dvec3(volume_size) - 1.0;
  camera.target_mm = transform_point(world_from_voxel, 0.5 * last);

  // The nearest eye from which every corner of the volume is within the picture.
  const double tan_y = half_height(camera);
  const double tan_x = tan_y * size.x / size.y;
  double distance = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 voxel{(corner & 1) != 0 ? last.x + 0.5 : -0.5,
                           (corner & 2) != 0 ? last.y + 0.5 : -0.5,
                           (corner & 4) != 0 ? last.z + 0.5 : -0.5};
    const glm::dvec3 from_target = transform_point(world_from_voxel, voxel) - camera.target_mm;
    const double nearer = -from_target.y;  // the view runs along +y
    distance = std::max({distance, nearer + std::abs(from_target.x) / tan_x,
                         nearer + std::abs(from_target.z) / tan_y});
  }
  constexpr double kAir = 1.05;  // so that nothing touches the picture's border
  camera.eye_mm = camera.target_mm - glm::dvec3(0, kAir * distance, 0);
  return camera;
}

Camera orbited(const Camera& camera, PictureSize size, glm::dvec2 move) {
  const CameraBasis basis = basis_of(camera);
  const double angle_a_pixel = std::numbers::pi / size.y;
  // The volume turns with the pointer, so the eye goes the other way.
  const glm::dvec3 up = -basis.down;
  glm::dvec3 from_target = camera.eye_mm - camera.target_mm;
  from_target = turned(from_target, up, -move.x * angle_a_pixel);
  const glm::dvec3 right = turned(basis.right, up, -move.x * angle_a_pixel);
  from_target = turned(from_target, right, -move.y * angle_a_pixel);
  Camera result = camera;
  result.eye_mm = camera.target_mm + from_target;
  result.up = turned(up, right, -move.y * angle_a_pixel);
  return result;
}

Camera panned(const Camera& camera, PictureSize size, glm::dvec2 move) {
  const CameraBasis basis = basis_of(camera);
  const double distance = glm::length(camera.target_mm - camera.eye_mm);
  const double mm_a_pixel = 2.0 * half_height(camera) * distance / size.y;
  const glm::dvec3 shift = -(basis.right * move.x + basis.down * move.y) * mm_a_pixel;
  Camera result = camera;
  result.eye_mm += shift;
  result.target_mm += shift;
  return result;
}

Camera zoomed(const Camera& camera, double factor) {
  Camera result = camera;
  result.eye_mm = camera.target_mm + (camera.eye_mm - camera.target_mm) / factor;
  return result;
}

Camera rolled(const Camera& camera, double degrees) {
  const CameraBasis basis = basis_of(camera);
  Camera result = camera;
  // The camera turns anticlockwise for the picture to turn clockwise.
  result.up = turned(-basis.down, basis.forward, -radians(degrees));
  return result;
}

}  // namespace maille
