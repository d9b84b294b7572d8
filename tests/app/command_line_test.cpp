#include <algorithm>

#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/sha256.h"
#include "tests/app/program.h"
#include "volume/phantom.h"
#include "volume/volume_file.h"

namespace maille::test {
namespace {

void expect_refused(const std::vector<std::string>& words, int exit_code) {
  const auto run = run_maille(words);
  std::string line;
  for (const auto& word : words) line += word + " ";
  EXPECT_EQ(run.exit_code, exit_code) << line << run.err;
  EXPECT_EQ(run.err.rfind("maille: error: ", 0), 0u) << line << run.err;
  EXPECT_EQ(run.out, "") << line;
}

TEST(CommandLine, EveryCommandHasHelp) {
  const auto all = run_maille({"--help"});
  EXPECT_EQ(all.exit_code, 0);
  for (const auto* const word :
       {"render", "deform", "pick", "info", "phantom", "demo", "measure", "--version",
        "--list-devices", "--device", "--threads", "--seed", "--deterministic", "--quiet",
        "--verbose", "--volume-store", "--lattice-memory", "--undo-memory"}) {
    EXPECT_NE(all.out.find(word), std::string::npos) << word;
  }
  for (const auto* const command : {"render", "deform", "pick", "info", "phantom", "demo"}) {
    const auto run = run_maille({command, "--help"});
    EXPECT_EQ(run.exit_code, 0) << command;
    EXPECT_NE(run.out.find("Usage: maille " + std::string(command)), std::string::npos) << run.out;
    for (const auto* const option :
         {"--device", "--volume-store", "--threads", "--deterministic"}) {
      EXPECT_NE(run.out.find(option), std::string::npos) << command << " " << option;
    }
    EXPECT_EQ(run.err, "");
  }
}

TEST(CommandLine, MeasureHasHelpForEachPage) {
  for (const std::vector<std::string>& words : {std::vector<std::string>{"measure"},
                                                {"measure", "speed"},
                                                {"measure", "error"},
                                                {"measure", "frame"},
                                                {"measure", "stability"}}) {
    auto with_help = words;
    with_help.push_back("--help");
    const auto run = run_maille(with_help);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_NE(run.out.find("Usage: maille measure"), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("--threads"), std::string::npos) << run.out;
  }
}

TEST(CommandLine, MeasureRefusesBeforeItWorks) {
  const Folder folder;
  const auto out = folder("pages");
  expect_refused({"measure"}, 2);
  expect_refused({"measure", "table1", "-o", out}, 2);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"measure"}, {"measure", "table1", "-o", out}}) {
    EXPECT_NE(run_maille(words).err.find("measure: expected one of speed, error, frame, stability"),
              std::string::npos);
  }
  expect_refused({"measure", "speed"}, 2);
  expect_refused({"measure", "error", "-o", out}, 2);
  expect_refused({"measure", "error", "--stage", "-o", out}, 2);
  expect_refused({"measure", "error", "--stage", "render", "-o", out}, 2);
  expect_refused({"measure", "error", "--stage", "chainmail", "--elements", "5000", "-o", out}, 2);
  expect_refused({"measure", "error", "--stage", "chainmail", "--head", "h.nrrd", "-o", out}, 2);
  expect_refused({"measure", "error", "--stage", "relaxation", "--elements", "10", "-o", out}, 2);
  expect_refused({"measure", "error", "--stage", "resample", "--elements", "5000", "-o", out}, 2);
  expect_refused({"measure", "error", "--stage", "resample", "--edge", "16", "-o", out}, 2);
  expect_refused({"measure", "error", "--stage", "relaxation", "--edge", "64", "-o", out}, 2);
  EXPECT_NE(run_maille({"measure", "error", "--stage", "render", "-o", out})
                .err.find("chainmail, relaxation or resample"),
            std::string::npos);
  expect_refused({"measure", "speed", "-o", out, "more"}, 2);
  expect_refused({"measure", "stability"}, 2);
  expect_refused({"measure", "stability", "-o", out, "--groups", "none_such"}, 2);
  EXPECT_NE(run_maille({"measure", "stability", "-o", out, "--groups", "x"}).err.find("coincident"),
            std::string::npos);
  expect_refused({"measure", "stability", "-o", out, "--edge", "3"}, 2);
  EXPECT_FALSE(std::filesystem::exists(out));
  write_file(folder / "file", "x");
  for (const auto* const place : {"file", "file/below"}) {
    expect_refused({"measure", "speed", "-o", folder(place)}, 6);
    expect_refused({"measure", "error", "--stage", "chainmail", "-o", folder(place)}, 6);
    expect_refused({"measure", "stability", "-o", folder(place)}, 6);
  }
}

