#include "resample/resampler.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "tests/resample/scenes.h"

namespace maille {
namespace {

using namespace testing;

struct Resampled {
  Volume volume;
  ResampleCounts counts;
};
Resampled resampled(const Volume& volume, const Lattice& lattice, ResampleMethod method,
                    double background = -1.0, int threads = 2) {
  WorkerPool pool(threads);
  ResampleCounts counts;
  const Resampler resampler(volume, lattice, Cuts(volume.size()), method, background);
  Volume out = resample_volume(resampler, {VoxelIndex(0), volume.size()}, pool, counts);
  return {std::move(out), counts};
}

constexpr ResampleMethod kMethods[] = {ResampleMethod::nearest, ResampleMethod::linear};

TEST(Resampler, UntouchedVolumeComesBackBitForBit) {
  const Size3 size{37, 45, 33};
  std::mt19937 random(5);
  for (const VoxelType type : {VoxelType::uint8, VoxelType::int8, VoxelType::uint16,
                               VoxelType::int16, VoxelType::float32}) {
    std::vector<std::byte> bytes(static_cast<std::size_t>(voxel_count(size)) *
                                 bytes_per_voxel(type));
    for (auto& b : bytes) b = static_cast<std::byte>(random());  // floats: NaN and all
    auto owner = std::make_shared<std::vector<std::byte>>(std::move(bytes));
    const Volume volume(size, type, axis_aligned(glm::dvec3(1)), *owner, owner);
    for (const ResampleMethod method : kMethods) {
      const auto out = resampled(volume, Lattice(size), method);
      EXPECT_EQ(
          std::memcmp(out.volume.bytes().data(), volume.bytes().data(), volume.bytes().size()), 0)
          << name_of(type);
      EXPECT_EQ(out.counts.moved_voxels, 0);
      EXPECT_EQ(out.counts.voxels, voxel_count(size));
    }
  }
}

TEST(Resampler, SignBitsAreFlippedForTextures) {
  const Size3 size{5, 4, 3};
  const Volume volume = volume_from<std::int16_t>(size, VoxelType::int16, glm::dvec3(1),
                                                  [](VoxelIndex v) { return 100 * v.x - 250; });
  const Resampler resampler(volume, Lattice(size), Cuts(size), ResampleMethod::linear, 0);
  std::vector<std::byte> bytes(volume.bytes().size());
  resampler.resample(0, bytes, true);
  for (std::size_t i = 0; i < bytes.size() / 2; ++i) {
    std::uint16_t stored;
    std::memcpy(&stored, &bytes[2 * i], 2);
    EXPECT_EQ(static_cast<int>(stored) - 32768, volume.voxels<std::int16_t>()[i]);
  }
}

// Whole bricks that the material has left, far from the volume's border: what their own elements
// make of them lies in the volume, but nothing of it lies there.
TEST(Resampler, WhatHasShrunkLeavesNothingBehind) {
  const Size3 size{1000, 6, 5};
  const double middle = 499.5;
  const Lattice lattice =
      lattice_from(size, [&](glm::dvec3 at) { return glm::dvec3(-0.75 * (at.x - middle), 0, 0); });
  const double half_width = 0.25 * 500 + 0.5;
  for (const ResampleMethod method : kMethods) {
    const auto out = resampled(numbered(size), lattice, method, -5.0);
    for_each_voxel(size, [&](VoxelIndex v) {
      const bool away = std::abs(v.x - middle) > half_width;
      const bool within = std::abs(v.x - middle) < half_width - 1.0;
      const double value = out.volume.value_at(v);
      if (away) {
        ASSERT_EQ(value, -5.0) << v.x;
      } else if (within) {
        ASSERT_GE(value, 0.0) << v.x;
      }
    });
  }
}

TEST(Resampler, TranslationOfEverythingShiftsTheVolume) {
  const Size3 size{50, 40, 35};
  const glm::ivec3 shift{5, -3, 2};
  const Lattice lattice = lattice_from(size, [&](glm::dvec3) { return glm::dvec3(shift); });
  for (const Volume& volume :
       {numbered(size),
        volume_from<std::int16_t>(size, VoxelType::int16, {1, 2, 0.5},
                                  [](VoxelIndex v) { return v.x * 7 - v.y * 31 + v.z * 101; })}) {
    for (const ResampleMethod method : kMethods) {
      const auto out = resampled(volume, lattice, method, -5.0);
      for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
          for (int x = 0; x < size.x; ++x) {
            const VoxelIndex from = VoxelIndex(x, y, z) - shift;
            const double expected = contains(size, from) ? volume.value_at(from) : -5.0;
            ASSERT_EQ(out.volume.value_at({x, y, z}), expected) << x << ' ' << y << ' ' << z;
          }
        }
      }
    }
  }
}

