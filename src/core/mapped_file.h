// A file's bytes as memory, read on demand by the operating system and never copied.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <utility>

#include "core/result.h"

namespace maille {

class MappedFile {
 public:
  // Errors: file_system (cannot be opened, is not a regular file). An empty file maps to no bytes.
  static Result<MappedFile> open(const std::filesystem::path& path);
  MappedFile(MappedFile&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}
  MappedFile& operator=(MappedFile&&) = delete;
  ~MappedFile();

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::span<const std::byte> bytes_;
};

}  // namespace maille
