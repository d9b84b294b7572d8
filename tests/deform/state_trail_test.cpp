// What is left, told from the states of a decay whose end is known.
#include "deform/state_trail.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/deform/relaxing.h"

namespace maille {
namespace {

using testing::RelaxationScene;
using testing::springy;
using testing::workers;

constexpr Size3 kSize{9, 9, 9};

// A box whose elements go towards (1, -2, 0.5) voxels: e^(-rate) of the way is left after a cycle.
class Decay {
 public:
  explicit Decay(double rate)
      : rate_(rate), scene_(testing::constant_volume(kSize, 0, {2, 1, 0.5}), {springy(0, 1.0)}) {
    box_ = std::make_unique<SpringBox>(
        SpringBox::Problem{scene_.start, scene_.field, scene_.cuts, scene_.held, scene_.anchors},
        VoxelBox{{}, kSize}, workers());
  }
  const SpringBox& at(int cycle) {
    const double left = std::exp(-rate_ * cycle);
    put([&](std::int64_t, double) { return 1.0 - left; });
    return *box_;
  }
  static double left_voxels(double rate, int cycle) {
    return std::sqrt(5.25) * std::exp(-rate * cycle);
  }
  template <class F>
  void put(F&& share) {
    const glm::dvec3 end_mm = glm::dvec3(1, -2, 0.5) * box_->spacing_mm();
    for (std::int64_t e = 0; e < voxel_count(box_->extent()); ++e) {
      if (!box_->is_free(e)) continue;
      for (int c = 0; c < 3; ++c) {
        box_->u_mm()[static_cast<std::size_t>(c)][e] =
            static_cast<float>(share(e, end_mm[c]) * end_mm[c]);
      }
    }
  }
  const SpringBox& box() const { return *box_; }

 private:
  double rate_;
  RelaxationScene scene_;
  std::unique_ptr<SpringBox> box_;
};

TEST(StateTrail, SaysNothingBeforeThereAreTwoSpans) {
  Decay decay(0.5);
  StateTrail trail(decay.box());
  EXPECT_EQ(trail.left().largest_voxels, 0.0);
  trail.add(decay.at(0));
  trail.add(decay.at(1));
  EXPECT_EQ(trail.left().largest_voxels, 0.0);
}

TEST(StateTrail, TellsWhatIsLeftOfADecayHoweverSlow) {
  for (const double rate : {1.0, 0.3, 0.1, 0.03, 0.01}) {
    Decay decay(rate);
    StateTrail trail(decay.box());
    const int cycles = static_cast<int>(6.0 / rate);
    for (int i = 0; i <= cycles; ++i) {
      trail.add(decay.at(i));
      // A span has to see a curve before it can tell one.
      if (i * rate < 2.0 || i < 4) continue;
      const double left = Decay::left_voxels(rate, i);
      EXPECT_NEAR(trail.left().largest_voxels, left, 0.02 * left) << rate << ", cycle " << i;
      EXPECT_NEAR(trail.left().rms_voxels, left, 0.02 * left) << rate << ", cycle " << i;
      EXPECT_TRUE(trail.left().one_way);
    }
  }
}

TEST(StateTrail, ASteadyDriftHasFarToGo) {
  Decay decay(1.0);
  StateTrail trail(decay.box());
  for (int i = 0; i <= 40; ++i) {
    decay.put([&](std::int64_t, double) { return 0.001 * i; });
    trail.add(decay.box());
  }
  // 0.0023 voxel a cycle, and no end to be seen.
  EXPECT_GT(trail.left().largest_voxels, 0.5);
  EXPECT_TRUE(trail.left().one_way);
}

TEST(StateTrail, ToAndFroIsNotOneWay) {
  Decay decay(1.0);
  StateTrail trail(decay.box());
  for (int i = 0; i <= 41; ++i) {
    decay.put([&](std::int64_t e, double) { return (e * 7 + i) % 5 * 0.01; });
    trail.add(decay.box());
  }
  EXPECT_FALSE(trail.left().one_way);
}

TEST(StateTrail, TakesBoundedMemoryHoweverLongItGoesOn) {
  Decay decay(0.01);
  StateTrail trail(decay.box());
  std::int64_t most = 0;
  for (int i = 0; i < 1000; ++i) {
    trail.add(decay.at(i));
    most = std::max(most, trail.bytes());
  }
  EXPECT_LE(most, 26 * 12 * voxel_count(kSize));
}

}  // namespace
}  // namespace maille
