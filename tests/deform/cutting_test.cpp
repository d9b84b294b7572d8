#include "deform/cutting.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "deform/violations.h"
#include "tests/deform/lattices.h"
#include "tests/deform/scenes.h"

namespace maille {
namespace {

using testing::consistent;
using testing::for_each_link_of;
using testing::for_each_voxel;
using testing::pieces;
using testing::place_of;
using testing::random_lattice;
using testing::removed_links;

CutSurface polygon(const std::vector<glm::dvec3>& corners) {
  auto surface = CutSurface::polygon(corners);
  EXPECT_TRUE(surface.ok()) << (surface.ok() ? "" : surface.error().message);
  return std::move(surface).value();
}

Cuts cut(const Lattice& lattice, const CutSurface& surface) {
  auto cuts = cut_along(Cuts(lattice.grid().volume_size()), lattice, surface);
  EXPECT_TRUE(cuts.ok());
  return std::move(cuts).value();
}

// A square around a point, as large as anything here.
std::vector<glm::dvec3> square(glm::dvec3 center, glm::dvec3 normal, double half_edge) {
  const glm::dvec3 n = glm::normalize(normal);
  const glm::dvec3 other = std::abs(n.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 a = glm::normalize(glm::cross(n, other)) * half_edge;
  const glm::dvec3 b = glm::normalize(glm::cross(n, a)) * half_edge;
  return {center - a - b, center + a - b, center + a + b, center - a + b};
}

// No piece has elements on both sides. side(voxel): -1, 1, or 0 where it is too close to tell.
template <class Side>
void expect_parted(const Cuts& cuts, Side&& side) {
  const Size3 size = cuts.grid().volume_size();
  const std::vector<int> piece = pieces(cuts);
  std::set<int> below;
  std::set<int> above;
  std::size_t i = 0;
  for_each_voxel(size, [&](VoxelIndex v) {
    const int s = side(v);
    if (s < 0) below.insert(piece[i]);
    if (s > 0) above.insert(piece[i]);
    ++i;
  });
  EXPECT_FALSE(below.empty());
  EXPECT_FALSE(above.empty());
  for (const int p : below) EXPECT_FALSE(above.contains(p));
}

TEST(Cutting, AxisAlignedPlanesPartTheVolumeAtWholeAndHalfPlaces) {
  const Size3 size{36, 35, 34};
  const Lattice rest(size);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double at : {0.0, 0.5, 7.0, 31.0, 31.5, 31.75, 32.0, 31.0 + 1.0 / 65536}) {
      // Just as large as the volume: its edges run through the border's elements.
      std::vector<glm::dvec3> corners(4);
      const int a = (axis + 1) % 3;
      const int b = (axis + 2) % 3;
      for (std::size_t i = 0; i < 4; ++i) {
        corners[i][axis] = at;
        corners[i][a] = i == 1 || i == 2 ? size[a] - 1 : 0;
        corners[i][b] = i >= 2 ? size[b] - 1 : 0;
      }
      const Cuts cuts = cut(rest, polygon(corners));
      // Elements on the surface are on the lower side.
      expect_parted(cuts, [&](VoxelIndex v) { return v[axis] <= at ? -1 : 1; });
      for_each_link_of(size, [&](VoxelIndex lower, int link_axis, VoxelIndex upper) {
        const bool across = link_axis == axis && lower[axis] <= at && upper[axis] > at;
        EXPECT_EQ(cuts.removed(lower, link_axis), across) << lower.x << lower.y << lower.z;
      });
      EXPECT_TRUE(consistent(cuts));
    }
  }
}

TEST(Cutting, ObliquePlanesThroughElementsPartTheVolume) {
  const Size3 size{20, 36, 18};
  const Lattice rest(size);
  for (const glm::ivec3 normal :
       {glm::ivec3(1, 1, 0), glm::ivec3(1, -1, 0), glm::ivec3(1, 1, 1), glm::ivec3(-1, 1, 1),
        glm::ivec3(2, 1, 0), glm::ivec3(1, -2, 3), glm::ivec3(0, -1, -1)}) {
    // Exactly through elements, and with whole corners: u x v = normal * scale.
    const glm::ivec3 u =
        normal.x || normal.y ? glm::ivec3(-normal.y, normal.x, 0) : glm::ivec3(1, 0, 0);
    const glm::ivec3 v(normal.y * u.z - normal.z * u.y, normal.z * u.x - normal.x * u.z,
                       normal.x * u.y - normal.y * u.x);
    const glm::ivec3 center = size / 2;
    const std::vector<glm::dvec3> corners{
        glm::dvec3(center - 60 * u - 60 * v), glm::dvec3(center + 60 * u - 60 * v),
        glm::dvec3(center + 60 * u + 60 * v), glm::dvec3(center - 60 * u + 60 * v)};
    const Cuts cuts = cut(rest, polygon(corners));
    const int first = normal.x ? normal.x : normal.y ? normal.y : normal.z;
    const auto side = [&](VoxelIndex voxel) {
      const glm::ivec3 d = voxel - center;
      const int height = d.x * normal.x + d.y * normal.y + d.z * normal.z;
      return height != 0 ? (height > 0 ? 1 : -1) : (first > 0 ? -1 : 1);
    };
    expect_parted(cuts, side);
    for_each_link_of(size, [&](VoxelIndex lower, int axis, VoxelIndex upper) {
      ASSERT_EQ(cuts.removed(lower, axis), side(lower) != side(upper));
    });
  }
}

// Fans around a corner that is an element, sharing edges that run through rows of elements.
TEST(Cutting, SharedEdgesAndCornersLetNothingThrough) {
  const Size3 size{12, 12, 12};
  const Lattice rest(size);
  const std::vector<glm::dvec3> star{{-9, -9, 5}, {5, -9, 5}, {20, -9, 5}, {20, 5, 5},
                                     {20, 20, 5}, {5, 20, 5}, {-9, 20, 5}, {-9, 5, 5},
                                     {-9, 5, 5},  {-9, -9, 5}};
  expect_parted(cut(rest, polygon(star)), [](VoxelIndex v) { return v.z <= 5 ? -1 : 1; });
  // A blade in zigzag: its folds run along rows of elements.
  const std::vector<glm::dvec3> path{{-8, 5, -4}, {0, 5, -4},  {3, 8, -4}, {6, 5, -4},
                                     {9, 2, -4},  {11, 4, -4}, {25, 4, -4}};
  const auto blade = CutSurface::sweep(path, {0, 0, 30});
  ASSERT_TRUE(blade.ok());
  expect_parted(cut(rest, *blade), [&](VoxelIndex v) {
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
      if (v.x > path[i + 1].x) continue;
      const double y =
          path[i].y + (path[i + 1].y - path[i].y) * (v.x - path[i].x) / (path[i + 1].x - path[i].x);
      return std::abs(v.y - y) < 1e-9 ? 0 : v.y < y ? -1 : 1;
    }
    return 0;
  });
}

