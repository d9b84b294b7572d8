// Volumes of cells against closed forms.
#include "resample/volume_kept.h"

#include <cmath>

#include <gtest/gtest.h>

#include "deform/carving.h"
#include "tests/resample/scenes.h"

namespace maille {
namespace {

using testing::lattice_from;

MaterialField field_of(Size3 size, std::vector<std::uint8_t> samples) {
  Material soft;
  soft.name = "soft";
  soft.value_low = 0;
  soft.value_high = 1;
  Material hard;
  hard.name = "hard";
  hard.value_low = 1;
  hard.value_high = 2;
  return {Volume::of(size, VoxelType::uint8, axis_aligned(glm::dvec3(1)), std::move(samples)),
          *MaterialTable::create({soft, hard})};
}

MaterialField one_material(Size3 size) {
  return field_of(size, std::vector<std::uint8_t>(static_cast<std::size_t>(voxel_count(size)), 0));
}

constexpr double kRounding = 0.01;  // of fixed point, over one cell

TEST(VolumeKept, NothingHasMoved) {
  const Size3 size{10, 12, 14};
  WorkerPool pool(2);
  const auto kept = volume_kept(Lattice(size), Cuts(size), one_material(size), pool);
  ASSERT_EQ(kept.size(), 3u);
  for (const VolumeKept& k : kept) EXPECT_EQ(k.cells, 0);
  EXPECT_EQ(sum_of(kept).ratio, 1.0);
}

TEST(VolumeKept, IsTheDeterminantOfAnAffineMap) {
  const Size3 size{40, 35, 37};
  WorkerPool pool(2);
  const glm::dmat3 strain(glm::dvec3(0.2, 0.1, 0.0), glm::dvec3(-0.3, 0.1, 0.0),
                          glm::dvec3(0.0, 0.05, -0.2));
  const Lattice lattice =
      lattice_from(size, [&](glm::dvec3 p) { return strain * p + glm::dvec3(0.5); });
  const auto kept = volume_kept(lattice, Cuts(size), one_material(size), pool);
  EXPECT_EQ(kept[0].cells, 39 * 34 * 36);
  const double volume = glm::determinant(glm::dmat3(1.0) + strain);
  EXPECT_NEAR(kept[0].ratio, volume, 1e-4);
  EXPECT_NEAR(kept[0].change_rms, std::abs(volume - 1.0), 1e-3);
}

TEST(VolumeKept, ATurnKeepsIt) {
  const Size3 size{20, 20, 20};
  WorkerPool pool(1);
  const glm::dmat3 turn(glm::dvec3(0.0, 1.0, 0.0), glm::dvec3(-1.0, 0.0, 0.0),
                        glm::dvec3(0.0, 0.0, 1.0));
  const Lattice lattice =
      lattice_from(size, [&](glm::dvec3 p) { return turn * p - p + glm::dvec3(20, 0, 0); });
  const VolumeKept all = sum_of(volume_kept(lattice, Cuts(size), one_material(size), pool));
  EXPECT_EQ(all.cells, 19 * 19 * 19);
  EXPECT_EQ(all.ratio, 1.0);
  EXPECT_LT(all.change_rms, 1e-12);
}

// A bent cell: x stretches with y and z, u = a y z, whose cells have 1 + 0 of volume along x: none
// of it changes, for shear keeps volume; u_x = a x y has 1 + a y.
TEST(VolumeKept, IsExactForBentCells) {
  const Size3 size{9, 17, 9};
  WorkerPool pool(1);
  constexpr double kA = 1.0 / 64.0;  // all displacements are fixed point
  const auto shear =
      lattice_from(size, [&](glm::dvec3 p) { return glm::dvec3(1 + kA * p.y * p.z, 0, 0); });
  EXPECT_NEAR(sum_of(volume_kept(shear, Cuts(size), one_material(size), pool)).ratio, 1.0, 1e-6);
  const auto fan =
      lattice_from(size, [&](glm::dvec3 p) { return glm::dvec3(1 + kA * p.x * p.y, 0, 0); });
  EXPECT_NEAR(sum_of(volume_kept(fan, Cuts(size), one_material(size), pool)).ratio, 1.0 + kA * 8.0,
              1e-6);
}

TEST(VolumeKept, IsToldByMaterialAndLeavesOutCutCells) {
  const Size3 size{20, 20, 20};
  WorkerPool pool(3);
  std::vector<std::uint8_t> samples;
  for (std::int64_t i = 0; i < voxel_count(size); ++i) samples.push_back(i % size.x >= 10);
  const MaterialField field = field_of(size, std::move(samples));
  // The soft half is stretched along x to twice its length, the hard one goes along.
  const auto lattice =
      lattice_from(size, [](glm::dvec3 p) { return glm::dvec3(1 + std::min(p.x, 9.0), 0, 0); });
  const auto kept = volume_kept(lattice, Cuts(size), field, pool);
  EXPECT_EQ(kept[0].cells, 9 * 19 * 19);
  EXPECT_NEAR(kept[0].ratio, 2.0, kRounding);
  EXPECT_EQ(kept[1].cells, 9 * 19 * 19);
  EXPECT_NEAR(kept[1].ratio, 1.0, kRounding);
  EXPECT_EQ(kept[2].cells, 19 * 19);
  const Cuts carved = carve(Cuts(size), Lattice(size), glm::dvec3(15, 10, 10), 0.5);
  EXPECT_EQ(volume_kept(lattice, carved, field, pool)[1].cells, 9 * 19 * 19 - 8);
}

}  // namespace
}  // namespace maille