// The closed forms of an affine map: on a linear ramp trilinear interpolation is exact.
TEST(Resampler, AffineMapsOfARamp) {
  const Size3 size{48, 40, 36};
  const glm::dvec3 center{24, 20, 18};
  const Volume volume =
      volume_from<float>(size, VoxelType::float32, glm::dvec3(1),
                         [](VoxelIndex v) { return 3.0 * v.x - 2.0 * v.y + 0.5 * v.z; });
  const std::vector<glm::dmat3> maps = {
      glm::dmat3(1.5, 0, 0, 0, 0.75, 0, 0, 0, 1.0),
      glm::dmat3(1, 0, 0, 0.3, 1, 0, -0.2, 0.25, 1),
      glm::dmat3(0, 1, 0, -1, 0, 0, 0, 0, 1),  // a quarter turn
      glm::dmat3(4, 0, 0, 0, 0.25, 0, 0, 0, 1),
  };
  for (const glm::dmat3& map : maps) {
    const Lattice lattice =
        lattice_from(size, [&](glm::dvec3 p) { return center + map * (p - center) - p; });
    const auto out = resampled(volume, lattice, ResampleMethod::linear, 1e6);
    const glm::dmat3 inverse = glm::inverse(map);
    std::int64_t covered = 0;
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
          const glm::dvec3 rest = center + inverse * (glm::dvec3(x, y, z) - center);
          const double value = out.volume.value_at({x, y, z});
          bool inside = true;
          for (int c = 0; c < 3; ++c) {
            inside = inside && rest[c] > 0.01 && rest[c] < size[c] - 1.01;
          }
          // A border element carries half its voxel outwards, unturned.
          const glm::dvec3 border = glm::clamp(rest, glm::dvec3(0), glm::dvec3(size - 1));
          const glm::dvec3 away = glm::dvec3(x, y, z) - (center + map * (border - center));
          const bool outside = glm::length(away) > 0.9;
          if (inside) {
            ASSERT_NEAR(value, 3 * rest.x - 2 * rest.y + 0.5 * rest.z, 0.05)
                << x << ' ' << y << ' ' << z;
            ++covered;
          }
          if (outside) {
            ASSERT_EQ(value, 1e6) << x << ' ' << y << ' ' << z;
          }
        }
      }
    }
    EXPECT_GT(covered, 1000);
  }
}

struct Deformation {
  const char* name;
  Field u;
};

// Smooth, still at the border of a 40 x 44 x 38 volume.
double bump(glm::dvec3 p) {
  const glm::dvec3 s = glm::sin(p / glm::dvec3(39, 43, 37) * 3.14159265358979);
  return s.x * s.y * s.z;
}
const std::vector<Deformation> kSmooth = {
    {"mild", [](glm::dvec3 p) { return bump(p) * glm::dvec3(2.3, -1.7, 1.1); }},
    {"stretched and squeezed", [](glm::dvec3 p) { return glm::dvec3(0, 0, 9.0 * bump(p)); }},
    {"sheared", [](glm::dvec3 p) { return glm::dvec3(6.0 * bump(p) * std::sin(p.y / 5), 0, 0); }},
};

