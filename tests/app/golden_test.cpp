// The demonstration with a small head, against pictures kept in tests/golden/.
//
// Tolerance: a pixel counts as different when a channel is off by more than kDifference of 255, and
// at most kShare of the pixels may be. Drivers round and contract differently, and a silhouette
// that moves by less than a pixel changes a pixel wholly; a wrong shape, colour or shading changes
// far more of them. tools/golden draws the pictures anew.
#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/app/picture.h"
#include "tests/app/program.h"

namespace maille::test {
namespace {

constexpr int kDifference = 6;
constexpr double kShare = 0.002;

TEST(Demonstration, golden_pictures) {
  const Folder folder;
  write_file(folder / "head.json",
             R"({"volume": {"phantom": "head", "size": [112, 128, 128], "seed": 1},
                 "relaxation": {"tolerance_voxels": 0.3},
                 "camera": {"eye_mm": [390, -190, 10], "target_mm": [0, -85, -20]}})");
  const auto run = run_maille(
      {"demo", folder("head.json"), "-o", folder("demo"), "--size", "256x256", "--deterministic"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_NE(run.out.find("demo/after.png"), std::string::npos) << run.out;
  for (const auto* const name : {"before", "after"}) {
    const auto drawn_path = folder / ("demo/" + std::string(name) + ".png");
    const auto golden_path = std::filesystem::path(MAILLE_SOURCE_DIR "/tests/golden") /
                             ("demo_" + std::string(name) + ".png");
    const auto drawn = read_png(drawn_path);
    ASSERT_EQ(drawn.width, 256);
    if (std::getenv("MAILLE_UPDATE_GOLDEN") != nullptr) {
      std::filesystem::create_directories(golden_path.parent_path());
      std::filesystem::copy_file(drawn_path, golden_path,
                                 std::filesystem::copy_options::overwrite_existing);
    }
    const auto golden = read_png(golden_path);
    EXPECT_LE(share_that_differs(drawn, golden, kDifference), kShare) << name;
  }
  // The nose is small: were the tolerance too wide to see it, the two pictures would pass as one.
  EXPECT_GT(share_that_differs(read_png(folder / "demo/before.png"),
                               read_png(folder / "demo/after.png"), kDifference),
            2 * kShare);
  for (int frame = 0; frame <= 26; ++frame) {
    char name[32];
    std::snprintf(name, sizeof name, "demo/frames/frame_%03d.png", frame);
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "demo/stats.json"));
}

}  // namespace
}  // namespace maille::test
