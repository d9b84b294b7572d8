#include "deform/cut_counts.h"

#include <bit>

namespace maille {
namespace {

std::int64_t bits(const CutBrick::Rows& rows) {
  std::int64_t count = 0;
  for (const std::uint32_t row : rows) count += std::popcount(row);
  return count;
}

}  // namespace

CutCounts count_removed(const Cuts& cuts) {
  CutCounts counts;
  cuts.for_each_brick([&](std::int64_t, const CutBrick& brick) {
    for (const auto& rows : brick.removed) counts.links_removed += bits(rows);
    counts.elements_carved += bits(brick.carved);
  });
  return counts;
}

}  // namespace maille
