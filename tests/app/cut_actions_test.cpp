// Scenes that cut, carve and restore, and runs under a memory budget, as a person starts them.
#include <algorithm>
#include <cstring>
#include <map>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/app/program.h"
#include "volume/volume_file.h"

namespace maille::test {
namespace {

constexpr Size3 kSize{40, 36, 34};

// Values 100 .. 227, in a grid that is neither isotropic nor aligned with the world.
Volume test_volume() {
  std::vector<std::int16_t> samples;
  for (int n = 0; n < kSize.x * kSize.y * kSize.z; ++n) {
    samples.push_back(static_cast<std::int16_t>(100 + n * 37 % 128));
  }
  glm::dmat4 world_from_voxel(1.0);
  world_from_voxel[0] = {0, 1.5, 0, 0};
  world_from_voxel[1] = {-0.75, 0, 0, 0};
  world_from_voxel[2] = {0, 0, 2, 0};
  world_from_voxel[3] = {10, -20, 30, 1};
  return Volume::of(kSize, VoxelType::int16, world_from_voxel, std::move(samples));
}

std::string mm(glm::dvec3 voxel) {
  const auto at = transform_point(test_volume().world_from_voxel(), voxel);
  return nlohmann::json({at.x, at.y, at.z}).dump();
}

struct Played {
  Run run;
  nlohmann::json stats;
  std::optional<Volume> volume;
};

Played play(const Folder& folder, const std::string& actions, std::vector<std::string> words = {},
            const std::map<std::string, std::string>& environment = {}) {
  EXPECT_TRUE(write_volume(folder / "in.nrrd", test_volume()).ok());
  write_file(folder / "scene.json",
             R"({"volume": {"file": "in.nrrd"}, "materials": {"table": [{"values": [0, 1000],
                 "compress": 0.5, "stretch": 1.5, "shear": 0.2}]}, "actions": [)" +
                 actions + "]}");
  words.insert(words.begin(), {"deform", folder("scene.json"), "-o", folder("out.nrrd"), "--extent",
                               "keep", "--stats", folder("stats.json")});
  Played played{run_maille(words, environment), {}, {}};
  if (played.run.exit_code != 0) return played;
  played.stats = nlohmann::json::parse(read_file(folder / "stats.json"));
  auto volume = read_volume(folder / "out.nrrd");
  EXPECT_TRUE(volume.ok());
  if (volume) played.volume = *std::move(volume);
  return played;
}

// Voxels that differ from the volume's, all of them background; -1 if another one does.
std::int64_t holes(const Volume& volume) {
  const auto before = test_volume();
  std::int64_t count = 0;
  for (int z = 0; z < kSize.z; ++z) {
    for (int y = 0; y < kSize.y; ++y) {
      for (int x = 0; x < kSize.x; ++x) {
        const double value = volume.value_at({x, y, z});
        if (value == before.value_at({x, y, z})) continue;
        if (value != 100.0) return -1;
        ++count;
      }
    }
  }
  return count;
}

bool left_out(const Played& played, const std::string& name) {
  const auto& names = played.stats["left_out"];
  return std::find(names.begin(), names.end(), name) != names.end();
}

const std::string kDrag =
    R"({"drag": {"from": {"voxel": [20, 18, 17]}, "radius_voxels": 2, "by_voxels": [3, -2, 2]}})";

TEST(CutActions, WhatIsCarvedIsBackgroundInTheSavedVolume) {
  const Folder folder;
  const auto played =
      play(folder, R"({"carve": {"center_voxel": [20, 18, 17], "radius_voxels": 5}})");
  ASSERT_EQ(played.run.exit_code, 0) << played.run.err;
  const auto carved = played.stats["cuts"]["elements_carved"].get<std::int64_t>();
  EXPECT_EQ(carved, 515);  // points of the integer grid in a ball of radius 5
  // One of 128 voxels has the background's value anyway.
  EXPECT_GT(holes(*played.volume), carved * 95 / 100);
  EXPECT_LE(holes(*played.volume), carved);
  EXPECT_TRUE(left_out(played, "cut") && left_out(played, "chainmail") && left_out(played, "undo"));
  EXPECT_FALSE(left_out(played, "carve"));
  EXPECT_FALSE(played.stats.contains("chainmail"));
}

TEST(CutActions, MillimetresAndVoxelsMeanTheSamePlace) {
  const Folder folder;
  const auto in_voxels =
      play(folder, R"({"carve": {"center_voxel": [9, 20, 11], "radius_voxels": 4}})");
  const auto in_mm =
      play(folder, R"({"carve": {"center_mm": )" + mm({9, 20, 11}) + R"(, "radius_voxels": 4}})");
  ASSERT_TRUE(in_voxels.volume && in_mm.volume);
  const auto a = in_voxels.volume->bytes();
  const auto b = in_mm.volume->bytes();
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size()), 0);
}

