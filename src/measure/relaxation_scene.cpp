#include "measure/relaxation_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "material/limits_from_stiffness.h"
#include "volume/phantom.h"
#include "volume/volume_file.h"

namespace maille {
namespace {

constexpr int kSheetThickness = 8;

int edge_of(std::int64_t elements) {
  return std::max(8, static_cast<int>(std::lround(std::cbrt(static_cast<double>(elements)))));
}

Material material_of_stiffness(int value, double stiffness) {
  Material material;
  material.name = "k" + std::to_string(value);
  material.value_low = value;
  material.value_high = value + 1;
  material.stiffness = stiffness;
  return material;
}

// With limits that follow from stiffness: no fold from a drag, and no violated link in what is
// stiff.
std::vector<Material> materials_of(const std::vector<double>& stiffness) {
  std::vector<Material> materials;
  for (const double k : stiffness) {
    materials.push_back(material_of_stiffness(static_cast<int>(materials.size()), k));
  }
  return std::move(limits_from_stiffness(std::move(materials))).value();
}

template <class F>
Volume cube_of(Size3 size, F&& value) {
  std::vector<std::uint8_t> samples;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        samples.push_back(static_cast<std::uint8_t>(value(VoxelIndex(x, y, z))));
      }
    }
  }
  return Volume::of(size, VoxelType::uint8, axis_aligned(glm::dvec3(1)), std::move(samples));
}

Volume part_of(const Volume& volume, const VoxelBox& box) {
  return with_voxel_type(volume.type(), [&]<class T>() {
    const auto all = volume.voxels<T>();
    std::vector<T> samples;
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        const auto first = all.begin() + linear_index({box.lo.x, y, z}, volume.size());
        samples.insert(samples.end(), first, first + box.size().x);
      }
    }
    return Volume::of(box.size(), volume.type(), axis_aligned(volume.spacing_mm()),
                      std::move(samples));
  });
}

}  // namespace

RelaxationScene homogeneous_relaxation(std::int64_t elements) {
  const int edge = edge_of(elements);
  const double radius = edge / 12.0;
  return {{"homogeneous",
           "one material",
           empty_volume(Size3(edge)),
           materials_of({1.0}),
           {},
           {VoxelIndex(edge / 2), radius, glm::dvec3(0.8, 0.3, -0.2) * radius}},
          {}};
}

RelaxationScene stiff_ball_relaxation(std::int64_t elements) {
  const int edge = edge_of(elements);
  const double radius = edge / 5.0;
  return {{"stiff_ball",
           "a ball 1000 times stiffer than its medium",
           cube_of(Size3(edge),
                   [&](VoxelIndex v) { return glm::length(glm::dvec3(v - edge / 2)) <= radius; }),
           materials_of({1.0, 1000.0}),
           {},
           {VoxelIndex(edge / 2), edge / 20.0, glm::dvec3(0.8, 0.3, -0.2) * (edge / 12.0)}},
          {}};
}

RelaxationScene random_relaxation(std::int64_t elements, std::uint64_t seed) {
  const int edge = edge_of(elements);
  constexpr int kBlock = 4;
  std::mt19937_64 random(seed);
  const Size3 blocks((edge + kBlock - 1) / kBlock);
  std::vector<std::uint8_t> of_block(static_cast<std::size_t>(voxel_count(blocks)));
  for (auto& kind : of_block) kind = static_cast<std::uint8_t>(random() % 3);
  return {{"random",
           "three materials in random blocks",
           cube_of(Size3(edge),
                   [&](VoxelIndex v) {
                     return of_block[static_cast<std::size_t>(linear_index(v / kBlock, blocks))];
                   }),
           materials_of({0.1, 1.0, 10.0}),
           {},
           {VoxelIndex(edge / 2), edge / 12.0, glm::dvec3(0.8, 0.3, -0.2) * (edge / 24.0)}},
          {}};
}

RelaxationScene sheet_relaxation(std::int64_t elements) {
  const int edge = std::max(
      8, static_cast<int>(std::lround(std::sqrt(static_cast<double>(elements) / kSheetThickness))));
  const Size3 size(edge, edge, kSheetThickness);
  return {{"thin_sheet",
           "a sheet of 8 elements between two edges",
           empty_volume(size),
           materials_of({1.0}),
           {},
           {size / 2, edge / 24.0, glm::dvec3(0.1, 0.0, 1.0) * (edge / 16.0)}},
          {face_low_x | face_high_x, false}};
}

Result<RelaxationScene> nose_relaxation(std::int64_t elements, std::uint64_t seed,
                                        const std::optional<std::filesystem::path>& scan,
                                        WorkerPool& pool) {
  constexpr int kEdgeWithANose = 128;
  const int edge = edge_of(elements);
  auto head = scan ? read_volume(*scan)
                   : make_phantom("head", Size3(std::max(edge, kEdgeWithANose)), seed, pool);
  if (!head) return head.error();
  const Size3 size = (*head).size();
  const VoxelIndex nose = nose_of(*head);
  // Most of it behind the nose.
  const Size3 part = glm::min(Size3(edge), size);
  const VoxelIndex lo =
      glm::clamp(nose - VoxelIndex(part.x / 2, part.y / 4, part.z / 2), VoxelIndex(0), size - part);
  return RelaxationScene{{"head_nose",
                          scan ? "the scan's nose, CT materials" : "the built-in head's nose",
                          part_of(*head, {lo, lo + part}),
                          MaterialTable::ct().materials(),
                          {},
                          {nose - lo, edge / 32.0, glm::dvec3(0.25, -1.0, 0.125) * (edge / 16.0)}},
                         {}};
}

}  // namespace maille
