#include "references/paper_walk.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "tests/measure/deformed_scenes.h"

namespace maille {
namespace {

using namespace testing;

using Neighbours = PaperWalkOptions::Neighbours;

struct Walks {
  std::vector<WalkedVoxel> voxels;
  WalkCounts counts;
};

Walks walks_over(const DeformedElements& elements, const PaperWalkOptions& options = {}) {
  Walks walks{paper_walk(elements, VoxelIndex(0), elements.size(), options), {}};
  walks.counts = count_walks(elements, NearestBruteForce(elements), VoxelIndex(0), elements.size(),
                             walks.voxels);
  return walks;
}

// Kept in the tests' XML, so that shares can be read off without a failure.
void record(const std::string& scene, const WalkCounts& counts) {
  const auto keep = [&](const char* what, auto value) {
    ::testing::Test::RecordProperty(scene + "_" + what, std::to_string(value));
  };
  keep("right_share", counts.right_share());
  keep("voxels", counts.voxels);
  keep("there", counts.there);
  keep("right", counts.right);
  keep("wrong", counts.wrong());
  keep("missed", counts.missed);
  keep("steps_a_voxel", static_cast<double>(counts.steps) / static_cast<double>(counts.voxels));
}

// A tie between neighbours is broken as among all elements.
TEST(PaperWalk, BreaksTiesAsTheBruteForceDoes) {
  const DeformedElements elements = deformed({7, 6, 5}, [](glm::dvec3) { return glm::dvec3(0.5); });
  for (const Neighbours neighbours : {Neighbours::six, Neighbours::twenty_six}) {
    const WalkCounts counts = walks_over(elements, {neighbours}).counts;
    EXPECT_EQ(counts.right, counts.voxels);
  }
}

TEST(PaperWalk, AtRestNeedsNoStep) {
  const DeformedElements elements =
      deformed({13, 10, 11}, [](glm::dvec3) { return glm::dvec3(0); }, {1, 0.8, 2.5});
  for (const Neighbours neighbours : {Neighbours::six, Neighbours::twenty_six}) {
    const WalkCounts counts = walks_over(elements, {neighbours}).counts;
    EXPECT_EQ(counts.right, counts.voxels);
    EXPECT_EQ(counts.steps, 0);
  }
}

// In voxels that everything has left there is nothing to find, and the walk says so.
TEST(PaperWalk, FindsWhatWasShifted) {
  const Size3 size{30, 26, 28};
  const glm::ivec3 shift{5, -3, 2};
  const glm::dvec3 spacing_mm{1, 0.8, 1.5};
  const DeformedElements elements = deformed(
      size, [&](glm::dvec3) { return glm::dvec3(shift); }, spacing_mm);
  for (const Neighbours neighbours : {Neighbours::six, Neighbours::twenty_six}) {
    // Beyond the volume too, where some of it lies now.
    const VoxelIndex lo = VoxelIndex(0) - 8;
    const VoxelIndex hi = size + 8;
    const auto walked = paper_walk(elements, lo, hi, {neighbours});
    std::size_t i = 0;
    for (int z = lo.z; z < hi.z; ++z) {
      for (int y = lo.y; y < hi.y; ++y) {
        for (int x = lo.x; x < hi.x; ++x, ++i) {
          const VoxelIndex from = VoxelIndex(x, y, z) - shift;
          const VoxelIndex border = glm::clamp(from, VoxelIndex(0), size - 1);
          ASSERT_EQ(walked[i].element, element_of(border, size)) << x << ' ' << y << ' ' << z;
          // Cells are as at rest: half a voxel's diagonal is how far an element reaches.
          const glm::dvec3 away_mm = glm::dvec3(from - border) * spacing_mm;
          const bool reached = 4.0 * glm::dot(away_mm, away_mm) < glm::dot(spacing_mm, spacing_mm);
          ASSERT_EQ(walked[i].found(), reached) << x << ' ' << y << ' ' << z;
        }
      }
    }
    const WalkCounts counts = count_walks(elements, NearestBruteForce(elements), lo, hi, walked);
    EXPECT_EQ(counts.right, counts.there);
    EXPECT_EQ(counts.wrong(), 0);
    EXPECT_LT(counts.found, counts.voxels);
  }
}

// What the paper promises, where it holds.
TEST(PaperWalk, FindsMoreThan99PercentWhereItIsSmooth) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const DeformedElements elements =
        deformed({40, 36, 38}, smooth_waves(seed, 0.3), {1, 0.8, 1.2});
    for (const Neighbours neighbours : {Neighbours::six, Neighbours::twenty_six}) {
      const WalkCounts counts = walks_over(elements, {neighbours}).counts;
      record("smooth_" + std::to_string(seed) + (neighbours == Neighbours::six ? "_6" : "_26"),
             counts);
      EXPECT_GT(counts.there, counts.voxels / 2);
      EXPECT_GT(counts.right_share(), 0.99);
    }
  }
}

