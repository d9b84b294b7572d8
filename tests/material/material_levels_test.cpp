#include "material/material_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "material/material_table.h"

namespace maille {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Material material(double low, double high, double compress, double stretch, double shear,
                  double stiffness) {
  Material m;
  m.name = "m";
  m.value_low = low;
  m.value_high = high;
  m.compress = glm::dvec3(compress);
  m.stretch = glm::dvec3(stretch);
  m.shear = glm::dvec3(shear);
  m.stiffness = stiffness;
  return m;
}

MaterialTable linear(std::vector<Material> materials) {
  return std::move(MaterialTable::create(std::move(materials), Interpolation::linear)).value();
}

// The numbers of a material as interpolation sees them: nine limits, ln stiffness, blend and what
// runs straight of a yield strain.
using Numbers = std::array<double, 12>;

Numbers numbers_of(const Material& m) {
  Numbers out{};
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    out[i] = 1.0 - m.compress[c];
    out[3 + i] = m.stretch[c] - 1.0;
    out[6 + i] = m.shear[c];
  }
  out[9] = std::log(m.stiffness);
  out[10] = m.rest_vector_blend.value();
  out[11] = m.yield_strain ? 1.0 / (1.0 + *m.yield_strain) : 0.0;
  return out;
}

// The same of what a table gives a value: limits back in voxels.
Numbers numbers_at(const MaterialTable& table, double value) {
  const MaterialId id = table.id_of(value);
  const ElementLimits& limits = table.limits(id);
  Numbers out{};
  for (int c = 0; c < 3; ++c) {
    const auto i = static_cast<std::size_t>(c);
    out[i] = limits.compress[c] / 512.0;
    out[3 + i] = limits.stretch[c] / 512.0;
    out[6 + i] = limits.shear[c] / 512.0;
  }
  out[9] = -std::log(static_cast<double>(table.compliance(id)));
  out[10] = table.rest_vector_blend(id);
  out[11] = 1.0 / (1.0 + static_cast<double>(table.yield_strain(id)));
  return out;
}

// The straight lines themselves. Materials by rising value, ranges finite.
Numbers straight_at(const std::vector<Material>& materials, double value) {
  const auto middle = [](const Material& m) { return 0.5 * (m.value_low + m.value_high); };
  if (value <= middle(materials.front())) return numbers_of(materials.front());
  for (std::size_t i = 1; i < materials.size(); ++i) {
    const double from = middle(materials[i - 1]);
    const double to = middle(materials[i]);
    if (value > to) continue;
    const auto a = numbers_of(materials[i - 1]);
    const auto b = numbers_of(materials[i]);
    Numbers out{};
    for (std::size_t n = 0; n < out.size(); ++n) {
      out[n] = (a[n] * (to - value) + b[n] * (value - from)) / (to - from);
    }
    return out;
  }
  return numbers_of(materials.back());
}

// What the header promises of a level.
double promised_error(const std::vector<Material>& materials) {
  double change = 0.0;
  for (std::size_t i = 1; i < materials.size(); ++i) {
    const auto a = numbers_of(materials[i - 1]);
    const auto b = numbers_of(materials[i]);
    double most = 0.0;
    for (std::size_t n = 0; n < a.size(); ++n) most = std::max(most, std::abs(a[n] - b[n]));
    change += most;
  }
  return std::max(1.0 / 1024, change / (514.0 - 4.0 * static_cast<double>(materials.size())));
}

std::vector<Material> random_materials(int count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<Material> materials;
  double value = -1000.0;
  for (int i = 0; i < count; ++i) {
    const double low = value + (i % 2 ? uniform(0.0, 30.0) : 0.0);  // every other after a gap
    value = low + uniform(1.0, 50.0);
    Material m = material(low, value, 1, 1, 0, std::exp(uniform(-3.0, 3.0)));
    for (int c = 0; c < 3; ++c) {
      m.compress[c] = uniform(0.0, 1.0);
      m.stretch[c] = uniform(1.0, 4.0);
      m.shear[c] = uniform(0.0, 1.0);
    }
    m.rest_vector_blend = uniform(0.0, 1.0);
    if (i % 3) m.yield_strain = std::exp(uniform(-7.0, 3.0));
    materials.push_back(m);
  }
  return materials;
}

