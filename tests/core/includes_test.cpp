// Holds the source to the house's drawing: which room may include which.
#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/core/scratch.h"

namespace maille {
namespace {

using Rooms = std::set<std::string>;

// What each room may include besides itself: the closure of the drawing's arrows.
const std::map<std::string, Rooms>& allowed() {
  static const std::map<std::string, Rooms> rooms = {
      {"core", {}},
      {"volume", {"core"}},
      {"material", {"core", "volume"}},
      {"deform", {"core", "volume", "material"}},
      {"resample", {"core", "volume", "material", "deform"}},
      {"gpu", {"core"}},
      {"render", {"core", "volume", "gpu", "shaders", "shared"}},
      // No room but a library under tests/: what the product is compared with.
      {"references", {"core", "material"}},
      {"measure",
       {"core", "volume", "material", "deform", "resample", "gpu", "render", "references",
        "shaders", "shared"}},
      {"app",
       {"core", "volume", "material", "deform", "resample", "gpu", "render", "measure", "shaders",
        "shared"}},
  };
  return rooms;
}

// of_room: the room that all of `source` belongs to; empty: its folders are rooms.
// Shader headers are generated ("shaders/") or shared with C++ ("shared/"); they are no rooms.
std::vector<std::string> wrong_includes(const std::filesystem::path& source,
                                        const std::string& of_room = "") {
  std::vector<std::string> wrong;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(source)) {
    const auto ending = entry.path().extension();
    if (ending != ".h" && ending != ".cpp" && ending != ".inl") continue;
    const auto relative = entry.path().lexically_relative(source);
    const std::string room = of_room.empty() ? relative.begin()->string() : of_room;
    std::ifstream file(entry.path());
    std::string line;
    for (int number = 1; std::getline(file, line); ++number) {
      const auto hash = line.find_first_not_of(" \t");
      if (hash == line.npos || line[hash] != '#') continue;
      const auto word = line.find_first_not_of(" \t", hash + 1);
      if (word == line.npos || line.compare(word, 7, "include") != 0) continue;
      const auto open = line.find_first_of("\"<", word);
      if (open == line.npos) continue;
      const auto close = line.find_first_of("\">", open + 1);
      const std::string path = line.substr(open + 1, close - open - 1);
      const std::string target = path.substr(0, path.find('/'));
      const bool names_a_room = path.find('/') != path.npos && allowed().contains(target);
      if (line[open] == '<' && !names_a_room) continue;  // the system's and the libraries' headers
      const auto may = allowed().find(room);
      if (may != allowed().end() && path.find('/') != path.npos &&
          (target == room || may->second.contains(target))) {
        continue;
      }
      wrong.push_back("src/" + relative.string() + ":" + std::to_string(number) + ": room \"" +
                      room + "\" may not include \"" + path + "\"");
    }
  }
  std::sort(wrong.begin(), wrong.end());
  return wrong;
}

TEST(Includes, FollowTheArrows) {
  const auto wrong = wrong_includes(std::filesystem::path(MAILLE_SOURCE_DIR) / "src");
  for (const auto& line : wrong) ADD_FAILURE() << line;
}

TEST(Includes, TheReferencesShareNoSolver) {
  const auto wrong = wrong_includes(
      std::filesystem::path(MAILLE_SOURCE_DIR) / "tests" / "references", "references");
  for (const auto& line : wrong) ADD_FAILURE() << line;
}

TEST(Includes, TheTestSeesEachKindOfWrongOne) {
  const test::Scratch folder;
  std::filesystem::create_directories(folder / "gpu");
  std::filesystem::create_directories(folder / "core");
  std::filesystem::create_directories(folder / "attic");
  folder.write("gpu/device.cpp",
               "#include \"gpu/device.h\"\n#include <vector>\n  #  include \"volume/brick.h\"\n"
               "#include <vulkan/vulkan.h>\n#include \"core/result.h\"\n");
  folder.write("gpu/image.h", "#include <volume/volume.h>\n#include \"device.h\"\n");
  folder.write("core/trace.h", "#include <cstdint>\n#include \"app/window.h\"\n");
  folder.write("attic/old.h", "#include \"core/result.h\"\n");
  const auto wrong = wrong_includes(folder.path());
  const std::vector<std::string> expected = {
      "src/attic/old.h:1: room \"attic\" may not include \"core/result.h\"",
      "src/core/trace.h:2: room \"core\" may not include \"app/window.h\"",
      "src/gpu/device.cpp:3: room \"gpu\" may not include \"volume/brick.h\"",
      "src/gpu/image.h:1: room \"gpu\" may not include \"volume/volume.h\"",
      "src/gpu/image.h:2: room \"gpu\" may not include \"device.h\"",
  };
  EXPECT_EQ(wrong, expected);
}

// The drawing has no way back: rooms can be put in an order in which each needs only earlier ones.
TEST(Includes, TheArrowsHaveNoCircle) {
  Rooms done = {"shaders", "shared"};
  for (std::size_t round = 0; round < allowed().size(); ++round) {
    for (const auto& [room, needs] : allowed()) {
      if (std::includes(done.begin(), done.end(), needs.begin(), needs.end())) done.insert(room);
    }
  }
  for (const auto& [room, needs] : allowed()) EXPECT_TRUE(done.contains(room)) << room;
}

}  // namespace
}  // namespace maille
