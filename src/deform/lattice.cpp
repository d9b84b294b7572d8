#include "deform/lattice.h"

namespace maille {

std::int64_t Lattice::brick_count() const {
  std::int64_t count = 0;
  for_each_brick([&](std::int64_t, const LatticeBrick&) { ++count; });
  return count;
}

std::int64_t Lattice::bytes() const {
  std::int64_t sum = 0;
  for_each_brick([&](std::int64_t, const LatticeBrick& brick) { sum += brick.bytes(); });
  return sum;
}

std::int64_t Lattice::displacement_bytes() const {
  std::int64_t sum = 0;
  for_each_brick([&](std::int64_t, const LatticeBrick& brick) {
    for (int c = 0; c < 3; ++c) sum += brick.plane(c) ? brick.plane(c)->array_bytes() : 0;
  });
  return sum;
}

bool same_displacements(const Lattice& a, const Lattice& b) {
  bool same = true;
  Lattice::for_each_difference(a, b, [&](std::int64_t i) {
    same = same && same_displacements(a.brick(i), b.brick(i), a.grid().box(a.grid().brick(i)));
  });
  return same;
}

}  // namespace maille
