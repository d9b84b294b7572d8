#include "volume/header_lines.h"

#include <charconv>
#include <cmath>

namespace maille {
namespace {

constexpr std::string_view kSpaces = " \t\r\n\v\f";
constexpr std::size_t kLongestQuote = 60;

template <class T>
std::optional<T> parse(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

}  // namespace

HeaderLines::HeaderLines(std::span<const std::byte> bytes)
    : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}

std::optional<HeaderLine> HeaderLines::next() {
  if (offset_ >= text_.size()) return std::nullopt;
  const std::size_t end = text_.find('\n', offset_);
  const auto line = text_.substr(offset_, end == text_.npos ? text_.npos : end - offset_);
  offset_ = end == text_.npos ? text_.size() : end + 1;
  return HeaderLine{++number_, trimmed(line)};
}

Error expected_at_line(const std::filesystem::path& path, int line, std::string_view expected,
                       std::string_view got) {
  return {ErrorKind::bad_input, path.string() + ":" + std::to_string(line) + ": expected " +
                                    std::string(expected) + ", got " + in_quotes(got)};
}

Error expected_at_byte(const std::filesystem::path& path, std::size_t offset,
                       const std::string& expected) {
  return {ErrorKind::bad_input,
          path.string() + ": byte offset " + std::to_string(offset) + ": expected " + expected};
}

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, kLongestQuote)) out += c >= 0x20 && c < 0x7f ? c : '?';
  return out + (text.size() > kLongestQuote ? "…\"" : "\"");
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(kSpaces);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kSpaces) - first + 1);
}

std::string lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (text = trimmed(text); !text.empty();) {
    const auto end = std::min(text.find_first_of(kSpaces), text.size());
    words.push_back(text.substr(0, end));
    text = trimmed(text.substr(end));
  }
  return words;
}

std::optional<std::int64_t> integer_of(std::string_view text) { return parse<std::int64_t>(text); }

std::optional<double> number_of(std::string_view text) { return parse<double>(text); }

std::optional<std::vector<double>> finite_numbers_of(std::string_view text, std::size_t count) {
  std::vector<double> numbers;
  for (const auto word : words_of(text)) {
    const auto number = number_of(word);
    if (!number || !std::isfinite(*number) || numbers.size() == count) return std::nullopt;
    numbers.push_back(*number);
  }
  if (numbers.size() != count) return std::nullopt;
  return numbers;
}

std::string text_of(double number) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, number).ptr};
}

}  // namespace maille
