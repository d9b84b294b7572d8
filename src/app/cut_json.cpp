#include "app/cut_json.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace maille {
namespace {

constexpr double kMaxCutVoxels = 8e6;  // what CutSurface takes

ScenePoint read_point(const JsonReader& value, bool is_mm) {
  return {value.vector(is_mm ? Bounds::any() : Bounds::between(-kMaxCutVoxels, kMaxCutVoxels)),
          is_mm};
}

// The one of two keys that says where, in mm or in voxels; refused unless one of them is there.
std::optional<std::pair<JsonReader, bool>> place_of(const JsonReader& value,
                                                    const std::string& name) {
  const std::string in_mm = name + "_mm";
  const std::string in_voxels = name + "_voxel";
  if (value.is_object() && value.has(in_mm) == value.has(in_voxels)) {
    value.refuse("expected \"" + in_voxels + "\" or \"" + in_mm + "\"");
  }
  if (value.failed()) return std::nullopt;
  const bool is_mm = value.has(in_mm);
  return std::pair(value.at(is_mm ? in_mm : in_voxels), is_mm);
}

ScenePoint read_center(const JsonReader& value) {
  const auto place = place_of(value, "center");
  return place ? read_point(place->first, place->second) : ScenePoint{};
}

std::vector<ScenePoint> read_points(const JsonReader& value, const std::string& name,
                                    std::size_t least) {
  std::vector<ScenePoint> points;
  const auto place = place_of(value, name);
  if (!place) return points;
  const auto& [list, is_mm] = *place;
  const auto expected = "an array of at least " + std::to_string(least) + " points";
  list.each(expected, [&, mm = is_mm](const JsonReader& point, std::size_t) {
    points.push_back(read_point(point, mm));
  });
  if (points.size() < least) list.refuse_value(expected);
  return points;
}

glm::dvec3 read_direction(const JsonReader& value) {
  const glm::dvec3 direction = value.vector(Bounds::between(-1e9, 1e9));
  if (!value.failed() && !(glm::length(direction) > 1e-9)) {
    value.refuse("expected a direction, got no length");
  }
  return direction;
}

CutDisc read_disc(const JsonReader& value) {
  value.expect_object({"center_voxel", "center_mm", "normal", "radius_mm"});
  return {read_center(value), read_direction(value.at("normal")),
          value.at("radius_mm").number(Bounds::above(0))};
}

CutSweep read_sweep(const JsonReader& value) {
  value.expect_object({"path_voxel", "path_mm", "direction", "depth_mm"});
  return {read_points(value, "path", 2), read_direction(value.at("direction")),
          value.at("depth_mm").number(Bounds::above(0))};
}

}  // namespace

Action read_cut(const JsonReader& value) {
  value.expect_object({"polygon_voxel", "polygon_mm", "disc", "sweep"});
  const auto keys = value.keys();
  if (keys.size() != 1) {
    value.refuse("expected one of \"polygon_voxel\", \"polygon_mm\", \"disc\" and \"sweep\"");
    return CutAction{};
  }
  if (keys[0] == "disc") return CutAction{read_disc(value.at("disc"))};
  if (keys[0] == "sweep") return CutAction{read_sweep(value.at("sweep"))};
  return CutAction{CutPolygon{read_points(value, "polygon", 3)}};
}

Ball read_ball(const JsonReader& value) {
  value.expect_object({"center_voxel", "center_mm", "radius_voxels"});
  return {read_center(value), value.at("radius_voxels").number(Bounds::at_least(0))};
}

}  // namespace maille
