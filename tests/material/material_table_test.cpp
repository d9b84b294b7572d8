#include "material/material_table.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "material/material_field.h"

namespace maille {
namespace {

Material material(const char* name, double low, double high) {
  Material m;
  m.name = name;
  m.value_low = low;
  m.value_high = high;
  return m;
}

TEST(MaterialTable, RangesAreHalfOpenAndGapsGoToTheNearest) {
  const auto table = MaterialTable::create(
      {material("b", 100, 200), material("a", 0, 50), material("c", 200, 300)});
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->materials()[0].name, "a");
  EXPECT_EQ(table->id_of(-1e9), 0);
  EXPECT_EQ(table->id_of(0), 0);
  EXPECT_EQ(table->id_of(49.999), 0);
  EXPECT_EQ(table->id_of(60), 0);
  EXPECT_EQ(table->id_of(90), 1);
  EXPECT_EQ(table->id_of(100), 1);
  EXPECT_EQ(table->id_of(199.999), 1);
  EXPECT_EQ(table->id_of(200), 2);
  EXPECT_EQ(table->id_of(1e9), 2);
  EXPECT_EQ(table->id_of(std::numeric_limits<double>::quiet_NaN()), 0);
}

TEST(MaterialTable, LimitsAreMeansRoundedTowardsTheInside) {
  Material a = material("a", 0, 1);
  Material b = material("b", 1, 2);
  a.compress = {0.5, 0.9, 1.0};
  b.compress = {0.7, 0.8, 1.0};
  a.stretch = {1.5, 1.25, 1.0};
  b.stretch = {2.0, 1.0, 1.0};
  a.shear = {0.3, 0.1, 0.0};
  b.shear = {0.201, 0.0, 0.0};
  const auto table = MaterialTable::create({a, b});
  ASSERT_TRUE(table.ok());
  for (const bool swapped : {false, true}) {
    const LinkLimits link = table->link(swapped ? 1 : 0, swapped ? 0 : 1);
    EXPECT_EQ(link.lower[0][0], -204);  // (0.5 + 0.7) / 2 - 1 = -0.4 voxel: -204.8 units
    EXPECT_EQ(link.upper[0][0], 384);   // 0.75 voxel exactly
    EXPECT_EQ(link.lower[1][1], -76);   // -0.15: -76.8
    EXPECT_EQ(link.upper[1][1], 64);
    EXPECT_EQ(link.lower[2][2], 0);  // rigid
    EXPECT_EQ(link.upper[2][2], 0);
    // Shear of component x: 0.2505 voxel is 128.3, but 0.3 is 153 whole units and 0.201 is 102.
    EXPECT_EQ(link.upper[1][0], 127);
    EXPECT_EQ(link.lower[1][0], -127);
    EXPECT_EQ(link.upper[0][1], 25);  // 0.05: 25.6
  }
}

// Against the means of what was asked for, in long double: no link has more room than they, and
// none loses more to rounding than a whole unit of each limit and half of one of the mean.
TEST(MaterialTable, NoLinkHasMoreRoomThanTheMeanOfItsLimits) {
  std::mt19937 random(20070308);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<Material> materials;
  for (int i = 0; i < 60; ++i) {
    Material m = material("m", i, i + 1);
    for (int c = 0; c < 3; ++c) {
      // A third in whole hundredths, as people type them.
      const double step = i % 3 == 0 ? 100.0 : 1e15;
      m.compress[c] = std::round(uniform(0.0, 1.0) * step) / step;
      m.stretch[c] = 1.0 + std::round(uniform(0.0, i % 5 == 0 ? 100.0 : 2.0) * step) / step;
      m.shear[c] = std::round(uniform(0.0, 1.0) * step) / step;
    }
    materials.push_back(m);
  }
  const auto table = MaterialTable::create(materials);
  ASSERT_TRUE(table.ok());
  for (int i = 0; i < table->count(); ++i) {
    for (int j = 0; j < table->count(); ++j) {
      const auto link = table->link(static_cast<MaterialId>(i), static_cast<MaterialId>(j));
      const Material& a = materials[static_cast<std::size_t>(i)];
      const Material& b = materials[static_cast<std::size_t>(j)];
      const auto expect_inside = [&](std::int32_t units, long double mean_voxels) {
        const long double mean = 512 * mean_voxels;
        EXPECT_GE(units, 0);
        EXPECT_LE(units, mean + 1e-9L) << i << ' ' << j;
        EXPECT_GT(units, mean - 1.5L) << i << ' ' << j;
      };
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (int c = 0; c < 3; ++c) {
          if (c == static_cast<int>(axis)) {
            expect_inside(-link.lower[axis][c],
                          1.0L - (static_cast<long double>(a.compress[c]) + b.compress[c]) / 2);
            expect_inside(link.upper[axis][c],
                          (static_cast<long double>(a.stretch[c]) + b.stretch[c]) / 2 - 1.0L);
          } else {
            const auto shear = (static_cast<long double>(a.shear[c]) + b.shear[c]) / 2;
            expect_inside(-link.lower[axis][c], shear);
            expect_inside(link.upper[axis][c], shear);
          }
        }
      }
    }
  }
}

