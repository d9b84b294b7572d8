#include "volume/phantom.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "volume/statistics.h"

namespace maille {
namespace {

constexpr double kPi = 3.14159265358979323846;

Volume make(std::string_view name, Size3 size, std::uint64_t seed = 1) {
  auto volume = make_phantom(name, size, seed);
  EXPECT_TRUE(volume.ok()) << volume.error().message;
  return *std::move(volume);
}

// FNV-1a
std::uint64_t hash_of(const Volume& volume) {
  std::uint64_t hash = 14695981039346656037u;
  for (const auto byte : volume.bytes()) {
    hash = (hash ^ static_cast<std::uint64_t>(byte)) * 1099511628211u;
  }
  return hash;
}

VoxelIndex voxel_at(const Volume& volume, glm::dvec3 mm) {
  const auto voxel = transform_point(glm::inverse(volume.world_from_voxel()), mm);
  return VoxelIndex(glm::round(voxel));
}

class Phantoms : public testing::TestWithParam<std::string_view> {};

TEST_P(Phantoms, AreTheSameForAnyNumberOfThreadsAndAtEveryCall) {
  const Size3 size(45, 38, 51);
  WorkerPool one(1), many(8);
  const auto a = make_phantom(GetParam(), size, 7, one);
  const auto b = make_phantom(GetParam(), size, 7, many);
  const auto c = make_phantom(GetParam(), size, 7);
  ASSERT_TRUE(a.ok() && b.ok() && c.ok());
  EXPECT_EQ(hash_of(*a), hash_of(*b));
  EXPECT_EQ(hash_of(*a), hash_of(*c));
}

TEST_P(Phantoms, MindTheSeedOnlyInNoise) {
  const Size3 size(40, 40, 40);
  const auto a = make(GetParam(), size, 1), b = make(GetParam(), size, 2);
  const bool has_noise = a.type() != VoxelType::uint8;
  EXPECT_EQ(hash_of(a) != hash_of(b), has_noise);
  const double most = a.type() == VoxelType::uint16 ? 1100 : 60;
  for (int z = 0; z < 40; ++z) {
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 40; ++x) {
        ASSERT_LT(std::abs(a.value_at({x, y, z}) - b.value_at({x, y, z})), most);
      }
    }
  }
}

TEST_P(Phantoms, ComeInEverySize) {
  for (const Size3 size : {Size3(1, 1, 1), Size3(1, 64, 3), Size3(100, 2, 9), Size3(7, 7, 300)}) {
    const auto volume = make(GetParam(), size);
    EXPECT_EQ(volume.size(), size);
    EXPECT_EQ(volume.bytes().size(),
              static_cast<std::size_t>(voxel_count(size)) * bytes_per_voxel(volume.type()));
  }
}

// The extent in mm does not depend on the number of voxels.
TEST_P(Phantoms, FillTheirBox) {
  const auto a = make(GetParam(), {20, 30, 40}), b = make(GetParam(), {41, 17, 23});
  const glm::dvec3 extent_a = a.spacing_mm() * glm::dvec3(a.size());
  const glm::dvec3 extent_b = b.spacing_mm() * glm::dvec3(b.size());
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(extent_a[axis], extent_b[axis], 1e-9);
}

INSTANTIATE_TEST_SUITE_P(All, Phantoms,
                         testing::ValuesIn(phantom_names().begin(), phantom_names().end()),
                         [](const auto& name) { return std::string(name.param); });

// The same bits on every machine. Whoever changes a shape on purpose changes its number here.
TEST(Phantom, GoldenHashes) {
  const Size3 size(37, 41, 43);
  const std::vector<std::pair<std::string_view, std::uint64_t>> golden = {
      {"hydrogen", 16584813624177912119u},
      {"head", 7092539105159161657u},
      {"endoscopy", 12999806586224724647u},
      {"beetle", 797518051956639196u},
      {"spheres", 9213896867106444143u}};
  for (const auto& [name, hash] : golden) EXPECT_EQ(hash_of(make(name, size)), hash) << name;
}

