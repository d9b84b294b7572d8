#include "deform/label_lines.h"

#include <algorithm>

#include "core/several_widths.h"

namespace maille {
namespace {

template <class L>
[[gnu::always_inline]] inline L pushed(L from, L slack) {
  return static_cast<L>(std::max(from, slack) - slack);
}

template <class L>
[[gnu::always_inline]] inline bool push(const L* from, const L* slack, L* to) {
  L rose = 0;
  for (int x = 0; x < kBrickEdge; ++x) {
    const L label = std::max(to[x], pushed(from[x], slack[x]));
    rose = static_cast<L>(rose | (label ^ to[x]));
    to[x] = label;
  }
  return rose != 0;
}

template <class L>
[[gnu::always_inline]] inline L highest(const L* from, const L* slack, const L* to) {
  L most = 0;
  for (int x = 0; x < kBrickEdge; ++x) {
    const L label = pushed(from[x], slack[x]);
    most = std::max(most, label > to[x] ? label : L{0});
  }
  return most;
}

template <class L>
[[gnu::always_inline]] inline bool greater(const L* a, const L* b) {
  L any = 0;
  for (int x = 0; x < kBrickEdge; ++x) any = static_cast<L>(any | (std::max(a[x], b[x]) ^ b[x]));
  return any != 0;
}

template <class L>
[[gnu::always_inline]] inline L highest_where(const L* labels, std::uint32_t which) {
  L most = 0;
  for (int x = 0; x < kBrickEdge; ++x) {
    most = std::max(most, (which >> x) & 1 ? labels[x] : L{0});
  }
  return most;
}

}  // namespace

// The loader chooses among plain functions only.
#define MAILLE_LINES_OF(L)                                                                     \
  MAILLE_FOR_SEVERAL_WIDTHS bool push_line(const L* from, const L* slack, L* to) {             \
    return push(from, slack, to);                                                              \
  }                                                                                            \
  MAILLE_FOR_SEVERAL_WIDTHS L highest_push(const L* from, const L* slack, const L* to) {       \
    return highest(from, slack, to);                                                           \
  }                                                                                            \
  MAILLE_FOR_SEVERAL_WIDTHS bool any_greater(const L* a, const L* b) { return greater(a, b); } \
  MAILLE_FOR_SEVERAL_WIDTHS L highest_of(const L* labels, std::uint32_t which) {               \
    return highest_where(labels, which);                                                       \
  }
MAILLE_LINES_OF(std::uint16_t)
MAILLE_LINES_OF(std::uint32_t)

}  // namespace maille
