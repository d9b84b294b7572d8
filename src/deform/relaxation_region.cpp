#include "deform/relaxation_region.h"

#include <algorithm>

namespace maille {
namespace {

// A region this much smaller than the volume is worth having: growing costs a new start.
constexpr std::int64_t kWorthwhile = 4;
constexpr int kLeastMargin = 8;

VoxelBox grown(const VoxelBox& box, const VoxelBox& whole, double share) {
  const Size3 margin = glm::max(Size3(glm::dvec3(box.size()) * share), Size3(kLeastMargin));
  return intersection({box.lo - margin, box.hi + margin}, whole);
}

}  // namespace

RelaxationRegion::RelaxationRegion(const VoxelBox& disturbed, Size3 volume, AnchorRules anchors,
                                   std::int64_t most_elements)
    : whole_{VoxelIndex(0), volume}, most_elements_(most_elements) {
  const std::uint8_t holding =
      anchors.faces ? anchors.faces : static_cast<std::uint8_t>(anchors.free_border ? 0 : 63);
  for (int axis = 0; axis < 3; ++axis) {
    if ((holding >> (2 * axis)) & 1) ++whole_.lo[axis];
    if ((holding >> (2 * axis + 1)) & 1) --whole_.hi[axis];
  }
  const VoxelBox start = intersection(disturbed, whole_);
  if (whole_.empty() || start.empty()) return;
  if (!take(grown(start, whole_, 0.5))) take(start);
}

bool RelaxationRegion::grow() { return !whole() && take(grown(box_, whole_, 0.5)); }

bool RelaxationRegion::take(const VoxelBox& wanted) {
  const std::int64_t all = voxel_count(whole_.size());
  VoxelBox box = wanted;
  if (all <= kWorthwhile * voxel_count(box.size()) && all <= most_elements_) box = whole_;
  if (voxel_count(box.size()) > most_elements_) {
    limited_ = true;
    // The largest margin that fits around what there is, or as much of the middle.
    VoxelBox fits = box_;
    for (double share = 0.4; share > 0.01 && !box_.empty(); share *= 0.7) {
      const VoxelBox smaller = grown(box_, whole_, share);
      if (voxel_count(smaller.size()) <= most_elements_) {
        fits = smaller;
        break;
      }
    }
    if (box_.empty()) {
      fits = box;
      while (!fits.empty() && voxel_count(fits.size()) > most_elements_) {
        const Size3 cut = glm::max(fits.size() / 16, Size3(1));
        fits = {fits.lo + cut, fits.hi - cut};
      }
    }
    if (fits.empty() || fits == box_) return false;
    box_ = fits;
    return true;
  }
  if (box == box_) return false;
  box_ = box;
  return true;
}

}  // namespace maille
