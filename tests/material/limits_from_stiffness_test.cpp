#include "material/limits_from_stiffness.h"

#include <limits>

#include <gtest/gtest.h>

#include "material/material_table.h"
#include "material/material_warnings.h"

namespace maille {
namespace {

// Ranges one wide, limits that must not matter.
std::vector<Material> of_stiffness(const std::vector<double>& stiffnesses) {
  std::vector<Material> materials;
  for (const double stiffness : stiffnesses) {
    Material m;
    m.value_low = static_cast<double>(materials.size());
    m.value_high = m.value_low + 1.0;
    m.name = "m" + std::to_string(materials.size());
    m.compress = glm::dvec3(0.123);
    m.shear = glm::dvec3(77.0);
    m.stiffness = stiffness;
    materials.push_back(m);
  }
  return materials;
}

TEST(LimitsFromStiffness, NeedTheSameForceInEveryDirection) {
  const SoftestLimits softest{{0.5, 0.6, 0.7}, {3.0, 2.0, 1.5}, {0.2, 0.25, 0.0}};
  const auto materials = limits_from_stiffness(of_stiffness({8.0, 0.5, 2.0, 33.0}), softest);
  ASSERT_TRUE(materials.ok());
  ASSERT_EQ(materials->size(), 4u);
  for (const Material& m : *materials) {
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(m.stiffness * (1.0 - m.compress[c]), 0.5 * (1.0 - softest.compress[c]), 1e-12);
      EXPECT_NEAR(m.stiffness * (m.stretch[c] - 1.0), 0.5 * (softest.stretch[c] - 1.0), 1e-12);
      EXPECT_NEAR(m.stiffness * m.shear[c], 0.5 * softest.shear[c], 1e-12);
    }
    EXPECT_FALSE(component_that_may_fold(m.compress, m.shear));
  }
  // The order and all else as it was.
  EXPECT_EQ((*materials)[3].name, "m3");
  EXPECT_EQ((*materials)[3].value_low, 3.0);
  EXPECT_EQ((*materials)[0].stiffness, 8.0);
  // By hand: 8 is sixteen times 0.5.
  EXPECT_NEAR((*materials)[0].compress.x, 1.0 - 0.5 / 16, 1e-15);
  EXPECT_NEAR((*materials)[0].stretch.x, 1.0 + 2.0 / 16, 1e-15);
  EXPECT_TRUE(MaterialTable::create(*materials).ok());
  EXPECT_TRUE(warnings_of(*materials, Interpolation::step).empty());
}

TEST(LimitsFromStiffness, WithoutAWordTakesDefaultsThatDoNotFold) {
  const auto materials = limits_from_stiffness(of_stiffness({1.0, 2.0}));
  ASSERT_TRUE(materials.ok());
  EXPECT_EQ((*materials)[0].compress, SoftestLimits{}.compress);
  EXPECT_EQ((*materials)[0].shear, SoftestLimits{}.shear);
  EXPECT_TRUE(warnings_of(*materials, Interpolation::step).empty());
}

TEST(LimitsFromStiffness, TheSoftestIsOneThatDeforms) {
  auto materials = of_stiffness({0.001, 0.01, 1.0, 4.0});
  materials[0].fixed = true;
  materials[1].rigid = true;
  const auto derived = limits_from_stiffness(materials);
  ASSERT_TRUE(derived.ok());
  EXPECT_EQ((*derived)[2].stretch, SoftestLimits{}.stretch);
  EXPECT_EQ((*derived)[3].stretch, glm::dvec3(1.125));
  EXPECT_EQ((*derived)[0].stretch, SoftestLimits{}.stretch);  // softer still: no more than that
  EXPECT_EQ((*derived)[1].stretch, glm::dvec3(1.0));
  EXPECT_EQ((*derived)[1].compress, glm::dvec3(1.0));
  EXPECT_EQ((*derived)[1].shear, glm::dvec3(0.0));

  for (auto& m : materials) m.fixed = true;
  const auto all_fixed = limits_from_stiffness(materials);
  ASSERT_TRUE(all_fixed.ok());
  EXPECT_EQ((*all_fixed)[0].stretch, SoftestLimits{}.stretch);
  EXPECT_NEAR((*all_fixed)[2].stretch.x, 1.0005, 1e-12);
}

TEST(LimitsFromStiffness, RefusesWithAReason) {
  const auto refusal = [](const std::vector<double>& stiffnesses, const SoftestLimits& softest) {
    const auto derived = limits_from_stiffness(of_stiffness(stiffnesses), softest);
    if (derived.ok()) return std::string("accepted");
    EXPECT_EQ(derived.error().kind, ErrorKind::bad_input);
    return derived.error().message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  SoftestLimits softest;
  EXPECT_EQ(refusal({1.0}, softest), "accepted");
  EXPECT_EQ(refusal({1.0, nan}, softest),
            "material \"m1\": expected a stiffness within 1e-12 to 1e12");
  EXPECT_EQ(refusal({1.0, 2.0, -1.0}, softest),
            "material \"m2\": expected a stiffness within 1e-12 to 1e12");
  softest.compress.y = nan;
  EXPECT_EQ(refusal({1.0}, softest),
            "limits of the softest material: expected compress within 0 to 1");
  softest = {};
  softest.stretch.z = 0.9;
  EXPECT_EQ(refusal({1.0}, softest),
            "limits of the softest material: expected stretch within 1 to 100000");
  softest = {};
  softest.shear.x = 0.3;
  EXPECT_EQ(refusal({1.0}, softest),
            "limits of the softest material: expected compress above twice shear");
}

}  // namespace
}  // namespace maille
