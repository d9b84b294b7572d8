// Bytes put aside in a file that has no name and goes with the program, however that ends. Room
// that is freed is used again before the file grows.
//
// Owned by one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>

#include "core/result.h"

namespace maille {

class ScratchFile {
 public:
  struct Slot {
    std::int64_t offset = 0;
    std::int64_t bytes = 0;
  };

  // In the folder for temporary files (TMPDIR). Errors: file_system.
  static Result<ScratchFile> create();
  ScratchFile(ScratchFile&& other) noexcept;
  ScratchFile& operator=(ScratchFile&&) = delete;
  ~ScratchFile();

  // Errors: file_system (the disk is full); nothing is kept then.
  Result<Slot> write(std::span<const std::byte> bytes);
  // bytes: as many as were written. Errors: file_system.
  Result<void> read(const Slot& slot, std::span<std::byte> bytes) const;
  void free(const Slot& slot);

  std::int64_t size_bytes() const { return size_; }

 private:
  ScratchFile(int descriptor, std::string folder)
      : descriptor_(descriptor), folder_(std::move(folder)) {}
  Error failure(const char* doing, int reason) const;
  std::int64_t take_room(std::int64_t bytes);

  int descriptor_;
  std::string folder_;
  std::int64_t size_ = 0;
  std::map<std::int64_t, std::int64_t> holes_;  // length by offset, never two in touch
};

}  // namespace maille
