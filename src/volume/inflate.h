// Deflate streams (gzip or zlib, told apart by their first bytes) into memory of a known size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "core/result.h"

namespace maille {

// Deflate makes at most 1032 bytes of one (a match of 258 bytes in 2 bits): what claims more lies,
// and is refused before anything is allocated for it.
inline constexpr std::uint64_t kDeflateLargestRatio = 1032;

// Drops the first skip bytes of what the stream holds and fills all of out with the next. Gzip
// files of several members read as one. Bytes that the stream holds beyond that are not looked at;
// a stream that ends with out has its checksum verified.
// path and offset say where compressed lies, for errors: bad_input (corrupt, or ends too early).
Result<void> inflate_into(std::span<std::byte> out, std::uint64_t skip,
                          std::span<const std::byte> compressed, const std::filesystem::path& path,
                          std::size_t offset);

}  // namespace maille
