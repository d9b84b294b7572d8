#include "material/spring_table.h"

#include <cmath>
#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

namespace maille {
namespace {

// Names m0, m1, ...; ids are in the order given.
std::vector<Material> of_stiffness(const std::vector<double>& stiffnesses) {
  std::vector<Material> materials;
  for (const double stiffness : stiffnesses) {
    Material m;
    m.value_low = static_cast<double>(materials.size());
    m.value_high = m.value_low + 1.0;
    m.name = "m" + std::to_string(materials.size());
    m.stiffness = stiffness;
    materials.push_back(m);
  }
  return materials;
}

MaterialTable table_of(std::vector<Material> materials,
                       Interpolation interpolation = Interpolation::step) {
  return std::move(MaterialTable::create(std::move(materials), interpolation)).value();
}

SpringTable springs_of(const std::vector<Material>& materials) {
  return SpringTable::of(table_of(materials));
}

double stiffness(const SpringTable& springs, int id) {
  return 1.0 / static_cast<double>(springs.compliance(static_cast<MaterialId>(id)));
}

void expect_stiffnesses(const SpringTable& springs, const std::vector<double>& expected) {
  ASSERT_EQ(springs.count(), static_cast<int>(expected.size()));
  for (int id = 0; id < springs.count(); ++id) {
    const double wanted = expected[static_cast<std::size_t>(id)];
    EXPECT_NEAR(stiffness(springs, id), wanted, 1e-6 * wanted) << "material " << id;
  }
}

void expect_within_bounds(const SpringTable& springs) {
  for (int id = 0; id < springs.count(); ++id) {
    EXPECT_GE(stiffness(springs, id), 0.999e-6) << id;
    EXPECT_LE(stiffness(springs, id), 1.001e12) << id;
  }
}

TEST(SpringTable, IsTheMaterialTableWhereNothingIsClamped) {
  for (const auto& stiffnesses :
       std::vector<std::vector<double>>{{0.3, 7.0, 0.01, 0.3, 6.9}, {42.0}, {1e-6}, {1e12}}) {
    const auto table = table_of(of_stiffness(stiffnesses));
    const auto springs = SpringTable::of(table);
    ASSERT_EQ(springs.count(), table.count());
    for (int i = 0; i < table.count(); ++i) {
      const auto id = static_cast<MaterialId>(i);
      EXPECT_EQ(springs.compliance(id), table.compliance(id));
    }
    EXPECT_EQ(springs.clamped(), std::nullopt);
  }
}

TEST(SpringTable, NarrowsAGapAndMovesWhatIsStiffer) {
  const auto springs = springs_of(of_stiffness({5e6, 0.001, 5e7, 0.1}));
  expect_stiffnesses(springs, {100.0, 0.001, 1000.0, 0.1});
  EXPECT_EQ(springs.clamped(),
            "springs take \"m0\" as 1000 times as stiff as \"m3\", not 5e+07 times");
  // The widest of several is named.
  const auto several = springs_of(of_stiffness({1.0, 1e4, 1e9, 1e11, 3e11, 1e-4}));
  expect_stiffnesses(several, {0.1, 100.0, 1e5, 1e7, 3e7, 1e-4});
  EXPECT_EQ(several.clamped(),
            "springs take \"m2\" as 1000 times as stiff as \"m1\", not 1e+05 times (and narrow 2 "
            "gaps more)");
}

TEST(SpringTable, TakesAThousandAsItIs) {
  EXPECT_EQ(springs_of(of_stiffness({1e-12, 1e-9})).clamped(), std::nullopt);
  EXPECT_EQ(springs_of(of_stiffness({1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12})).clamped(),
            std::nullopt);
  EXPECT_EQ(springs_of(of_stiffness({0.007, 7.0})).clamped(), std::nullopt);
  EXPECT_NE(springs_of(of_stiffness({0.007, 7.001})).clamped(), std::nullopt);
}

// Against gaps counted one by one over the set of stiffnesses, for tables that need no more.
TEST(SpringTable, OfRandomMaterialsIsWhatTheRulesSay) {
  std::mt19937 random(7);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int clamped = 0;
  for (int round = 0; round < 200; ++round) {
    std::vector<double> stiffnesses;
    for (int i = 0; i < 1 + round % 6; ++i) {
      const bool again = i > 0 && i % 3 == 0;  // some as stiff as another
      stiffnesses.push_back(again ? stiffnesses.front() : std::pow(10.0, uniform(-6.0, 6.0)));
    }
    auto materials = of_stiffness(stiffnesses);
    for (std::size_t i = 0; i < materials.size(); ++i) {
      materials[i].fixed = random() % 4 == 0;
      materials[i].rigid = i > 0 && random() % 5 == 0;
    }
    std::set<double> deformable;
    bool any_rigid = false;
    for (const Material& m : materials) {
      if (!m.rigid) deformable.insert(m.stiffness);
      any_rigid = any_rigid || m.rigid;
    }
    std::map<double, double> taken;
    bool any_gap = false;
    double below = 0.0;
    double stiffest = 0.0;
    for (const double s : deformable) {
      any_gap = any_gap || (below > 0.0 && s > 1000.0 * below);
      stiffest = below > 0.0 ? stiffest * std::min(1000.0, s / below) : s;
      taken[s] = stiffest;
      below = s;
    }
    std::vector<double> expected;
    for (const Material& m : materials) {
      expected.push_back(m.rigid ? 1000.0 * stiffest : taken.at(m.stiffness));
    }
    const auto springs = springs_of(materials);
    expect_stiffnesses(springs, expected);
    EXPECT_EQ(springs.clamped().has_value(), any_gap || any_rigid);
    clamped += any_gap;
  }
  EXPECT_GT(clamped, 20);
  EXPECT_LT(clamped, 180);
}

TEST(SpringTable, TakesWhatIsRigidAsAThousandTimesTheStiffestThatIsNot) {
  auto materials = of_stiffness({2.0, 0.5, 1e-9, 1e9});
  materials[2].rigid = true;  // whatever its number
  materials[3].rigid = materials[3].fixed = true;
  const auto springs = springs_of(materials);
  expect_stiffnesses(springs, {2.0, 0.5, 2000.0, 2000.0});
  EXPECT_EQ(springs.clamped(), "for springs, what is rigid is 1000 times as stiff as \"m0\"");

  // A fixed one is not rigid: its springs count.
  materials[3].rigid = false;
  const auto with_fixed = springs_of(materials);
  expect_stiffnesses(with_fixed, {2.0, 0.5, 2e6, 2e3});
  EXPECT_EQ(with_fixed.clamped(),
            "springs take \"m3\" as 1000 times as stiff as \"m0\", not 5e+08 times; what is rigid "
            "is 1000 times as stiff as \"m3\"");
}

TEST(SpringTable, OfRigidMaterialsOnlyMakesThemAlike) {
  auto materials = of_stiffness({1e-9, 1.0, 1e9});
  for (Material& m : materials) m.rigid = true;
  materials[1].fixed = true;
  const auto springs = springs_of(materials);
  expect_stiffnesses(springs, {1.0, 1.0, 1.0});
  EXPECT_EQ(springs.clamped(), std::nullopt);
}

TEST(SpringTable, MovesAllToWhereAFloatIsAtEase) {
  expect_stiffnesses(springs_of(of_stiffness({1e-12})), {1e-6});
  expect_stiffnesses(springs_of(of_stiffness({1e-12, 3e-12})), {1e-6, 3e-6});
  expect_stiffnesses(springs_of(of_stiffness({1e-9, 1e9})), {1e-6, 1e-3});
  expect_stiffnesses(springs_of(of_stiffness({1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9})),
                     {1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9, 1e12});
  EXPECT_EQ(springs_of(of_stiffness({1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9})).clamped(),
            std::nullopt);
  auto with_rigid = of_stiffness({2e11, 1e12, 1.0});
  with_rigid[2].rigid = true;
  expect_stiffnesses(springs_of(with_rigid), {2e8, 1e9, 1e12});
}

TEST(SpringTable, NarrowsMoreWhereTheWholeIsTooLong) {
  std::vector<double> decades;
  for (int i = -12; i <= 12; i += 3) decades.push_back(std::pow(10.0, i));
  decades.push_back(10 * decades.back() / 11);  // a gap of 1.1 is none to narrow
  auto materials = of_stiffness(decades);
  const auto springs = springs_of(materials);
  expect_within_bounds(springs);
  // 18 decades: 7 gaps of G, 1000 / 1.1 narrowed to G, and 1.1.
  const double gap = std::pow(1e18 / 1.1, 1.0 / 8);
  for (int id = 1; id < 8; ++id) {
    EXPECT_NEAR(stiffness(springs, id) / stiffness(springs, id - 1), gap, 1e-4 * gap) << id;
  }
  EXPECT_NEAR(stiffness(springs, 9) / stiffness(springs, 7), gap, 1e-4 * gap);
  EXPECT_NEAR(stiffness(springs, 8) / stiffness(springs, 9), 1.1, 1e-5);
  ASSERT_TRUE(springs.clamped());
  EXPECT_EQ(springs.clamped()->rfind("springs take \"m", 0), 0u) << *springs.clamped();
  EXPECT_NE(springs.clamped()->find("as 175.7 times as stiff"), std::string::npos)
      << *springs.clamped();
}

TEST(SpringTable, OfAFullTableKeepsOrderAndBounds) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> exponent(-12.0, 12.0);
  std::vector<double> stiffnesses{1e-12, 1e12};
  while (stiffnesses.size() < 256) stiffnesses.push_back(std::pow(10.0, exponent(random)));
  auto materials = of_stiffness(stiffnesses);
  materials[100].rigid = true;
  const auto springs = springs_of(materials);
  expect_within_bounds(springs);
  for (int i = 0; i < 256; ++i) {
    for (int j = 0; j < 256; ++j) {
      if (i == 100 || j == 100) continue;
      const auto a = static_cast<std::size_t>(i);
      const auto b = static_cast<std::size_t>(j);
      if (stiffnesses[a] > 1.001 * stiffnesses[b]) {
        ASSERT_GT(stiffness(springs, i), stiffness(springs, j)) << i << ' ' << j;
      }
    }
  }
  EXPECT_NEAR(stiffness(springs, 100) / stiffness(springs, 1), 1000.0, 0.01);
}

TEST(SpringTable, SeesTheLevelsOfInterpolatedRanges) {
  auto materials = of_stiffness({1e-9, 1e9});
  const auto table = table_of(materials, Interpolation::linear);
  ASSERT_EQ(table.count(), 256);
  const auto springs = SpringTable::of(table);
  ASSERT_EQ(springs.count(), 256);
  EXPECT_EQ(springs.clamped(), std::nullopt);
  expect_within_bounds(springs);
  for (int i = 0; i < 256; ++i) {
    const double wanted =
        1000.0 / static_cast<double>(table.compliance(static_cast<MaterialId>(i)));
    EXPECT_NEAR(stiffness(springs, i), wanted, 1e-5 * wanted) << i;
  }
  // The levels of a rigid range are alike, above the last one that is not rigid.
  materials[1].stiffness = 100.0;
  materials[0].stiffness = 1.0;
  materials[1].rigid = true;
  const auto half_rigid = table_of(materials, Interpolation::linear);
  const auto half = SpringTable::of(half_rigid);
  const MaterialId first = half_rigid.id_of(1.0);
  ASSERT_GT(first, 0);
  ASSERT_LT(first, half.count() - 1);
  for (int id = first; id < half.count(); ++id) {
    EXPECT_NEAR(stiffness(half, id), 1000.0 * stiffness(half, first - 1),
                0.01 * stiffness(half, first - 1))
        << id;
  }
  EXPECT_NEAR(stiffness(half, first - 1), 10.0, 0.5);
}

TEST(SpringTable, KnowsWhetherAllHaveOneBlend) {
  auto materials = of_stiffness({1.0, 2.0, 3.0});
  for (Material& m : materials) m.rest_vector_blend = 0.25;
  const auto one = springs_of(materials);
  EXPECT_TRUE(one.one_blend());
  EXPECT_EQ(one.smallest_blend(), 0.25f);
  materials[1].rest_vector_blend = 0.125;
  materials[2].rest_vector_blend = 0.5;
  const auto several = springs_of(materials);
  EXPECT_FALSE(several.one_blend());
  EXPECT_EQ(several.smallest_blend(), 0.125f);
  EXPECT_EQ(several.rest_vector_blend(0), 0.25f);
  EXPECT_EQ(several.rest_vector_blend(1), 0.125f);
  EXPECT_EQ(several.rest_vector_blend(2), 0.5f);
}

}  // namespace
}  // namespace maille