TEST(CommandLine, WrongUsageIs2) {
  expect_refused({"--no-such-option"}, 2);
  expect_refused({"render"}, 2);
  expect_refused({"render", "x.nrrd"}, 2);
  expect_refused({"render", "x.nrrd", "-o", "x.png", "--size", "512"}, 2);
  expect_refused({"render", "x.nrrd", "-o", "x.png", "--size", "0x5"}, 2);
  expect_refused({"render", "x.nrrd", "-o", "x.png", "--size", "5x5x5"}, 2);
  expect_refused({"render", "x.nrrd", "-o", "x.png", "--threads", "0"}, 2);
  expect_refused({"render", "x.nrrd", "-o", "x.png", "--volume-store", "tape"}, 2);
  expect_refused({"deform", "x.nrrd", "-o", "y.nrrd", "--lattice-memory", "0"}, 2);
  expect_refused({"deform", "x.nrrd", "-o", "y.nrrd", "--undo-memory", "lots"}, 2);
  expect_refused({"info", "x.nrrd", "y.nrrd"}, 2);
  expect_refused({"info", "x.nrrd", "--frobnicate"}, 2);
  expect_refused({"pick", "x.nrrd", "1"}, 2);
  expect_refused({"pick", "x.nrrd", "600", "1"}, 2);
  expect_refused({"pick", "x.nrrd", "1", "a"}, 2);
  expect_refused({"phantom", "unicorn", "--size", "8x8x8", "-o", "x.nrrd"}, 2);
  expect_refused({"phantom", "head", "--size", "8x8", "-o", "x.nrrd"}, 2);
  expect_refused({"phantom", "head", "-o", "x.nrrd"}, 2);
  for (const auto* const seed : {"-1", "1.5", "", "99999999999999999999"}) {
    expect_refused({"info", "x.nrrd", "--seed", seed}, 2);
  }
  expect_refused({"--list-devices", "render", "x.nrrd", "-o", "x.png"}, 2);
  expect_refused({"--list-devices", "x.nrrd"}, 2);
}

TEST(CommandLine, AWordThatIsNeitherCommandNorFileIs2) {
  expect_refused({"rendr"}, 2);
  EXPECT_NE(run_maille({"rendr"}).err.find("unknown command or missing file: rendr"),
            std::string::npos);
  const Folder folder;
  expect_refused({folder("missing.nrrd")}, 6);
  expect_refused({folder("missing.json")}, 6);
  expect_refused({folder.path().string()}, 6);
  write_file(folder / "scene.json", R"({"volume": {"file": "missing.nrrd"}})");
  expect_refused({folder("scene.json")}, 6);
}

TEST(CommandLine, TheWindowSaysThatItPlaysNoActions) {
  const Folder folder;
  write_file(folder / "volume.nrrd", "this is no volume\n");
  write_file(folder / "scene.json", R"({"volume": {"file": "volume.nrrd"},
      "actions": [{"drag": {"from": {"voxel": [1, 1, 1]}, "by_voxels": [1, 0, 0]}}]})");
  const auto run = run_maille({folder("scene.json")});
  EXPECT_NE(run.exit_code, 0);
  EXPECT_EQ(run.err.rfind("maille: note: the window opens the scene and leaves its actions", 0), 0u)
      << run.err;
  const auto quiet = run_maille({folder("scene.json"), "--quiet"});
  EXPECT_EQ(quiet.err.rfind("maille: error: ", 0), 0u) << quiet.err;
}

