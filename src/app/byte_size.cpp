#include "app/byte_size.h"

#include <cctype>
#include <charconv>
#include <cstdio>
#include <limits>

namespace maille {
namespace {

constexpr std::string_view kLetters = "KMGT";

}  // namespace

std::optional<std::int64_t> parse_byte_size(std::string_view text) {
  std::int64_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [next, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || number < 1 || end - next > 1) return std::nullopt;
  if (next == end) return number;
  const auto letter =
      kLetters.find(static_cast<char>(std::toupper(static_cast<unsigned char>(*next))));
  if (letter == std::string_view::npos) return std::nullopt;
  const int shift = 10 * (static_cast<int>(letter) + 1);
  if (number > (std::numeric_limits<std::int64_t>::max() >> shift)) return std::nullopt;
  return number << shift;
}

std::string text_of_bytes(std::int64_t bytes) {
  if (bytes < 1024) return std::to_string(bytes) + " bytes";
  auto amount = static_cast<double>(bytes) / 1024.0;
  std::size_t letter = 0;
  for (; amount >= 1024.0 && letter + 1 < kLetters.size(); ++letter) amount /= 1024.0;
  char text[32];
  std::snprintf(text, sizeof text, "%.1f %ciB", amount, kLetters[letter]);
  return text;
}

}  // namespace maille
