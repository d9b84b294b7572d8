// Random deformed volumes that are parted for good and carved, the parts far apart in value: what
// mixes across a removed link shows.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/resample/faults.h"
#include "tests/resample/random_scenes.h"
#include "tests/resample/resampled.h"
#include "tests/resample/true_answers.h"

namespace maille {
namespace {

using namespace testing;

constexpr double kApart = 1000.0;  // of the values of two parts; those of one lie within 1
constexpr double kGone = 1e6;      // and more, of what is carved

struct PartedScene {
  RandomScene whole;
  Lattice lattice;
  Cuts cuts;
  std::function<int(VoxelIndex)> part;
  Volume volume;
};

PartedScene parted_scene(Shape shape, unsigned seed, std::optional<Size3> of_size = {}) {
  RandomScene whole = random_scene(shape, seed, of_size);
  const Size3 size = whole.size;
  Chance chance(500 + seed);
  const auto anywhere = [&] { return glm::dvec3(size - 1) * (0.5 + 0.8 * chance.vector(0.5)); };
  const glm::dvec3 on_plane = anywhere();
  const glm::dvec3 normal = chance.vector(1.0);
  const glm::dvec3 center = anywhere();
  const double radius = chance.between(2.0, 8.0);
  const auto part = [=](VoxelIndex v) {
    const int side = glm::dot(glm::dvec3(v) - on_plane, normal) > 0.0 ? 1 : 0;
    return glm::distance(glm::dvec3(v), center) < radius ? 2 : side;
  };
  CutsByHand by_hand(size);
  for_each_voxel(size, [&](VoxelIndex v) {
    for (int axis = 0; axis < 3; ++axis) {
      VoxelIndex next = v;
      ++next[axis];
      if (part(v) != part(next)) by_hand.remove(v, axis);
    }
    // And some that part nothing.
    if (chance.below(60) == 0) by_hand.remove(v, chance.below(3));
  });
  const glm::dvec3 hole = anywhere();
  const double hole_radius = chance.between(0.0, 4.0);
  for_each_voxel(size, [&](VoxelIndex v) {
    if (glm::distance(glm::dvec3(v), hole) < hole_radius) by_hand.carve(v);
  });
  const Cuts cuts = by_hand.done();
  std::vector<float> values;
  for_each_voxel(size, [&](VoxelIndex v) {
    const double of_part = cuts.carved(v) ? kGone : kApart * part(v);
    values.push_back(static_cast<float>(of_part + chance.between(0.0, 1.0)));
  });
  // Each part is carried somewhere else.
  const glm::dvec3 by[] = {chance.vector(2.5), glm::dvec3(0), chance.vector(4.0)};
  const Lattice lattice = lattice_from(size, [&](glm::dvec3 p) {
    return whole.lattice.displacement_voxels(VoxelIndex(p)) + by[part(VoxelIndex(p))];
  });
  Volume volume = Volume::of(size, VoxelType::float32, axis_aligned(whole.spacing_mm), values);
  return {std::move(whole), lattice, cuts, part, std::move(volume)};
}

class PartedVoxels : public ::testing::TestWithParam<std::tuple<Shape, unsigned>> {
 protected:
  PartedScene scene_ = parted_scene(std::get<0>(GetParam()), std::get<1>(GetParam()));
};

TEST_P(PartedVoxels, ShowOnePartOnly) {
  for (const ResampleMethod method : kResampleMethods) {
    const auto out = resampled(scene_.volume, scene_.lattice, scene_.cuts, method);
    Faults mixed;
    std::int64_t of_part[3] = {};
    for_each_voxel(scene_.whole.size, [&](VoxelIndex v) {
      const double value = out.volume.value_at(v);
      if (value == kBackground) return;
      bool of_one = false;
      for (int part = 0; part < 3; ++part) {
        const bool here = value >= kApart * part && value <= kApart * part + 1.0;
        of_part[part] += here;
        of_one = of_one || here;
      }
      if (!of_one) mixed.add(text(v), ": ", value);
    });
    EXPECT_EQ(mixed.count(), 0) << name_of(method) << ": " << mixed.first();
    EXPECT_GT(of_part[0] + of_part[1] + of_part[2], voxel_count(scene_.whole.size) / 10);
  }
}

// A point on a face may be either cell's.
bool among_whole_cells(const Cuts& cuts, glm::dvec3 rest) {
  constexpr double kFace_voxels = 1e-3;
  const VoxelIndex lo(glm::floor(rest - kFace_voxels));
  const VoxelIndex hi(glm::floor(rest + kFace_voxels));
  const Size3 last = cuts.grid().volume_size() - 1;
  for (int z = std::max(lo.z, -1); z <= std::min(hi.z, last.z); ++z) {
    for (int y = std::max(lo.y, -1); y <= std::min(hi.y, last.y); ++y) {
      for (int x = std::max(lo.x, -1); x <= std::min(hi.x, last.x); ++x) {
        if (!TrueAnswers::whole(cuts, {x, y, z})) return false;
      }
    }
  }
  return true;
}

// What nothing was cut from is as if nothing were cut.
TEST_P(PartedVoxels, OfWholeCellsShowAPointThatLiesThere) {
  const Size3 size = scene_.whole.size;
  const TrueAnswers truth(scene_.lattice, &scene_.cuts);
  const std::vector<glm::vec3> rest = rest_positions(scene_.volume, scene_.lattice, scene_.cuts);
  Faults off;
  Faults missing;
  std::int64_t of_whole_cells = 0;
  std::size_t i = 0;
  for_each_voxel(size, [&](VoxelIndex v) {
    const glm::dvec3 at(rest[i++]);
    const auto answers = truth.at(v);
    if (std::isnan(at.x)) {
      if (answers.rest.empty() || truth.may_be_uncovered(v, 1e-3)) return;
      missing.add(text(v));
      return;
    }
    if (!among_whole_cells(scene_.cuts, at)) return;
    ++of_whole_cells;
    const double off_voxels = glm::distance(moved(scene_.lattice, at), glm::dvec3(v));
    if (!(off_voxels <= 1e-3)) {
      off.add(text(v), ": ", text(at), " lies ", off_voxels, " voxels away");
    }
  });
  EXPECT_EQ(off.count(), 0) << off.first();
  EXPECT_EQ(missing.count(), 0) << missing.first();
  EXPECT_GT(of_whole_cells, voxel_count(size) / 20);
}

// Of some bricks, each of which any thread may take.
TEST(PartedVolumes, HaveTheSameBitsForAnyNumberOfThreads) {
  for (const Shape shape : {Shape::smooth, Shape::folded}) {
    const PartedScene scene = parted_scene(shape, 7, Size3(36, 34, 33));
    for (const Cuts& cuts : {scene.cuts, Cuts(scene.whole.size)}) {
      for (const ResampleMethod method : kResampleMethods) {
        const auto one = resampled(scene.volume, scene.lattice, cuts, method, 1);
        for (const int threads : {2, 5}) {
          const auto many = resampled(scene.volume, scene.lattice, cuts, method, threads);
          EXPECT_TRUE(same_bytes(one.volume, many.volume))
              << "shape " << static_cast<int>(shape) << ", " << threads << " threads";
          EXPECT_EQ(one.counts.background_voxels, many.counts.background_voxels);
          EXPECT_EQ(one.counts.moved_voxels, many.counts.moved_voxels);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Smooth, PartedVoxels,
                         ::testing::Combine(::testing::Values(Shape::smooth),
                                            ::testing::Range(41u, 46u)),
                         name_of_scene);
INSTANTIATE_TEST_SUITE_P(Rough, PartedVoxels,
                         ::testing::Combine(::testing::Values(Shape::rough),
                                            ::testing::Range(46u, 51u)),
                         name_of_scene);
INSTANTIATE_TEST_SUITE_P(Steep, PartedVoxels,
                         ::testing::Combine(::testing::Values(Shape::steep),
                                            ::testing::Range(71u, 74u)),
                         name_of_scene);
INSTANTIATE_TEST_SUITE_P(Folded, PartedVoxels,
                         ::testing::Combine(::testing::Values(Shape::folded),
                                            ::testing::Range(51u, 55u)),
                         name_of_scene);
INSTANTIATE_TEST_SUITE_P(Wild, PartedVoxels,
                         ::testing::Combine(::testing::Values(Shape::wild),
                                            ::testing::Range(55u, 58u)),
                         name_of_scene);

}  // namespace
}  // namespace maille
