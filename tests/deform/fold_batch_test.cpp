// One element at a time against the forces on it, which other code makes, and eight at a time
// against one.
#include "deform/fold_batch.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "deform/fold_guard.h"
#include "tests/deform/spring_row_scenes.h"

namespace maille {
namespace {

using testing::RelaxationScene;
using testing::springy;
using testing::workers;

class Shaken {
 public:
  explicit Shaken(unsigned seed, double most = 0.3)
      : scene_(testing::random_volume({9, 8, 10}, 2, 3, seed, {1, 0.7, 1.6}),
               {springy(0, 1.0), springy(1, 20.0)}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> off(-most, most);
    scene_.displace([&](VoxelIndex) { return glm::dvec3(off(random), off(random), off(random)); });
    if (seed % 3 == 0) {
      const auto disc = CutSurface::disc({4.3, 4.3, 4.3}, {1, 1, -1}, 4.0, glm::dvec3(1));
      scene_.cuts = *cut_along(scene_.cuts, Lattice(scene_.size()), *disc);
    }
    box_ = std::make_unique<SpringBox>(
        SpringBox::Problem{scene_.start, scene_.field, scene_.cuts, scene_.held, scene_.anchors},
        VoxelBox{{}, scene_.size()}, workers());
  }
  SpringBox& box() { return *box_; }

  std::vector<std::int64_t> free_of_color(int color) const {
    std::vector<std::int64_t> elements;
    for (std::int64_t e = 0; e < voxel_count(box_->extent()); ++e) {
      if (box_->is_free(e) && FoldBatch::color_of(*box_, e) == color) elements.push_back(e);
    }
    return elements;
  }
  // Of springs and corners, stiffness * mm.
  glm::dvec3 force_on(std::int64_t e) {
    const std::int64_t r = e / box_->extent().x;
    RunVectors force;
    glm::dvec3 sum(0.0);
    for_each_run(*box_, r, static_cast<int>(e - r * box_->extent().x),
                 static_cast<int>(e - r * box_->extent().x) + 1, [&](const SpringRun& run) {
                   spring_forces(*box_, run, force);
                   sum = {force.x[0], force.y[0], force.z[0]};
                 });
    BoxVectors corners = make_box_vectors(box_->extent(), workers());
    FoldGuard(*box_, workers()).add_forces(corners);
    return sum + glm::dvec3(corners[0][e], corners[1][e], corners[2][e]);
  }

 private:
  RelaxationScene scene_;
  std::unique_ptr<SpringBox> box_;
};

TEST(FoldBatch, MovesToWhereNoForceIsLeft) {
  int near_folding = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    Shaken shaken(seed);
    const auto elements = shaken.free_of_color(static_cast<int>(seed));
    for (std::size_t i = 0; i < elements.size(); i += 4) {
      const FoldEnergy folds(shaken.box());
      const std::int64_t e = elements[i];
      const double before = glm::length(shaken.force_on(e));
      const FoldBatch one(folds, std::span(&e, 1));
      for (int k = 0; k < 60; ++k) one.move_to_least_energy(folds, shaken.box().u_mm(), 1.0);
      EXPECT_LT(glm::length(shaken.force_on(e)), 1e-4 * (before + 1.0)) << seed << ", " << e;
      folds.for_each_corner_at(e, [&](const CellCorner& corner) {
        near_folding += folds.determinant(corner) < kFoldReach;
      });
    }
  }
  EXPECT_GT(near_folding, 15);
}

TEST(FoldBatch, NoElementMindsWhichOthersAreInItsBatch) {
  for (const double share : {1.0, 1.6}) {
    Shaken together(5, 0.4);
    Shaken alone(5, 0.4);
    const FoldEnergy folds(together.box());
    const FoldEnergy folds_alone(alone.box());
    const auto elements = together.free_of_color(3);
    ASSERT_GE(elements.size(), 13u);
    double largest = 0.0;
    double largest_alone = 0.0;
    const std::array<std::span<const std::int64_t>, 2> parts = {std::span(elements).subspan(0, 8),
                                                                std::span(elements).subspan(8, 5)};
    for (const auto part : parts) {
      largest = std::max(
          largest,
          FoldBatch(folds, part).move_to_least_energy(folds, together.box().u_mm(), share));
    }
    for (std::size_t i = 0; i < 13; ++i) {
      largest_alone = std::max(largest_alone,
                               FoldBatch(folds_alone, std::span(&elements[i], 1))
                                   .move_to_least_energy(folds_alone, alone.box().u_mm(), share));
    }
    EXPECT_GT(largest, 0.0);
    EXPECT_EQ(largest, largest_alone);
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::int64_t e = 0; e < voxel_count(together.box().extent()); ++e) {
        ASSERT_EQ(together.box().u_mm()[c][e], alone.box().u_mm()[c][e]) << e;
      }
    }
  }
}

}  // namespace
}  // namespace maille
