// Columns of text, as wide as what stands in them.
#pragma once

#include <string>
#include <vector>

namespace maille {

// The first row is the heading. The first column is flush left, the others right. Every row has as
// many cells as the first; UTF-8 letters count as one.
std::string text_table(const std::vector<std::vector<std::string>>& rows);

// printf's %.*f.
std::string fixed_number(double value, int decimals);

// printf's %.*g, for numbers that go over decades.
std::string short_number(double value, int digits = 6);

// The same rows as CSV (RFC 4180).
std::string csv(const std::vector<std::vector<std::string>>& rows);

}  // namespace maille
