#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/app/picture.h"
#include "tests/app/program.h"
#include "volume/volume_file.h"

namespace maille::test {
namespace {

// A ball of 200 in 0, radius 10 mm around the world's origin, 1 mm voxels.
void write_ball(const std::filesystem::path& path) {
  constexpr int kEdge = 41;
  std::vector<std::uint8_t> samples;
  for (int z = 0; z < kEdge; ++z) {
    for (int y = 0; y < kEdge; ++y) {
      for (int x = 0; x < kEdge; ++x) {
        const double r =
            std::sqrt(double((x - 20) * (x - 20) + (y - 20) * (y - 20) + (z - 20) * (z - 20)));
        samples.push_back(static_cast<std::uint8_t>(std::clamp(100 + 100 * (10 - r), 0.0, 200.0)));
      }
    }
  }
  const auto volume = Volume::of(Size3(kEdge), VoxelType::uint8,
                                 axis_aligned({1, 1, 1}, {-20, -20, -20}), std::move(samples));
  ASSERT_TRUE(write_volume(path, volume).ok());
}

// Looked at from the front; the drag is straight towards the viewer's right.
const char* const kScene = R"({"volume": {"file": "ball.nrrd"},
    "materials": {"table": [{"values": [0, 256], "compress": 1, "stretch": 1, "shear": 0}]},
    "render": {"mode": "iso", "iso_value": 100},
    "camera": {"eye_mm": [0, -100, 0], "target_mm": [0, 0, 0]},
    "actions": [
      {"render": {"to": "before.png"}},
      {"drag": {"from": {"pixel": [64, 64]}, "by_mm": [8, 0, 0], "steps": 2, "name": "ball"}},
      {"render": {"to": "after.png"}}]})";

void write_scene(const Folder& folder) {
  write_ball(folder / "ball.nrrd");
  write_file(folder / "scene.json", kScene);
}

// Columns of the leftmost and rightmost pixels that are not background.
std::pair<int, int> extent_of(const Pixels& pixels) {
  std::pair<int, int> extent{pixels.width, -1};
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      const auto i = static_cast<std::size_t>(y * pixels.width + x) * 3;
      const bool background =
          std::equal(pixels.rgb.begin() + static_cast<std::ptrdiff_t>(i),
                     pixels.rgb.begin() + static_cast<std::ptrdiff_t>(i) + 3, pixels.rgb.begin());
      if (background) continue;
      extent.first = std::min(extent.first, x);
      extent.second = std::max(extent.second, x);
    }
  }
  return extent;
}

