// A displacement field that the program wrote, read without any code of its own.
#pragma once

#include <cstring>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>
#include <glm/glm.hpp>

#include "tests/app/program.h"

namespace maille::test {

// Floats after the header of an uncompressed NRRD.
inline std::vector<glm::vec3> read_field(const std::filesystem::path& path) {
  const auto text = read_file(path);
  const auto header = text.find("\n\n");
  EXPECT_NE(header, std::string::npos);
  EXPECT_NE(text.substr(0, header).find("type: float"), std::string::npos);
  std::vector<glm::vec3> vectors((text.size() - header - 2) / sizeof(glm::vec3));
  std::memcpy(vectors.data(), text.data() + header + 2, vectors.size() * sizeof(glm::vec3));
  return vectors;
}

}  // namespace maille::test
