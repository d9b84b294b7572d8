#include "app/png.h"

#include <csetjmp>

#include <png.h>

#include "core/atomic_file.h"

namespace maille {
namespace {

void append(png_structp png, png_bytep bytes, png_size_t count) {
  auto& out = *static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(png));
  out.insert(out.end(), bytes, bytes + count);
}

void ignore_flush(png_structp) {}

}  // namespace

Result<void> write_png(const std::filesystem::path& path, const Picture& picture) {
  // Everything that a longjmp of libpng would pass over lives outside of the jump's reach.
  std::vector<std::uint8_t> encoded;
  const auto pixels =
      static_cast<std::size_t>(picture.size.x) * static_cast<std::size_t>(picture.size.y);
  std::vector<std::uint8_t> rgb(pixels * 3);
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) rgb[i * 3 + c] = picture.rgba[i * 4 + c];
  }

  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return Error{ErrorKind::out_of_memory, path.string() + ": the picture could not be encoded"};
  }
  png_set_write_fn(png, &encoded, append, ignore_flush);
  png_set_IHDR(png, info, static_cast<png_uint_32>(picture.size.x),
               static_cast<png_uint_32>(picture.size.y), 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  // A frame a step: half the time of the default level for a tenth more bytes.
  png_set_compression_level(png, 3);
  png_write_info(png, info);
  for (int row = 0; row < picture.size.y; ++row) {
    png_write_row(png, rgb.data() + static_cast<std::size_t>(row) *
                                        static_cast<std::size_t>(picture.size.x) * 3);
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);

  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  if (auto written = file->write(std::as_bytes(std::span<const std::uint8_t>(encoded))); !written) {
    return written;
  }
  return file->commit();
}

}  // namespace maille