// In object order the answer must be what looking at every element finds.
TEST(Resampler, NearestElementEqualsBruteForce) {
  const Size3 size{40, 44, 38};
  for (const glm::dvec3 spacing_mm : {glm::dvec3(1), glm::dvec3(1, 0.8, 2.5)}) {
    const Volume volume = numbered(size, spacing_mm);
    for (const Deformation& d : kSmooth) {
      const Lattice lattice = lattice_from(size, d.u);
      const auto out = resampled(volume, lattice, ResampleMethod::nearest);
      EXPECT_EQ(out.counts.unfilled_voxels, 0) << d.name;
      std::vector<glm::dvec3> at;
      for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
          for (int x = 0; x < size.x; ++x) {
            at.push_back((glm::dvec3(x, y, z) + lattice.displacement_voxels({x, y, z})) *
                         spacing_mm);
          }
        }
      }
      // A sample of the voxels against all elements within reach of any displacement above.
      std::int64_t wrong = 0;
      for (int z = 1; z < size.z; z += 3) {
        for (int y = 1; y < size.y; y += 3) {
          for (int x = 0; x < size.x; ++x) {
            const glm::dvec3 p = glm::dvec3(x, y, z) * spacing_mm;
            double best = 1e30;
            for (int ez = std::max(0, z - 12); ez < std::min(size.z, z + 13); ++ez) {
              for (int ey = std::max(0, y - 12); ey < std::min(size.y, y + 13); ++ey) {
                for (int ex = std::max(0, x - 12); ex < std::min(size.x, x + 13); ++ex) {
                  const auto& e = at[static_cast<std::size_t>(linear_index({ex, ey, ez}, size))];
                  best = std::min(best, glm::dot(e - p, e - p));
                }
              }
            }
            const auto found = static_cast<std::size_t>(out.volume.value_at({x, y, z}));
            const double mine = glm::dot(at[found] - p, at[found] - p);
            wrong += mine > best * (1 + 1e-5) + 1e-9;  // the squares of floats
          }
        }
      }
      EXPECT_EQ(wrong, 0) << d.name;
    }
  }
}

// Forward, then back: the inverse map undoes the lattice.
TEST(Resampler, RestPositionsInvertTheLattice) {
  const Size3 size{40, 44, 38};
  const Volume volume = numbered(size);
  for (const Deformation& d : kSmooth) {
    const Lattice lattice = lattice_from(size, d.u);
    const Resampler resampler(volume, lattice, Cuts(size), ResampleMethod::linear, 0);
    double worst = 0.0;
    for (int z = 0; z < size.z; z += 3) {
      for (int y = 0; y < size.y; y += 3) {
        for (int x = 0; x < size.x; x += 2) {
          const glm::dvec3 rest(x, y, z);
          const glm::dvec3 moved = rest + lattice.displacement_voxels({x, y, z});
          const auto back = resampler.rest_position(moved);
          ASSERT_TRUE(back.has_value()) << d.name << ' ' << x << ' ' << y << ' ' << z;
          worst = std::max(worst, glm::length(*back - rest));
        }
      }
    }
    EXPECT_LT(worst, 2e-3) << d.name;
    // The same map brick by brick, forwards through the trilinear lattice again.
    std::vector<glm::vec3> rest(kBrickVoxels);
    resampler.rest_positions(0, rest);
    const VoxelBox box = lattice.grid().box({0, 0, 0});
    std::size_t i = 0;
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        for (int x = box.lo.x; x < box.hi.x; ++x, ++i) {
          ASSERT_FALSE(std::isnan(rest[i].x));
          const glm::dvec3 r(rest[i]);
          const VoxelIndex base = glm::min(VoxelIndex(r), size - 2);
          const glm::dvec3 t = r - glm::dvec3(base);
          glm::dvec3 forward = r;
          for (int k = 0; k < 8; ++k) {
            const VoxelIndex o(k & 1, (k >> 1) & 1, k >> 2);
            double w = 1;
            for (int c = 0; c < 3; ++c) w *= o[c] ? t[c] : 1 - t[c];
            forward += w * lattice.displacement_voxels(base + o);
          }
          ASSERT_LT(glm::length(forward - glm::dvec3(x, y, z)), 2e-3)
              << d.name << ' ' << x << ' ' << y << ' ' << z;
        }
      }
    }
  }
}