TEST(MaterialTable, ALinkTakesTheFloorOfTheMeanOfItsElements) {
  Material a = material("a", 0, 1);
  Material b = material("b", 1, 2);
  a.compress = glm::dvec3(1.0 - 7 / 512.0);
  b.compress = glm::dvec3(1.0 - 4 / 512.0);
  a.stretch = glm::dvec3(1.0 + 9 / 512.0);
  b.stretch = glm::dvec3(1.0);
  a.shear = {1 / 512.0, 3 / 512.0, 5 / 512.0};
  b.shear = {0.0, 1 / 512.0, 4 / 512.0};
  const auto table = MaterialTable::create({a, b});
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->limits(0).compress, glm::ivec3(7));
  EXPECT_EQ(table->limits(0).stretch, glm::ivec3(9));
  EXPECT_EQ(table->limits(1).shear, glm::ivec3(0, 1, 4));
  const auto link = table->link(0, 1);
  EXPECT_EQ(link.lower[0], glm::ivec3(-5, -2, -4));
  EXPECT_EQ(link.upper[0], glm::ivec3(4, 2, 4));
  EXPECT_EQ(link.lower[2], glm::ivec3(0, -2, -5));
  EXPECT_EQ(link.upper[2], glm::ivec3(0, 2, 4));
}

TEST(MaterialTable, AWholeUnitSurvivesItsArithmetic) {
  Material m = material("m", 0, 1);
  m.shear = glm::dvec3((1.0 / 49) * (49.0 / kUnitsPerVoxel));
  ASSERT_LT(m.shear.x * kUnitsPerVoxel, 1.0);
  const auto table = MaterialTable::create({m});
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->limits(0).shear, glm::ivec3(1));
}

TEST(MaterialTable, ARigidMaterialHasNoRoomAndHalvesThatOfItsNeighbours) {
  Material rigid = material("rigid", 0, 1);
  rigid.rigid = true;
  rigid.shear = glm::dvec3(std::numeric_limits<double>::quiet_NaN());  // nobody asks for it
  Material soft = material("soft", 1, 2);
  soft.compress = glm::dvec3(0.5);
  soft.stretch = glm::dvec3(3.0);
  soft.shear = glm::dvec3(0.25);
  const auto table = MaterialTable::create({rigid, soft});
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->materials()[0].compress, glm::dvec3(1.0));
  EXPECT_EQ(table->materials()[0].stretch, glm::dvec3(1.0));
  EXPECT_EQ(table->materials()[0].shear, glm::dvec3(0.0));
  EXPECT_FALSE(table->fixed(0));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(table->link(0, 0).lower[axis], glm::ivec3(0));
    EXPECT_EQ(table->link(0, 0).upper[axis], glm::ivec3(0));
    for (int c = 0; c < 3; ++c) {
      const bool along = c == static_cast<int>(axis);
      EXPECT_EQ(table->link(0, 1).lower[axis][c], along ? -128 : -64);
      EXPECT_EQ(table->link(1, 0).upper[axis][c], along ? 512 : 64);
    }
  }
}