TEST(Phantom, WhatCannotBeMadeIsWrongUsage) {
  for (const auto& [name, size] : std::vector<std::pair<std::string_view, Size3>>{
           {"haed", {8, 8, 8}},
           {"", {8, 8, 8}},
           {"head", {0, 8, 8}},
           {"head", {8, -1, 8}},
           {"head", {2000000000, 2000000000, 2000000000}},
           {"spheres", {100000, 100000, 10000}}}) {
    const auto volume = make_phantom(name, size, 1);
    ASSERT_FALSE(volume.ok()) << name;
    EXPECT_EQ(volume.error().kind, ErrorKind::usage);
    EXPECT_NE(volume.error().message.find("expected"), std::string::npos);
  }
}

TEST(HeadPhantom, TissuesLieWhereTheyShould) {
  const auto head = make("head", {200, 240, 276});
  const auto hu = [&](double x, double y, double z) {
    return head.value_at(voxel_at(head, {x, y, z}));
  };
  EXPECT_EQ(hu(0, -120, 60), -1000) << "before the forehead";
  EXPECT_EQ(hu(95, 100, 110), -1000) << "a corner";
  EXPECT_NEAR(hu(20, 10, 70), 34, 32) << "brain";
  EXPECT_GT(hu(0, 4, 111), 300) << "vault";
  EXPECT_GT(hu(0, -88, -100), 300) << "chin";
  EXPECT_GT(hu(0, 21, -95), 300) << "a vertebra";
  EXPECT_EQ(hu(0, -11, -90), -1000) << "throat";
  EXPECT_EQ(hu(24, -60, -32), -1000) << "maxillary sinus";
  EXPECT_NEAR(hu(31, -77, 0), 15, 25) << "left eye";
  EXPECT_NEAR(hu(-31, -77, 0), 15, 25) << "right eye";
  EXPECT_NEAR(hu(0, -110, -36), 48, 40) << "tip of the nose";
  EXPECT_NEAR(hu(45, 30, -100), 48, 140) << "neck";
  EXPECT_GT(hu(3, -88, -57), 1500) << "an upper tooth";
  const auto statistics = statistics_of(head);
  EXPECT_EQ(statistics.lowest, -1000);
  EXPECT_NEAR(statistics.highest, 2115, 25);
}

// Coming from outside, one meets air, then skin and fat, then bone, then brain.
TEST(HeadPhantom, LayersFollowOneAnotherThroughTheForehead) {
  const auto head = make("head", {200, 240, 276});
  double skin_y = 1e9, bone_y = 1e9, brain_y = 1e9;
  for (double y = -127; y < 0; y += 0.5) {
    const double hu = head.value_at(voxel_at(head, {0, y, 60}));
    if (hu > -500 && skin_y > 1e8) skin_y = y;
    if (hu > 300 && bone_y > 1e8) bone_y = y;
    if (hu < 100 && bone_y < 1e8 && brain_y > 1e8) brain_y = y;
  }
  EXPECT_GT(bone_y - skin_y, 2);
  EXPECT_LT(bone_y - skin_y, 12);
  EXPECT_GT(brain_y - bone_y, 3);
  EXPECT_LT(brain_y - bone_y, 12);
}

TEST(HeadPhantom, LiesInLpsWithItsFaceForwards) {
  const auto head = make("head", {100, 120, 138});
  const auto& world = head.world_from_voxel();
  for (int axis = 0; axis < 3; ++axis) EXPECT_GT(world[axis][axis], 0);
  const glm::dvec3 extent = head.spacing_mm() * glm::dvec3(head.size());
  EXPECT_NEAR(extent.x, 200, 1e-9);
  EXPECT_NEAR(extent.y, 240, 1e-9);
  EXPECT_NEAR(extent.z, 276, 1e-9);
}