TEST(CommandLine, OutputsAreLookedAtBeforeAnyWork) {
  const Folder folder;
  // The input is never reached.
  const auto in = folder("missing.nrrd");
  expect_refused({"render", in, "-o", folder("x.jpg")}, 2);
  expect_refused({"render", in, "-o", folder("x")}, 2);
  expect_refused({"deform", in, "-o", folder("x.nhdr")}, 2);
  expect_refused({"deform", in, "-o", folder("x.mha"), "--field", folder("f.txt")}, 2);
  expect_refused({"deform", in, "-o", folder("x.mha"), "--forward-field", folder("f")}, 2);
  expect_refused({"phantom", "head", "--size", "8x8x8", "-o", folder("x.png")}, 2);
  const auto place = folder("no/such/file");
  write_file(folder / "file", "");
  for (const auto& [option, path] : std::vector<std::pair<std::string, std::string>>{
           {"--stats", place}, {"--trace", place}, {"--stats", folder.path().string()}}) {
    const auto run = run_maille({"deform", in, "-o", folder("x.mha"), option, path});
    EXPECT_EQ(run.exit_code, 6);
    EXPECT_NE(run.err.find(option + ": "), std::string::npos) << run.err;
  }
  const auto frames =
      run_maille({"render", in, "-o", folder("x.png"), "--frames", folder("file/below")});
  EXPECT_EQ(frames.exit_code, 6);
  EXPECT_NE(frames.err.find("--frames: "), std::string::npos) << frames.err;
  // Of a scene's actions too, before its volume is looked for.
  for (const auto* const action :
       {R"("save": {"volume": "no/x.nrrd"})", R"("save": {"field": "no/x.nrrd"})"}) {
    write_file(folder / "scene.json", R"({"volume": {"file": "missing.nrrd"}, "actions": [{)" +
                                          std::string(action) + "}]}");
    const auto run = run_maille({"deform", folder("scene.json"), "-o", folder("x.nrrd")});
    EXPECT_EQ(run.exit_code, 6);
    EXPECT_NE(run.err.find("scene.json: actions[0].save."), std::string::npos) << run.err;
  }
}

TEST(CommandLine, BadInputIs3) {
  const Folder folder;
  write_file(folder / "text.nrrd", "this is no volume\n");
  write_file(folder / "empty.mha", "");
  write_file(folder / "syntax.json", "{\"volume\": ");
  write_file(folder / "key.json", R"({"volume": {"phantom": "head"}, "colour": 1})");
  write_file(folder / "phantom.json", R"({"volume": {"phantom": "unicorn"}})");
  write_file(folder / "outside.json", R"({"volume": {"phantom": "head", "size": [16, 16, 16]},
      "actions": [{"drag": {"from": {"voxel": [16, 2, 3]}, "by_voxels": [1, 0, 0]}}]})");
  write_file(folder / "pixel.json", R"({"volume": {"phantom": "head", "size": [16, 16, 16]},
      "actions": [{"drag": {"from": {"pixel": [1, 2]}, "by_voxels": [1, 0, 0]}}]})");
  write_file(folder / "undo.json",
             R"({"volume": {"phantom": "head", "size": [16, 16, 16]}, "actions": [{"undo": 1}]})");
  expect_refused({"info", folder("text.nrrd")}, 3);
  expect_refused({"info", folder("empty.mha")}, 3);
  for (const auto* const name :
       {"syntax.json", "key.json", "phantom.json", "outside.json", "pixel.json", "undo.json"}) {
    expect_refused({"deform", folder(name), "-o", folder("out.nrrd")}, 3);
    EXPECT_FALSE(std::filesystem::exists(folder / "out.nrrd")) << name;
  }
  const auto run = run_maille({"deform", folder("outside.json"), "-o", folder("out.nrrd")});
  EXPECT_NE(run.err.find("outside.json: actions[0].drag.from.voxel: expected a voxel inside the "
                         "volume of 16x16x16"),
            std::string::npos)
      << run.err;
}