// A wild lattice folds and tears; still nothing is left unfilled while its border rests, no value
// comes from nowhere, and any number of threads gives the same bits.
TEST(Resampler, FoldedLatticesAreFilledAndDeterministic) {
  const Size3 size{70, 40, 36};
  std::mt19937 random(9);
  std::uniform_real_distribution<double> wild(-2.5, 2.5);
  const Lattice lattice = lattice_from(size, [&](glm::dvec3 p) {
    for (int c = 0; c < 3; ++c) {
      if (p[c] < 4 || p[c] > size[c] - 5) return glm::dvec3(0);
    }
    return glm::dvec3(wild(random), wild(random), wild(random));
  });
  WorkerPool pool(2);
  EXPECT_GT(count_folded_cells(lattice, Cuts(size), pool), 1000);
  const Volume volume =
      volume_from<std::uint8_t>(size, VoxelType::uint8, glm::dvec3(1),
                                [](VoxelIndex v) { return 100 + (v.x * 7 + v.y * 3 + v.z) % 100; });
  for (const ResampleMethod method : kMethods) {
    const auto one = resampled(volume, lattice, method, 0.0, 1);
    EXPECT_EQ(one.counts.unfilled_voxels, 0);
    EXPECT_EQ(one.counts.background_voxels, 0);
    for (const std::uint8_t v : one.volume.voxels<std::uint8_t>()) {
      ASSERT_GE(v, 100);
      ASSERT_LT(v, 200);
    }
    for (const int threads : {2, 3, 8}) {
      const auto many = resampled(volume, lattice, method, 0.0, threads);
      EXPECT_EQ(std::memcmp(one.volume.bytes().data(), many.volume.bytes().data(),
                            one.volume.bytes().size()),
                0);
    }
  }
}

// Material that leaves the volume leaves voxels with nothing, however far it goes and however many
// bricks lie between: that is background, not a hole.
TEST(Resampler, WhatLeavesTheVolumeIsNoHole) {
  const Size3 size{100, 40, 36};
  const Volume volume = numbered(size);
  const glm::dvec3 far(1e5, 0, 0);
  const auto all = [&](glm::dvec3) { return far; };
  const auto one_face = [&](glm::dvec3 p) { return p.x > 90 ? far : glm::dvec3(0); };
  const auto inside = [&](glm::dvec3 p) {
    return glm::length(p - glm::dvec3(50, 20, 18)) < 12 ? far : glm::dvec3(0);
  };
  for (const ResampleMethod method : kMethods) {
    const auto gone = resampled(volume, lattice_from(size, all), method);
    EXPECT_EQ(gone.counts.background_voxels, voxel_count(size));
    EXPECT_EQ(gone.counts.unfilled_voxels, 0);
    EXPECT_EQ(resampled(volume, lattice_from(size, one_face), method).counts.unfilled_voxels, 0);
    // Behind a border at rest everything stays covered, by cells that reach as far as the drag.
    const auto stretched = resampled(volume, lattice_from(size, inside), method);
    EXPECT_GT(stretched.counts.moved_voxels, 1000);
    EXPECT_EQ(stretched.counts.background_voxels, 0);
    EXPECT_EQ(stretched.counts.unfilled_voxels, 0);
  }
}

