// Amounts of memory as a person writes and reads them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace maille {

// "512M" -> 512 * 2^20: a whole number, with K, M, G or T for powers of 1024 in either case.
// nullopt: anything else, 0 included, and what 63 bits do not hold.
std::optional<std::int64_t> parse_byte_size(std::string_view text);

// "3.2 GiB", "17 bytes".
std::string text_of_bytes(std::int64_t bytes);

}  // namespace maille