// By volume: how many voxels hold at least half of what a ball holds.
TEST(SpheresPhantom, RadiiAreThoseOfTheFormula) {
  const Size3 size(100, 125, 80);
  const auto spheres = make("spheres", size);
  const glm::dvec3 spacing = spheres.spacing_mm();
  const double voxel_mm3 = spacing.x * spacing.y * spacing.z;
  double above_inner = 0, above_zero = 0;
  for (const auto value : spheres.voxels<std::uint8_t>()) {
    above_inner += value >= 130;  // between outer 120 and inner 200: only the inner ball
    above_zero += value >= 60;
  }
  const auto radius = [&](double voxels) { return std::cbrt(voxels * voxel_mm3 * 3 / (4 * kPi)); };
  EXPECT_NEAR(radius(above_inner), 20, 0.35);
  EXPECT_NEAR(radius(above_zero), 44, 0.35);  // 60 is half of 120
  const auto at = [&](double x) { return spheres.value_at(voxel_at(spheres, {x, 0, 0})); };
  EXPECT_EQ(at(0), 200);
  EXPECT_EQ(at(26), 60);
  EXPECT_EQ(at(38), 120);
  EXPECT_EQ(at(48), 0);
}

TEST(HydrogenPhantom, HasTheShapeOfTheOrbital) {
  const auto hydrogen = make("hydrogen", {65, 65, 65});
  const auto density = [&](glm::dvec3 bohr) {
    return hydrogen.value_at(voxel_at(hydrogen, bohr * (32.0 / 17.0)));
  };
  EXPECT_NEAR(density({0, 0, 6}), 255, 2);
  EXPECT_NEAR(density({0, 0, -6}), 255, 2);
  EXPECT_NEAR(density({6, 0, 0}), 255.0 / 4, 2);
  EXPECT_NEAR(density({0, -6, 0}), 255.0 / 4, 2);
  EXPECT_EQ(density({0, 0, 0}), 0);
  // The nodal cone 3 z^2 = r^2.
  EXPECT_NEAR(density(glm::dvec3(1, 1, 1) * (6 / std::sqrt(3.0))), 0, 2);
}

TEST(EndoscopyPhantom, TheLumenGoesThroughFromEndToEnd) {
  const Size3 size(60, 60, 80);
  const auto bowel = make("endoscopy", size);
  const auto is_air = [&](VoxelIndex v) { return bowel.value_at(v) < -500; };
  std::vector<bool> seen(static_cast<std::size_t>(voxel_count(size)));
  std::vector<VoxelIndex> open;
  const auto visit = [&](VoxelIndex v) {
    if (!contains(size, v) || !is_air(v)) return;
    const auto at = static_cast<std::size_t>(linear_index(v, size));
    if (!seen[at]) open.push_back(v);
    seen[at] = true;
  };
  for (int y = 0; y < size.y; ++y) {
    for (int x = 0; x < size.x; ++x) visit({x, y, 0});
  }
  ASSERT_FALSE(open.empty());
  bool reaches_top = false;
  while (!open.empty()) {
    const auto v = open.back();
    open.pop_back();
    reaches_top = reaches_top || v.z == size.z - 1;
    for (int axis = 0; axis < 3; ++axis) {
      VoxelIndex step(0);
      step[axis] = 1;
      visit(v + step);
      visit(v - step);
    }
  }
  EXPECT_TRUE(reaches_top);
}

TEST(BeetlePhantom, IsHollow) {
  const auto beetle = make("beetle", {200, 300, 120});
  const auto value = [&](double x, double y, double z) {
    return beetle.value_at(voxel_at(beetle, {x, y, z}));
  };
  EXPECT_EQ(value(19, 25, 10), 0) << "outside";
  EXPECT_LT(value(2, 12, -1), 5000) << "inside";
  double most = 0;
  for (double z = 2; z < 11; z += 0.1) most = std::max(most, value(4, 8, z));
  EXPECT_GT(most, 30000) << "the wing case above";
}

}  // namespace
}  // namespace maille
