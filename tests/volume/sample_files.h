// Sample bytes made independently of the code under test: what files of a volume hold.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>

#include "tests/core/scratch.h"
#include "volume/volume_file.h"

namespace maille::test {

inline const std::vector<VoxelType> kAllTypes = {
    VoxelType::uint8, VoxelType::int8, VoxelType::uint16, VoxelType::int16, VoxelType::float32};

// count samples of the type that reach its ends, as little- or big-endian bytes, one by one.
inline std::string sample_text(VoxelType type, int count, bool is_big) {
  std::string bytes;
  for (int i = 0; i < count; ++i) {
    std::uint32_t bits = static_cast<std::uint32_t>(i) * 2654435761u >> 7;
    int width = 1;
    switch (type) {
      case VoxelType::uint8:
      case VoxelType::int8: break;
      case VoxelType::uint16:
      case VoxelType::int16: width = 2; break;
      case VoxelType::float32: {
        width = 4;
        float value = static_cast<float>(i) * -1.25e3f + 0.1f;
        if (i == 3) value = std::numeric_limits<float>::quiet_NaN();
        if (i == 4) value = std::numeric_limits<float>::denorm_min();
        std::memcpy(&bits, &value, 4);
        break;
      }
    }
    for (int byte = 0; byte < width; ++byte) {
      const int shift = 8 * (is_big ? width - 1 - byte : byte);
      bytes += static_cast<char>(bits >> shift & 255u);
    }
  }
  return bytes;
}

// gzip (window_bits 15 + 16) or zlib (15).
inline std::string deflated(const std::string& bytes, int window_bits = 15 + 16) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, window_bits, 9, Z_DEFAULT_STRATEGY), Z_OK);
  std::string out(deflateBound(&stream, bytes.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

inline std::string text_of_samples(const Volume& volume) {
  return {reinterpret_cast<const char*>(volume.bytes().data()), volume.bytes().size()};
}

inline void expect_matrix(const glm::dmat4& got, const glm::dmat4& expected) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      EXPECT_NEAR(got[column][row], expected[column][row],
                  1e-12 * (1 + std::abs(expected[column][row])))
          << "column " << column << " row " << row;
    }
  }
}

// Reading fails as bad_input with a message that starts with the file's path and says each part.
inline void expect_refused(const std::filesystem::path& path,
                           const std::vector<std::string>& parts) {
  const auto volume = read_volume(path);
  ASSERT_FALSE(volume.ok()) << path << " was read";
  EXPECT_EQ(volume.error().kind, ErrorKind::bad_input) << volume.error().message;
  EXPECT_TRUE(volume.error().message.starts_with(path.string())) << volume.error().message;
  EXPECT_NE(volume.error().message.find("expected"), std::string::npos) << volume.error().message;
  for (const auto& part : parts) {
    EXPECT_NE(volume.error().message.find(part), std::string::npos)
        << "\"" << part << "\" is not in: " << volume.error().message;
  }
}

// text with the first occurrence of from turned into to; from must occur.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace maille::test
