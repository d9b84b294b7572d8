#include "deform/lattice_brick.h"

#include <algorithm>
#include <utility>

namespace maille {

LatticeBrick::Pointer LatticeBrick::create(const VoxelBox& box,
                                           const BrickDisplacements& displacements) {
  Planes planes;
  for (std::size_t c = 0; c < 3; ++c) {
    planes[c] = DisplacementPlane::encode(box, displacements.u[c]);
  }
  return create(std::move(planes));
}

LatticeBrick::Pointer LatticeBrick::create(Planes planes) {
  auto brick = std::make_shared<LatticeBrick>();
  brick->planes_ = std::move(planes);
  for (int c = 0; c < 3; ++c) {
    const auto& plane = brick->plane(c);
    if (!plane) continue;
    brick->lowest_[c] = plane->lowest();
    brick->highest_[c] = plane->highest();
    brick->moved_ = brick->moved_.empty() ? plane->moved()
                                          : VoxelBox{glm::min(brick->moved_.lo, plane->moved().lo),
                                                     glm::max(brick->moved_.hi, plane->moved().hi)};
  }
  if (brick->moved_.empty()) return nullptr;
  return brick;
}

void LatticeBrick::read_row(int component, int first, int count, std::int32_t* u) const {
  if (const auto& p = plane(component)) {
    p->read_row(first, count, u);
  } else {
    std::fill_n(u, count, 0);
  }
}

std::int64_t LatticeBrick::bytes() const {
  std::int64_t sum = sizeof(LatticeBrick);
  for (const auto& plane : planes_) sum += plane ? plane->bytes() : 0;
  return sum;
}

bool same_displacements(const LatticeBrick* a, const LatticeBrick* b, const VoxelBox& box) {
  if (a == b) return true;
  if (!a || !b) return false;  // a brick at rest is none
  const Size3 extent = box.size();
  for (int c = 0; c < 3; ++c) {
    if (a->plane(c) == b->plane(c)) continue;
    for (int z = 0; z < extent.z; ++z) {
      for (int y = 0; y < extent.y; ++y) {
        std::int32_t of_a[kBrickEdge];
        std::int32_t of_b[kBrickEdge];
        const int row = (z * kBrickEdge + y) * kBrickEdge;
        a->read_row(c, row, extent.x, of_a);
        b->read_row(c, row, extent.x, of_b);
        if (!std::equal(of_a, of_a + extent.x, of_b)) return false;
      }
    }
  }
  return true;
}

}  // namespace maille
