// SHA-256 of bytes, for saying which samples a volume has.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace maille {

std::string sha256_hex(std::span<const std::byte> bytes);  // 64 lower-case digits

}  // namespace maille
