#include "tests/app/picture.h"

#include <algorithm>
#include <cstdlib>

#include <png.h>

#include "app/png.h"
#include "tests/app/program.h"

namespace maille::test {

Pixels read_png(const std::filesystem::path& path) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  Pixels pixels;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return pixels;
  image.format = PNG_FORMAT_RGB;
  pixels.rgb.resize(PNG_IMAGE_SIZE(image));
  if (png_image_finish_read(&image, nullptr, pixels.rgb.data(), 0, nullptr) == 0) return {};
  pixels.width = static_cast<int>(image.width);
  pixels.height = static_cast<int>(image.height);
  return pixels;
}

double share_that_differs(const Pixels& a, const Pixels& b, int difference) {
  if (a.width != b.width || a.height != b.height || a.rgb.empty()) return 1.0;
  std::size_t differ = 0;
  const std::size_t count = a.rgb.size() / 3;
  for (std::size_t i = 0; i < count; ++i) {
    bool far = false;
    for (std::size_t c = 0; c < 3; ++c) {
      far = far || std::abs(int{a.rgb[3 * i + c]} - int{b.rgb[3 * i + c]}) > difference;
    }
    differ += far ? 1 : 0;
  }
  return static_cast<double>(differ) / static_cast<double>(count);
}

namespace {

TEST(Png, APictureComesBackAsItWasWritten) {
  const Folder folder;
  Picture picture{{3, 2}, {}};
  for (int i = 0; i < 24; ++i) picture.rgba.push_back(static_cast<std::uint8_t>(i * 10));
  ASSERT_TRUE(write_png(folder / "p.png", picture).ok());
  const auto back = read_png(folder / "p.png");
  ASSERT_EQ(back.width, 3);
  ASSERT_EQ(back.height, 2);
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(back.rgb[3 * i + c], picture.rgba[4 * i + c]);
  }
  EXPECT_EQ(write_png(folder / "no/such/p.png", picture).error().kind, ErrorKind::file_system);
}

}  // namespace
}  // namespace maille::test
