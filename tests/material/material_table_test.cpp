#include "material/material_table.h"

#include <cmath>
#include <limits>

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
    const LinkLimits& link = table->link(swapped ? 1 : 0, swapped ? 0 : 1);
    EXPECT_EQ(link.lower[0][0], -204);  // (0.5 + 0.7) / 2 - 1 = -0.4 voxel: -204.8 units
    EXPECT_EQ(link.upper[0][0], 384);   // 0.75 voxel exactly
    EXPECT_EQ(link.lower[1][1], -76);   // -0.15: -76.8
    EXPECT_EQ(link.upper[1][1], 64);
    EXPECT_EQ(link.lower[2][2], 0);  // rigid
    EXPECT_EQ(link.upper[2][2], 0);
    EXPECT_EQ(link.upper[1][0], 128);  // shear of component x: 0.2505 voxel: 128.3
    EXPECT_EQ(link.lower[1][0], -128);
    EXPECT_EQ(link.upper[0][1], 25);  // 0.05: 25.6
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
  EXPECT_TRUE(refused([](Material& m) { m.value_high = m.value_low; }));
  EXPECT_TRUE(refused([&](Material& m) { m.value_high = nan; }));
  EXPECT_FALSE(MaterialTable::create({}).ok());
  EXPECT_FALSE(MaterialTable::create({material("a", 0, 10), material("b", 9, 20)}).ok());
}

TEST(MaterialTable, WarnsWhereADragMayFold) {
  Material safe = material("safe", 0, 1);
  safe.compress = glm::dvec3(0.6);
  safe.shear = glm::dvec3(0.29);
  Material loose = material("loose", 1, 2);
  loose.compress = glm::dvec3(0.6);
  loose.shear = {0.1, 0.3, 0.1};
  const auto table = MaterialTable::create({safe, loose});
  ASSERT_TRUE(table.ok());
  ASSERT_EQ(table->warnings().size(), 1u);
  EXPECT_NE(table->warnings()[0].find("loose"), std::string::npos);
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

TEST(MaterialField, ReadsEveryTypeLikeTheTable) {
  const Size3 size{5, 4, 3};
  const auto table =
      MaterialTable::create({material("a", -100, 0), material("b", 0, 60), material("c", 60, 200)});
  ASSERT_TRUE(table.ok());
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

}  // namespace
}  // namespace maille