class MaterialLevels : public ::testing::TestWithParam<int> {};

TEST_P(MaterialLevels, StayAsCloseToTheStraightLineAsPromised) {
  const auto materials = random_materials(GetParam(), static_cast<unsigned>(GetParam()));
  const auto table = linear(materials);
  EXPECT_LE(table.count(), 256);
  const double promised = promised_error(materials);
  const double low = materials.front().value_low - 10.0;
  const double high = materials.back().value_high + 10.0;
  constexpr int kSamples = 50000;
  for (int i = 0; i <= kSamples; ++i) {
    const double value = low + (high - low) * i / kSamples;
    const auto got = numbers_at(table, value);
    const auto exact = straight_at(materials, value);
    for (std::size_t n = 0; n < 9; ++n) {
      ASSERT_LE(got[n], exact[n] + promised + 1e-9) << "number " << n << " at " << value;
      // Rounded towards the inside by less than a unit.
      ASSERT_GT(got[n], exact[n] - promised - 1.0 / 512) << "number " << n << " at " << value;
    }
    for (std::size_t n = 9; n < got.size(); ++n) {
      ASSERT_NEAR(got[n], exact[n], promised + 1e-6) << "number " << n << " at " << value;
    }
  }
}

TEST_P(MaterialLevels, HaveAMaterialsOwnNumbersInItsMiddle) {
  const auto materials = random_materials(GetParam(), 1000u + static_cast<unsigned>(GetParam()));
  const auto table = linear(materials);
  const auto step = std::move(MaterialTable::create(materials)).value();
  ASSERT_EQ(step.count(), GetParam());
  for (const Material& m : materials) {
    const double middle = 0.5 * (m.value_low + m.value_high);
    const MaterialId id = table.id_of(middle);
    const MaterialId own = step.id_of(middle);
    EXPECT_EQ(table.limits(id).compress, step.limits(own).compress);
    EXPECT_EQ(table.limits(id).stretch, step.limits(own).stretch);
    EXPECT_EQ(table.limits(id).shear, step.limits(own).shear);
    EXPECT_EQ(table.compliance(id), step.compliance(own));
    EXPECT_EQ(table.rest_vector_blend(id), step.rest_vector_blend(own));
    EXPECT_EQ(table.yield_strain(id), step.yield_strain(own));
  }
}

