#include "core/atomic_file.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace maille {
namespace {

std::filesystem::path directory_of(const std::filesystem::path& path) {
  const auto parent = path.parent_path();
  return parent.empty() ? std::filesystem::path(".") : parent;
}

Error system_error(const std::filesystem::path& path, const char* doing) {
  return {ErrorKind::file_system,
          path.string() + ": " + doing + " failed: " + std::strerror(errno)};
}

// mkstemp makes files private; a saved picture should be as readable as any new file.
mode_t default_file_mode() {
  const mode_t mask = umask(0);
  umask(mask);
  return 0666 & ~mask;
}

}  // namespace

AtomicFile::AtomicFile(int descriptor, std::filesystem::path target,
                       std::filesystem::path temporary)
    : descriptor_(descriptor), target_(std::move(target)), temporary_(std::move(temporary)) {}

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      target_(std::move(other.target_)),
      temporary_(std::move(other.temporary_)) {}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  close(descriptor_);
  unlink(temporary_.c_str());
}

Error AtomicFile::failure(const char* doing) const { return system_error(target_, doing); }

Result<AtomicFile> AtomicFile::create(const std::filesystem::path& path) {
  // A link is written through to what it names, as every editor does; one to nothing yet makes it.
  std::error_code ignored;
  auto target = path;
  for (int links = 0; links < 40 && std::filesystem::is_symlink(target, ignored); ++links) {
    target = directory_of(target) / std::filesystem::read_symlink(target, ignored);
  }
  const auto kind = std::filesystem::status(target, ignored).type();
  if (target.empty() || (kind != std::filesystem::file_type::regular &&
                         kind != std::filesystem::file_type::not_found)) {
    // Renaming over a pipe or a device would take it away from everybody else.
    return Error{ErrorKind::file_system,
                 path.string() + ": expected the name of a file, got a directory or a device"};
  }
  std::string name =
      (directory_of(target) / ("." + target.filename().string() + ".XXXXXX")).string();
  const int descriptor = mkstemp(name.data());
  if (descriptor < 0) return system_error(path, "creating a temporary file beside it");
  fchmod(descriptor, default_file_mode());
  return AtomicFile(descriptor, target, name);
}

Result<void> AtomicFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return failure("writing");
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

Result<void> AtomicFile::commit() {
  if (fsync(descriptor_) != 0) return failure("flushing to disk");
  if (rename(temporary_.c_str(), target_.c_str()) != 0) return failure("renaming into place");
  close(std::exchange(descriptor_, -1));
  const int directory = open(directory_of(target_).c_str(), O_RDONLY | O_DIRECTORY);
  if (directory >= 0) {
    // Some file systems refuse fsync on a directory; the file itself is safe by now.
    fsync(directory);
    close(directory);
  }
  return {};
}

Result<void> write_text_file(const std::filesystem::path& path, std::string_view text) {
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  if (auto written = file->write(std::as_bytes(std::span(text))); !written) return written;
  return file->commit();
}

}  // namespace maille
