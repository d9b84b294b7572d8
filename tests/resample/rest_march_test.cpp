// The march against the map that it inverts, in double precision, and its leave to march against
// pairs of points.
#include "resample/rest_march.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "tests/resample/scenes.h"

namespace maille {
namespace {

using namespace testing;

// u at a rest position, as displacement_tile.h states it.
glm::dvec3 displacement(const Lattice& lattice, glm::dvec3 rest, CellMap map = CellMap::trilinear) {
  const Size3 size = lattice.grid().volume_size();
  const glm::dvec3 inside = glm::clamp(rest, glm::dvec3(0), glm::dvec3(size - 1));
  const auto base = glm::min(VoxelIndex(glm::floor(inside)), glm::max(size - 2, VoxelIndex(0)));
  const glm::dvec3 t = inside - glm::dvec3(base);
  const auto u_at = [&](glm::ivec3 corner) {
    return lattice.displacement_voxels(glm::min(base + corner, size - 1));
  };
  glm::dvec3 sum(0);
  if (map == CellMap::tetrahedra) {
    // By barycentric coordinates: corners are joined one by one as a level falls from 1 to 0.
    std::array<int, 3> axes{0, 1, 2};
    std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return t[a] > t[b]; });
    glm::ivec3 corner(0);
    double level = 1.0;
    for (const int axis : axes) {
      sum += (level - t[axis]) * u_at(corner);
      level = t[axis];
      corner[axis] = 1;
    }
    return sum + level * u_at(corner);
  }
  for (int k = 0; k < 8; ++k) {
    const glm::ivec3 at(k & 1, (k >> 1) & 1, k >> 2);
    double weight = 1.0;
    for (int c = 0; c < 3; ++c) weight *= at[c] ? t[c] : 1.0 - t[c];
    if (weight == 0.0) continue;
    sum += weight * u_at(at);
  }
  return sum;
}

Lattice rough(Size3 size, double most, unsigned seed, const glm::dmat3& affine = glm::dmat3(1.0),
              glm::dvec3 shift = glm::dvec3(0)) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> off(-most, most);
  return lattice_from(size, [&](glm::dvec3 at) {
    const glm::dvec3 from = at - 0.5 * glm::dvec3(size);
    return affine * from - from + shift + glm::dvec3(off(random), off(random), off(random));
  });
}

const Size3 kSize{19, 23, 17};
const glm::dmat3 kTurned(0.8, 0.6, 0, -0.6, 0.8, 0, 0, 0, 1);
const glm::dmat3 kStretched(3.5, 0, 0, 0, 0.5, 0, 0, 0.3, 1);
const glm::dmat3 kSheared(1, 0, 0, 0.7, 1, 0, -0.4, 0, 1);

TEST(DisplacementTile, MapIsTheLatticesOwnAndSoAreItsDerivatives) {
  const Lattice lattice = rough(kSize, 0.4, 1, kTurned);
  DisplacementTile tile;
  const VoxelIndex first(2, 3, 1);
  tile.fill(lattice, {first, kSize});
  std::mt19937 random(2);
  for (int i = 0; i < 500; ++i) {
    glm::dvec3 rest;
    for (int c = 0; c < 3; ++c) {
      rest[c] = std::uniform_real_distribution<double>(first[c], kSize[c] - 1)(random);
    }
    const glm::dvec3 local = rest - glm::dvec3(first);
    const auto map = DisplacementTile::Reader<1>(tile).at<CellMap::trilinear>(
        Float4{static_cast<float>(local.x), static_cast<float>(local.y),
               static_cast<float>(local.z), 0.0f});
    const glm::dvec3 u = displacement(lattice, rest);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(map.u[c] + tile.common_voxels()[c], u[c], 1e-4);
    const Float4 columns[3] = {map.du_dx, map.du_dy, map.du_dz};
    for (int axis = 0; axis < 3; ++axis) {
      // Within the cell u is linear along each axis.
      glm::dvec3 lower = rest;
      glm::dvec3 upper = rest;
      lower[axis] = std::floor(rest[axis]);
      upper[axis] = lower[axis] + 1.0;
      const glm::dvec3 along = displacement(lattice, upper) - displacement(lattice, lower);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(columns[axis][c], along[c], 1e-4);
    }
  }
}