// A stretch along an axis leaves axis neighbours the ones to walk by: nothing is lost.
TEST(PaperWalk, StretchedAlongAnAxis) {
  const Size3 size{48, 20, 18};
  const DeformedElements stretched =
      deformed(size, affine(glm::dmat3(4, 0, 0, 0, 1, 0, 0, 0, 1), {24, 10, 9}));
  const DeformedElements squeezed_too = deformed(size, stretched_and_squeezed(47));
  for (const Neighbours neighbours : {Neighbours::six, Neighbours::twenty_six}) {
    const char* suffix = neighbours == Neighbours::six ? "_6" : "_26";
    const std::vector<std::pair<const char*, const DeformedElements*>> scenes = {
        {"stretched_4", &stretched}, {"stretched_and_squeezed", &squeezed_too}};
    for (const auto& [name, elements] : scenes) {
      const WalkCounts counts = walks_over(*elements, {neighbours}).counts;
      record(std::string(name) + suffix, counts);
      EXPECT_EQ(counts.there, counts.voxels) << name;
      EXPECT_EQ(counts.right, counts.voxels) << name;
    }
  }
}

// Sheared as well, what lies next to an element in space is none of its neighbours: the way there
// leads uphill. By 26 the walk ends within reach and believes what it has; by 6 most often beyond.
TEST(PaperWalk, LosesItsWayWhereStretchAndShearMeet) {
  const Size3 size{40, 30, 20};
  const DeformedElements elements =
      deformed(size, affine(glm::dmat3(4, 0, 0, 2.6, 1, 0, 0, 0, 1), {20.3, 15.1, 10}));
  const WalkCounts six = walks_over(elements, {Neighbours::six}).counts;
  const WalkCounts twenty_six = walks_over(elements, {Neighbours::twenty_six}).counts;
  record("sheared_6", six);
  record("sheared_26", twenty_six);
  EXPECT_GT(six.missed, six.there / 2);
  EXPECT_GT(twenty_six.wrong(), twenty_six.there / 20);
  EXPECT_EQ(twenty_six.missed, 0);
}

TEST(PaperWalk, FailsAtFoldsAndSaysSo) {
  const Size3 size{48, 12, 12};
  const DeformedElements elements = deformed(size, folded());
  for (const Neighbours neighbours : {Neighbours::six, Neighbours::twenty_six}) {
    const Walks walks = walks_over(elements, {neighbours});
    record(neighbours == Neighbours::six ? "folded_6" : "folded_26", walks.counts);
    EXPECT_GT(walks.counts.missed, 0);
    EXPECT_EQ(walks.counts.gave_up, 0);
    // Found or not by what lies where, told without the walk's own arithmetic: here all moves along
    // x alone, so that an element's reach follows from its two links along x.
    for (std::size_t i = 0; i < walks.voxels.size(); ++i) {
      const WalkedVoxel& walked = walks.voxels[i];
      double longest = 1.0;
      const VoxelIndex at = voxel_of(walked.element, size);
      for (int x = std::max(at.x - 1, 0); x < std::min(at.x + 1, size.x - 1); ++x) {
        const VoxelIndex lower(x, at.y, at.z), upper(x + 1, at.y, at.z);
        longest = std::max(longest, std::abs(elements.at_mm(element_of(upper, size)).x -
                                             elements.at_mm(element_of(lower, size)).x));
      }
      const double reach_mm = 0.5 * std::sqrt(longest * longest + 2.0);
      const double away_mm =
          glm::length(elements.at_mm(walked.element) - glm::dvec3(voxel_of(i, size)));
      ASSERT_EQ(walked.found(), away_mm <= reach_mm) << i;
    }
  }
}

// The first voxel has to be walked to; from there on rows and planes start where the ones before
// did, with the displacement found there.
TEST(PaperWalk, RowsAndPlanesStartWhereTheOnesBeforeDid) {
  const DeformedElements elements =
      deformed({40, 6, 7}, [](glm::dvec3) { return glm::dvec3(9, 0, 0); });
  const auto walked = paper_walk(elements, {20, 0, 0}, {30, 6, 7}, {Neighbours::six});
  EXPECT_EQ(walked.front().steps, 9);
  EXPECT_TRUE(std::all_of(walked.begin() + 1, walked.end(),
                          [](const WalkedVoxel& voxel) { return voxel.steps == 0; }));
}

// A voxel further is a step every fourth time: from the element before, since a voxel less the
// displacement there is a whole element further.
TEST(PaperWalk, StartsAtTheNearerOfItsGuesses) {
  const Size3 size{40, 3, 3};
  const DeformedElements elements =
      deformed(size, affine(glm::dmat3(4, 0, 0, 0, 1, 0, 0, 0, 1), {20, 1, 1}));
  const auto walked = paper_walk(elements, {0, 1, 1}, {40, 2, 2}, {Neighbours::six});
  std::int64_t steps = 0;
  for (const WalkedVoxel& voxel : walked) steps += voxel.steps;
  EXPECT_EQ(steps - walked.front().steps, 10);  // elements 15 to 25
}

TEST(PaperWalk, GivesUpAfterItsSteps) {
  const Size3 size{30, 5, 5};
  const DeformedElements elements = deformed(size, [](glm::dvec3) { return glm::dvec3(9, 0, 0); });
  const auto end_with = [&](int most_steps) {
    return paper_walk(elements, {20, 2, 2}, {21, 3, 3}, {Neighbours::six, most_steps}).front();
  };
  EXPECT_EQ(end_with(8).end, WalkedVoxel::End::too_many_steps);
  EXPECT_EQ(end_with(8).steps, 8);
  EXPECT_EQ(end_with(9).end, WalkedVoxel::End::found);
  EXPECT_EQ(end_with(9).steps, 9);
  EXPECT_EQ(end_with(9).element, element_of({11, 2, 2}, size));
}

}  // namespace
}  // namespace maille
