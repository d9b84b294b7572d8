#include <cmath>
#include <cstring>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "material/material_table.h"
#include "tests/app/field_file.h"
#include "tests/app/program.h"
#include "volume/volume_file.h"

namespace maille::test {
namespace {

Volume load(const std::filesystem::path& path) {
  auto volume = read_volume(path);
  EXPECT_TRUE(volume.ok()) << volume.error().message;
  return *std::move(volume);
}

// A smooth float volume with a grid that is neither isotropic nor aligned with the world.
Volume smooth_volume(Size3 size) {
  std::vector<float> samples;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        samples.push_back(static_cast<float>(100 + 20 * std::sin(0.21 * x) * std::cos(0.17 * y) +
                                             10 * std::sin(0.13 * z + 0.1 * x)));
      }
    }
  }
  glm::dmat4 world_from_voxel(1.0);
  world_from_voxel[0] = {0, 1.5, 0, 0};
  world_from_voxel[1] = {-0.75, 0, 0, 0};
  world_from_voxel[2] = {0, 0, 2, 0};
  world_from_voxel[3] = {10, -20, 30, 1};
  return Volume::of(size, VoxelType::float32, world_from_voxel, std::move(samples));
}

double trilinear(const Volume& volume, glm::dvec3 p) {
  const auto at = glm::clamp(p, glm::dvec3(0.0), glm::dvec3(volume.size() - 1));
  const auto low = glm::min(glm::ivec3(glm::floor(at)), volume.size() - 2);
  const auto f = at - glm::dvec3(low);
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 o(corner & 1, (corner >> 1) & 1, corner >> 2);
    const auto w = glm::dvec3(o) * f + (1.0 - glm::dvec3(o)) * (1.0 - f);
    sum += w.x * w.y * w.z * volume.value_at(low + o);
  }
  return sum;
}

