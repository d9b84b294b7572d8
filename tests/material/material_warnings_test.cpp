#include "material/material_warnings.h"

#include <gtest/gtest.h>

#include "material/limits_from_stiffness.h"
#include "material/material_table.h"

namespace maille {
namespace {

using Sentences = std::vector<std::string>;

Material material(const char* name, double stiffness, double compress, double stretch,
                  double shear) {
  Material m;
  m.name = name;
  m.stiffness = stiffness;
  m.compress = glm::dvec3(compress);
  m.stretch = glm::dvec3(stretch);
  m.shear = glm::dvec3(shear);
  return m;
}

Sentences warnings(const std::vector<Material>& materials) {
  return warnings_of(materials, Interpolation::step);
}

TEST(MaterialWarnings, SayWhereADragMayFold) {
  Material loose = material("loose", 1, 0.6, 1.5, 0.1);
  loose.shear.y = 0.3;
  EXPECT_EQ(warnings({material("safe", 1, 0.6, 1.5, 0.29), loose}),
            Sentences({"material \"loose\": compress 0.6 is not above twice shear 0.3: a drag may "
                       "fold its cells"}));
  EXPECT_TRUE(warnings({material("no shear", 1, 0.0, 1.5, 0.0)}).empty());
}

TEST(MaterialWarnings, SayWhatIsStifferAndYetWider) {
  const Material soft = material("soft", 1, 0.6, 1.5, 0.1);
  EXPECT_EQ(warnings({soft, material("firm", 2, 0.6, 1.75, 0.1)}),
            Sentences({"material \"firm\": is stiffer than \"soft\" (2 against 1) but may stretch "
                       "further (1.75 against 1.5)"}));
  EXPECT_EQ(warnings({material("firm", 2, 0.5, 1.5, 0.1), soft}),
            Sentences({"material \"firm\": is stiffer than \"soft\" (2 against 1) but may be "
                       "compressed further (0.5 against 0.6)"}));
  Material along_z = material("firm", 2, 0.6, 1.5, 0.1);
  along_z.shear.z = 0.2;
  EXPECT_EQ(warnings({soft, along_z}),
            Sentences({"material \"firm\": is stiffer than \"soft\" (2 against 1) but may shear "
                       "further along z (0.2 against 0.1)"}));
  // Each once, against the one it differs from most; as stiff is not stiffer.
  EXPECT_EQ(
      warnings({soft, material("narrow", 1, 0.6, 1.25, 0.1), material("firm", 2, 0.6, 1.4, 0.1)}),
      Sentences({"material \"firm\": is stiffer than \"narrow\" (2 against 1) but may "
                 "stretch further (1.4 against 1.25)"}));
  EXPECT_TRUE(warnings({soft, material("as stiff", 1, 0.6, 1.75, 0.1)}).empty());
}

TEST(MaterialWarnings, SayOnceWhenForcesDifferByMoreThanFour) {
  const Material soft = material("soft", 1, 0.6, 1.5, 0.1);
  // Ten times as stiff: within four is 0.4 of the room, or a fortieth.
  EXPECT_TRUE(warnings({soft, material("firm", 10, 0.85, 1.19, 0.039)}).empty());
  EXPECT_TRUE(warnings({soft, material("firm", 10, 0.98, 1.02, 0.0026)}).empty());
  EXPECT_EQ(warnings({soft, material("firm", 10, 0.85, 1.25, 0.039)}),
            Sentences({"limits and stiffness disagree: it takes 5 times the force to bring "
                       "\"firm\" to its stretch limit that it takes with \"soft\""}));
  EXPECT_EQ(warnings({soft, material("firm", 10, 0.98, 1.02, 0.002)}),
            Sentences({"limits and stiffness disagree: it takes 5 times the force to bring "
                       "\"soft\" to its shear limit that it takes with \"firm\""}));
  // Also where no two neighbours in stiffness are four apart.
  EXPECT_EQ(
      warnings({soft, material("b", 3, 0.6, 1.5, 0.1), material("c", 9, 0.6, 1.5, 0.1)}).size(),
      1u);
  EXPECT_EQ(warnings({soft, material("firm", 50, 0.992, 1.252, 0.002)}),
            Sentences({"limits and stiffness disagree: it takes 25 times the force to bring "
                       "\"firm\" to its stretch limit that it takes with \"soft\""}));
  // A direction without room says nothing.
  EXPECT_TRUE(warnings({soft, material("firm", 10, 1.0, 1.1, 0.0)}).empty());
}

TEST(MaterialWarnings, LeaveOutWhatDoesNotDeform) {
  const Material soft = material("soft", 1, 0.6, 1.5, 0.1);
  Material bone = material("bone", 1000, 0.5, 3.0, 0.2);
  EXPECT_EQ(warnings({soft, bone}).size(), 1u);
  bone.fixed = true;
  EXPECT_TRUE(warnings({soft, bone}).empty());
  bone = material("bone", 1000, 1.0, 1.0, 0.0);
  EXPECT_TRUE(warnings({soft, bone}).empty());
  bone.rigid = true;
  EXPECT_TRUE(warnings({soft, bone}).empty());
}

TEST(MaterialWarnings, SayWhatIsTooStiffToDeform) {
  Material m = material("m", 1, 0.6, 1.5, 0.1);
  Material stiff = m;
  m.value_high = 1.0;
  stiff.value_low = 1.0;
  stiff.value_high = 2.0;
  stiff.name = "stiff";
  stiff.stiffness = 257.0;  // half a voxel of stretch is 256 units
  auto derived = limits_from_stiffness({m, stiff});
  ASSERT_TRUE(derived.ok());
  EXPECT_EQ(warnings(*derived),
            Sentences({"material \"stiff\": its limits are below 1/512 voxel: it acts as rigid"}));
  stiff.stiffness = 255.0;
  derived = limits_from_stiffness({m, stiff});
  ASSERT_TRUE(derived.ok());
  EXPECT_TRUE(warnings(*derived).empty());
}

TEST(MaterialWarnings, SayWhenForcesPartBetweenInterpolatedMaterials) {
  const auto derived = [](double stiffness) {
    Material a;
    Material b;
    a.name = "a";
    b.name = "b";
    a.value_high = b.value_low = 1.0;
    b.value_high = 2.0;
    b.stiffness = stiffness;
    return std::move(limits_from_stiffness({a, b})).value();
  };
  // (sqrt(R) + 1/sqrt(R)) / 2: 3.6 for 50, 5.05 for 100.
  EXPECT_TRUE(warnings_of(derived(50), Interpolation::linear).empty());
  EXPECT_TRUE(warnings_of(derived(100), Interpolation::step).empty());
  EXPECT_EQ(warnings_of(derived(100), Interpolation::linear),
            Sentences({"limits and stiffness disagree between \"a\" and \"b\", where they are "
                       "interpolated: halfway it takes 5.05 times the force to come to the "
                       "limits"}));
}

// A preset's warnings are few: one for each tissue that may fold, one where stiffness and limits
// part company.
TEST(MaterialWarnings, OfThePresetsAreFew) {
  const auto ct = MaterialTable::ct().warnings();
  ASSERT_EQ(ct.size(), 4u);
  EXPECT_NE(ct[3].find("disagree"), std::string::npos) << ct[3];
  EXPECT_EQ(MaterialTable::relative(0, 255).warnings(),
            Sentences({"material \"firm\": is stiffer than \"soft\" (1 against 0.1) but may shear "
                       "further (0.3 against 0.24)"}));
}

}  // namespace
}  // namespace maille
