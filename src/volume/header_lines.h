// A text header, line by line, and the words for what is wrong in it:
//   scan.nrrd:7: expected three sizes >= 1, got "512 512"
//   scan.nrrd: byte offset 320: expected 108000 bytes of samples, got 12
// Numbers are read without regard to the locale.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace maille {

struct HeaderLine {
  int number = 0;         // from 1
  std::string_view text;  // without its end (LF or CR LF), spaces around it trimmed
};

// Walks over bytes that outlive it. What follows the last line taken starts at offset().
class HeaderLines {
 public:
  explicit HeaderLines(std::span<const std::byte> bytes);
  std::optional<HeaderLine> next();  // nothing at the end of the bytes
  std::size_t offset() const { return offset_; }
  int line_number() const { return number_; }

 private:
  std::string_view text_;
  std::size_t offset_ = 0;
  int number_ = 0;
};

// Errors of kind bad_input. got is quoted, cut short and freed of what a terminal would obey.
Error expected_at_line(const std::filesystem::path& path, int line, std::string_view expected,
                       std::string_view got);
Error expected_at_byte(const std::filesystem::path& path, std::size_t offset,
                       const std::string& expected);
std::string in_quotes(std::string_view text);

std::string_view trimmed(std::string_view text);
std::string lower_case(std::string_view text);  // ASCII letters only
std::vector<std::string_view> words_of(std::string_view text);

// The whole text as a number, or nothing. Numbers may be NaN or infinite.
std::optional<std::int64_t> integer_of(std::string_view text);
std::optional<double> number_of(std::string_view text);
// All words as finite numbers, exactly count of them, or nothing.
std::optional<std::vector<double>> finite_numbers_of(std::string_view text, std::size_t count);

// The shortest text that reads back as the same number.
std::string text_of(double number);

}  // namespace maille
