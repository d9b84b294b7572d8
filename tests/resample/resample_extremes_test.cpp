// The least and the most that a lattice can be told to do.
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <ostream>
#include <random>

#include <gtest/gtest.h>

#include "references/nearest_brute_force.h"
#include "tests/core/scratch.h"
#include "tests/resample/faults.h"
#include "tests/resample/random_scenes.h"
#include "tests/resample/resampled.h"
#include "tests/resample/true_answers.h"
#include "volume/volume_file.h"

namespace maille {
namespace {

using namespace testing;

// Of numbered().
VoxelIndex volume_index(double value, Size3 size) {
  const auto n = static_cast<std::int64_t>(value);
  return {static_cast<int>(n % size.x), static_cast<int>(n / size.x % size.y),
          static_cast<int>(n / size.x / size.y)};
}

// Every voxel against all cells and elements: for lattices that have no closed form.
void expect_true_answers(const Lattice& lattice, glm::dvec3 spacing_mm = glm::dvec3(1)) {
  const Size3 size = lattice.grid().volume_size();
  const Cuts cuts(size);
  const Volume volume = numbered(size, spacing_mm);
  const auto nearest = resampled(volume, lattice, cuts, ResampleMethod::nearest);
  const auto linear = resampled(volume, lattice, cuts, ResampleMethod::linear);
  const std::vector<glm::vec3> rest = rest_positions(volume, lattice, cuts);
  const TrueAnswers truth(lattice);
  const DeformedElements elements(size, spacing_mm, displacements_of(lattice));
  const NearestBruteForce all(elements);
  std::size_t i = 0;
  for_each_voxel(size, [&](VoxelIndex v) {
    const glm::dvec3 at(rest[i++]);
    const auto answers = truth.at(v);
    const bool shown = !std::isnan(at.x);
    const bool held = !answers.rest.empty();
    EXPECT_EQ(shown, linear.volume.value_at(v) != kBackground) << text(v);
    if (held == shown) {
      const double value = nearest.volume.value_at(v);
      EXPECT_EQ(shown, value != kBackground) << text(v);
      if (shown) {
        EXPECT_LT(glm::distance(moved(lattice, at), glm::dvec3(v)), 1e-3) << text(v);
      }
      if (value != kBackground) {
        const glm::dvec3 here_mm = glm::dvec3(v) * spacing_mm;
        const auto found = static_cast<std::size_t>(value);
        EXPECT_LE(std::sqrt(elements.distance(found, here_mm).squared_mm2),
                  std::sqrt(all.nearest_to(here_mm).squared_mm2) + 1e-4)
            << text(v);
      }
    } else {
      EXPECT_TRUE(shown ? truth.may_be_covered(v, 1e-3) : truth.may_be_uncovered(v, 1e-3))
          << text(v);
    }
  });
}

TEST(Extremes, ACellStretchedOver200Voxels) {
  for (int axis = 0; axis < 3; ++axis) {
    Size3 size(5);
    size[axis] = 241;
    constexpr int kLower = 20;
    const Lattice lattice = lattice_from(size, [&](glm::dvec3 p) {
      glm::dvec3 u(0);
      if (p[axis] > kLower) u[axis] = 200.0;
      return u;
    });
    const Volume volume =
        volume_from<float>(size, VoxelType::float32, glm::dvec3(1),
                           [&](VoxelIndex v) { return static_cast<double>(v[axis]); });
    for (const ResampleMethod method : kResampleMethods) {
      const auto out = resampled(volume, lattice, Cuts(size), method);
      EXPECT_EQ(out.counts.unfilled_voxels, 0);
      EXPECT_EQ(out.counts.background_voxels, 0);
      for_each_voxel(size, [&](VoxelIndex v) {
        const double at = v[axis];
        const double value = out.volume.value_at(v);
        double expected = at <= kLower         ? at
                          : at >= kLower + 201 ? at - 200
                                               : kLower + (at - kLower) / 201.0;
        if (method == ResampleMethod::nearest) expected = std::round(expected);
        if (method == ResampleMethod::nearest || method == ResampleMethod::linear) {
          ASSERT_NEAR(value, expected, method == ResampleMethod::nearest ? 0.0 : 1e-3) << text(v);
        } else {
          // Others mix as they say; of these elements at least.
          ASSERT_GE(value, std::floor(expected) - 2.0) << text(v);
          ASSERT_LE(value, std::ceil(expected) + 2.0) << text(v);
        }
      });
    }
  }
}

// Less than a unit of the lattice from one element to the next: all lie in one place, and what is
// left of the volume are the outer halves of its border's voxels.
TEST(Extremes, SqueezedToAMillionth) {
  const Size3 size{35, 34, 33};
  for (const glm::dvec3 place : {glm::dvec3(17, 16, 15), glm::dvec3(17.25, 16.375, 15.4)}) {
    for (const glm::bvec3 squeezed :
         {glm::bvec3(true), glm::bvec3(true, false, false), glm::bvec3(false, false, true)}) {
      const Lattice lattice = lattice_from(size, [&](glm::dvec3 p) {
        const glm::dvec3 to = place + 1e-6 * (p - place);
        glm::dvec3 u(0);
        for (int c = 0; c < 3; ++c) {
          if (squeezed[c]) u[c] = to[c] - p[c];
        }
        return u;
      });
      const Volume volume =
          volume_from<float>(size, VoxelType::float32, glm::dvec3(1),
                             [&](VoxelIndex v) { return static_cast<double>(v.x + v.y + v.z); });
      for (const ResampleMethod method : kResampleMethods) {
        const auto out = resampled(volume, lattice, Cuts(size), method);
        EXPECT_EQ(out.counts.unfilled_voxels, 0);
        for_each_voxel(size, [&](VoxelIndex v) {
          // Half a voxel around the place, and the rounding of the lattice.
          bool inside = true;
          bool outside = false;
          for (int c = 0; c < 3; ++c) {
            const double away = squeezed[c] ? std::abs(v[c] - place[c]) : 0.0;
            inside = inside && away < 0.5 - 2.0 / kUnitsPerVoxel;
            outside = outside || away > 0.5 + 2.0 / kUnitsPerVoxel;
          }
          const double value = out.volume.value_at(v);
          if (inside) {
            ASSERT_NE(value, kBackground) << text(v) << " of " << text(place);
            ASSERT_GE(value, 0.0);
            ASSERT_LE(value, size.x + size.y + size.z - 3);
          }
          if (outside) {
            ASSERT_EQ(value, kBackground) << text(v) << " of " << text(place);
          }
        });
      }
    }
  }
}

// One layer of cells alone, flat or nearly: nothing else is disturbed.
TEST(Extremes, OneLayerOfCellsSqueezedFlat) {
  const Size3 size{40, 9, 8};
  for (const double left : {0.0, 1.0 / kUnitsPerVoxel, 1e-6}) {
    const Lattice lattice = lattice_from(size, [&](glm::dvec3 p) {
      return p.x <= 20 ? glm::dvec3(0) : glm::dvec3(left - 1.0, 0, 0);
    });
    const Volume volume = numbered(size);
    for (const ResampleMethod method : {ResampleMethod::nearest, ResampleMethod::linear}) {
      const auto out = resampled(volume, lattice, Cuts(size), method);
      for_each_voxel(size, [&](VoxelIndex v) {
        const double value = out.volume.value_at(v);
        if (v.x <= 20) {
          ASSERT_EQ(value, volume.value_at(v)) << text(v);
        } else if (v.x < 39) {
          const double off = method == ResampleMethod::nearest ? 0.0 : 2e-2;
          ASSERT_NEAR(value, volume.value_at(v + VoxelIndex(1, 0, 0)), off) << text(v);
        }
      });
    }
  }
}

TEST(Extremes, CarriedAMillionVoxelsAway) {
  const Size3 size{34, 33, 9};
  for (const glm::dvec3 by : {glm::dvec3(1e6, 0, 0), glm::dvec3(-1e6, 3.3, 0),
                              glm::dvec3(0, 0, 1e6), glm::dvec3(-1e6, 1e6, -1e6)}) {
    const Lattice lattice = lattice_from(size, [&](glm::dvec3) { return by; });
    for (const ResampleMethod method : kResampleMethods) {
      const auto out = resampled(numbered(size), lattice, Cuts(size), method);
      EXPECT_EQ(out.counts.background_voxels, voxel_count(size));
      EXPECT_EQ(out.counts.unfilled_voxels, 0);
    }
  }
}

// There it lies, in bricks beyond the volume.
TEST(Extremes, SeenAMillionVoxelsBeyondTheVolume) {
  const Size3 size{34, 33, 9};
  const Volume volume = numbered(size);
  for (const glm::dvec3 by : {glm::dvec3(1e6, 0, 0), glm::dvec3(-1e6 + 0.375, 3.25, 0),
                              glm::dvec3(-1e6, 999'999.5, -1e6)}) {
    const Lattice lattice = lattice_from(size, [&](glm::dvec3) { return by; });
    const VoxelBox there{VoxelIndex(glm::floor(by)) - 2, VoxelIndex(glm::ceil(by)) + size + 2};
    for (const ResampleMethod method : kResampleMethods) {
      const Resampler resampler(volume, lattice, Cuts(size), method, kBackground);
      Faults wrong;
      std::int64_t shown = 0;
      const BrickIndex lo = BrickGrid::brick_of(there.lo);
      for_each_voxel(BrickGrid::brick_of(there.hi) - lo + 1, [&](BrickIndex b) {
        const VoxelIndex first = (lo + b) * kBrickEdge;
        const VoxelBox box = intersection({first, first + kBrickEdge}, there);
        if (box.empty()) return;
        std::vector<std::byte> bytes(kBrickVoxels * sizeof(float));
        resampler.resample(box, bytes, false);
        std::size_t i = 0;
        for_each_voxel(box.size(), [&](VoxelIndex in_box) {
          float value = 0.0f;
          std::memcpy(&value, &bytes[sizeof value * i++], sizeof value);
          const VoxelIndex v = box.lo + in_box;
          const glm::dvec3 rest = glm::dvec3(v) - by;
          const glm::dvec3 depth = glm::min(rest, glm::dvec3(size - 1) - rest) + 0.5;
          const double least = std::min({depth.x, depth.y, depth.z});
          if (least == 0.0) return;  // at the very end
          const bool filled = value != static_cast<float>(kBackground);
          shown += filled;
          if (filled != (least > 0.0)) {
            wrong.add(text(v), ": ", value, " of ", text(rest));
          } else if (filled && method == ResampleMethod::nearest) {
            const glm::dvec3 element(volume_index(value, size));
            const glm::dvec3 inside = glm::clamp(rest, glm::dvec3(0), glm::dvec3(size - 1));
            const glm::dvec3 away = glm::abs(element - inside);
            if (std::max({away.x, away.y, away.z}) > 0.5) wrong.add(text(v), ": ", value);
          } else if (filled && !is_smoothed(method)) {
            // Along z numbers rise by more than a thousand a voxel.
            if (std::abs(value - trilinear(volume, rest)) > 0.5) {
              wrong.add(text(v), ": ", value, " not ", trilinear(volume, rest));
            }
          }
        });
      });
      EXPECT_EQ(wrong.count(), 0) << name_of(method) << ": " << wrong.first();
      EXPECT_GE(shown, voxel_count(size - 1));
    }
  }
}

// To the other end of a volume that long, where everything else was carved away.
TEST(Extremes, SeenAMillionVoxelsAway) {
  const Size3 size{1'000'096, 2, 2};
  const Volume volume = volume_from<float>(
      size, VoxelType::float32, glm::dvec3(1),
      [](VoxelIndex v) { return (v.x < 96 ? 100.0 + v.x : 0.0) + 0.25 * v.y + 0.5 * v.z; });
  const int whole = 1'000'000;
  const glm::dvec3 by(whole - 0.375, 0, 0);
  CutsByHand by_hand(size);
  by_hand.cut_across_x(63);
  for_each_voxel({96, 2, 2}, [&](VoxelIndex v) { by_hand.carve(v + VoxelIndex(whole, 0, 0)); });
  by_hand.cut_across_x(whole - 1);
  const Cuts cuts = by_hand.done();
  Lattice lattice(size);
  const BrickGrid& grid = lattice.grid();
  for (std::int64_t b = 0; b < 2; ++b) {
    const VoxelBox box = grid.box(grid.brick(b));
    auto moved = std::make_unique<BrickDisplacements>();
    for_each_voxel(box.size(), [&](VoxelIndex v) {
      moved->u[0][element_in_brick(box.lo + v)] = static_cast<int>(by.x * kUnitsPerVoxel);
    });
    lattice.set(b, LatticeBrick::create(box, *moved));
  }
  for (const ResampleMethod method : {ResampleMethod::nearest, ResampleMethod::linear}) {
    const Resampler resampler(volume, lattice, cuts, method, kBackground);
    std::vector<std::byte> bytes(kBrickVoxels * sizeof(float));
    for (std::int64_t b = whole / kBrickEdge; b < grid.count(); ++b) {
      const VoxelBox box = grid.box(grid.brick(b));
      resampler.resample(b, bytes, false);
      std::size_t i = 0;
      for_each_voxel(box.size(), [&](VoxelIndex in_box) {
        const VoxelIndex v = box.lo + in_box;
        float value = 0.0f;
        std::memcpy(&value, &bytes[sizeof value * i++], sizeof value);
        const double rest = v.x - by.x;  // 0.375, 1.375, ...
        const double expected = 0.25 * v.y + 0.5 * v.z;
        if (rest < 63.5) {
          const double along =
              method == ResampleMethod::nearest ? std::round(rest) : std::min(rest, 63.0);
          ASSERT_NEAR(value, 100.0 + along + expected, 1e-3) << text(v);
        } else {
          ASSERT_EQ(value, static_cast<float>(kBackground)) << text(v);
        }
      });
    }
    const auto picked = resampler.rest_position({whole + 10.0, 0.5, 1.0});
    ASSERT_TRUE(picked.has_value());
    EXPECT_LT(glm::distance(*picked, glm::dvec3(10.375, 0.5, 1.0)), 1e-3) << text(*picked);
  }
}

TEST(Extremes, LatticesOfOneCellAndOfOneElement) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    Chance chance(seed);
    const Size3 size = seed % 4 == 0 ? Size3(1) : Size3(2);
    const glm::dvec3 shift = chance.vector(0.9);
    const double rough = seed % 2 == 0 ? 0.15 : 0.0;
    const Lattice lattice =
        lattice_from(size, [&](glm::dvec3) { return shift + chance.vector(rough); });
    expect_true_answers(lattice, seed % 3 == 0 ? glm::dvec3(1, 0.7, 1.8) : glm::dvec3(1));
  }
}

// What went wrong once, made as small as it could be: sheared past its own height, and folded.
struct SmallLattice {
  const char* name;
  Size3 size;
  std::vector<glm::dvec3> u_voxels;
};
void PrintTo(const SmallLattice& lattice, std::ostream* out) { *out << lattice.name; }
const SmallLattice kSmallLattices[] = {
    {"sheared",
     {3, 3, 1},
     {{-1.25, 0.25, 0},
      {-1.25, 0.25, 0},
      {-1.25, 0.25, 0},
      {0.25, 0.25, 0},
      {0.25, 0.25, 0},
      {0.25, 0.25, 0},
      {1.75, 0.25, 0},
      {1.75, 0.25, 0},
      {1.75, 0.25, 0}}},
    {"row_past_its_end",
     {3, 1, 1},
     {{0.875, -0.875, 0.25}, {-1.625, -1.625, -1.125}, {1, 1.25, 0.5}}},
    {"row_there_and_back",
     {3, 1, 1},
     {{-1.75, 1.375, -0.5}, {1.875, -1.625, -0.375}, {-0.625, 0, 2}}},
    {"row_beside_a_voxel",
     {3, 1, 1},
     {{0, -1.625, -1.375}, {-1.25, 1.25, -1.75}, {-1.875, 0.5, 0.375}}},
    {"square_beside_a_voxel",
     {2, 2, 1},
     {{-1.75, 1.375, -0.5}, {1.875, -1.625, -0.375}, {-0.625, 0, 2}, {1.25, 0.625, 1.25}}},
    {"square_over_a_voxel",
     {2, 2, 1},
     {{-1.75, -0.375, -0.625}, {1, 0.875, -0.625}, {-0.125, -0.875, 1.125}, {1.25, -1.875, -0.75}}},
    {"bent",
     {3, 2, 1},
     {{2, 1.75, -1.5},
      {2, -1, -0.375},
      {-0.5, 0.625, 1.75},
      {1.375, -0.75, 0.125},
      {-0.25, -1.125, 0.125},
      {1.625, -0.125, -0.25}}},
};
class Small : public ::testing::TestWithParam<SmallLattice> {};
TEST_P(Small, LatticesShowWhatLiesThere) {
  const SmallLattice& small = GetParam();
  expect_true_answers(lattice_from(small.size, [&](glm::dvec3 p) {
    return small.u_voxels[static_cast<std::size_t>(linear_index(VoxelIndex(p), small.size))];
  }));
}
std::string name_of_small(const ::testing::TestParamInfo<SmallLattice>& lattice) {
  return lattice.param.name;
}
INSTANTIATE_TEST_SUITE_P(Lattices, Small, ::testing::ValuesIn(kSmallLattices), name_of_small);

TEST(Extremes, BorderBricksOfOneVoxel) {
  for (const Size3 size : {Size3(33, 4, 5), Size3(3, 33, 5), Size3(65, 3, 4), Size3(4, 2, 65)}) {
    for (const glm::dvec3 shift : {glm::dvec3(0.3, -0.4, 0.2), glm::dvec3(-1.3, 0.6, -2.1)}) {
      const Field waves = smooth_waves(11, 0.25);
      expect_true_answers(lattice_from(size, [&](glm::dvec3 p) { return waves(p) + shift; }));
    }
  }
}

// The corner of a volume of more than 2^32 voxels, mapped from a file of holes, is as the same
// corner alone.
TEST(Extremes, BeyondTwoToThe32VoxelsIsAsAnywhere) {
  constexpr Size3 kHuge{2048, 2048, 1035};
  constexpr VoxelIndex kCorner{1984, 1984, 960};
  constexpr Size3 kSmall{64, 64, 75};
  ASSERT_GT(linear_index(kCorner, kHuge), std::int64_t{1} << 31);
  const Volume corner =
      volume_from<std::uint8_t>(kSmall, VoxelType::uint8, glm::dvec3(1),
                                [](VoxelIndex v) { return 40 + (v.x * 3 + v.y * 2 + v.z) % 150; });
  const test::Scratch scratch;
  const auto path = scratch / "huge_2048x2048x1035_uint8.raw";
  {
    std::ofstream file(path, std::ios::binary);
    for_each_voxel({1, kSmall.y, kSmall.z}, [&](VoxelIndex row) {
      file.seekp(linear_index(kCorner + row, kHuge));
      const auto first = static_cast<std::size_t>(linear_index(row, kSmall));
      file.write(reinterpret_cast<const char*>(&corner.bytes()[first]), kSmall.x);
    });
  }
  const auto huge = read_volume(path);
  ASSERT_TRUE(huge.ok()) << huge.error().message;
  ASSERT_EQ(huge->size(), kHuge);
  // Still towards the inside of the volume, moved and folding at its border.
  const auto u = [](glm::dvec3 p) {
    const glm::dvec3 away = p - glm::dvec3(45, 44, 60);
    const double share = std::max(0.0, 1.0 - glm::length(away) / 30.0);
    return share * glm::dvec3(9, -7, 12) + share * glm::dvec3(3.0 * std::sin(1.9 * p.y), 0, 0);
  };
  const Lattice there_alone = lattice_from(kSmall, u);
  const auto carve = [](CutsByHand& cuts, VoxelIndex origin) {
    for (int y = 30; y < 60; ++y) {
      for (int z = 40; z < 75; ++z) cuts.remove(origin + VoxelIndex(44, y, z), 0);
    }
    for_each_voxel({5, 5, 5}, [&](VoxelIndex v) { cuts.carve(origin + v + VoxelIndex(50)); });
  };
  CutsByHand small_cuts(kSmall);
  CutsByHand huge_cuts(kHuge);
  carve(small_cuts, VoxelIndex(0));
  carve(huge_cuts, kCorner);
  Lattice there(kHuge);
  const BrickGrid& small_grid = there_alone.grid();
  const auto in_huge = [&](std::int64_t b) {
    return there.grid().linear(BrickGrid::brick_of(kCorner) + small_grid.brick(b));
  };
  for (std::int64_t b = 0; b < small_grid.count(); ++b) {
    const VoxelBox box = small_grid.box(small_grid.brick(b));
    auto moved = std::make_unique<BrickDisplacements>();
    for_each_voxel(box.size(), [&](VoxelIndex v) {
      for (int c = 0; c < 3; ++c) {
        moved->u[c][element_in_brick(v)] = there_alone.u(box.lo + v)[c];
      }
    });
    there.set(in_huge(b), LatticeBrick::create({kCorner + box.lo, kCorner + box.hi}, *moved));
  }
  for (const bool with_cuts : {false, true}) {
    for (const ResampleMethod method : kResampleMethods) {
      const Resampler small(corner, there_alone, with_cuts ? small_cuts.done() : Cuts(kSmall),
                            method, 7);
      const Resampler large(*huge, there, with_cuts ? huge_cuts.done() : Cuts(kHuge), method, 7);
      std::int64_t moved = 0;
      Faults different;
      for (std::int64_t b = 0; b < small_grid.count(); ++b) {
        const VoxelBox box = small_grid.box(small_grid.brick(b));
        std::vector<std::byte> here(kBrickVoxels);
        std::vector<std::byte> far(kBrickVoxels);
        moved += small.resample(b, here, false).moved_voxels;
        large.resample(in_huge(b), far, false);
        for (std::size_t i = 0; i < static_cast<std::size_t>(voxel_count(box.size())); ++i) {
          // Rest positions in floats have fewer digits there: a value may round to the next.
          const int apart = std::abs(static_cast<int>(here[i]) - static_cast<int>(far[i]));
          if (apart > (method == ResampleMethod::nearest ? 0 : 1))
            different.add("brick ", b, ": ", i);
        }
      }
      EXPECT_GT(moved, 10'000);
      EXPECT_EQ(different.count(), 0) << different.first();
    }
  }
}

// What is no number stays where it is: it reaches no point that has nothing of its voxel.
TEST(Extremes, NanAndInfiniteVoxels) {
  const Size3 size{40, 12, 11};
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  std::mt19937 random(4);
  std::vector<float> values;
  for_each_voxel(size, [&](VoxelIndex) {
    const unsigned kind = random() % 30;
    values.push_back(kind == 0   ? kNan
                     : kind == 1 ? kInfinity
                     : kind == 2 ? -kInfinity
                                 : static_cast<float>(random() % 100));
  });
  const Volume volume = Volume::of(size, VoxelType::float32, axis_aligned(glm::dvec3(1)), values);
  const auto at = [&](VoxelIndex v) {
    return values[static_cast<std::size_t>(linear_index(v, size))];
  };
  const auto same = [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  // Whole voxels: as they were. Along one axis: mixed of the two beside it, and of them alone.
  for (const glm::dvec3 shift : {glm::dvec3(3, -2, 1), glm::dvec3(2.25, 0, -1)}) {
    const Lattice lattice = lattice_from(size, [&](glm::dvec3) { return shift; });
    const auto nearest = resampled(volume, lattice, Cuts(size), ResampleMethod::nearest);
    const auto linear = resampled(volume, lattice, Cuts(size), ResampleMethod::linear);
    std::int64_t odd = 0;
    Faults wrong;
    for_each_voxel(size, [&](VoxelIndex v) {
      const glm::dvec3 rest = glm::dvec3(v) - shift;
      const VoxelIndex lower(glm::floor(rest));
      const VoxelIndex upper = lower + VoxelIndex(rest.x != lower.x, 0, 0);
      if (!contains(size, lower) || !contains(size, upper)) return;
      const auto index = static_cast<std::size_t>(linear_index(v, size));
      const float by_nearest = nearest.volume.voxels<float>()[index];
      const float by_linear = linear.volume.voxels<float>()[index];
      EXPECT_TRUE(same(by_nearest, at(VoxelIndex(glm::round(rest))))) << text(v);
      const float a = at(lower);
      const float b = at(upper);
      odd += !std::isfinite(a) || !std::isfinite(b);
      const bool whole = a == b || lower == upper;
      const bool finite = std::isfinite(a) && std::isfinite(b);
      const bool right = whole    ? same(by_linear, a)
                         : finite ? std::abs(by_linear - (a + (rest.x - lower.x) * (b - a))) < 1e-2
                                  : !std::isfinite(by_linear);
      if (!right) wrong.add(text(v), ": ", by_linear, " between ", a, " and ", b);
    });
    EXPECT_EQ(wrong.count(), 0) << wrong.first();
    EXPECT_GT(odd, 100);
  }
}

}  // namespace
}  // namespace maille
