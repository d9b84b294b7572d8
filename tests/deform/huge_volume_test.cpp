// Bricks whose voxels have indices beyond 2^31 and 2^32, in a volume mapped from a file of holes:
// what happens there is what happens in a small volume of the same values.
#include <cstdio>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "deform/deformer.h"
#include "deform/violations.h"
#include "tests/core/scratch.h"
#include "tests/deform/lattices.h"
#include "tests/deform/scenes.h"
#include "volume/volume_file.h"

namespace maille {
namespace {

using testing::for_each_voxel;
using testing::material;
using testing::random_volume;
using testing::table;
using testing::workers;

constexpr Size3 kHuge{2048, 2048, 1035};
// The small volume is its last corner, whole bricks from its own.
constexpr VoxelIndex kCorner{1984, 1984, 960};
constexpr Size3 kSmall{64, 64, 75};

std::int64_t resident_bytes() {
  long pages = 0;
  long resident = 0;
  std::ifstream("/proc/self/statm") >> pages >> resident;
  return std::int64_t{resident} * sysconf(_SC_PAGESIZE);
}

// Zero everywhere but in the corner; a file takes the room of what is written only.
std::filesystem::path file_of_holes(const test::Scratch& scratch, const Volume& corner) {
  const auto path = scratch / "huge_2048x2048x1035_uint8.raw";
  std::ofstream file(path, std::ios::binary);
  const auto samples = corner.bytes();
  for (int z = 0; z < kSmall.z; ++z) {
    for (int y = 0; y < kSmall.y; ++y) {
      file.seekp(linear_index(kCorner + VoxelIndex(0, y, z), kHuge));
      const auto first = static_cast<std::size_t>(linear_index({0, y, z}, kSmall));
      file.write(reinterpret_cast<const char*>(&samples[first]), kSmall.x);
    }
  }
  file.close();
  // The corner ends where the volume does.
  EXPECT_EQ(std::filesystem::file_size(path), static_cast<std::uintmax_t>(voxel_count(kHuge)));
  return path;
}

// Whether both hold the very same bricks, bit by bit, the huge one nowhere else.
void expect_same(const Deformer& huge, const Deformer& small) {
  const BrickGrid& there = huge.lattice().grid();
  const BrickGrid& here = small.lattice().grid();
  EXPECT_EQ(huge.lattice().brick_count(), small.lattice().brick_count());
  for_each_voxel(here.bricks(), [&](BrickIndex b) {
    const std::int64_t linear = there.linear(BrickGrid::brick_of(kCorner) + b);
    ASSERT_EQ(there.box(there.brick(linear)).lo, kCorner + b * kBrickEdge);
    const VoxelBox box = here.box(b);
    ASSERT_EQ(there.box(there.brick(linear)).size(), box.size());
    EXPECT_TRUE(same_displacements(huge.lattice().brick(linear),
                                   small.lattice().brick(here.linear(b)), box));
  });
  std::int64_t different_cuts = 0;
  for_each_voxel(kSmall, [&](VoxelIndex v) {
    different_cuts += huge.cuts().carved(kCorner + v) != small.cuts().carved(v);
    for (int axis = 0; axis < 3; ++axis) {
      different_cuts += huge.cuts().removed(kCorner + v, axis) != small.cuts().removed(v, axis);
    }
  });
  EXPECT_EQ(different_cuts, 0);
}

TEST(HugeVolume, BeyondTwoToThe32VoxelsIsAsAnywhere) {
  ASSERT_GT(linear_index(kCorner, kHuge), std::int64_t{1} << 31);
  const VoxelIndex handle{40, 39, 70};
  ASSERT_GT(linear_index(kCorner + handle, kHuge), std::int64_t{1} << 32);
  const std::int64_t before = resident_bytes();
  // Softest at value 0, so that nothing reaches out of the corner.
  const auto materials = [] {
    return table({material(0, 1, 0, 4, 1), material(1, 2, 0.7, 1.3, 0.3), material(2, 3, 1, 1, 0),
                  material(3, 4, 0.2, 2, 0.8)});
  };
  const Volume corner = random_volume(kSmall, 4, 2, 2031);
  const test::Scratch scratch;
  auto mapped = read_volume(file_of_holes(scratch, corner));
  ASSERT_TRUE(mapped.ok()) << mapped.error().message;
  EXPECT_EQ(mapped->value_at(kCorner + handle), corner.value_at(handle));
  Deformer huge(*std::move(mapped), materials(), {face_high_z, false});
  Deformer small(corner, materials(), {face_high_z, false});
  const glm::dvec3 at_corner(kCorner);
  struct Step {
    VoxelIndex handle;
    glm::dvec3 by;
  };
  std::int64_t moved = 0;
  for (const Step& step : {Step{handle, {3, -2, -3.5}}, Step{{36, 50, 68}, {-1, 2, 100}},
                           Step{{55, 34, 50}, {2, 4, 1}}}) {
    ASSERT_TRUE(huge.begin_stroke(kCorner + step.handle, 1.5).ok());
    ASSERT_TRUE(small.begin_stroke(step.handle, 1.5).ok());
    const auto there = huge.drag_to(step.by, workers());
    const auto here = small.drag_to(step.by, workers());
    ASSERT_TRUE(there.ok());
    ASSERT_TRUE(here.ok());
    EXPECT_EQ(there->moved_by_voxels, here->moved_by_voxels);
    EXPECT_EQ(there->clamped, here->clamped);
    EXPECT_EQ(there->elements_moved, here->elements_moved);
    moved += there->elements_moved;
    huge.end_stroke();
    small.end_stroke();
    expect_same(huge, small);
    const glm::dvec3 ball = glm::dvec3(step.handle) + step.by * 0.1;
    ASSERT_TRUE(huge.carve(at_corner + ball, 2.5).ok());
    ASSERT_TRUE(small.carve(ball, 2.5).ok());
    const auto blade = [&](glm::dvec3 from) {
      const glm::dvec3 path[] = {from + ball - 4.3, from + ball + 5.2};
      return std::move(CutSurface::sweep(path, {0, 0, 9})).value();
    };
    ASSERT_TRUE(huge.cut(blade(at_corner)).ok());
    ASSERT_TRUE(small.cut(blade(glm::dvec3(0))).ok());
    expect_same(huge, small);
    EXPECT_FALSE(small.cuts().empty());
  }
  EXPECT_GT(moved, 1000);
  // Nothing has come near the small volume's own borders that the huge one goes on beyond.
  for_each_voxel(kSmall, [&](VoxelIndex v) {
    if (v.x > 0 && v.y > 0 && v.z > 0) return;
    ASSERT_EQ(small.lattice().u(v), glm::ivec3(0)) << v.x << ' ' << v.y << ' ' << v.z;
  });
  EXPECT_EQ(violations_of(huge.lattice(), huge.materials(), huge.cuts()).links, 0);
  while (huge.undo()) {
    ASSERT_TRUE(small.undo());
    expect_same(huge, small);
  }
  EXPECT_TRUE(huge.lattice().at_rest());
  EXPECT_TRUE(huge.cuts().empty());
  EXPECT_LT(resident_bytes() - before, std::int64_t{200} << 20);  // of more than 4 GiB
}

}  // namespace
}  // namespace maille