TEST_P(MaterialLevels, AreMonotoneFromMiddleToMiddle) {
  const auto materials = random_materials(GetParam(), 2000u + static_cast<unsigned>(GetParam()));
  const auto table = linear(materials);
  for (std::size_t i = 1; i < materials.size(); ++i) {
    const double from = 0.5 * (materials[i - 1].value_low + materials[i - 1].value_high);
    const double to = 0.5 * (materials[i].value_low + materials[i].value_high);
    const auto a = numbers_of(materials[i - 1]);
    const auto b = numbers_of(materials[i]);
    auto before = numbers_at(table, from);
    for (int s = 1; s <= 1000; ++s) {
      const auto now = numbers_at(table, from + (to - from) * s / 1000);
      for (std::size_t n = 0; n < now.size(); ++n) {
        const double rise = (now[n] - before[n]) * (b[n] > a[n] ? 1.0 : -1.0);
        ASSERT_GE(rise, 0.0) << "number " << n << " between materials " << i - 1 << " and " << i;
      }
      before = now;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Materials, MaterialLevels, ::testing::Values(1, 2, 3, 10, 100));

TEST(MaterialLevels, TouchFromMinusToPlusInfinity) {
  for (const auto interpolation : {Interpolation::step, Interpolation::linear}) {
    const auto levels = levels_of(random_materials(7, 5), interpolation);
    EXPECT_EQ(levels.front().value_low, -kInfinity);
    EXPECT_EQ(levels.back().value_high, kInfinity);
    for (std::size_t i = 1; i < levels.size(); ++i) {
      EXPECT_EQ(levels[i - 1].value_high, levels[i].value_low);
      EXPECT_LT(levels[i].value_low, levels[i].value_high);
    }
  }
}

TEST(MaterialLevels, GoWhereNumbersChange) {
  auto materials = random_materials(3, 9);
  for (auto& m : materials) m = material(m.value_low, m.value_high, 0.5, 2, 0.1, 1.0);
  EXPECT_EQ(linear(materials).count(), 3);
  // Only between the first two, and all of them.
  materials[0].stretch.y = 9.0;
  const auto table = linear(materials);
  EXPECT_EQ(table.count(), 256);
  EXPECT_EQ(table.id_of(0.5 * (materials[1].value_low + materials[1].value_high)), 254);
  // No more than the fixed-point unit can tell apart: 1/16 voxel is 32 units.
  materials[0].stretch.y = 2.0 + 1.0 / 16;
  EXPECT_LE(linear(materials).count(), 3 + 32);
  EXPECT_GE(linear(materials).count(), 3 + 31);
}

TEST(MaterialLevels, GoFromOneBlendToAnother) {
  auto low = material(0, 10, 0.5, 2, 0.1, 1.0);
  auto high = material(10, 20, 0.5, 2, 0.1, 1.0);
  low.rest_vector_blend = 0.0;
  high.rest_vector_blend = 0.75;
  const auto table = linear({low, high});
  EXPECT_EQ(table.count(), 256);
  const auto blend_at = [&](double value) { return table.rest_vector_blend(table.id_of(value)); };
  EXPECT_EQ(blend_at(5), 0.0f);
  EXPECT_NEAR(blend_at(7.5), 0.1875, 0.002);
  EXPECT_NEAR(blend_at(10), 0.375, 0.002);
  EXPECT_EQ(blend_at(15), 0.75f);
}

TEST(MaterialLevels, GoFromClayToRubberWithoutAJump) {
  auto clay = material(0, 10, 0.5, 2, 0.1, 1.0);
  const auto rubber = material(10, 20, 0.5, 2, 0.1, 1.0);
  clay.yield_strain = 0.25;
  const auto table = linear({clay, rubber});
  EXPECT_EQ(table.count(), 256);
  const auto yield_at = [&](double value) { return table.yield_strain(table.id_of(value)); };
  EXPECT_EQ(yield_at(5), 0.25f);
  // 1 / (1 + y) is 0.8 in clay, so 0.6 and 0.4 on the way to 0.
  EXPECT_NEAR(yield_at(7.5), 2.0 / 3.0, 0.01);
  EXPECT_NEAR(yield_at(10), 1.5, 0.02);
  EXPECT_EQ(yield_at(15), kInfinity);
  // Between clays it runs all but straight, and one that all share is nothing to interpolate.
  auto firmer = rubber;
  firmer.yield_strain = 0.35;
  const auto clays = linear({clay, firmer});
  EXPECT_NEAR(clays.yield_strain(clays.id_of(10)), 0.3, 0.003);
  firmer.yield_strain = clay.yield_strain = 1.0 / 3e9;
  firmer.stiffness = 2.0;
  const auto same = linear({clay, firmer});
  ASSERT_GT(same.count(), 2);
  for (int id = 0; id < same.count(); ++id) {
    EXPECT_EQ(same.yield_strain(static_cast<MaterialId>(id)), static_cast<float>(1.0 / 3e9));
  }
}

TEST(MaterialLevels, AreNotSpentOnWhatIsRigidAllOver) {
  auto rigid = material(100, 200, 1, 1, 0, 1.0);
  rigid.rigid = true;
  // Nor on a blend that the table would choose for it.
  rigid.rest_vector_blend = 0.25;
  const auto table = linear({material(0, 100, 0.5, 3, 0.25, 1.0), rigid});
  EXPECT_EQ(table.count(), 256);
  EXPECT_EQ(table.id_of(100), 255);
}

TEST(MaterialLevels, OfAFullTableAreItsMaterials) {
  std::vector<Material> materials;
  for (int i = 0; i < 256; ++i) materials.push_back(material(i, i + 1, 0.5, 1.0 + i, 0.1, 1.0));
  const auto table = linear(materials);
  ASSERT_EQ(table.count(), 256);
  for (int i = 0; i < 256; ++i) {
    EXPECT_EQ(table.id_of(i + 0.5), i);
    EXPECT_EQ(table.limits(static_cast<MaterialId>(i)).stretch.x, 512 * i);
  }
}

TEST(MaterialLevels, LeaveFixedAndRigidToTheRange) {
  auto bone = material(100, 200, 0.9, 1.1, 0.0, 100.0);
  bone.fixed = bone.rigid = true;
  const auto table =
      linear({material(0, 100, 0.5, 3, 0.25, 1.0), bone, material(250, 350, 0.5, 3, 0.25, 1.0)});
  const auto stretch_at = [&](double value) {
    return table.limits(table.id_of(value)).stretch.x / 512.0;
  };
  EXPECT_TRUE(table.any_fixed());
  // From 2 at 50 straight to 0 at 150, but none at all in bone.
  EXPECT_NEAR(stretch_at(75), 1.5, 0.05);
  EXPECT_NEAR(stretch_at(99.999), 1.0, 0.05);
  EXPECT_FALSE(table.fixed(table.id_of(99.999)));
  for (const double value : {100.0, 120.0, 150.0, 180.0, 199.999, 225.0}) {
    const ElementLimits& limits = table.limits(table.id_of(value));
    EXPECT_EQ(limits.compress, glm::ivec3(0)) << value;
    EXPECT_EQ(limits.stretch, glm::ivec3(0)) << value;
    EXPECT_EQ(limits.shear, glm::ivec3(0)) << value;
    EXPECT_TRUE(table.fixed(table.id_of(value))) << value;
  }
  // The gap's middle is the lower's; beyond it, half the way from 150 to 300 is done.
  EXPECT_FALSE(table.fixed(table.id_of(225.001)));
  EXPECT_NEAR(stretch_at(225.001), 1.0, 0.05);
  // Stiffness knows no ranges: 10 is halfway, geometrically.
  EXPECT_NEAR(1.0 / table.compliance(table.id_of(100)), 10.0, 0.5);
}

TEST(MaterialLevels, HoldTheNumbersOfAnOpenRangeUpToItsEnd) {
  const auto table =
      linear({material(-kInfinity, 0, 0.5, 2, 0.1, 1.0), material(0, 10, 0.5, 4, 0.1, 1.0),
              material(10, kInfinity, 0.5, 2, 0.1, 1.0)});
  const auto stretch_at = [&](double value) {
    return table.limits(table.id_of(value)).stretch.x / 512.0;
  };
  EXPECT_EQ(stretch_at(-1e300), 1.0);
  EXPECT_EQ(stretch_at(-1e-6), 1.0);
  EXPECT_NEAR(stretch_at(2.5), 2.0, 0.02);
  EXPECT_EQ(stretch_at(5), 3.0);
  EXPECT_NEAR(stretch_at(7.5), 2.0, 0.02);
  EXPECT_EQ(stretch_at(10), 1.0);
  EXPECT_EQ(stretch_at(kInfinity), 1.0);

  const auto halves =
      linear({material(-kInfinity, 0, 0.5, 2, 0.1, 1.0), material(0, kInfinity, 0.5, 4, 0.1, 1.0)});
  EXPECT_EQ(halves.count(), 2);
  EXPECT_EQ(halves.id_of(-1e-300), 0);
  EXPECT_EQ(halves.id_of(0), 1);
  EXPECT_EQ(linear({material(-kInfinity, kInfinity, 0.5, 4, 0.1, 1.0)}).count(), 1);
}

TEST(MaterialLevels, TakeRangesAsNarrowAndAsWideAsDoublesAre) {
  const double next = std::nextafter(1.0, 2.0);
  const auto narrow =
      linear({material(1.0, next, 0.5, 2, 0.1, 1.0), material(next, 2.0, 0.5, 4, 0.1, 1.0)});
  EXPECT_EQ(narrow.limits(narrow.id_of(1.0)).stretch.x, 512);
  EXPECT_EQ(narrow.limits(narrow.id_of(1.5)).stretch.x, 3 * 512);

  // Four doubles each: most levels have no value, the middles' have. A border lies up to half a
  // double off, which is an eighth of the way here.
  const double u = next - 1.0;
  const auto few = linear({material(1.0, 1.0 + 4 * u, 0.5, 2, 0.1, 1.0),
                           material(1.0 + 4 * u, 1.0 + 8 * u, 0.5, 4, 0.1, 1.0)});
  EXPECT_EQ(few.limits(few.id_of(1.0 + 2 * u)).stretch.x, 512);
  EXPECT_NEAR(few.limits(few.id_of(1.0 + 4 * u)).stretch.x, 2 * 512, 128);
  EXPECT_EQ(few.limits(few.id_of(1.0 + 6 * u)).stretch.x, 3 * 512);

  // One double each, where halfway to the next rounds up to it.
  const auto single = linear({material(1.0 + u, 1.0 + 2 * u, 0.5, 2, 0.1, 1.0),
                              material(1.0 + 2 * u, 1.0 + 3 * u, 0.5, 4, 0.1, 1.0)});
  EXPECT_EQ(single.limits(single.id_of(1.0 + u)).stretch.x, 512);
  EXPECT_EQ(single.limits(single.id_of(1.0 + 2 * u)).stretch.x, 3 * 512);

  // Further apart than a double reaches, and what holds at the border differs.
  auto rigid = material(1.7e308, 1.79e308, 1, 1, 0, 1.0);
  rigid.rigid = true;
  const auto wide = linear({material(-1.79e308, -1.7e308, 0.5, 3, 0.1, 1.0), rigid});
  EXPECT_EQ(wide.limits(wide.id_of(-1.745e308)).stretch.x, 2 * 512);
  EXPECT_NEAR(wide.limits(wide.id_of(-0.8725e308)).stretch.x / 512.0, 1.5, 0.02);
  EXPECT_EQ(wide.limits(wide.id_of(1.0)).stretch.x, 0);
}

TEST(MaterialLevels, LeaveTheTableAsWritten) {
  const auto materials = random_materials(4, 11);
  const auto table = linear(materials);
  EXPECT_EQ(table.interpolation(), Interpolation::linear);
  ASSERT_EQ(table.materials().size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(table.materials()[i].value_low, materials[i].value_low);
    EXPECT_EQ(table.materials()[i].value_high, materials[i].value_high);
    EXPECT_EQ(table.materials()[i].shear, materials[i].shear);
  }
}

TEST(MaterialLevels, OfThePresetsKeepTheirFlags) {
  const auto ct = MaterialTable::ct(Interpolation::linear);
  EXPECT_FALSE(ct.fixed(ct.id_of(249.9)));
  EXPECT_TRUE(ct.fixed(ct.id_of(250)));
  EXPECT_EQ(ct.limits(ct.id_of(115)).shear, MaterialTable::ct().limits(2).shear);
  EXPECT_GT(MaterialTable::relative(0, 255, Interpolation::linear).count(), 100);
  EXPECT_EQ(MaterialTable::relative(3, 3, Interpolation::linear).count(), 1);
}

}  // namespace
}  // namespace maille
