// Saving that never leaves half a file: bytes go to a temporary file beside the target, which takes
// the target's name only when all of it is on the disk (fsync, rename, fsync of the directory).
// Destroyed without commit(), it leaves the old file as it was and nothing else behind.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "core/result.h"

namespace maille {

class AtomicFile {
 public:
  // Errors: file_system, naming the path.
  static Result<AtomicFile> create(const std::filesystem::path& path);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

  Result<void> write(std::span<const std::byte> bytes);
  Result<void> commit();

 private:
  AtomicFile(int descriptor, std::filesystem::path target, std::filesystem::path temporary);
  Error failure(const char* doing) const;

  int descriptor_ = -1;
  std::filesystem::path target_;
  std::filesystem::path temporary_;
};

Result<void> write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace maille