TEST(MaterialTable, RefusesWhatCannotBeAndNamesTheMaterial) {
  const auto refused = [](auto&& change) {
    Material m = material("jelly", 0, 10);
    change(m);
    const auto table = MaterialTable::create({m});
    if (table.ok()) return false;
    EXPECT_EQ(table.error().kind, ErrorKind::bad_input);
    EXPECT_NE(table.error().message.find("jelly"), std::string::npos) << table.error().message;
    return true;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(refused([](Material&) {}));
  EXPECT_TRUE(refused([](Material& m) { m.compress.y = 1.01; }));
  EXPECT_TRUE(refused([](Material& m) { m.compress.y = -0.01; }));
  EXPECT_TRUE(refused([](Material& m) { m.stretch.z = 0.99; }));
  EXPECT_TRUE(refused([&](Material& m) { m.shear.x = nan; }));
  EXPECT_TRUE(refused([](Material& m) { m.shear.x = -1; }));
  EXPECT_TRUE(refused([](Material& m) { m.stiffness = 0; }));
  EXPECT_TRUE(refused([&](Material& m) { m.stiffness = nan; }));
  EXPECT_TRUE(refused([](Material& m) { m.rest_vector_blend = -0.01; }));
  EXPECT_TRUE(refused([](Material& m) { m.rest_vector_blend = 1.01; }));
  EXPECT_TRUE(refused([&](Material& m) { m.rest_vector_blend = nan; }));
  EXPECT_FALSE(refused([](Material& m) { m.rest_vector_blend = 1.0; }));
  EXPECT_TRUE(refused([](Material& m) { m.yield_strain = 0.0; }));
  EXPECT_TRUE(refused([](Material& m) { m.yield_strain = -0.1; }));
  EXPECT_TRUE(refused([&](Material& m) { m.yield_strain = nan; }));
  EXPECT_FALSE(refused([](Material& m) { m.yield_strain = 1e-9; }));
  EXPECT_TRUE(refused([](Material& m) { m.value_high = m.value_low; }));
  EXPECT_TRUE(refused([&](Material& m) { m.value_high = nan; }));
  EXPECT_FALSE(MaterialTable::create({}).ok());
  EXPECT_FALSE(MaterialTable::create({material("a", 0, 10), material("b", 9, 20)}).ok());
}

TEST(MaterialTable, HasBlendAndYieldStrainOfEachMaterial) {
  std::vector<Material> materials{material("rubber", 0, 1), material("clay", 1, 2),
                                  material("sand", 2, 3), material("steel", 3, 4)};
  materials[1].rest_vector_blend = 0.5;
  materials[1].yield_strain = 0.125;
  materials[2].yield_strain = 1e-300;  // beyond a float's reach, and yet above 0
  materials[3].yield_strain = 1e300;
  const auto table = MaterialTable::create(materials);
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->rest_vector_blend(0), 0.25f);
  EXPECT_EQ(table->rest_vector_blend(1), 0.5f);
  EXPECT_EQ(table->yield_strain(0), std::numeric_limits<float>::infinity());
  EXPECT_EQ(table->yield_strain(1), 0.125f);
  EXPECT_GT(table->yield_strain(2), 0.0f);
  EXPECT_LT(table->yield_strain(2), 1e-30f);
  EXPECT_EQ(table->yield_strain(3), std::numeric_limits<float>::infinity());
}

TEST(MaterialTable, RelativePresetTakesAnyRange) {
  EXPECT_EQ(MaterialTable::relative(0, 255).count(), 2);
  EXPECT_EQ(MaterialTable::relative(0, 255).id_of(255), 1);
  EXPECT_EQ(MaterialTable::relative(0, 255).id_of(84), 0);
  for (const double value : {0.0, -3.0, 1e20, -1e30, 3e38}) {
    const MaterialTable table = MaterialTable::relative(value, value);
    EXPECT_EQ(table.count(), 1);
    EXPECT_EQ(table.id_of(value), 0);
  }
}

class MaterialFieldOf : public ::testing::TestWithParam<Interpolation> {};

TEST_P(MaterialFieldOf, ReadsEveryTypeLikeTheTable) {
  const Size3 size{5, 4, 3};
  std::vector<Material> materials{material("a", -100, 0), material("b", 0, 60),
                                  material("c", 60, 200)};
  materials[1].stiffness = 50.0;
  const auto table = MaterialTable::create(materials, GetParam());
  ASSERT_TRUE(table.ok());
  EXPECT_EQ(table->count() > 3, GetParam() == Interpolation::linear);
  for (const VoxelType type : {VoxelType::uint8, VoxelType::int8, VoxelType::uint16,
                               VoxelType::int16, VoxelType::float32}) {
    const Volume volume = with_voxel_type(type, [&]<class T>() {
      std::vector<T> samples(static_cast<std::size_t>(voxel_count(size)));
      for (std::size_t i = 0; i < samples.size(); ++i) {
        samples[i] = static_cast<T>(std::is_signed_v<T> ? static_cast<int>(i * 4) - 110
                                                        : static_cast<int>(i * 2));
      }
      return Volume::of(size, type, axis_aligned(glm::dvec3(1)), std::move(samples));
    });
    const MaterialField field(volume, *table);
    const VoxelBox box{{1, 0, 0}, {4, 4, 3}};
    std::vector<MaterialId> ids(static_cast<std::size_t>(voxel_count(box.size())));
    EXPECT_EQ(field.read(box, ids), std::nullopt);
    std::size_t i = 0;
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        for (int x = box.lo.x; x < box.hi.x; ++x, ++i) {
          EXPECT_EQ(ids[i], table->id_of(volume.value_at({x, y, z}))) << name_of(type);
          EXPECT_EQ(field.at({x, y, z}), ids[i]);
        }
      }
    }
    EXPECT_EQ(field.read({{2, 2, 2}, {3, 3, 3}}, ids),
              std::optional<MaterialId>(field.at({2, 2, 2})));
  }
}

INSTANTIATE_TEST_SUITE_P(Interpolations, MaterialFieldOf,
                         ::testing::Values(Interpolation::step, Interpolation::linear));

}  // namespace
}  // namespace maille