TEST(DeformCommand, WithoutActionsTheVolumeComesBackBitForBit) {
  const Folder folder;
  ASSERT_EQ(
      run_maille({"phantom", "head", "--size", "33x40x35", "-o", folder("in.nrrd")}).exit_code, 0);
  const auto run = run_maille({"deform", folder("in.nrrd"), "-o", folder("out.mha"), "--field",
                               folder("field.nrrd"), "--forward-field", folder("forward.nrrd"),
                               "--stats", folder("stats.json")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out + run.err, "");
  const auto in = load(folder / "in.nrrd");
  const auto out = load(folder / "out.mha");
  EXPECT_EQ(in.size(), out.size());
  ASSERT_EQ(in.bytes().size(), out.bytes().size());
  EXPECT_EQ(std::memcmp(in.bytes().data(), out.bytes().data(), in.bytes().size()), 0);
  for (const auto* const name : {"field.nrrd", "forward.nrrd"}) {
    const auto field = read_field(folder / name);
    ASSERT_EQ(field.size(), 33u * 40u * 35u);
    for (const auto& v : field) ASSERT_EQ(v, glm::vec3(0.0f));
  }
  const auto stats = nlohmann::json::parse(read_file(folder / "stats.json"));
  EXPECT_FALSE(stats.contains("chainmail") || stats.contains("device") ||
               stats.contains("resample"));
  EXPECT_GT(stats["machine"]["triad_gb_per_s"], 0.0);
}

TEST(DeformCommand, RigidMaterialMovesWholeByVoxelsOrMillimetres) {
  const Folder folder;
  const Size3 size{36, 34, 33};
  ASSERT_TRUE(write_volume(folder / "in.nrrd", smooth_volume(size)).ok());
  // (2, -1, 3) voxels are (0.75, 3, 6) mm with these axes.
  for (const auto* const by :
       {R"("by_voxels": [2, -1, 3])", R"("by_mm": [0.75, 3, 6], "steps": 3)"}) {
    write_file(folder / "scene.json", std::string(R"({"volume": {"file": "in.nrrd"},
        "materials": {"table": [{"values": [0, 1000], "compress": 1, "stretch": 1, "shear": 0}]},
        "actions": [{"drag": {"from": {"voxel": [18, 17, 16]}, "radius_voxels": 2, )") +
                                          by + "}}]}");
    const auto run =
        run_maille({"deform", folder("scene.json"), "-o", folder("out.nrrd"), "--extent", "keep",
                    "--forward-field", folder("forward.nrrd"), "--stats", folder("stats.json")});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto in = load(folder / "in.nrrd");
    const auto out = load(folder / "out.nrrd");
    for (int z = 3; z < size.z; ++z) {
      for (int y = 0; y < size.y - 1; ++y) {
        for (int x = 2; x < size.x; ++x) {
          ASSERT_EQ(out.value_at({x, y, z}), in.value_at({x - 2, y + 1, z - 3}))
              << x << " " << y << " " << z;
        }
      }
    }
    for (const auto& v : read_field(folder / "forward.nrrd")) {
      ASSERT_LT(glm::distance(v, glm::vec3(0.75f, 3.0f, 6.0f)), 1e-5f);
    }
    const auto stats = nlohmann::json::parse(read_file(folder / "stats.json"));
    EXPECT_EQ(stats["chainmail"]["violated_links"], 0);
    EXPECT_EQ(stats["resample"]["folded_cells"], 0);
    EXPECT_EQ(stats["volume_kept"]["ratio"], 1.0);
    EXPECT_EQ(stats["resample"]["unfilled_voxels"], 0);
    EXPECT_GE(stats["memory"]["stroke_bytes_peak"], stats["memory"]["lattice_bytes"]);
    EXPECT_GT(stats["memory"]["stroke_bytes_per_element"], 0.0);
    EXPECT_FALSE(stats.contains("relaxation"));
  }
}

const char* const kElastic = R"({"volume": {"file": "in.nrrd"},
    "materials": {"table": [{"values": [0, 1000], "compress": 0.7, "stretch": 1.4, "shear": 0.3}]},
    "actions": [
      {"drag": {"from": {"voxel": [20, 20, 20]}, "radius_voxels": 3, "by_voxels": [5, -4, 3],
                "steps": 4, "name": "a"}},
      {"relax": {"until_voxels": 0.3, "at_most_seconds": 2}},
      {"drag": {"from": {"voxel": [30, 12, 25]}, "radius_voxels": 2, "by_mm": [1, 4, 2]}},
      {"save": {"volume": "saved.nrrd", "field": "saved_field.nrrd"}}]})";

// Follows the saved field from each voxel of the output and samples the input there.
TEST(DeformCommand, TheSavedFieldLeadsBackToTheInput) {
  const Folder folder;
  const Size3 size{44, 40, 38};
  ASSERT_TRUE(write_volume(folder / "in.nrrd", smooth_volume(size)).ok());
  write_file(folder / "scene.json", kElastic);
  const auto run = run_maille({"deform", folder("scene.json"), "-o", folder("out.nrrd"), "--field",
                               folder("field.nrrd"), "--deterministic"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(read_file(folder / "out.nrrd"), read_file(folder / "saved.nrrd"));
  EXPECT_EQ(read_file(folder / "field.nrrd"), read_file(folder / "saved_field.nrrd"));
  const auto in = load(folder / "in.nrrd");
  const auto out = load(folder / "out.nrrd");
  const auto field = read_field(folder / "field.nrrd");
  ASSERT_EQ(field.size(), static_cast<std::size_t>(voxel_count(size)));
  const auto voxel_from_world = glm::inverse(in.world_from_voxel());
  double worst = 0.0;
  std::int64_t moved = 0;
  for (int z = 2; z < size.z - 2; ++z) {
    for (int y = 2; y < size.y - 2; ++y) {
      for (int x = 2; x < size.x - 2; ++x) {
        const VoxelIndex voxel{x, y, z};
        const auto v = field[static_cast<std::size_t>(linear_index(voxel, size))];
        const auto out_mm = transform_point(out.world_from_voxel(), glm::dvec3(voxel));
        const auto from = transform_point(voxel_from_world, out_mm + glm::dvec3(v));
        const double sampled = trilinear(in, from);
        worst = std::max(worst, std::abs(sampled - out.value_at(voxel)));
        moved += glm::length(v) > 0.1f ? 1 : 0;
      }
    }
  }
  EXPECT_GT(moved, 1000);
  EXPECT_LT(worst, 0.02);  // of values in 70..130: what floats in the field leave
}

TEST(DeformCommand, DeterministicModeGivesTheSameBitsForAnyNumberOfThreads) {
  const Folder folder;
  ASSERT_TRUE(write_volume(folder / "in.nrrd", smooth_volume({70, 40, 38})).ok());
  write_file(folder / "scene.json", kElastic);
  std::string first;
  std::string first_field;
  for (const auto* const threads : {"1", "2"}) {
    const auto run =
        run_maille({"deform", folder("scene.json"), "-o", folder("out.nrrd"), "--field",
                    folder("field.nrrd"), "--deterministic", "--threads", threads});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto volume = read_file(folder / "out.nrrd");
    const auto field = read_file(folder / "field.nrrd");
    if (first.empty()) {
      first = volume;
      first_field = field;
      EXPECT_FALSE(first.empty());
    }
    EXPECT_EQ(volume, first);
    EXPECT_EQ(field, first_field);
  }
}

TEST(DeformCommand, UndoAndRedoAndReleaseAreActions) {
  const Folder folder;
  ASSERT_TRUE(write_volume(folder / "in.nrrd", smooth_volume({34, 33, 32})).ok());
  const std::string drag =
      R"({"drag": {"from": {"voxel": [16, 16, 16]}, "by_voxels": [4, 0, 0], "name": "a"}})";
  const auto deformed = [&](const std::string& actions) {
    write_file(folder / "scene.json",
               R"({"volume": {"file": "in.nrrd"}, "actions": [)" + actions + "]}");
    const auto run = run_maille({"deform", folder("scene.json"), "-o", folder("out.nrrd")});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return read_file(folder / "out.nrrd");
  };
  const auto dragged = deformed(drag);
  const auto untouched = deformed("");
  EXPECT_NE(dragged, untouched);
  EXPECT_EQ(deformed(drag + R"(, {"undo": 1})"), untouched);
  EXPECT_EQ(deformed(drag + R"(, {"undo": 1}, {"redo": 1})"), dragged);
  EXPECT_EQ(deformed(drag + R"(, {"release": {"name": "a"}})"), dragged);

  // A relaxation that finds nothing to do is no step and leaves what was undone to redo.
  EXPECT_EQ(deformed(drag + R"(, {"undo": 1}, {"relax": {}}, {"redo": 1})"), dragged);
  EXPECT_NE(deformed(drag + R"(, {"relax": {}})"), dragged);
  EXPECT_EQ(deformed(drag + R"(, {"relax": {}}, {"undo": 1})"), dragged);

  write_file(folder / "scene.json", R"({"volume": {"file": "in.nrrd"}, "actions": [)" + drag +
                                        R"(, {"release": {"name": "b"}}]})");
  const auto run = run_maille({"deform", folder("scene.json"), "-o", folder("out.nrrd")});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("actions[1].release: "), std::string::npos) << run.err;
}

TEST(DeformCommand, StatisticsTellCopiesFromResampledBricks) {
  const Folder folder;
  ASSERT_TRUE(write_volume(folder / "in.nrrd", smooth_volume({160, 40, 38})).ok());
  write_file(folder / "scene.json", R"({"volume": {"file": "in.nrrd"},
      "materials": {"table": [{"values": [0, 1000], "shear": 0.5}]},
      "actions": [{"drag": {"from": {"voxel": [10, 10, 10]}, "by_voxels": [0, 2, 0]}},
                  {"relax": {"at_most_seconds": 0}}]})");
  const auto run = run_maille(
      {"deform", folder("scene.json"), "-o", folder("out.nrrd"), "--stats", folder("stats.json")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto stats = nlohmann::json::parse(read_file(folder / "stats.json"));
  const auto& resample = stats["resample"];
  EXPECT_EQ(resample["voxels"].get<int>() + resample["copied_voxels"].get<int>(), 160 * 40 * 38);
  EXPECT_GE(resample["voxels"], resample["moved_voxels"]);
  EXPECT_GT(resample["moved_voxels"], 0);
  EXPECT_GE(resample["copied_voxels"], 32 * 40 * 38);
  EXPECT_GT(resample["copy_seconds"], 0.0);
  EXPECT_EQ(stats["relaxation"]["iterations"], 0);
  EXPECT_EQ(stats["relaxation"]["converged"], false);
  EXPECT_GT(stats["relaxation"]["free_elements"], 0);
  EXPECT_FALSE(stats["relaxation"].contains("stiffness_clamped"));
}

// Between drag and save, on the volume of smooth_volume({40, 40, 40}).
nlohmann::json relaxed(const Folder& folder, const std::string& table, const std::string& actions,
                       std::vector<std::string> words = {}, std::string* said = nullptr) {
  EXPECT_TRUE(write_volume(folder / "in.nrrd", smooth_volume({40, 40, 40})).ok());
  write_file(folder / "scene.json",
             R"({"volume": {"file": "in.nrrd"}, "materials": {"table": [)" + table +
                 R"(]}, "actions": [{"drag": {"from": {"voxel": [20, 20, 20]}, "radius_voxels": 3,
                    "by_voxels": [3, 1, 0], "name": "a"}}, )" +
                 actions + "]}");
  words.insert(words.begin(), {"deform", folder("scene.json"), "-o", folder("out.nrrd"), "--stats",
                               folder("stats.json"), "--deterministic"});
  const auto run = run_maille(words);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  if (said) *said = run.err;
  return nlohmann::json::parse(read_file(folder / "stats.json"))["relaxation"];
}

const char* const kSoft = R"({"values": [0, 1000], "compress": 0.6, "stretch": 1.5, "shear": 0.2})";

TEST(DeformCommand, ARelaxationConvergesAndSaysHowNear) {
  const Folder folder;
  std::string said;
  const auto stats = relaxed(folder, kSoft, R"({"relax": {"until_voxels": 0.01}})", {}, &said);
  EXPECT_EQ(stats["converged"], true);
  EXPECT_LE(stats["residual_voxels"], 0.01);
  EXPECT_GT(stats["residual_voxels"], 0.0);
  EXPECT_LT(stats["residual_rms_voxels"], stats["residual_voxels"]);
  EXPECT_GT(stats["iterations"], 0);
  EXPECT_LT(stats["energy_last"], stats["energy_first"]);
  EXPECT_EQ(stats["energy_ever_rose"], false);
  EXPECT_EQ(stats["region_limited"], false);
  EXPECT_EQ(said.find("lattice-memory"), std::string::npos) << said;
}

TEST(DeformCommand, AnEquilibriumIsNotLookedForTwiceButAFinerOneIs) {
  const Folder folder;
  const std::string rough = R"({"relax": {"until_voxels": 0.1}})";
  const std::string fine = R"({"relax": {"until_voxels": 0.005}})";
  const auto once = relaxed(folder, kSoft, rough);
  const auto twice = relaxed(folder, kSoft, rough + "," + rough);
  EXPECT_EQ(twice["iterations"], once["iterations"]);
  const auto finer = relaxed(folder, kSoft, rough + "," + fine + "," + rough);
  EXPECT_GT(finer["iterations"], once["iterations"]);
  EXPECT_EQ(finer["converged"], true);
  // What was let go is no equilibrium any more.
  const auto released = relaxed(folder, kSoft, rough + R"(,{"release": {"name": "a"}},)" + rough);
  EXPECT_GT(released["iterations"], once["iterations"]);
  EXPECT_EQ(released["converged"], true);
}

// Released and relaxed in one go or after a relaxation before; what is undone is as it was.
TEST(DeformCommand, ClayKeepsAPartOfADrag) {
  const Folder folder;
  const std::string relax = R"({"relax": {"until_voxels": 0.01}})";
  const std::string release = R"({"release": {"name": "a"}})";
  const auto deformed = [&](const std::string& table, const std::string& actions) {
    EXPECT_EQ(relaxed(folder, table, actions)["converged"], true);
    return read_file(folder / "out.nrrd");
  };
  std::string clay = kSoft;
  clay.insert(1, R"("yield_strain": 0.05, )");
  const auto held = deformed(clay, relax);
  EXPECT_EQ(held, deformed(kSoft, relax));  // nothing flows before it is released
  const auto kept = deformed(clay, relax + "," + release + "," + relax);
  EXPECT_NE(kept, held);
  EXPECT_NE(kept, deformed(kSoft, relax + "," + release + "," + relax));
  EXPECT_EQ(kept, deformed(clay, relax + "," + release + "," + relax + "," + relax));
  EXPECT_EQ(held, deformed(clay, relax + "," + release + "," + relax + R"(, {"undo": 2})"));
  EXPECT_EQ(kept,
            deformed(clay, relax + "," + release + "," + relax + R"(, {"undo": 2}, {"redo": 2})"));
}

TEST(DeformCommand, ARelaxationThatMemoryLimitsSaysSo) {
  const Folder folder;
  std::string said;
  const auto stats = relaxed(folder, kSoft, R"({"relax": {}}, {"relax": {}})",
                             {"--lattice-memory", "1600K"}, &said);
  EXPECT_EQ(stats["region_limited"], true);
  EXPECT_GT(stats["free_elements"], 0);
  EXPECT_LT(stats["free_elements"], 38 * 38 * 38);
  const std::string note = "maille: note: relaxation moves " +
                           std::to_string(stats["free_elements"].get<int>()) + " of 64000 elements";
  const auto first = said.find(note);
  ASSERT_NE(first, std::string::npos) << said;
  EXPECT_NE(said.find("--lattice-memory 1.6 MiB", first), std::string::npos) << said;
  EXPECT_EQ(said.find("note: relaxation moves", first + note.size()), std::string::npos) << said;
}

TEST(DeformCommand, StiffnessThatSpringsDoNotTakeAsItStandsIsNamed) {
  const Folder folder;
  std::string said;
  const auto stats = relaxed(folder,
                             R"({"values": [0, 500], "compress": 0.6, "stretch": 1.5, "shear": 0.2},
         {"values": [500, 1000], "name": "steel", "compress": 0.9, "stretch": 1.1, "shear": 0.1,
          "stiffness": 1e7})",
                             R"({"relax": {}})", {}, &said);
  ASSERT_TRUE(stats.contains("stiffness_clamped"));
  EXPECT_NE(stats["stiffness_clamped"].get<std::string>().find("steel"), std::string::npos);
  EXPECT_NE(said.find(stats["stiffness_clamped"].get<std::string>()), std::string::npos) << said;
}

