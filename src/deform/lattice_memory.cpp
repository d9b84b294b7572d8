#include "deform/lattice_memory.h"

#include <string>
#include <vector>

namespace maille {
namespace {

// Calls f(plane) for the planes of a's bricks that are not b's.
template <class F>
void for_each_plane(const Lattice& a, const Lattice& b, F&& f) {
  Lattice::for_each_difference(a, b, [&](std::int64_t linear) {
    const LatticeBrick* brick = a.brick(linear);
    for (int c = 0; brick && c < 3; ++c) {
      if (const auto& plane = brick->plane(c)) f(*plane);
    }
  });
}

std::string in_kib(std::int64_t bytes) { return std::to_string((bytes + 1023) / 1024) + " KiB"; }

}  // namespace

Result<void> LatticeMemory::check(const Lattice& before, const Lattice& now) const {
  std::int64_t bytes = 0;
  for_each_plane(now, before, [&](const DisplacementPlane& plane) {
    if (!plane.paged()) bytes += plane.array_bytes();
  });
  if (bytes <= store_->budget_bytes()) return {};
  return Error{ErrorKind::out_of_memory,
               "what moves at once takes " + in_kib(bytes) + ", and the lattice may take " +
                   in_kib(store_->budget_bytes()) + " (--lattice-memory)"};
}

void LatticeMemory::take_in(const Lattice& before, const Lattice& now) {
  for_each_plane(now, before, [&](const DisplacementPlane& plane) { plane.page_through(store_); });
  store_->hold_budget();
}

void LatticeMemory::prefer(const Lattice& now, const Lattice& before) {
  std::vector<const PagedArray*> arrays;
  const auto gather = [&](const DisplacementPlane& plane) {
    if (plane.paged()) arrays.push_back(plane.paged());
  };
  for_each_plane(before, now, gather);
  store_->set_wanted(arrays, false);
  arrays.clear();
  for_each_plane(now, before, gather);
  store_->set_wanted(arrays, true);
}

}  // namespace maille
