#include "deform/lattice_memory.h"

#include <csignal>
#include <cstdlib>
#include <random>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "deform/deformer.h"
#include "tests/deform/scenes.h"

namespace maille {
namespace {

using testing::constant_volume;
using testing::equal;
using testing::material;
using testing::random_volume;
using testing::table;
using testing::workers;

constexpr std::int64_t kPlaneBytes = kBrickVoxels * 2;
constexpr Size3 kSize{70, 66, 40};

Deformer deformer_with(std::optional<std::int64_t> lattice_memory_bytes) {
  DeformerOptions options;
  options.lattice_memory_bytes = lattice_memory_bytes;
  return Deformer(random_volume(kSize, 2, 8, 5),
                  table({material(0, 1, 0.5, 1.5, 0.2), material(1, 2, 0.9, 1.2, 0.4)}), {},
                  options);
}

// The same random session with and without a budget: bits are the same after every action.
TEST(LatticeMemory, ABudgetChangesNoBit) {
  const unsigned seed = 411;
  SCOPED_TRACE(seed);
  const std::int64_t budget = 30 * kPlaneBytes;
  Deformer free = deformer_with(std::nullopt);
  Deformer limited = deformer_with(budget);
  std::mt19937 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (int n = 0; n < 60; ++n) {
    const VoxelIndex at{below(kSize.x), below(kSize.y), below(kSize.z)};
    const glm::dvec3 by(below(90) / 10.0 - 4.5, below(90) / 10.0 - 4.5, below(90) / 10.0 - 4.5);
    const int kind = below(10);
    for (Deformer* deformer : {&free, &limited}) {
      if (kind < 5) {
        ASSERT_TRUE(deformer->begin_stroke(at, 2).ok());
        for (const double share : {0.5, 1.0}) {
          const auto dragged = deformer->drag_to(by * share, workers());
          ASSERT_TRUE(dragged.ok()) << dragged.error().message;
        }
        kind == 4 ? deformer->cancel_stroke() : deformer->end_stroke();
      } else if (kind == 5) {
        deformer->release_all();
      } else if (kind == 6) {
        ASSERT_TRUE(deformer->carve(glm::dvec3(at), 3).ok());
      } else if (kind == 7) {
        static_cast<void>(deformer->redo());
      } else {
        static_cast<void>(deformer->undo());
      }
    }
    ASSERT_TRUE(equal(free.lattice(), limited.lattice())) << n;
    const auto counters = limited.memory()->store().counters();
    EXPECT_LE(counters.bytes_in_memory, budget);
    // A solver and this test read one row at a time.
    EXPECT_LE(counters.peak_bytes_in_memory, budget + kPlaneBytes);
  }
  while (free.undo()) {
    ASSERT_TRUE(limited.undo());
    ASSERT_TRUE(equal(free.lattice(), limited.lattice()));
  }
  EXPECT_FALSE(limited.undo());
  EXPECT_TRUE(limited.lattice().at_rest());
  EXPECT_GT(limited.memory()->store().counters().planes_read, 50);
}

TEST(LatticeMemory, AStrokeThatNeedsMoreIsRefusedAndNothingMoves) {
  Deformer deformer = deformer_with(6 * kPlaneBytes);
  ASSERT_TRUE(deformer.begin_stroke({16, 16, 16}, 1).ok());
  ASSERT_TRUE(deformer.drag_to({0.5, 0, 0}, workers()).ok());
  const Lattice before = deformer.lattice();
  const auto refused = deformer.drag_to({30, 30, 30}, workers());
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, ErrorKind::out_of_memory);
  EXPECT_NE(refused.error().message.find("384 KiB (--lattice-memory)"), std::string::npos)
      << refused.error().message;
  EXPECT_TRUE(equal(deformer.lattice(), before));
  ASSERT_TRUE(deformer.drag_to({0, 0, 0}, workers()).ok());
  EXPECT_TRUE(deformer.lattice().at_rest());
}

TEST(LatticeMemory, WithoutABudgetPlanesKeepTheirValues) {
  Deformer deformer = deformer_with(std::nullopt);
  ASSERT_TRUE(deformer.begin_stroke({16, 16, 16}, 1).ok());
  ASSERT_TRUE(deformer.drag_to({0.5, 0, 0}, workers()).ok());
  EXPECT_EQ(deformer.memory(), nullptr);
  deformer.lattice().for_each_brick(
      [](std::int64_t, const LatticeBrick& brick) { EXPECT_EQ(brick.plane(0)->paged(), nullptr); });
}

TEST(LatticeMemory, AFullDiskLosesNothing) {
  Deformer deformer = deformer_with(30 * kPlaneBytes);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit none{0, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &none);
  std::vector<Lattice> states;
  std::optional<Error> error;
  for (int n = 0; n < 20 && !error; ++n) {
    ASSERT_TRUE(deformer.begin_stroke({8 + 3 * n, 30, 20}, 1).ok());
    const auto dragged = deformer.drag_to({2, -1.5, 1 + 0.1 * n}, workers());
    if (dragged) {
      deformer.end_stroke();
      states.push_back(deformer.lattice());
    } else {
      error = dragged.error();
      deformer.cancel_stroke();
    }
  }
  setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->kind, ErrorKind::file_system);
  ASSERT_GT(states.size(), 1u);
  EXPECT_TRUE(equal(deformer.lattice(), states.back()));
  // With room again it goes on where it was.
  for (std::size_t n = states.size(); n-- > 1;) {
    ASSERT_TRUE(deformer.undo());
    EXPECT_TRUE(equal(deformer.lattice(), states[n - 1]));
  }
}

}  // namespace
}  // namespace maille