TEST(RenderCommand, DrawsBeforeAndAfterADragFromAPixel) {
  const Folder folder;
  write_scene(folder);
  const auto run =
      run_maille({"render", folder("scene.json"), "-o", folder("end.png"), "--size", "128x128",
                  "--frames", folder("frames"), "--stats", folder("stats.json")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out + run.err, "");
  const auto before = read_png(folder / "before.png");
  const auto after = read_png(folder / "after.png");
  ASSERT_EQ(before.width, 128);
  const auto [left, right] = extent_of(before);
  const auto [left_after, right_after] = extent_of(after);
  // 15 degrees each side of the axis, 100 mm away: 64 pixels are 26.8 mm.
  EXPECT_NEAR(right - left + 1, 2 * 10.05 / 26.8 * 64, 2.5);
  EXPECT_NEAR(left_after - left, 8 / 26.8 * 64, 2.0);
  EXPECT_NEAR(right_after - right, 8 / 26.8 * 64, 2.0);
  EXPECT_EQ(share_that_differs(read_png(folder / "end.png"), after, 0), 0.0);
  EXPECT_EQ(share_that_differs(read_png(folder / "frames/frame_000.png"), before, 0), 0.0);
  EXPECT_EQ(share_that_differs(read_png(folder / "frames/frame_002.png"), after, 0), 0.0);
  EXPECT_FALSE(std::filesystem::exists(folder / "frames/frame_003.png"));

  const auto stats = nlohmann::json::parse(read_file(folder / "stats.json"));
  EXPECT_EQ(stats["chainmail"]["drags"], 2);
  EXPECT_EQ(stats["frames"]["count"], 6);
  EXPECT_GT(stats["frames"]["first_picture_seconds"], 0.0);
  EXPECT_EQ(stats["pick"]["count"], 1);
  EXPECT_GT(stats["upload"]["bricks"], 0);
  EXPECT_GT(stats["resample"]["voxels"], 0);
  EXPECT_FALSE(stats["device"]["name"].get<std::string>().empty());
  const auto& left_out = stats["left_out"];
  for (const auto* const name : {"relaxation", "material_lookup", "composite", "window"}) {
    EXPECT_NE(std::find(left_out.begin(), left_out.end(), name), left_out.end()) << name;
  }
}

TEST(RenderCommand, SparseAndDenseStoresShowTheSame) {
  const Folder folder;
  write_scene(folder);
  for (const auto* const store : {"sparse", "dense"}) {
    const auto run =
        run_maille({"render", folder("scene.json"), "-o", folder(std::string(store) + ".png"),
                    "--size", "128x128", "--volume-store", store});
    if (run.exit_code == 4 && std::string(store) == "sparse") {
      GTEST_SKIP() << "no sparse images here: " << run.err;
    }
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  // A software device filters the two with other instructions: the last bit of a texel may differ,
  // and with it whether a ray that grazes the ball meets it.
  EXPECT_LT(share_that_differs(read_png(folder / "sparse.png"), read_png(folder / "dense.png"), 3),
            0.001);
}

TEST(PickCommand, FindsTheSurfaceBeforeAndAfterADrag) {
  const Folder folder;
  write_scene(folder);
  // The picture's middle; after the drag the ball's own middle is 8 mm to the right of it.
  const auto run = run_maille({"pick", folder("scene.json"), "83", "64", "--size", "128x128"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto hit = nlohmann::json::parse(run.out);
  const auto world = hit["world_mm"].get<std::vector<double>>();
  const glm::dvec3 from_center(world[0] - 8, world[1], world[2]);
  EXPECT_NEAR(glm::length(from_center), 10.0, 0.15);
  EXPECT_LT(from_center.y, -9.5);
  const auto voxel = hit["voxel"].get<std::vector<double>>();
  const auto rest = hit["rest_voxel"].get<std::vector<double>>();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(voxel[axis], world[axis] + 20, 1e-3);
    EXPECT_NEAR(rest[axis], voxel[axis] - (axis == 0 ? 8 : 0), 0.01);
  }
  EXPECT_NEAR(hit["value"].get<double>(), 100.0, 5.0);
  const auto normal = hit["normal"].get<std::vector<double>>();
  EXPECT_LT(normal[1], -0.9);
}

TEST(PickCommand, PrintsNullForAMiss) {
  const Folder folder;
  write_scene(folder);
  const auto run = run_maille({"pick", folder("scene.json"), "2", "2", "--size", "128x128"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, "null\n");
}

TEST(RenderCommand, FramesOfAnEarlierRunGo) {
  const Folder folder;
  write_scene(folder);
  std::filesystem::create_directories(folder / "frames");
  for (const auto* const name : {"frame_007.png", "frame_0123.png", "frame_one.png", "other.png"}) {
    write_file(folder / "frames" / name, "");
  }
  const auto run = run_maille({"render", folder("scene.json"), "-o", folder("end.png"), "--size",
                               "128x128", "--frames", folder("frames")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "frames")) {
    names.insert(entry.path().filename().string());
  }
  EXPECT_EQ(names, (std::set<std::string>{"frame_000.png", "frame_001.png", "frame_002.png",
                                          "frame_one.png", "other.png"}));
}

TEST(RenderCommand, ADragFromAnEmptyPixelIsBadInput) {
  const Folder folder;
  write_ball(folder / "ball.nrrd");
  std::string scene = kScene;
  scene.replace(scene.find("[64, 64]"), 8, "[2, 2]");
  write_file(folder / "scene.json", scene);
  const auto run =
      run_maille({"render", folder("scene.json"), "-o", folder("x.png"), "--size", "128x128"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("actions[1].drag: from.pixel: nothing is to be seen at (2, 2)"),
            std::string::npos)
      << run.err;
}

TEST(RenderCommand, AnUnwritablePictureIs6) {
  const Folder folder;
  write_scene(folder);
  const auto run = run_maille(
      {"render", folder("scene.json"), "-o", folder("no/such/x.png"), "--size", "32x32"});
  EXPECT_EQ(run.exit_code, 6) << "before the drag from pixel (64, 64) outside of 32x32";
  write_file(folder / "still.json", R"({"volume": {"file": "ball.nrrd"}})");
  const auto still = run_maille(
      {"render", folder("still.json"), "-o", folder("no/such/x.png"), "--size", "32x32"});
  EXPECT_EQ(still.exit_code, 6) << still.err;
}

TEST(DemoCommand, PlaysVolumesOfAnyShape) {
  const Folder folder;
  const float nan = std::nanf("");
  const std::vector<std::pair<std::string, Volume>> volumes = {
      {"one", Volume::of<std::uint8_t>({1, 1, 1}, VoxelType::uint8, glm::dmat4(1.0), {7})},
      {"row", Volume::of({300, 1, 1}, VoxelType::uint8, glm::dmat4(1.0),
                         std::vector<std::uint8_t>(300, 9))},
      {"nan",
       Volume::of({4, 4, 4}, VoxelType::float32, glm::dmat4(1.0), std::vector<float>(64, nan))}};
  for (const auto& [name, volume] : volumes) {
    ASSERT_TRUE(write_volume(folder / (name + ".nrrd"), volume).ok());
    const auto run = run_maille(
        {"demo", folder(name + ".nrrd"), "-o", folder(name), "--size", "32x32", "--deterministic"});
    EXPECT_EQ(run.exit_code, 0) << name << ": " << run.err;
    EXPECT_TRUE(std::filesystem::exists(folder / name / "after.png")) << name;
  }
}

}  // namespace
}  // namespace maille::test