class CuttingAtRandom : public ::testing::TestWithParam<int> {};

TEST_P(CuttingAtRandom, PlanesPartDeformedVolumes) {
  const int seed = GetParam();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(static_cast<unsigned>(seed));
  std::uniform_real_distribution<double> number(-1, 1);
  const Size3 size{40, 35, 34};
  // From less than a voxel to links that lie across many others; multiples of 1/2 voxel make ties.
  const int most = seed % 3 == 0 ? 200 : seed % 3 == 1 ? 5 * kUnitsPerVoxel : 2;
  Lattice lattice = random_lattice(size, most, 0.3, random);
  if (seed % 3 == 2) {
    std::vector<glm::ivec3> u;
    for_each_voxel(size, [&](VoxelIndex v) { u.push_back(lattice.u(v) * (kUnitsPerVoxel / 2)); });
    lattice = testing::lattice_of(size, u);
  }
  for (int round = 0; round < 4; ++round) {
    glm::dvec3 normal{number(random), number(random), number(random)};
    glm::dvec3 center = glm::dvec3(size) * 0.5 + 5.0 * normal;
    if (round == 0) {  // ties
      normal = {seed % 2 ? 1.0 : 0.0, 1.0, 0.0};
      center = glm::floor(center);
    }
    if (glm::length(normal) < 0.1) continue;
    normal = glm::normalize(normal);
    const std::vector<glm::dvec3> corners = square(center, normal, 120.0);
    const Cuts cuts = cut(lattice, polygon(corners));
    EXPECT_TRUE(consistent(cuts));
    const auto height = [&](VoxelIndex v) {
      return glm::dot(place_of(lattice, v) - center, normal);
    };
    // Corners are rounded: too close to tell within 1/10000 voxel.
    const auto side = [&](VoxelIndex v) {
      const double h = height(v);
      return std::abs(h) < 1e-4 ? 0 : h < 0 ? -1 : 1;
    };
    expect_parted(cuts, side);
    for_each_link_of(size, [&](VoxelIndex lower, int axis, VoxelIndex upper) {
      if (side(lower) == 0 || side(upper) == 0) return;
      ASSERT_EQ(cuts.removed(lower, axis), side(lower) != side(upper));
    });
  }
}