TEST(CutActions, RestoringBringsTheBitsBack) {
  const Folder folder;
  const auto played = play(folder, R"({"carve": {"center_voxel": [20, 18, 17], "radius_voxels": 5}},
                      {"restore": {"center_voxel": [20, 18, 17], "radius_voxels": 9}})");
  ASSERT_EQ(played.run.exit_code, 0) << played.run.err;
  EXPECT_EQ(played.stats["cuts"]["elements_carved"], 0);
  EXPECT_EQ(played.stats["cuts"]["links_removed"], 0);
  EXPECT_EQ(holes(*played.volume), 0);
}

// Every way to say where a cut goes takes the links that cross the plane between z = 16 and 17.
TEST(CutActions, PolygonsDiscsAndSweepsTakeTheLinksAcross) {
  const Folder folder;
  const auto corner = [](double x, double y) { return glm::dvec3(x, y, 16.5); };
  const auto text = [](glm::dvec3 v) { return nlohmann::json({v.x, v.y, v.z}).dump(); };
  const auto outline = [&](auto&& write) {
    return "[" + write(corner(-2, -2)) + "," + write(corner(50, -2)) + "," + write(corner(50, 50)) +
           "," + write(corner(-2, 50)) + "]";
  };
  const std::int64_t across = kSize.x * kSize.y;
  // The volume's y runs along the world's -x, 0.75 mm a voxel.
  const std::vector<std::string> cuts = {
      R"("polygon_voxel": )" + outline(text), R"("polygon_mm": )" + outline(mm),
      R"("disc": {"center_voxel": [20, 18, 16.5], "normal": [0, 0, 3], "radius_mm": 100})",
      R"("disc": {"center_mm": )" + mm({20, 18, 16.5}) +
          R"(, "normal": [0, 0, -1], "radius_mm": 100})",
      R"("sweep": {"path_voxel": [[-2, -2, 16.5], [50, -2, 16.5]], "direction": [-5, 0, 0],
                   "depth_mm": 60})"};
  for (const std::string& cut : cuts) {
    const auto played = play(folder, R"({"cut": {)" + cut + "}}");
    ASSERT_EQ(played.run.exit_code, 0) << played.run.err;
    EXPECT_EQ(played.stats["cuts"]["links_removed"], across) << cut;
    EXPECT_EQ(played.stats["cuts"]["elements_carved"], 0);
    EXPECT_EQ(holes(*played.volume), 0) << "a cut alone opens nothing";
    EXPECT_TRUE(left_out(played, "carve"));
    EXPECT_FALSE(left_out(played, "cut"));
  }
}

TEST(CutActions, TheNormalOfADiscIsInTheWorld) {
  const Folder folder;
  // The world's y is the volume's x.
  const auto played =
      play(folder, R"({"cut": {"disc": {"center_voxel": [20.5, 18, 17], "normal": [0, 1, 0],
                                   "radius_mm": 100}}})");
  ASSERT_EQ(played.run.exit_code, 0) << played.run.err;
  EXPECT_EQ(played.stats["cuts"]["links_removed"], kSize.y * kSize.z);
}

// Stiff material goes along with a handle as far as its links lead, and no further.
TEST(CutActions, TheSidesPartWhenDragged) {
  const Folder folder;
  const std::string cut =
      R"({"cut": {"disc": {"center_voxel": [20, 18, 16.5], "normal": [0, 0, 1],
                           "radius_mm": 100}}},)";
  const std::string pull =
      R"({"drag": {"from": {"voxel": [20, 18, 25]}, "radius_voxels": 2, "by_voxels": [0, 0, 6]}})";
  auto played = play(folder, cut + pull);
  ASSERT_EQ(played.run.exit_code, 0) << played.run.err;
  const auto before = test_volume();
  for (int y = 0; y < kSize.y; ++y) {
    for (int x = 0; x < kSize.x; ++x) {
      for (int z = 0; z <= 16; ++z) {
        ASSERT_EQ(played.volume->value_at({x, y, z}), before.value_at({x, y, z}));
      }
    }
  }
  // Between the sides there is nothing.
  EXPECT_EQ(played.volume->value_at({20, 18, 17}), 100.0);
  EXPECT_EQ(played.volume->value_at({20, 18, 18}), 100.0);
  EXPECT_EQ(played.stats["chainmail"]["violated_links"], 0);
  // Without the cut the other side comes along.
  played = play(folder, pull);
  ASSERT_EQ(played.run.exit_code, 0) << played.run.err;
  EXPECT_NE(played.volume->value_at({20, 18, 17}), 100.0);
}

TEST(CutActions, UndoAndRedoWalkOverThem) {
  const Folder folder;
  const std::string carve = R"({"carve": {"center_voxel": [20, 18, 17], "radius_voxels": 5}},)";
  const std::string cut =
      R"({"cut": {"disc": {"center_voxel": [8, 8, 8.5], "normal": [0, 0, 1], "radius_mm": 4}}},)";
  auto played = play(folder, carve + cut + R"({"undo": 2})");
  ASSERT_EQ(played.run.exit_code, 0) << played.run.err;
  EXPECT_EQ(played.stats["cuts"]["links_removed"], 0);
  EXPECT_EQ(holes(*played.volume), 0);
  EXPECT_EQ(played.stats["undo"]["redo_steps"], 2);
  EXPECT_FALSE(left_out(played, "undo"));
  played = play(folder, carve + cut + R"({"undo": 2}, {"redo": 1})");
  ASSERT_EQ(played.run.exit_code, 0) << played.run.err;
  EXPECT_EQ(played.stats["cuts"]["elements_carved"], 515);
  EXPECT_GT(holes(*played.volume), 0);
}

