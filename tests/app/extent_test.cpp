// Material that was pulled out of the volume: saved, looked at, picked, and refused where it went
// too far.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/app/field_file.h"
#include "tests/app/picture.h"
#include "tests/app/program.h"
#include "volume/volume_file.h"

namespace maille::test {
namespace {

const Size3 kSize(36);

// A ball of radius 10 in the middle of a block of 1 mm voxels, numbered by place so that one out of
// its place shows, with the world's origin in its middle.
Volume ball() {
  std::vector<std::int16_t> samples;
  for (int z = 0; z < kSize.z; ++z) {
    for (int y = 0; y < kSize.y; ++y) {
      for (int x = 0; x < kSize.x; ++x) {
        const double r = glm::length(glm::dvec3(x, y, z) - 17.5);
        const int number = (x * 7 + y * 3 + z) % 100;
        samples.push_back(static_cast<std::int16_t>(r < 10 ? 1000 + number : number - 500));
      }
    }
  }
  return Volume::of(kSize, VoxelType::int16, axis_aligned({1, 1, 1}, {-17.5, -17.5, -17.5}),
                    std::move(samples));
}

// Rigid, so that it moves as a whole.
std::string scene(const std::string& by_voxels, const std::string& more = "",
                  const std::string& actions = "") {
  return R"({"volume": {"file": "ball.nrrd"},
      "materials": {"table": [{"values": [-5000, 5000], "compress": 1, "stretch": 1, "shear": 0}]},
      "camera": {"eye_mm": [0, -200, 0], "target_mm": [0, 0, 0]},)" +
         more + R"("actions": [{"drag": {"from": {"voxel": [17, 17, 17]}, "by_voxels": )" +
         by_voxels + "}}" + actions + "]}";
}

Volume load(const std::filesystem::path& path) {
  auto volume = read_volume(path);
  EXPECT_TRUE(volume.ok()) << volume.error().message;
  return *std::move(volume);
}

TEST(SavedExtent, GrowsAroundWhatLeftTheVolume) {
  const Folder folder;
  ASSERT_TRUE(write_volume(folder / "ball.nrrd", ball()).ok());
  write_file(
      folder / "scene.json",
      scene("[20, -3, 0]", "",
            R"(, {"save": {"volume": "kept.nrrd", "field": "kept_field.nrrd", "extent": "keep"}},
                      {"save": {"volume": "saved.nrrd"}})"));
  const auto run = run_maille(
      {"deform", folder("scene.json"), "-o", folder("out.nrrd"), "--field", folder("field.nrrd")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Volume before = ball();
  const Volume out = load(folder / "out.nrrd");
  const Volume kept = load(folder / "kept.nrrd");
  ASSERT_EQ(out.size(), kSize + Size3(20, 3, 0));
  ASSERT_EQ(kept.size(), kSize);
  EXPECT_EQ(glm::dvec3(out.world_from_voxel()[3]), glm::dvec3(-17.5, -20.5, -17.5));
  EXPECT_EQ(load(folder / "saved.nrrd").size(), out.size());
  const auto field = read_field(folder / "field.nrrd");
  ASSERT_EQ(field.size(), static_cast<std::size_t>(voxel_count(out.size())));
  std::size_t i = 0;
  for (int z = 0; z < out.size().z; ++z) {
    for (int y = 0; y < out.size().y; ++y) {
      for (int x = 0; x < out.size().x; ++x, ++i) {
        const VoxelIndex voxel = VoxelIndex(x, y, z) + VoxelIndex(0, -3, 0);  // of the volume
        const VoxelIndex from = voxel - VoxelIndex(20, -3, 0);
        const double expected = contains(kSize, from) ? before.value_at(from) : -500;
        ASSERT_EQ(out.value_at({x, y, z}), expected) << x << ' ' << y << ' ' << z;
        if (contains(kSize, voxel)) {
          ASSERT_EQ(kept.value_at(voxel), expected);
        }
        const glm::vec3 back = contains(kSize, from) ? glm::vec3(-20, 3, 0) : glm::vec3(0);
        ASSERT_LT(glm::distance(field[i], back), 1e-4f);
      }
    }
  }
}

TEST(SavedExtent, IsRefusedWhereItWouldNotFit) {
  const Folder folder;
  ASSERT_TRUE(write_volume(folder / "ball.nrrd", ball()).ok());
  write_file(folder / "scene.json", scene("[90000, 80000, -70000]"));
  const auto run = run_maille({"deform", folder("scene.json"), "-o", folder("out.nrrd")});
  EXPECT_EQ(run.exit_code, 5);
  EXPECT_NE(run.err.find("90036x80036x70036"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("--extent keep"), std::string::npos) << run.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "out.nrrd"));
  const auto kept =
      run_maille({"deform", folder("scene.json"), "-o", folder("out.nrrd"), "--extent", "keep"});
  EXPECT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_EQ(run_maille({"deform", folder("scene.json"), "-o", folder("out.nrrd"), "--extent", "x"})
                .exit_code,
            2);
  write_file(folder / "scene.json",
             scene("[1, 0, 0]", "", R"(, {"save": {"volume": "a.nrrd", "extent": "all"}})"));
  const auto bad = run_maille({"deform", folder("scene.json"), "-o", folder("out.nrrd")});
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_NE(bad.err.find("save.extent: expected \"grow\" or \"keep\", got \"all\""),
            std::string::npos)
      << bad.err;
}

std::int64_t lit_pixels(const Pixels& pixels) {
  std::int64_t lit = 0;
  for (std::size_t i = 0; i + 2 < pixels.rgb.size(); i += 3) {
    lit += !std::equal(pixels.rgb.begin() + static_cast<std::ptrdiff_t>(i),
                       pixels.rgb.begin() + static_cast<std::ptrdiff_t>(i) + 3, pixels.rgb.begin());
  }
  return lit;
}

// The ball looks the same where it has gone, if the picture has a margin: on the side that begins
// with a brick and on the other, in both stores.
TEST(ShownMargin, ShowsWhatLeftTheVolume) {
  const Folder folder;
  ASSERT_TRUE(write_volume(folder / "ball.nrrd", ball()).ok());
  const std::string iso = R"("render": {"mode": "iso", "iso_value": 500, "shading": false)";
  const auto drawn = [&](const std::string& by, const std::string& margin,
                         const std::string& store) {
    write_file(folder / "scene.json", scene(by, iso + margin + "},"));
    const auto run = run_maille({"render", folder("scene.json"), "-o", folder("out.png"), "--size",
                                 "128x128", "--volume-store", store});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return lit_pixels(read_png(folder / "out.png"));
  };
  const std::int64_t whole = drawn("[0, 0, 1]", "", "dense");
  ASSERT_GT(whole, 200);
  for (const char* const by : {"[24, 0, 0]", "[-24, 0, -20]"}) {
    EXPECT_LT(drawn(by, "", "dense"), 0.7 * static_cast<double>(whole));
    for (const char* const store : {"dense", "sparse"}) {
      EXPECT_NEAR(static_cast<double>(drawn(by, R"(, "margin_voxels": 30)", store)),
                  static_cast<double>(whole), 0.06 * static_cast<double>(whole))
          << by << ' ' << store;
    }
  }
}

// What is picked there is told in the volume's own voxels.
TEST(ShownMargin, PicksWhatLeftTheVolume) {
  const Folder folder;
  ASSERT_TRUE(write_volume(folder / "ball.nrrd", ball()).ok());
  write_file(folder / "scene.json",
             scene("[-24, 0, 0]", R"("render": {"mode": "iso", "iso_value": 500,
                                                "margin_voxels": 30},)"));
  // 200 mm away 64 pixels are 53.6 mm: the ball's middle is 28.7 pixels to the left.
  const auto run = run_maille({"pick", folder("scene.json"), "35", "63", "--size", "128x128"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto hit = nlohmann::json::parse(run.out);
  ASSERT_FALSE(hit.is_null());
  EXPECT_LT(hit["voxel"][0], -2.0);
  for (int c = 0; c < 3; ++c) {
    const double moved = c == 0 ? -24 : 0;
    EXPECT_NEAR(hit["rest_voxel"][c].get<double>(), hit["voxel"][c].get<double>() - moved, 1e-3);
    EXPECT_NEAR(hit["world_mm"][c].get<double>(), hit["voxel"][c].get<double>() - 17.5, 1e-3);
  }
}

}  // namespace
}  // namespace maille::test