TEST(DisplacementTile, InTetrahedraTheDerivativesAreEdgesOfTheCell) {
  const Lattice lattice = rough(kSize, 0.4, 1, kTurned);
  DisplacementTile tile;
  tile.fill(lattice, {VoxelIndex(0), kSize});
  std::mt19937 random(2);
  for (int i = 0; i < 500; ++i) {
    glm::dvec3 rest;
    for (int c = 0; c < 3; ++c) {
      // Equal components too, where tetrahedra meet.
      rest[c] = std::uniform_int_distribution<int>(0, 4 * (kSize[c] - 1))(random) / 4.0;
    }
    const auto map = DisplacementTile::Reader<1>(tile).at<CellMap::tetrahedra>(Float4{
        static_cast<float>(rest.x), static_cast<float>(rest.y), static_cast<float>(rest.z), 0.0f});
    const glm::dvec3 u = displacement(lattice, rest, CellMap::tetrahedra);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(map.u[c] + tile.common_voxels()[c], u[c], 1e-4);
    // A little way on in some direction that stays inside of one: order of t kept, equal ones fall.
    const glm::dvec3 on = 0.01 * (glm::dvec3(4, 3, 2) / 4.0);
    if (glm::any(glm::greaterThan(rest + on, glm::dvec3(kSize - 1)))) continue;
    const glm::dvec3 there = displacement(lattice, rest + on, CellMap::tetrahedra);
    for (int c = 0; c < 3; ++c) {
      const double along = map.du_dx[c] * on.x + map.du_dy[c] * on.y + map.du_dz[c] * on.z;
      EXPECT_NEAR(along, there[c] - u[c], 1e-5);
    }
  }
}

TEST(DisplacementTile, NoTwoPointsAreNearerThanItsInjectionSays) {
  for (const auto& affine : {glm::dmat3(1.0), kTurned, kStretched, kSheared}) {
    const Lattice lattice = rough(kSize, 0.06, 3, affine);
    DisplacementTile tile;
    tile.fill(lattice, {VoxelIndex(0), kSize});
    for (const bool with_beyond : {false, true}) {
      const auto injection = tile.injection(with_beyond);
      ASSERT_TRUE(std::isfinite(injection.share));
      std::mt19937 random(4);
      const double margin = with_beyond ? 5.0 : 0.0;
      double worst = 0.0;
      for (int i = 0; i < 4000; ++i) {
        glm::dvec3 points[2];
        for (glm::dvec3& p : points) {
          for (int c = 0; c < 3; ++c) {
            p[c] = std::uniform_real_distribution<double>(-margin, kSize[c] - 1 + margin)(random);
          }
        }
        // Near ones too.
        if (i % 2) points[1] = points[0] + 0.05 * (points[1] - points[0]);
        const auto moved = [&](glm::dvec3 p) { return p + displacement(lattice, p); };
        const glm::dvec3 apart = points[0] - points[1];
        const glm::dvec3 off =
            glm::dmat3(injection.inverse) * (moved(points[0]) - moved(points[1])) - apart;
        const auto largest = [](glm::dvec3 v) {
          return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
        };
        EXPECT_LE(largest(off), (injection.share + 1e-4) * largest(apart));
        worst = std::max(worst, largest(off) / largest(apart));
      }
      EXPECT_GT(worst, 0.2 * injection.share) << "it says far too much";
    }
  }
}

TEST(DisplacementTile, SaysThatAFoldIsOne) {
  DisplacementTile tile;
  tile.fill(
      lattice_from(kSize, [](glm::dvec3 x) { return glm::dvec3(x.x > 9 ? -2.0 : 0.0, 0, 0); }),
      {VoxelIndex(0), kSize});
  EXPECT_GE(tile.injection(false).contraction(), 1.0);
  tile.fill(lattice_from(kSize, [](glm::dvec3 x) { return glm::dvec3(-x.x, 0, 0); }),
            {VoxelIndex(0), kSize});
  EXPECT_FALSE(tile.injection(false).contraction() < 1.0) << "flat";
}

// Of all of a march's voxels, from its first row on.
void expect_answers(const Lattice& lattice, RestMarch& march, const VoxelBox& voxels, CellMap map) {
  for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
    for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
      const Float4* const row = march.next_row();
      for (int x = voxels.lo.x; x < voxels.hi.x; ++x) {
        const Float4 rest = row[x - voxels.lo.x];
        const glm::dvec3 at(rest[0], rest[1], rest[2]);
        const glm::dvec3 now = at + displacement(lattice, at, map);
        EXPECT_LT(glm::length(now - glm::dvec3(x, y, z)), 5e-4)
            << "(" << x << ", " << y << ", " << z << ")";
      }
    }
  }
}

class RestMarchOf : public ::testing::TestWithParam<CellMap> {};
INSTANTIATE_TEST_SUITE_P(CellMaps, RestMarchOf,
                         ::testing::Values(CellMap::trilinear, CellMap::tetrahedra));