TEST(Resampler, CountsFoldedCells) {
  const Size3 size{20, 20, 20};
  WorkerPool pool(1);
  EXPECT_EQ(count_folded_cells(Lattice(size), Cuts(size), pool), 0);
  EXPECT_EQ(count_folded_cells(lattice_from(size, [](glm::dvec3 p) { return 0.2 * p; }), Cuts(size),
                               pool),
            0);
  // One element pulled past its neighbour turns cells around it inside out.
  EXPECT_GT(count_folded_cells(lattice_from(size,
                                            [](glm::dvec3 p) {
                                              return p == glm::dvec3(10) ? glm::dvec3(1.5, 0, 0)
                                                                         : glm::dvec3(0);
                                            }),
                               Cuts(size), pool),
            0);
}

TEST(Resampler, SlabsRowsAndSingleVoxels) {
  for (const Size3 size : {Size3(33, 20, 1), Size3(1, 40, 20), Size3(50, 1, 1), Size3(1, 1, 1)}) {
    const Volume volume = numbered(size);
    const Lattice lattice =
        lattice_from(size, [](glm::dvec3) { return glm::dvec3(0.4, 0.3, 0.2); });
    for (const ResampleMethod method : kMethods) {
      const auto out = resampled(volume, lattice, method);
      for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
          for (int x = 0; x < size.x; ++x) {
            const double value = out.volume.value_at({x, y, z});
            const auto own = static_cast<double>(linear_index({x, y, z}, size));
            if (method == ResampleMethod::nearest) {
              ASSERT_EQ(value, own);
            }
            ASSERT_GE(value, 0.0);
            ASSERT_LE(value, own);
          }
        }
      }
    }
  }
}

// What a drag dirties is all that a drag changes.
TEST(DirtyBricks, HoldEveryChange) {
  const Size3 size{100, 96, 70};
  const auto pulled = [&](glm::dvec3 center, glm::dvec3 by) {
    return lattice_from(size, [=](glm::dvec3 p) {
      return by * std::max(0.0, 1.0 - glm::length(p - center) / 18.0);
    });
  };
  const Lattice rest(size);
  const Lattice a = pulled({50, 40, 35}, {7, -9, 3});
  const Lattice b = pulled({30, 60, 35}, {-8, 4, 2});
  const auto dirty_between = [&](const Lattice& before, const Lattice& after, glm::dvec3 spacing_mm,
                                 ResampleMethod method) {
    return dirty_bricks(before, Cuts(size), after, Cuts(size), spacing_mm, {VoxelIndex(0), size},
                        method);
  };
  const std::vector<std::pair<Lattice, Lattice>> changes = {
      {rest, a}, {a, rest}, {a, b}, {rest, rest}};
  for (const glm::dvec3 spacing_mm : {glm::dvec3(1), glm::dvec3(4, 0.5, 1)}) {
    const Volume volume = numbered(size, spacing_mm);
    for (const auto& [before, after] : changes) {
      for (const ResampleMethod method : kResampleMethods) {
        const auto dirty = dirty_between(before, after, spacing_mm, method);
        const Volume old_volume = resampled(volume, before, method).volume;
        const Volume new_volume = resampled(volume, after, method).volume;
        for (int z = 0; z < size.z; ++z) {
          for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
              if (old_volume.value_at({x, y, z}) == new_volume.value_at({x, y, z})) continue;
              const auto brick = after.grid().linear(BrickGrid::brick_of({x, y, z}));
              ASSERT_TRUE(std::binary_search(dirty.begin(), dirty.end(), brick))
                  << x << ' ' << y << ' ' << z;
            }
          }
        }
      }
    }
  }
  for (const ResampleMethod method : kResampleMethods) {
    EXPECT_TRUE(dirty_between(a, a, glm::dvec3(1), method).empty());
    EXPECT_LT(dirty_between(rest, a, glm::dvec3(1), method).size(),
              static_cast<std::size_t>(rest.grid().count()));
  }
}

}  // namespace
}  // namespace maille
