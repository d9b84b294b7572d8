#include "measure/drag_scene.h"

#include <cmath>
#include <memory>
#include <new>
#include <random>
#include <span>

#include <sys/mman.h>

#include "volume/phantom.h"

namespace maille {
namespace {

constexpr double kSoft = 0.2;     // slack, voxels
constexpr double kStiff = 0.004;  // two units of the lattice
constexpr double kStiffness = 100.0;

Volume cube_of(int edge, std::vector<std::uint8_t> samples) {
  return Volume::of(Size3(edge), VoxelType::uint8, axis_aligned(glm::dvec3(1)), std::move(samples));
}

template <class F>
std::vector<std::uint8_t> samples_of(int edge, F&& value) {
  std::vector<std::uint8_t> samples;
  samples.reserve(static_cast<std::size_t>(voxel_count(Size3(edge))));
  for (int z = 0; z < edge; ++z) {
    for (int y = 0; y < edge; ++y) {
      for (int x = 0; x < edge; ++x) samples.push_back(value(VoxelIndex(x, y, z)));
    }
  }
  return samples;
}

}  // namespace

Deformer DragScene::deformer() const {
  return Deformer(volume, std::move(MaterialTable::create(materials)).value(), {});
}

Result<void> DragScene::play_before(Deformer& deformer, WorkerPool& pool) const {
  for (const Grab& done : before) {
    if (auto begun = deformer.begin_stroke(done.element, done.radius_voxels); !begun) return begun;
    if (auto drag = deformer.drag_to(done.by_voxels, pool); !drag) return drag.error();
    deformer.end_stroke();
    deformer.release_all();
  }
  return {};
}

Material slack_material(std::string name, int value, double slack, double stiffness) {
  Material material;
  material.name = std::move(name);
  material.value_low = value;
  material.value_high = value + 1;
  material.compress = glm::dvec3(1.0 - slack);
  material.stretch = glm::dvec3(1.0 + slack);
  material.shear = glm::dvec3(slack);
  material.stiffness = stiffness;
  return material;
}

Volume empty_volume(Size3 size) {
  const auto bytes = static_cast<std::size_t>(voxel_count(size));
  void* const pages =
      mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (pages == MAP_FAILED) throw std::bad_alloc();
  std::shared_ptr<const void> owner(pages, [bytes](void* address) { munmap(address, bytes); });
  const std::span samples(static_cast<const std::byte*>(pages), bytes);
  return Volume(size, VoxelType::uint8, axis_aligned(glm::dvec3(1)), samples, std::move(owner));
}

std::int64_t Octahedron::elements() const {
  const std::int64_t r = half_axis;
  return (2 * r + 1) * (2 * r * r + 2 * r + 3) / 3;
}

double Octahedron::drag_voxels() const {
  // Half a link further than the last element that moves, in the slack as the table rounds it.
  return (half_axis + 0.5) * std::floor(kSoft * kUnitsPerVoxel) / kUnitsPerVoxel;
}

Octahedron octahedron_of(std::int64_t elements) {
  Octahedron octahedron;
  while (octahedron.elements() < elements) ++octahedron.half_axis;
  if (octahedron.half_axis == 0) return octahedron;
  const Octahedron smaller{octahedron.half_axis - 1};
  return elements - smaller.elements() < octahedron.elements() - elements ? smaller : octahedron;
}

DragScene uniform_scene(std::string name, std::string title, Size3 size, Octahedron moved,
                        glm::dvec3 direction) {
  const VoxelIndex middle = size / 2 / kBrickEdge * kBrickEdge;
  return {std::move(name),
          std::move(title),
          empty_volume(size),
          {slack_material("soft", 0, kSoft, 1.0)},
          {},
          {middle, 0.0, moved.drag_voxels() * direction}};
}

Size3 volume_around(Octahedron moved) {
  // The middle is a multiple of 32 and has half_axis elements and a margin on each side.
  const int bricks = (moved.half_axis + 2 + kBrickEdge - 1) / kBrickEdge;
  return Size3(2 * bricks * kBrickEdge);
}

DragScene second_grab_scene(std::string name, std::string title, Octahedron moved,
                            glm::dvec3 direction) {
  const int aside = moved.half_axis / 4;
  const Size3 size = volume_around(Octahedron{moved.half_axis + aside});
  DragScene scene = uniform_scene(std::move(name), std::move(title), size, moved, direction);
  scene.before = {{scene.grab.element + VoxelIndex(aside, aside / 2, -aside), 0.0,
                   moved.drag_voxels() * glm::dvec3(0.9, 1.0, 0.8)}};
  return scene;
}

DragScene moved_again_scene(int edge, std::uint64_t seed) {
  // Twice as far as in a cube of slack 0.2 throughout the corners would need.
  const double far = 2.0 * kSoft * 3.0 * edge / 2.0;
  DragScene scene = random_scene(edge, 8, soft_and_stiff(), seed, far * glm::dvec3(1.0, -0.9, 0.8));
  scene.name = "moved_again";
  scene.title = "random 8³ blocks, all moved again";
  scene.before = {
      {scene.grab.element + VoxelIndex(edge / 8), 0.0, far * glm::dvec3(0.8, 1.0, 0.9)}};
  return scene;
}

DragScene single_row_scene(int bricks) {
  const int length = bricks * kBrickEdge;
  const double link = std::floor(kStiff * kUnitsPerVoxel) / kUnitsPerVoxel;
  // Along x it passes everything on, across it nothing.
  Material fibre = slack_material("fibre", 0, kStiff, 1.0);
  fibre.shear.x = 100.0;
  return {"single_row",
          "row of " + std::to_string(bricks) + " bricks, 32 elements each",
          empty_volume({length, kBrickEdge, kBrickEdge}),
          {fibre},
          {},
          {VoxelIndex(length, kBrickEdge, kBrickEdge) / 2, 0.0, {(length / 2 + 0.5) * link, 0, 0}}};
}

DragScene stiff_ball_scene(int edge, glm::dvec3 by_voxels) {
  const double radius = edge / 6.0;
  auto samples = samples_of(edge, [&](VoxelIndex voxel) {
    const glm::dvec3 away = glm::dvec3(voxel - VoxelIndex(edge / 2));
    return static_cast<std::uint8_t>(glm::dot(away, away) <= radius * radius ? 1 : 0);
  });
  return {"stiff_ball",
          "stiff ball in soft medium",
          cube_of(edge, std::move(samples)),
          soft_and_stiff(),
          {},
          {VoxelIndex(edge / 2), 0.0, by_voxels}};
}

DragScene random_scene(int edge, int block, std::vector<Material> materials, std::uint64_t seed,
                       glm::dvec3 by_voxels) {
  std::mt19937_64 random(seed);
  const Size3 blocks((edge + block - 1) / block);
  std::vector<std::uint8_t> of_block(static_cast<std::size_t>(voxel_count(blocks)));
  for (auto& kind : of_block) kind = static_cast<std::uint8_t>(random() % materials.size());
  auto samples = samples_of(edge, [&](VoxelIndex voxel) {
    return of_block[static_cast<std::size_t>(linear_index(voxel / block, blocks))];
  });
  std::string title = std::to_string(materials.size()) + " materials at random, a " +
                      (block == 1 ? "voxel" : std::to_string(block) + "³ block") + " each";
  return {block == 1 ? "random_voxels" : "random_blocks",
          std::move(title),
          cube_of(edge, std::move(samples)),
          std::move(materials),
          {},
          {VoxelIndex(edge / 2), 0.0, by_voxels}};
}

std::vector<Material> soft_and_stiff() {
  return {slack_material("soft", 0, kSoft, 1.0), slack_material("stiff", 1, kStiff, kStiffness)};
}

std::vector<Material> three_tissues() {
  std::vector<Material> tissues = {slack_material("soft", 0, 0.3, 0.1),
                                   slack_material("firm", 1, 0.15, 1.0),
                                   slack_material("tough", 2, 0.02, 10.0)};
  const double stretch[] = {1.8, 1.2, 1.05};
  const double shear[] = {0.15, 0.25, 0.01};
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    tissues[i].stretch = glm::dvec3(stretch[i]);
    tissues[i].shear = glm::dvec3(shear[i]);
  }
  return tissues;
}