TEST(DeformCommand, ATraceIsWritten) {
  const Folder folder;
  ASSERT_TRUE(write_volume(folder / "in.nrrd", smooth_volume({34, 33, 32})).ok());
  write_file(folder / "scene.json", kElastic);
  const auto run = run_maille(
      {"deform", folder("scene.json"), "-o", folder("out.nrrd"), "--trace", folder("trace.json")});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto text = read_file(folder / "trace.json");
  ASSERT_TRUE(nlohmann::json::accept(text));
  for (const auto* const span : {"load", "chainmail", "relaxation", "resample volume"}) {
    EXPECT_NE(text.find(span), std::string::npos) << span;
  }
  // One for each position of the two drags and one for each volume saved: none within another.
  const auto trace = nlohmann::json::parse(text);
  std::map<std::string, int> spans;
  for (const auto& event : trace.is_array() ? trace : trace["traceEvents"]) {
    ++spans[event["name"].get<std::string>()];
  }
  EXPECT_EQ(spans["chainmail"], 5);
  EXPECT_EQ(spans["resample volume"], 2);
}

TEST(DeformCommand, APresetsWarningsAreForWhoWantsToKnow) {
  const Folder folder;
  write_file(folder / "scene.json", R"({"volume": {"phantom": "head", "size": [24, 24, 24]},
      "materials": {"preset": "ct"},
      "actions": [{"drag": {"from": {"voxel": [12, 4, 12]}, "by_voxels": [0, -1, 0]}}]})");
  const auto words =
      std::vector<std::string>{"deform", folder("scene.json"), "-o", folder("out.nrrd")};
  auto verbose = words;
  verbose.emplace_back("--verbose");
  const auto warnings = MaterialTable::ct().warnings();
  ASSERT_FALSE(warnings.empty());
  const auto plain_run = run_maille(words);
  const auto verbose_run = run_maille(verbose);
  for (const auto& warning : warnings) {
    EXPECT_EQ(plain_run.err.find(warning), std::string::npos);
    EXPECT_NE(verbose_run.err.find(warning), std::string::npos) << verbose_run.err;
  }
  // The preset's bone is fixed.
  EXPECT_EQ(verbose_run.err.find("anchors"), std::string::npos) << verbose_run.err;
}

}  // namespace
}  // namespace maille::test
