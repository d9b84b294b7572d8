#include "app/demo_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "app/document.h"

namespace maille {
namespace {

constexpr double kDragVoxels = 25.0;
constexpr double kShareOfExtent = 0.08;
constexpr int kSteps = 25;
constexpr int kVoxelsBehind = 3;  // that must be tissue too, for a voxel to count as skin

// The volume's axis that runs closest along an axis of the world.
int axis_along(const Volume& volume, int world_axis) {
  const auto& m = volume.world_from_voxel();
  const auto spacing = volume.spacing_mm();
  int best = 0;
  for (int axis = 1; axis < 3; ++axis) {
    const auto share = [&](int a) { return std::abs(m[a][world_axis]) / spacing[a]; };
    if (share(axis) > share(best)) best = axis;
  }
  return best;
}

// The box, in voxels, around what reaches surface_value, without its outermost hundredths: a wire,
// a table's edge or noise must not push the camera away. Every fourth voxel tells enough.
struct Extent {
  glm::dvec3 low{0.0};
  glm::dvec3 high{0.0};
};
Extent extent_of(const Volume& volume, double surface_value) {
  constexpr int kStride = 4;
  constexpr double kTrimmed = 0.01;
  const Size3 size = volume.size();
  const glm::ivec3 counts = (size + (kStride - 1)) / kStride;
  std::array<std::vector<std::int64_t>, 3> occupied;
  for (int axis = 0; axis < 3; ++axis) {
    occupied[static_cast<std::size_t>(axis)].resize(static_cast<std::size_t>(counts[axis]));
  }
  std::int64_t all = 0;
  for (int z = 0; z < counts.z; ++z) {
    for (int y = 0; y < counts.y; ++y) {
      for (int x = 0; x < counts.x; ++x) {
        if (!(volume.value_at(VoxelIndex(x, y, z) * kStride) >= surface_value)) continue;
        ++occupied[0][static_cast<std::size_t>(x)];
        ++occupied[1][static_cast<std::size_t>(y)];
        ++occupied[2][static_cast<std::size_t>(z)];
        ++all;
      }
    }
  }
  Extent extent{glm::dvec3(0.0), glm::dvec3(size - 1)};
  if (all == 0) return extent;
  const auto trimmed = static_cast<std::int64_t>(kTrimmed * static_cast<double>(all));
  for (int axis = 0; axis < 3; ++axis) {
    const auto& along = occupied[static_cast<std::size_t>(axis)];
    std::size_t first = 0;
    std::size_t last = along.size() - 1;
    for (std::int64_t seen = along[first]; seen <= trimmed && first < last;) seen += along[++first];
    for (std::int64_t seen = along[last]; seen <= trimmed && last > first;) seen += along[--last];
    extent.low[axis] = static_cast<double>(first) * kStride;
    extent.high[axis] = static_cast<double>(last) * kStride;
  }
  return extent;
}

// From the front, turned towards the patient's left and a little above.
CameraSettings three_quarter_view(const Volume& volume, double surface_value) {
  const auto extent = extent_of(volume, surface_value);
  const auto& world = volume.world_from_voxel();
  CameraSettings camera;
  const auto edges = glm::max(extent.high - extent.low, glm::dvec3(1.0));  // of flat ones too
  const double radius_mm = 0.5 * glm::length(transform_vector(world, edges));
  // The corners of the box are empty: a head is round.
  const double distance_mm =
      0.85 * radius_mm / std::sin(glm::radians(camera.vertical_fov_degrees) / 2);
  const double turned = glm::radians(52.0);
  const double raised = glm::radians(6.0);
  const glm::dvec3 towards_eye(std::sin(turned) * std::cos(raised),
                               -std::cos(turned) * std::cos(raised), std::sin(raised));
  camera.target_mm = transform_point(world, 0.5 * (extent.low + extent.high));
  camera.eye_mm = *camera.target_mm + distance_mm * towards_eye;
  return camera;
}

}  // namespace

Scene built_in_scene() {
  Scene scene;
  scene.volume = PhantomSource{"head", {224, 256, 256}, 1};
  return scene;
}

Protrusion most_anterior(const Volume& volume, double surface_value) {
  const Size3 size = volume.size();
  const int depth_axis = axis_along(volume, 1);
  int width_axis = axis_along(volume, 0);
  if (width_axis == depth_axis) width_axis = (depth_axis + 1) % 3;
  const int height_axis = 3 - depth_axis - width_axis;
  const bool front_is_low = volume.world_from_voxel()[depth_axis][1] >= 0;

  Protrusion found;
  found.tip = size / 2;
  found.outward = glm::ivec3(0);
  found.outward[depth_axis] = front_is_low ? -1 : 1;

  const int deep = size[depth_axis];
  const auto voxel_at = [&](int depth, int across, int up) {
    VoxelIndex voxel;
    voxel[depth_axis] = front_is_low ? depth : deep - 1 - depth;
    voxel[width_axis] = across;
    voxel[height_axis] = up;
    return voxel;
  };
  const auto is_skin = [&](int depth, int across, int up) {
    for (int behind = 0; behind <= kVoxelsBehind && depth + behind < deep; ++behind) {
      if (!(volume.value_at(voxel_at(depth + behind, across, up)) >= surface_value)) return false;
    }
    return true;
  };
  const int first_across = size[width_axis] / 3;
  const int last_across = size[width_axis] - 1 - first_across;
  const int first_up = size[height_axis] / 5;
  const int last_up = size[height_axis] - 1 - first_up;
  for (int depth = 0; depth < deep; ++depth) {
    std::vector<VoxelIndex> plane;
    for (int up = first_up; up <= last_up; ++up) {
      for (int across = first_across; across <= last_across; ++across) {
        if (is_skin(depth, across, up)) plane.push_back(voxel_at(depth, across, up));
      }
    }
    if (plane.empty()) continue;
    // Of the foremost, the one nearest to their middle.
    glm::dvec3 middle(0.0);
    for (const auto& voxel : plane) middle += glm::dvec3(voxel) / static_cast<double>(plane.size());
    found.tip = *std::min_element(plane.begin(), plane.end(), [&](VoxelIndex a, VoxelIndex b) {
      return glm::distance(glm::dvec3(a), middle) < glm::distance(glm::dvec3(b), middle);
    });
    return found;
  }
  return found;
}

void add_demonstration(Scene& scene, const Volume& volume, const VolumeStatistics& range) {
  const auto* const preset = std::get_if<TransferPreset>(&scene.transfer_function);
  const bool ct = looks_like_hounsfield(volume, range);
  const auto transfer = preset == nullptr ? std::get<TransferFunction>(scene.transfer_function)
                                          : *TransferFunction::preset(ct ? "ct-skin" : "relative",
                                                                      range.lowest, range.highest);
  const auto protrusion = most_anterior(volume, transfer.surface_value());
  const int axis = protrusion.outward.x != 0 ? 0 : protrusion.outward.y != 0 ? 1 : 2;
  const int room = protrusion.outward[axis] < 0 ? protrusion.tip[axis]
                                                : volume.size()[axis] - 1 - protrusion.tip[axis];
  const double extent = volume.size()[axis];
  const double length = std::max(
      1.0, std::floor(std::min({kDragVoxels, kShareOfExtent * extent, std::max(room - 2.0, 1.0)})));
  DragAction drag;
  const auto inside =
      glm::clamp(protrusion.tip - 2 * protrusion.outward, glm::ivec3(0), volume.size() - 1);
  drag.from = FromVoxel{glm::dvec3(inside)};
  drag.radius_voxels = std::max(2.0, length / 7.0);
  drag.by = glm::dvec3(protrusion.outward) * length;
  drag.steps = kSteps;
  drag.name = "nose";
  scene.actions = {drag, RelaxAction{}};
  if (!scene.camera.eye_mm && !scene.camera.target_mm) {
    scene.camera = three_quarter_view(volume, transfer.surface_value());
  }
}

}  // namespace maille