DragScene anisotropic_scene(int edge, glm::dvec3 by_voxels) {
  Material fibre = slack_material("fibre", 0, kSoft, 1.0);
  fibre.compress = {0.98, 0.9, 0.8};
  fibre.stretch = {1.02, 1.2, 1.4};
  fibre.shear = {0.0, 0.1, 0.3};
  return {"anisotropic",
          "anisotropic slack, oblique drag",
          empty_volume(Size3(edge)),
          {fibre},
          {},
          {VoxelIndex(edge / 2), 0.0, by_voxels}};
}

VoxelIndex nose_of(const Volume& head) {
  constexpr double kSkin = -300.0;
  const Size3 size = head.size();
  for (int y = 0; y + 3 < size.y; ++y) {
    for (int z = 0; z < size.z; ++z) {
      for (int x = 0; x < size.x; ++x) {
        if (head.value_at({x, y, z}) >= kSkin && head.value_at({x, y + 3, z}) >= kSkin) {
          return {x, y + 2, z};
        }
      }
    }
  }
  return size / 2;
}

Result<DragScene> head_scene(int edge, std::uint64_t seed, WorkerPool& pool) {
  auto head = make_phantom("head", Size3(edge), seed, pool);
  if (!head) return head.error();
  const VoxelIndex nose = nose_of(*head);
  // A sixteenth of the volume: as far as the demonstration pulls it, and a little aside.
  const double length = edge / 16.0;
  return DragScene{"head_nose",
                   "the built-in head, CT materials, nose pulled",
                   *std::move(head),
                   MaterialTable::ct().materials(),
                   {},
                   {nose, edge / 64.0, glm::dvec3(0.25, -1.0, 0.125) * length}};
}

}  // namespace maille