TEST_P(RestMarchOf, EveryAnswerIsThePointThatNowLiesThere) {
  int marches = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    for (const auto& affine : {glm::dmat3(1.0), kTurned, kStretched, kSheared}) {
      const Lattice lattice = rough(kSize, seed % 2 ? 0.1 : 0.02, seed, affine);
      DisplacementTile tile;
      tile.fill(lattice, {VoxelIndex(0), kSize});
      const auto injection = tile.injection(true);
      if (!(injection.contraction() < 0.98)) continue;
      ++marches;
      const VoxelBox voxels{VoxelIndex(-3, -2, -4), kSize + 3};
      RestMarch march(tile, injection, voxels, GetParam());
      SCOPED_TRACE("seed " + std::to_string(seed));
      expect_answers(lattice, march, voxels, GetParam());
    }
  }
  EXPECT_GT(marches, 20);
}

// Close to folding along one axis and sheared along the others: the sums of the spread's rows say
// nothing of it, their weighted ones do.
TEST_P(RestMarchOf, NoLessWhereOneAxisBringsMoreThanTheOthers) {
  const Lattice lattice = lattice_from(kSize, [](glm::dvec3 x) {
    return glm::dvec3(2.4 * std::sin(x.x / 2.8) + 0.25 * x.y - 0.2 * x.z, 0.1 * std::sin(x.z), 0);
  });
  DisplacementTile tile;
  tile.fill(lattice, {VoxelIndex(0), kSize});
  const auto injection = tile.injection(true);
  EXPECT_GT(injection.share, 1.0);
  ASSERT_LT(injection.contraction(), 0.98);
  const VoxelBox voxels{VoxelIndex(-2), kSize + 2};
  RestMarch march(tile, injection, voxels, GetParam());
  expect_answers(lattice, march, voxels, GetParam());
}

TEST_P(RestMarchOf, NoLessNearAMillionVoxelsFromRest) {
  const glm::ivec3 shift(1'000'000, -400'000, 70'000);
  const Lattice lattice = rough(kSize, 0.06, 6, kSheared, glm::dvec3(shift) + 0.3);
  DisplacementTile tile;
  tile.fill(lattice, {VoxelIndex(0), kSize});
  const auto injection = tile.injection(false);
  ASSERT_LT(injection.contraction(), 0.98);
  const VoxelBox voxels{shift + 3, shift + kSize - 3};
  RestMarch march(tile, injection, voxels, GetParam());
  for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
    for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
      const Float4* const row = march.next_row();
      for (int x = voxels.lo.x; x < voxels.hi.x; ++x) {
        const Float4 rest = row[x - voxels.lo.x];
        const glm::dvec3 at(rest[0], rest[1], rest[2]);
        if (glm::any(glm::lessThan(at, glm::dvec3(0))) ||
            glm::any(glm::greaterThan(at, glm::dvec3(kSize - 1)))) {
          continue;
        }
        EXPECT_LT(glm::length(at + displacement(lattice, at, GetParam()) - glm::dvec3(x, y, z)),
                  5e-4);
      }
    }
  }
}

TEST_P(RestMarchOf, SameBitsForAnyWidthOfRegisters) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Lattice lattice = rough(kSize, 0.08, seed, seed % 2 ? kSheared : kTurned);
    DisplacementTile tile;
    tile.fill(lattice, {VoxelIndex(0), kSize});
    const auto injection = tile.injection(true);
    const VoxelBox voxels{VoxelIndex(-2), kSize + 1};
    RestMarch widest(tile, injection, voxels, GetParam());
    RestMarch narrow(tile, injection, voxels, GetParam(), Registers::narrow);
    for (int row = 0; row < voxels.size().y * voxels.size().z; ++row) {
      const Float4* const a = widest.next_row();
      const Float4* const b = narrow.next_row();
      ASSERT_EQ(std::memcmp(a, b, sizeof(Float4) * static_cast<std::size_t>(voxels.size().x)), 0)
          << "seed " << seed << ", row " << row;
    }
  }
}

// One element, one plane, one row: what is beyond an only element moves with it.
TEST_P(RestMarchOf, ThinVolumesToo) {
  for (const Size3 size : {Size3(1, 1, 1), Size3(1, 9, 5), Size3(8, 1, 1), Size3(6, 7, 1)}) {
    const Lattice lattice = rough(size, 0.1, 5);
    DisplacementTile tile;
    tile.fill(lattice, {VoxelIndex(0), size});
    const auto injection = tile.injection(true);
    ASSERT_LT(injection.contraction(), 0.98);
    RestMarch march(tile, injection, {VoxelIndex(0), size}, GetParam());
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        const Float4* const row = march.next_row();
        for (int x = 0; x < size.x; ++x) {
          const glm::dvec3 at(row[x][0], row[x][1], row[x][2]);
          EXPECT_LT(glm::length(at + displacement(lattice, at, GetParam()) - glm::dvec3(x, y, z)),
                    5e-4);
        }
      }
    }
  }
}

}  // namespace
}  // namespace maille