// A disc, against plain geometry in mm.
TEST_P(CuttingAtRandom, DiscsCutWhatTheyCover) {
  const int seed = GetParam();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(static_cast<unsigned>(seed) + 100);
  std::uniform_real_distribution<double> number(-1, 1);
  const Size3 size{44, 40, 36};
  const glm::dvec3 spacing_mm{0.7, 1.0, 2.5};
  const Lattice lattice = random_lattice(size, seed % 2 ? 300 : 2000, 0.4, random);
  const glm::dvec3 normal =
      glm::normalize(glm::dvec3(number(random), number(random), number(random) + 0.01));
  const glm::dvec3 center = glm::dvec3(size) * 0.5 + 8.0 * normal;
  const double radius_mm = 11.0;
  const auto disc = CutSurface::disc(center, 3.0 * normal, radius_mm, spacing_mm);
  ASSERT_TRUE(disc.ok());
  const Cuts cuts = cut(lattice, *disc);
  std::int64_t compared = 0;
  for_each_link_of(size, [&](VoxelIndex lower, int axis, VoxelIndex upper) {
    const glm::dvec3 p = (place_of(lattice, lower) - center) * spacing_mm;
    const glm::dvec3 q = (place_of(lattice, upper) - center) * spacing_mm;
    const double below = glm::dot(p, normal);
    const double above = glm::dot(q, normal);
    if (std::abs(below) < 1e-3 || std::abs(above) < 1e-3) return;
    bool expected = false;
    if ((below < 0) != (above < 0)) {
      const double away = glm::length(p + (q - p) * (below / (below - above)));
      if (std::abs(away - radius_mm) < radius_mm / 2000) return;
      expected = away < radius_mm;
    }
    ++compared;
    ASSERT_EQ(cuts.removed(lower, axis), expected);
  });
  EXPECT_GT(removed_links(cuts), 50);
  EXPECT_GT(compared, 100000);
}

