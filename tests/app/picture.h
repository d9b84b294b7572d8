// Pictures as tests look at them: read with libpng, compared pixel by pixel.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

namespace maille::test {

struct Pixels {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgb;
};

Pixels read_png(const std::filesystem::path& path);

// Share of pixels with a channel that differs by more than `difference`.
double share_that_differs(const Pixels& a, const Pixels& b, int difference);

}  // namespace maille::test
