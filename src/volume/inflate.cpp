#include "volume/inflate.h"

#include <algorithm>
#include <array>
#include <string>

#include <zlib.h>

#include "volume/header_lines.h"

namespace maille {
namespace {

constexpr std::size_t kLargestStep = std::size_t{1} << 30;  // zlib counts in 32 bits

class Inflater {
 public:
  Inflater(std::span<const std::byte> compressed, const std::filesystem::path& path,
           std::size_t offset)
      : compressed_(compressed), path_(path), offset_(offset) {
    constexpr int kLargestWindow = 15, kGzipOrZlib = 32;
    is_open_ = inflateInit2(&stream_, kLargestWindow + kGzipOrZlib) == Z_OK;
  }
  ~Inflater() {
    if (is_open_) inflateEnd(&stream_);
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  Result<void> fill(std::span<std::byte> out) {
    if (!is_open_) return Error{ErrorKind::out_of_memory, path_.string() + ": zlib did not start"};
    while (!out.empty()) {
      auto step = out.first(std::min(out.size(), kLargestStep));
      const auto made = advance(step);
      if (!made) return made.error();
      if (is_over_) {
        return refuse("more: " + std::to_string(out.size()) + " bytes are missing after the " +
                      std::to_string(total_made_) + " that the compressed stream holds");
      }
      out = out.subspan(*made);
    }
    return {};
  }

  // Reads on to the stream's checksum, if only that is left.
  Result<void> finish() {
    std::array<std::byte, 1> beyond;
    while (!ended_) {
      const auto made = advance(beyond);
      if (!made) return made.error();
      if (*made > 0) return {};
    }
    return {};
  }

 private:
  // Fills some of out, perhaps nothing; is_over_ says that there is no more to come.
  Result<std::size_t> advance(std::span<std::byte> out) {
    if (ended_ && !next_member()) {
      is_over_ = true;
      return std::size_t{0};
    }
    if (stream_.avail_in == 0) {
      const auto rest = compressed_.subspan(taken_);
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(rest.data()));
      stream_.avail_in = static_cast<uInt>(std::min(rest.size(), kLargestStep));
      taken_ += stream_.avail_in;
    }
    stream_.next_out = reinterpret_cast<Bytef*>(out.data());
    stream_.avail_out = static_cast<uInt>(out.size());
    const bool input_is_over = stream_.avail_in == 0;
    const int status = inflate(&stream_, Z_NO_FLUSH);
    const std::size_t made = out.size() - stream_.avail_out;
    total_made_ += made;
    if (status == Z_STREAM_END) {
      ended_ = true;
    } else if (status == Z_BUF_ERROR && input_is_over) {
      return refuse("the rest of a compressed stream, got the end of the file");
    } else if (status == Z_MEM_ERROR) {
      return Error{ErrorKind::out_of_memory, path_.string() + ": no memory to decompress"};
    } else if (status != Z_OK && status != Z_BUF_ERROR) {
      return refuse(std::string("a sound gzip or zlib stream, got corrupt data (") +
                    (stream_.msg ? stream_.msg : "no details") + ")");
    }
    return made;
  }

  bool next_member() {
    const std::size_t at = taken_ - stream_.avail_in;
    if (compressed_.size() - at < 2 || compressed_[at] != std::byte{0x1f} ||
        compressed_[at + 1] != std::byte{0x8b}) {
      return false;
    }
    ended_ = inflateReset(&stream_) != Z_OK;
    return !ended_;
  }

  Error refuse(const std::string& expected) const {
    return expected_at_byte(path_, offset_ + taken_ - stream_.avail_in, expected);
  }

  std::span<const std::byte> compressed_;
  const std::filesystem::path& path_;
  std::size_t offset_;
  z_stream stream_{};
  std::size_t taken_ = 0;  // bytes of compressed_ handed to zlib so far
  std::uint64_t total_made_ = 0;
  bool is_open_ = false;
  bool ended_ = false;    // the member at hand
  bool is_over_ = false;  // all of them
};

}  // namespace

Result<void> inflate_into(std::span<std::byte> out, std::uint64_t skip,
                          std::span<const std::byte> compressed, const std::filesystem::path& path,
                          std::size_t offset) {
  Inflater inflater(compressed, path, offset);
  std::array<std::byte, 65536> dropped;
  for (; skip > 0; skip -= std::min<std::uint64_t>(skip, dropped.size())) {
    const auto step = std::span(dropped).first(std::min<std::uint64_t>(skip, dropped.size()));
    if (auto filled = inflater.fill(step); !filled) return filled;
  }
  if (auto filled = inflater.fill(out); !filled) return filled;
  return inflater.finish();
}

}  // namespace maille
