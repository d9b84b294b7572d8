#include "core/scratch_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

namespace maille {
namespace {

// Holes of a few bytes would be of no use to anybody.
std::int64_t rounded_up(std::int64_t bytes) { return (bytes + 511) / 512 * 512; }

}  // namespace

Result<ScratchFile> ScratchFile::create() {
  std::error_code error;
  const auto folder = std::filesystem::temp_directory_path(error);
  if (error) {
    return Error{ErrorKind::file_system,
                 "making a scratch file failed: no folder for temporary files: " + error.message()};
  }
  std::string name = (folder / "maille-XXXXXX").string();
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor < 0) {
    return Error{ErrorKind::file_system,
                 folder.string() + ": making a scratch file failed: " + std::strerror(errno)};
  }
  ::unlink(name.c_str());
  return ScratchFile(descriptor, folder.string());
}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      folder_(std::move(other.folder_)),
      size_(other.size_),
      holes_(std::move(other.holes_)) {}

ScratchFile::~ScratchFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Error ScratchFile::failure(const char* doing, int reason) const {
  return {ErrorKind::file_system,
          folder_ + ": " + doing + " a scratch file failed: " + std::strerror(reason)};
}

// The smallest hole that is large enough would keep large ones whole, but means a search; slots are
// alike, so the first one serves.
std::int64_t ScratchFile::take_room(std::int64_t bytes) {
  for (auto hole = holes_.begin(); hole != holes_.end(); ++hole) {
    const auto [offset, length] = *hole;
    if (length < bytes) continue;
    holes_.erase(hole);
    if (length > bytes) holes_.emplace(offset + bytes, length - bytes);
    return offset;
  }
  return std::exchange(size_, size_ + bytes);
}

Result<ScratchFile::Slot> ScratchFile::write(std::span<const std::byte> bytes) {
  const auto count = static_cast<std::int64_t>(bytes.size());
  const Slot slot{take_room(rounded_up(count)), count};
  for (std::int64_t done = 0; done < count;) {
    const auto written =
        ::pwrite(descriptor_, bytes.data() + done, static_cast<std::size_t>(count - done),
                 static_cast<off_t>(slot.offset + done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int reason = written == 0 ? ENOSPC : errno;
      free(slot);
      return failure("writing", reason);
    }
    done += written;
  }
  return slot;
}

Result<void> ScratchFile::read(const Slot& slot, std::span<std::byte> bytes) const {
  const auto count = static_cast<std::int64_t>(bytes.size());
  for (std::int64_t done = 0; done < count;) {
    const auto got =
        ::pread(descriptor_, bytes.data() + done, static_cast<std::size_t>(count - done),
                static_cast<off_t>(slot.offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return failure("reading", got == 0 ? EIO : errno);
    done += got;
  }
  return {};
}

void ScratchFile::free(const Slot& slot) {
  auto offset = slot.offset;
  auto length = rounded_up(slot.bytes);
  auto next = holes_.lower_bound(offset);
  if (next != holes_.end() && next->first == offset + length) {
    length += next->second;
    next = holes_.erase(next);
  }
  if (next != holes_.begin()) {
    const auto before = std::prev(next);
    if (before->first + before->second == offset) {
      offset = before->first;
      length += before->second;
      holes_.erase(before);
    }
  }
  if (offset + length == size_) {
    size_ = offset;
  } else {
    holes_.emplace(offset, length);
  }
}

}  // namespace maille