// A star of many corners in an oblique plane, against the even-odd rule.
TEST_P(CuttingAtRandom, PolygonsCutWhatTheyCover) {
  const int seed = GetParam();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(static_cast<unsigned>(seed) + 200);
  std::uniform_real_distribution<double> number(-1, 1);
  const Size3 size{44, 40, 36};
  const Lattice lattice = random_lattice(size, seed % 2 ? 300 : 2000, 0.4, random);
  const glm::dvec3 normal =
      glm::normalize(glm::dvec3(number(random), number(random), number(random) + 0.01));
  const glm::dvec3 center = glm::dvec3(size) * 0.5 + 3.0 * normal;
  const std::vector<glm::dvec3> frame = square({0, 0, 0}, normal, 1.0);
  const glm::dvec3 right = glm::normalize(frame[1] - frame[0]);
  const glm::dvec3 up = glm::normalize(frame[3] - frame[0]);
  std::vector<glm::dvec2> outline;
  const int n = 5 + static_cast<int>(random() % 20);
  for (int i = 0; i < n; ++i) {
    const double angle = 6.283185307179586 * i / n * (seed % 4 < 2 ? 1 : -1);
    const double r = 10.0 + 7.0 * number(random);
    outline.emplace_back(r * std::cos(angle), r * std::sin(angle));
  }
  std::vector<glm::dvec3> corners;
  for (const glm::dvec2& p : outline) corners.push_back(center + p.x * right + p.y * up);
  const Cuts cuts = cut(lattice, polygon(corners));
  std::int64_t across = 0;
  for_each_link_of(size, [&](VoxelIndex lower, int axis, VoxelIndex upper) {
    const glm::dvec3 p = place_of(lattice, lower) - center;
    const glm::dvec3 q = place_of(lattice, upper) - center;
    const double below = glm::dot(p, normal);
    const double above = glm::dot(q, normal);
    if (std::abs(below) < 1e-3 || std::abs(above) < 1e-3) return;
    bool expected = false;
    if ((below < 0) != (above < 0)) {
      const glm::dvec3 hit = p + (q - p) * (below / (below - above));
      const glm::dvec2 h(glm::dot(hit, right), glm::dot(hit, up));
      for (int i = 0; i < n; ++i) {
        const glm::dvec2 a = outline[static_cast<std::size_t>(i)];
        const glm::dvec2 b = outline[static_cast<std::size_t>((i + 1) % n)];
        const double t = glm::clamp(glm::dot(h - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
        if (glm::length(h - a - t * (b - a)) < 2e-3) return;
        if ((a.y > h.y) != (b.y > h.y) && h.x < a.x + (b.x - a.x) * (h.y - a.y) / (b.y - a.y)) {
          expected = !expected;
        }
      }
    }
    across += expected;
    ASSERT_EQ(cuts.removed(lower, axis), expected);
  });
  EXPECT_GT(across, 50);
}

INSTANTIATE_TEST_SUITE_P(Seeds, CuttingAtRandom, ::testing::Range(1, 13));

TEST(Cutting, ASecondCutAddsAndKeepsTheBricksOfTheFirst) {
  const Size3 size{70, 40, 40};
  const Lattice rest(size);
  const std::vector<glm::dvec3> left{{5.5, 2, 2}, {5.5, 20, 2}, {5.5, 20, 20}, {5.5, 2, 20}};
  const std::vector<glm::dvec3> right{{50.5, 2, 2}, {50.5, 20, 2}, {50.5, 20, 20}, {50.5, 2, 20}};
  const Cuts first = cut(rest, polygon(left));
  const auto both = cut_along(first, rest, polygon(right));
  ASSERT_TRUE(both.ok());
  EXPECT_EQ(removed_links(first), 19 * 19);
  EXPECT_EQ(removed_links(*both), 2 * 19 * 19);
  EXPECT_EQ(first.shared(0), both->shared(0));
  const auto again = cut_along(*both, rest, polygon(right));
  ASSERT_TRUE(again.ok());
  Cuts::for_each_difference(*both, *again, [](std::int64_t b) { ADD_FAILURE() << b; });
}

TEST(Cutting, BesidesTheVolumeNothingIsCut) {
  const Lattice rest(Size3(40, 40, 40));
  const std::vector<glm::dvec3> beyond{{60, 2, 2}, {60, 20, 2}, {60, 20, 20}};
  EXPECT_TRUE(cut(rest, polygon(beyond)).empty());
  const std::vector<glm::dvec3> far{{8e6, 2, 2}, {8e6, 20, 2}, {-8e6, 20, -8e6}};
  EXPECT_TRUE(consistent(cut(rest, polygon(far))));
}

TEST(Cutting, CollapsedLinksStay) {
  const Size3 size{8, 8, 8};
  std::vector<glm::ivec3> u;  // all layers in one
  for_each_voxel(size, [&](VoxelIndex v) { u.emplace_back(0, 0, -v.z * kUnitsPerVoxel); });
  const Lattice flat = testing::lattice_of(size, u);
  const std::vector<glm::dvec3> through{{-1, -1, 0}, {9, -1, 0}, {9, 9, 0}, {-1, 9, 0}};
  EXPECT_TRUE(cut(flat, polygon(through)).empty());
}

// A surface far from where both ends of its links rest, and from both bricks' elements.
TEST(Cutting, LinksStretchedFarBeyondTheirBricks) {
  const Size3 size{64, 8, 8};
  for (const int sign : {1, -1}) {
    std::vector<glm::ivec3> u;  // the upper or the lower brick far away, the other at rest
    for_each_voxel(size, [&](VoxelIndex v) {
      u.emplace_back((v.x >= 32) == (sign > 0) ? sign * 200 * kUnitsPerVoxel : 0, 0, 0);
    });
    const Lattice lattice = testing::lattice_of(size, u);
    const Cuts cuts = cut(lattice, polygon(square({sign * 130.2, 4, 4}, {1, 0, 0}, 20)));
    EXPECT_EQ(removed_links(cuts), 64);
    EXPECT_TRUE(cuts.removed({31, 7, 7}, 0));
  }
}

// One voxel thick, one row, one voxel.
TEST(Cutting, ThinVolumes) {
  const CutSurface plane = polygon(square({2.5, 0, 0}, {1, 0, 0}, 50));
  EXPECT_EQ(removed_links(cut(Lattice(Size3(9, 9, 1)), plane)), 9);
  EXPECT_EQ(removed_links(cut(Lattice(Size3(9, 1, 1)), plane)), 1);
  EXPECT_EQ(removed_links(cut(Lattice(Size3(1, 1, 1)), plane)), 0);
}

TEST(Cutting, SmallCutsInLargeVolumesAreInstant) {
  const Lattice rest(Size3(832, 832, 494));
  const Cuts none(rest.grid().volume_size());
  const auto disc = CutSurface::disc({400, 400, 250}, {1, 2, 3}, 12, glm::dvec3(1));
  ASSERT_TRUE(disc.ok());
  const auto start = std::chrono::steady_clock::now();
  const auto cuts = cut_along(none, rest, *disc);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  ASSERT_TRUE(cuts.ok());
  EXPECT_FALSE(cuts->empty());
  EXPECT_LT(seconds.count(), 1.0);  // some milliseconds; far more only if all were looked at
  std::printf("disc of radius 12 in 832x832x494: %.2f ms\n", 1e3 * seconds.count());
}

void expect_refused(const Result<CutSurface>& surface, const std::string& reason) {
  ASSERT_FALSE(surface.ok());
  EXPECT_EQ(surface.error().kind, ErrorKind::usage);
  EXPECT_NE(surface.error().message.find(reason), std::string::npos) << surface.error().message;
}

TEST(CutSurface, SaysWhatIsWrong) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  const auto of = [](std::vector<glm::dvec3> corners) { return CutSurface::polygon(corners); };
  expect_refused(of({}), "at least 3");
  expect_refused(of({{0, 0, 0}, {1, 0, 0}}), "at least 3");
  expect_refused(of({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}), "at least 3");
  expect_refused(of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}), "no area");
  expect_refused(of({{0, 0, 0}, {1, nan, 0}, {2, 0, 0}}), "point 1");
  expect_refused(of({{0, 0, 0}, {1, 0, 0}, {2, 0, infinite}}), "point 2");
  expect_refused(of({{0, 0, 0}, {1e7, 0, 0}, {2, 5, 0}}), "point 1");
  expect_refused(of({{0, 0, 0}, {4, 4, 0}, {4, 0, 0}, {0, 5, 0}}), "touch or cross");
  expect_refused(of({{0, 0, 0}, {4, 0, 0}, {2, 0, 0}, {2, 3, 0}}), "touch or cross");
  expect_refused(of({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 0, 0}, {0, 4, 0}}), "touch or cross");
  expect_refused(of({{0, 0, 0}, {10, 0, 9}, {10, 10, 0}, {0, 10, 9}}), "flat");
  EXPECT_TRUE(of({{0, 0, 0}, {10, 0, 0.3}, {10, 10, 0}, {0, 10, 0.3}}).ok());
  EXPECT_TRUE(of({{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 0, 0}}).ok());  // closed by hand

  const glm::dvec3 one(1);
  expect_refused(CutSurface::disc({0, 0, 0}, {0, 0, 0}, 1, one), "normal");
  expect_refused(CutSurface::disc({0, 0, 0}, {0, nan, 0}, 1, one), "normal");
  expect_refused(CutSurface::disc({0, 0, 0}, {0, 0, 1}, 0, one), "radius");
  expect_refused(CutSurface::disc({0, 0, 0}, {0, 0, 1}, nan, one), "radius");
  expect_refused(CutSurface::disc({0, 0, 0}, {0, 0, 1}, 1e9, one), "voxels");
  expect_refused(CutSurface::disc({0, 0, 0}, {0, 0, 1}, 1e-9, one), "no area");
  expect_refused(CutSurface::disc({0, 0, 0}, {0, 0, 1}, 1, {1, 0, 1}), "spacing");
  expect_refused(CutSurface::disc({nan, 0, 0}, {0, 0, 1}, 1, one), "finite");

  const std::vector<glm::dvec3> path{{0, 0, 0}, {1, 0, 0}};
  expect_refused(CutSurface::sweep({path.data(), 1}, {0, 0, 1}), "at least 2");
  expect_refused(CutSurface::sweep(path, {0, 0, 0}), "no area");
  expect_refused(CutSurface::sweep(path, {1, 0, 0}), "no area");
  expect_refused(CutSurface::sweep(path, {0, nan, 0}), "finite");

  const CutSurface surface = polygon({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const Lattice long_one(Size3(kLongestCutAxis_voxels + 1, 1, 1));
  EXPECT_FALSE(cut_along(Cuts(long_one.grid().volume_size()), long_one, surface).ok());
}

TEST(Violations, ARemovedLinkIsNone) {
  const Size3 size{40, 10, 10};
  std::vector<glm::ivec3> u;  // the half x >= 32 pulled away
  for_each_voxel(size,
                 [&](VoxelIndex v) { u.emplace_back(v.x >= 32 ? 5 * kUnitsPerVoxel : 0, 0, 0); });
  const Lattice lattice = testing::lattice_of(size, u);
  const MaterialField field(testing::constant_volume(size),
                            testing::table({testing::material(0, 1, 0.5, 1.5, 0.24)}));
  EXPECT_EQ(violations_of(lattice, field, Cuts(size)).links, 100);
  const Cuts cuts = cut(lattice, polygon(square({33, 5, 5}, {1, 0, 0}, 50)));
  EXPECT_EQ(removed_links(cuts), 100);
  EXPECT_EQ(violations_of(lattice, field, cuts).links, 0);
}

}  // namespace
}  // namespace maille