TEST(CutActions, WhatCannotBeDoneIsBadInputWithItsPath) {
  const Folder folder;
  const auto crossed =
      play(folder, R"({"cut": {"polygon_voxel": [[0,0,0], [10,10,0], [10,0,0], [0,10,0]]}})");
  EXPECT_EQ(crossed.run.exit_code, 3);
  EXPECT_NE(crossed.run.err.find("actions[0].cut: "), std::string::npos) << crossed.run.err;
  const auto carved =
      play(folder, R"({"carve": {"center_voxel": [20, 18, 17], "radius_voxels": 9}},)" + kDrag);
  EXPECT_EQ(carved.run.exit_code, 3);
  EXPECT_NE(carved.run.err.find("actions[1].drag: "), std::string::npos) << carved.run.err;
  EXPECT_NE(carved.run.err.find("carved away"), std::string::npos) << carved.run.err;
}

// What one of them moves takes some 600 KiB, and undo keeps three more.
const std::string kManyDrags =
    kDrag + "," + kDrag + "," + kDrag + "," + kDrag + R"(, {"undo": 3}, {"redo": 2})";
const char* const kLittle = "1600K";

TEST(MemoryBudgets, AScratchFileChangesNoBit) {
  const Folder folder;
  const std::string actions =
      kDrag + "," + kDrag +
      R"(,{"drag": {"from": {"voxel": [5, 30, 30]}, "by_voxels": [2, -2, -3]}},
      {"undo": 2}, {"redo": 1})";
  const auto free = play(folder, kManyDrags);
  const auto limited = play(folder, kManyDrags, {"--lattice-memory", kLittle});
  ASSERT_EQ(free.run.exit_code, 0) << free.run.err;
  ASSERT_EQ(limited.run.exit_code, 0) << limited.run.err;
  const auto a = free.volume->bytes();
  const auto b = limited.volume->bytes();
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size()), 0);
  const auto& memory = limited.stats["memory"];
  EXPECT_EQ(memory["lattice_budget_bytes"], 1600 << 10);
  EXPECT_LE(memory["lattice_peak_bytes"],
            (1600 << 10) + 65536 * free.stats["machine"]["threads"].get<int>());
  EXPECT_GT(memory["scratch_bytes_written"], 0);
  EXPECT_GT(memory["scratch_planes_written"], 0);
  EXPECT_GT(free.stats["memory"]["lattice_bytes_per_element"], 1.0);
  EXPECT_FALSE(free.stats["memory"].contains("lattice_budget_bytes"));
}

TEST(MemoryBudgets, WhatMovesAtOnceMustFit) {
  const Folder folder;
  const auto played = play(folder, kDrag, {"--lattice-memory", "100K"});
  EXPECT_EQ(played.run.exit_code, 5);
  EXPECT_NE(played.run.err.find("100 KiB (--lattice-memory)"), std::string::npos) << played.run.err;
}

TEST(MemoryBudgets, WithoutAFolderForTheScratchFileItIs6) {
  const Folder folder;
  const auto played =
      play(folder, kManyDrags, {"--lattice-memory", kLittle}, {{"TMPDIR", "/nowhere/at/all"}});
  EXPECT_EQ(played.run.exit_code, 6);
  EXPECT_NE(played.run.err.find("scratch file"), std::string::npos) << played.run.err;
}

TEST(MemoryBudgets, DroppedUndoStepsAreSaidOnce) {
  const Folder folder;
  const std::string drags = kDrag + "," + kDrag + "," + kDrag + "," + kDrag + ",";
  const auto some = play(folder, drags + R"({"undo": 1})", {"--undo-memory", "2M"});
  ASSERT_EQ(some.run.exit_code, 0) << some.run.err;
  EXPECT_GT(some.stats["undo"]["dropped_steps"], 0);
  EXPECT_LE(some.stats["undo"]["bytes"], 2 << 20);
  const std::string note = "the oldest undo steps are dropped to hold --undo-memory 2.0 MiB";
  const auto first = some.run.err.find(note);
  ASSERT_NE(first, std::string::npos) << some.run.err;
  EXPECT_EQ(some.run.err.find(note, first + 1), std::string::npos);
  const auto all = play(folder, drags + R"({"undo": 4})", {"--undo-memory", "2M"});
  EXPECT_EQ(all.run.exit_code, 3);
  EXPECT_NE(all.run.err.find("were dropped to hold --undo-memory"), std::string::npos)
      << all.run.err;
}

}  // namespace
}  // namespace maille::test
