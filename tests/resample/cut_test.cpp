#include <cmath>
#include <cstring>
#include <iostream>
#include <random>

#include <gtest/gtest.h>

#include "tests/resample/resampled.h"
#include "tests/resample/scenes.h"

namespace maille {
namespace {

using namespace testing;

std::string text(VoxelIndex v) {
  return std::to_string(v.x) + ' ' + std::to_string(v.y) + ' ' + std::to_string(v.z);
}

// As a person drags a side of the cut between elements x = 31 and 32 (a brick border) away.
Lattice right_side_moved(Size3 size, glm::dvec3 by) {
  return lattice_from(size, [=](glm::dvec3 p) { return p.x > 31.5 ? by : glm::dvec3(0); });
}
glm::dvec3 fixed_point(glm::dvec3 u) { return glm::round(u * 512.0) / 512.0; }

TEST(Cut, ChangesNothingUntilSomethingMoves) {
  const Size3 size{67, 40, 35};
  std::mt19937 random(3);
  CutsByHand by_hand(size);
  for_each_voxel(size, [&](VoxelIndex v) {
    if (random() % 3 == 0) by_hand.remove(v, static_cast<int>(random() % 3));
  });
  const Cuts cuts = by_hand.done();
  for (const VoxelType type : {VoxelType::uint8, VoxelType::int8, VoxelType::uint16,
                               VoxelType::int16, VoxelType::float32}) {
    std::vector<std::byte> bytes(static_cast<std::size_t>(voxel_count(size)) *
                                 bytes_per_voxel(type));
    for (auto& b : bytes) b = static_cast<std::byte>(random());
    auto owner = std::make_shared<std::vector<std::byte>>(std::move(bytes));
    const Volume volume(size, type, axis_aligned(glm::dvec3(1)), *owner, owner);
    // At rest, and with something moved far enough away.
    const Lattice moved = lattice_from(size, [](glm::dvec3 p) {
      return p == glm::dvec3(3) ? glm::dvec3(0.5, 0, 0) : glm::dvec3(0);
    });
    for (const ResampleMethod method : kResampleMethods) {
      const auto rest = resampled(volume, Lattice(size), cuts, method);
      EXPECT_TRUE(same_bytes(rest.volume, volume));
      EXPECT_EQ(rest.counts.moved_voxels, 0);
      const auto out = resampled(volume, moved, cuts, method);
      std::int64_t differ = 0;
      const std::size_t bytes_each = bytes_per_voxel(type);
      for (std::size_t i = 0; i < volume.bytes().size() / bytes_each; ++i) {
        differ += std::memcmp(&out.volume.bytes()[i * bytes_each], &volume.bytes()[i * bytes_each],
                              bytes_each) != 0;
      }
      EXPECT_LE(differ, 1) << name_of(type);
    }
  }
}

// One side stays, the other is carried away whole: everything has a closed form.
TEST(Cut, ASideCarriedAwayLeavesACleanGap) {
  const Size3 size{80, 40, 36};
  CutsByHand by_hand(size);
  by_hand.cut_across_x(31);
  const Cuts cuts = by_hand.done();
  for (const glm::dvec3 spacing_mm : {glm::dvec3(1), glm::dvec3(0.7, 1.3, 2.5)}) {
    const Volume numbers = numbered(size, spacing_mm);
    const Volume ramp = volume_from<float>(size, VoxelType::float32, spacing_mm, [](VoxelIndex v) {
      return 3.0 * v.x - 2.0 * v.y + 0.5 * v.z;
    });
    const Volume halves = volume_from<float>(size, VoxelType::float32, spacing_mm,
                                             [](VoxelIndex v) { return v.x < 32 ? 0.1 : 0.7; });
    for (const glm::dvec3 wanted :
         {glm::dvec3(1, 0, 0), glm::dvec3(2.3, 0, 0), glm::dvec3(4.5, 0.25, 0),
          glm::dvec3(10, -3.4, 1.7), glm::dvec3(7.75, 0, 0), glm::dvec3(0.4, 0, 0),
          glm::dvec3(0, 3.3, 0), glm::dvec3(0.2, 5, -6.6)}) {
      const glm::dvec3 by = fixed_point(wanted);
      const Lattice lattice = right_side_moved(size, by);
      WorkerPool pool(1);
      EXPECT_EQ(count_folded_cells(lattice, cuts, pool), 0);
      const auto nearest = resampled(numbers, lattice, cuts, ResampleMethod::nearest);
      const auto linear = resampled(ramp, lattice, cuts, ResampleMethod::linear);
      const auto two = resampled(halves, lattice, cuts, ResampleMethod::linear);
      const Resampler resampler(ramp, lattice, cuts, ResampleMethod::linear, kBackground);
      for_each_voxel(size, [&](VoxelIndex v) {
        const std::string where = text(v) + " by " + std::to_string(by.x);
        if (v.x < 32) {
          ASSERT_EQ(nearest.volume.value_at(v), numbers.value_at(v)) << where;
          ASSERT_EQ(linear.volume.value_at(v), ramp.value_at(v)) << where;
          ASSERT_EQ(two.volume.value_at(v), halves.value_at(v)) << where;
          return;
        }
        const glm::dvec3 rest = glm::dvec3(v) - by;
        bool inside = rest.x >= 31.5;
        for (int c = 0; c < 3; ++c) inside = inside && rest[c] >= -0.5 && rest[c] <= size[c] - 0.5;
        const auto picked = resampler.rest_position(v);
        ASSERT_EQ(picked.has_value(), inside) << where;
        if (!inside) {
          ASSERT_EQ(nearest.volume.value_at(v), kBackground) << where;
          ASSERT_EQ(linear.volume.value_at(v), kBackground) << where;
          ASSERT_EQ(two.volume.value_at(v), kBackground) << where;
          return;
        }
        ASSERT_LT(glm::length(*picked - rest), 1e-3) << where;
        const glm::dvec3 border =
            glm::clamp(rest, glm::dvec3(32, 0, 0), glm::dvec3(size - 1));  // constant beyond
        ASSERT_NEAR(linear.volume.value_at(v), 3 * border.x - 2 * border.y + 0.5 * border.z, 2e-3)
            << where;
        ASSERT_EQ(two.volume.value_at(v), static_cast<double>(0.7f)) << where;
        // Nearest: one of those that no other element is nearer than.
        const auto n = static_cast<std::int64_t>(nearest.volume.value_at(v));
        const glm::dvec3 element(n % size.x, n / size.x % size.y, n / size.x / size.y);
        ASSERT_GE(element.x, 32) << where;
        const double away = glm::length((element - rest) * spacing_mm);
        const double best = glm::length(
            (glm::clamp(glm::round(rest), glm::dvec3(32, 0, 0), glm::dvec3(size - 1)) - rest) *
            spacing_mm);
        ASSERT_LE(away, best + 1e-4) << where;
      });
    }
  }
}

// Sides pushed into one another: who rests stays, and no one else's value is mixed in.
TEST(Cut, OverlappingSidesAreDeterministicAndUnmixed) {
  const Size3 size{70, 40, 33};
  CutsByHand by_hand(size);
  by_hand.cut_across_x(31);
  const Cuts cuts = by_hand.done();
  const Volume halves = volume_from<float>(size, VoxelType::float32, {1, 2, 1.5},
                                           [](VoxelIndex v) { return v.x < 32 ? 0.1 : 0.7; });
  const Lattice lattice = lattice_from(size, [](glm::dvec3 p) {
    return p.x > 31.5 ? glm::dvec3(-3.3, 1.1, 0) : glm::dvec3(2.6, 0.3, 0);
  });
  for (const ResampleMethod method : kResampleMethods) {
    const auto one = resampled(halves, lattice, cuts, method, 1);
    for (const float value : one.volume.voxels<float>()) {
      ASSERT_TRUE(value == 0.1f || value == 0.7f || value == static_cast<float>(kBackground))
          << value;
    }
    for (const int threads : {2, 3, 8}) {
      EXPECT_TRUE(same_bytes(one.volume, resampled(halves, lattice, cuts, method, threads).volume));
    }
  }
}

// A cut that ends inside: beyond its end the volume is as it would be without it.
TEST(Cut, EndsWhereItEnds) {
  const Size3 size{64, 48, 40};
  const auto stretch = [](glm::dvec3 p) {
    const double s = std::sin(p.y / 47 * 3.14159265358979) * std::sin(p.z / 39 * 3.14159265358979);
    return glm::dvec3((p.x < 31.5 ? -p.x : 63 - p.x) / 31.5 * 4.0 * s, 0, 0);
  };
  const Lattice lattice = lattice_from(size, stretch);
  CutsByHand by_hand(size);
  by_hand.cut_across_x(31, [](VoxelIndex v) { return v.y <= 20; });
  const Cuts cuts = by_hand.done();
  const Volume volume = volume_from<float>(
      size, VoxelType::float32, glm::dvec3(1),
      [](VoxelIndex v) { return 100.0 + v.y + 0.01 * v.z + (v.x < 32 ? 0.0 : 1000.0); });
  for (const ResampleMethod method : kResampleMethods) {
    const auto whole = resampled(volume, lattice, Cuts(size), method);
    const auto cut = resampled(volume, lattice, cuts, method);
    EXPECT_EQ(cut.counts.unfilled_voxels, 0);
    EXPECT_GT(cut.counts.background_voxels, 100);
    for_each_voxel(size, [&](VoxelIndex v) {
      const double value = cut.volume.value_at(v);
      if (v.y > 20) {
        // Values change by a thousand a voxel here, and bricks in sight of the cut have their rest
        // positions found another way: 2e-5 voxel apart at most.
        const double near = method == ResampleMethod::nearest ? 0.0 : 0.02;
        ASSERT_NEAR(value, whole.volume.value_at(v), near) << text(v);
      } else if (value != kBackground && !(is_smoothed(method) && v.y == 20)) {
        // Before the cell in which it ends, nothing of the other side; means reach around its end.
        const bool left = value < 500;
        ASSERT_TRUE(left || value >= 1099.9) << text(v) << ": " << value;
        ASSERT_TRUE(method == ResampleMethod::nearest || value < 170 || value >= 1099.9) << text(v);
      }
      // The gap: between the sides' last elements, half a voxel from each.
      const double l = 31.5 + lattice.displacement_voxels({31, v.y, v.z}).x;
      const double r = 31.5 + lattice.displacement_voxels({32, v.y, v.z}).x;
      const bool open = v.y <= 20 && v.x > l + 1e-4 && v.x < r - 1e-4;
      ASSERT_EQ(value == kBackground, open) << text(v) << ": " << value << ' ' << l << ' ' << r;
    });
  }
}

TEST(Carve, LeavesAHoleThatMovesWithItsSurroundings) {
  const Size3 size{70, 66, 40};
  const glm::dvec3 center(33, 31, 20);
  const auto carved = [&](glm::dvec3 p) { return glm::length(p - center) < 7.3; };
  CutsByHand by_hand(size);
  for_each_voxel(size, [&](VoxelIndex v) {
    if (carved(v)) by_hand.carve(v);
  });
  const Cuts cuts = by_hand.done();
  std::mt19937 random(17);
  for (const glm::dvec3 spacing_mm : {glm::dvec3(1), glm::dvec3(1, 0.6, 2)}) {
    const Volume volume = numbered(size, spacing_mm);
    for (const glm::dvec3 wanted :
         {glm::dvec3(0), glm::dvec3(5, -3, 2), glm::dvec3(-2.3, 4.6, 1.2)}) {
      const glm::dvec3 by = fixed_point(wanted);
      // What is gone may say anything.
      const Lattice lattice = lattice_from(size, [&](glm::dvec3 p) {
        return carved(p) ? glm::dvec3(int(random() % 20) - 10, int(random() % 3), 0) : by;
      });
      for (const ResampleMethod method : kResampleMethods) {
        const auto out = resampled(volume, lattice, cuts, method);
        if (by == glm::dvec3(0)) {
          EXPECT_EQ(out.counts.unfilled_voxels, 0);
        }
        for_each_voxel(size, [&](VoxelIndex v) {
          const glm::dvec3 rest = glm::dvec3(v) - by;
          bool covered = false;  // by the voxel of an element that is there
          for (int k = 0; k < 8; ++k) {
            const glm::dvec3 corner(k & 1, k >> 1 & 1, k >> 2);
            const glm::dvec3 at = glm::floor(rest) + corner;
            const glm::dvec3 element = glm::clamp(at, glm::dvec3(0), glm::dvec3(size - 1));
            const glm::dvec3 away = glm::abs(rest - element);
            covered =
                covered || (!carved(element) && away.x <= 0.5 && away.y <= 0.5 && away.z <= 0.5);
          }
          ASSERT_EQ(out.volume.value_at(v) != kBackground, covered) << text(v);
          if (!is_smoothed(method) && by == glm::round(by) && covered) {
            ASSERT_EQ(out.volume.value_at(v), volume.value_at(VoxelIndex(rest))) << text(v);
          }
        });
      }
    }
  }
}

TEST(Carve, TakesTheVoxelsOfElementsAtRest) {
  const Size3 size{40, 35, 33};
  for (const VoxelType type : {VoxelType::uint8, VoxelType::int16, VoxelType::float32}) {
    const Volume volume = [&] {
      const auto value = [](VoxelIndex v) { return 5.0 + (v.x + v.y + v.z) % 90; };
      if (type == VoxelType::uint8)
        return volume_from<std::uint8_t>(size, type, glm::dvec3(1), value);
      if (type == VoxelType::int16)
        return volume_from<std::int16_t>(size, type, glm::dvec3(1), value);
      return volume_from<float>(size, type, glm::dvec3(1), value);
    }();
    CutsByHand by_hand(size);
    const std::vector<VoxelIndex> gone = {{0, 0, 0}, {39, 34, 32}, {31, 20, 10}, {32, 20, 10}};
    for (const VoxelIndex v : gone) by_hand.carve(v);
    const double background = type == VoxelType::uint8 ? 0.0 : kBackground;  // clamped
    for (const ResampleMethod method : kResampleMethods) {
      const auto out = resampled(volume, Lattice(size), by_hand.done(), method);
      EXPECT_EQ(out.counts.moved_voxels, 4);
      EXPECT_EQ(out.counts.background_voxels, 4);
      EXPECT_EQ(out.counts.unfilled_voxels, 0);
      for_each_voxel(size, [&](VoxelIndex v) {
        const bool is_gone = std::find(gone.begin(), gone.end(), v) != gone.end();
        ASSERT_EQ(out.volume.value_at(v), is_gone ? background : volume.value_at(v)) << text(v);
      });
    }
    const Resampler resampler(volume, Lattice(size), by_hand.done(), ResampleMethod::linear, 0);
    EXPECT_FALSE(resampler.rest_position({31.2, 20.3, 10}).has_value());
    EXPECT_EQ(resampler.rest_position({30.4, 20.3, 10}), glm::dvec3(30.4, 20.3, 10));
    std::vector<glm::vec3> rest(kBrickVoxels);
    resampler.rest_positions(0, rest);
    EXPECT_TRUE(std::isnan(rest[0].x));
    EXPECT_EQ(rest[1], glm::vec3(1, 0, 0));
  }
}

// A volume and what has been done to it, at random.
struct State {
  Lattice lattice;
  Cuts cuts;
};
State random_state(Size3 size, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto anywhere = [&] {
    return glm::dvec3(size) * (0.5 + 0.3 * glm::dvec3(unit(random), unit(random), unit(random)));
  };
  const glm::dvec3 grab = anywhere();
  const glm::dvec3 pull = 9.0 * glm::dvec3(unit(random), unit(random), unit(random));
  const glm::dvec3 normal = glm::normalize(glm::dvec3(unit(random), unit(random), unit(random)));
  const glm::dvec3 on_plane = anywhere();
  const glm::dvec3 ball = anywhere();
  const double radius = 4 + 3 * unit(random);
  const bool parts = random() % 4 != 0;
  CutsByHand cuts(size);
  const auto side = [&](glm::dvec3 p) { return glm::dot(p - on_plane, normal) > 0; };
  if (parts) {
    // Within a disc of the plane only.
    for_each_voxel(size, [&](VoxelIndex v) {
      if (glm::length(glm::dvec3(v) - on_plane) > 15) return;
      for (int axis = 0; axis < 3; ++axis) {
        VoxelIndex next = v;
        ++next[axis];
        if (side(v) != side(next)) cuts.remove(v, axis);
      }
    });
  }
  if (random() % 2 == 0) {
    for_each_voxel(size, [&](VoxelIndex v) {
      if (glm::length(glm::dvec3(v) - ball) < radius) cuts.carve(v);
    });
  }
  const Lattice lattice = lattice_from(size, [&](glm::dvec3 p) {
    const double share = std::max(0.0, 1.0 - glm::length(p - grab) / 16.0);
    return (parts && side(p) ? -0.7 : 1.0) * share * pull;
  });
  return {random() % 6 == 0 ? Lattice(size) : lattice, cuts.done()};
}

TEST(Cut, WhatChangesIsDirtyAndThreadsAgree) {
  const Size3 size{70, 66, 48};
  const Volume volume = numbered(size, {1, 0.8, 1.7});
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    const State before = random_state(size, random);
    State after = random_state(size, random);
    if (seed % 3 == 0) after.lattice = before.lattice;
    if (seed % 3 == 1) after.cuts = before.cuts;
    for (const ResampleMethod method : kResampleMethods) {
      const auto dirty = dirty_bricks(before.lattice, before.cuts, after.lattice, after.cuts,
                                      volume.spacing_mm(), {VoxelIndex(0), size}, method);
      const auto a = resampled(volume, before.lattice, before.cuts, method);
      const auto b = resampled(volume, after.lattice, after.cuts, method);
      EXPECT_EQ(a.counts.unfilled_voxels, 0) << "seed " << seed;
      EXPECT_EQ(b.counts.unfilled_voxels, 0) << "seed " << seed;
      for_each_voxel(size, [&](VoxelIndex v) {
        if (a.volume.value_at(v) == b.volume.value_at(v)) return;
        const auto brick = BrickGrid(size).linear(BrickGrid::brick_of(v));
        ASSERT_TRUE(std::binary_search(dirty.begin(), dirty.end(), brick))
            << "seed " << seed << ": " << text(v);
      });
      if (seed > 3) continue;
      for (const int threads : {1, 3, 8}) {
        ASSERT_TRUE(same_bytes(
            b.volume, resampled(volume, after.lattice, after.cuts, method, threads).volume))
            << "seed " << seed;
      }
    }
  }
}

}  // namespace
}  // namespace maille