TEST(CommandLine, NoUsableDeviceIs4) {
  const Folder folder;
  write_file(folder / "s.json", R"({"volume": {"phantom": "hydrogen", "size": [16, 16, 16]}})");
  expect_refused({"render", folder("s.json"), "-o", folder("x.png"), "--device", "nonexistent"}, 4);
}

TEST(CommandLine, FileSystemTroubleIs6) {
  const Folder folder;
  expect_refused({"info", folder("missing.nrrd")}, 6);
  expect_refused({"info", folder.path().string()}, 6);
  expect_refused({"deform", folder("missing.json"), "-o", folder("x.nrrd")}, 6);
  expect_refused({"phantom", "head", "--size", "8x8x8", "-o", folder("no/such/folder/x.nrrd")}, 6);
  write_file(folder / "file", "");
  expect_refused({"demo", "-o", folder("file/below")}, 6);
}

TEST(CommandLine, InfoTellsWhatAPhantomHolds) {
  const Folder folder;
  const auto made = run_maille(
      {"phantom", "head", "--size", "20x24x28", "--seed", "5", "-o", folder("head.nrrd")});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(made.out + made.err, "");
  const auto run = run_maille({"info", folder("head.nrrd"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto info = nlohmann::json::parse(run.out);
  const auto volume = make_phantom("head", {20, 24, 28}, 5);
  ASSERT_TRUE(volume.ok());
  EXPECT_EQ(info["size"], nlohmann::json({20, 24, 28}));
  EXPECT_EQ(info["type"], "int16");
  EXPECT_EQ(info["voxel_sha256"], sha256_hex(volume.value().bytes()));
  EXPECT_EQ(info["nan_count"], 0);
  EXPECT_EQ(info["direction"], nlohmann::json({{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}));
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    EXPECT_NEAR(info["spacing_mm"][i].get<double>(), volume.value().spacing_mm()[axis], 1e-9);
    EXPECT_NEAR(info["origin_mm"][i].get<double>(), volume.value().world_from_voxel()[3][axis],
                1e-9);
  }
  std::int64_t counted = 0;
  for (const auto& bin : info["histogram"]) counted += bin.get<std::int64_t>();
  EXPECT_EQ(counted, 20 * 24 * 28);
  const auto samples = volume.value().voxels<std::int16_t>();
  EXPECT_EQ(info["range"][0], *std::min_element(samples.begin(), samples.end()));
  EXPECT_EQ(info["range"][1], *std::max_element(samples.begin(), samples.end()));

  const auto text = run_maille({"info", folder("head.nrrd")});
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_NE(text.out.find("20 24 28 voxels"), std::string::npos) << text.out;
}

TEST(CommandLine, TheColumnsOfDirectionAreTheAxes) {
  const Folder folder;
  // x of the volume runs along world y, y along world -x.
  glm::dmat4 world_from_voxel(1.0);
  world_from_voxel[0] = {0, 2, 0, 0};
  world_from_voxel[1] = {-3, 0, 0, 0};
  world_from_voxel[2] = {0, 0, 4, 0};
  world_from_voxel[3] = {5, 6, 7, 1};
  const auto volume = Volume::of<std::uint8_t>({2, 2, 2}, VoxelType::uint8, world_from_voxel,
                                               {0, 1, 2, 3, 4, 5, 6, 7});
  ASSERT_TRUE(write_volume(folder / "turned.nrrd", volume).ok());
  const auto run = run_maille({"info", folder("turned.nrrd"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto info = nlohmann::json::parse(run.out);
  EXPECT_EQ(info["direction"],
            nlohmann::json({{0.0, -1.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 0.0, 1.0}}));
  EXPECT_EQ(info["spacing_mm"], nlohmann::json({2.0, 3.0, 4.0}));
  EXPECT_EQ(info["origin_mm"], nlohmann::json({5.0, 6.0, 7.0}));
}

TEST(Sha256, KnowsThePublishedAnswers) {
  EXPECT_EQ(sha256_hex({}), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  const std::string abc = "abc";
  EXPECT_EQ(sha256_hex(std::as_bytes(std::span(abc))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace maille::test
