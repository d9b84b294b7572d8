#include "deform/stroke_bricks.h"

#include <utility>

namespace maille {
namespace {

std::uint32_t row_bits(const ElementSet::Mask& mask, std::size_t row) {
  std::uint32_t bits = 0;
  for (std::size_t x = 0; x < kBrickEdge; ++x) {
    bits |= std::uint32_t{mask.test(row * kBrickEdge + x)} << x;
  }
  return bits;
}

}  // namespace

StrokeBricks::StrokeBricks(const MaterialField& materials, const Cuts& cuts,
                           const ElementSet& pinned, AnchorRules anchors)
    : materials_(materials),
      cuts_(cuts),
      pinned_(pinned),
      anchors_(anchors),
      grid_(materials.size()) {}

const StrokeBrick& StrokeBricks::of(std::int64_t linear) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = bricks_.find(linear);
    if (found != bricks_.end()) return *found->second;
  }
  auto gathered = gather(linear);
  const std::lock_guard lock(mutex_);
  return *bricks_.emplace(linear, std::move(gathered)).first->second;
}

std::int64_t StrokeBricks::bytes() const {
  const std::lock_guard lock(mutex_);
  std::int64_t sum = 0;
  for (const auto& [linear, brick] : bricks_) {
    sum += static_cast<std::int64_t>(sizeof(StrokeBrick) + brick->ids.size() +
                                     (brick->held ? sizeof(StrokeBrick::Rows) : 0));
  }
  return sum;
}

std::unique_ptr<StrokeBrick> StrokeBricks::gather(std::int64_t linear) const {
  auto brick = std::make_unique<StrokeBrick>();
  brick->linear = linear;
  brick->index = grid_.brick(linear);
  brick->box = grid_.box(brick->index);
  brick->halo = {glm::max(brick->box.lo - 1, VoxelIndex(0)),
                 glm::min(brick->box.hi + 1, grid_.volume_size())};
  if (materials_.single_material()) {
    brick->uniform = MaterialId{0};
  } else {
    brick->ids.resize(static_cast<std::size_t>(voxel_count(brick->halo.size())));
    brick->uniform = materials_.read(brick->halo, brick->ids);
    if (brick->uniform) std::vector<MaterialId>().swap(brick->ids);
  }
  brick->held = held_in(*brick);
  return brick;
}

std::unique_ptr<StrokeBrick::Rows> StrokeBricks::held_in(const StrokeBrick& brick) const {
  const ElementSet::Mask* pinned = pinned_.brick(brick.linear);
  const MaterialTable& table = materials_.table();
  const bool fixed = table.any_fixed() && (!brick.uniform || table.fixed(*brick.uniform));
  const Size3 size = grid_.volume_size();
  const bool at_face =
      anchors_.faces != 0 && (glm::any(glm::equal(brick.box.lo, VoxelIndex(0))) ||
                              glm::any(glm::equal(brick.box.hi, VoxelIndex(size))));
  if (!pinned && !fixed && !at_face) return nullptr;
  auto rows = std::make_unique<StrokeBrick::Rows>();
  std::uint32_t any = 0;
  for (int z = brick.box.lo.z; z < brick.box.hi.z; ++z) {
    for (int y = brick.box.lo.y; y < brick.box.hi.y; ++y) {
      const auto row = static_cast<std::size_t>(element_in_brick({0, y, z}) / kBrickEdge);
      std::uint32_t bits = pinned ? row_bits(*pinned, row) : 0;
      for (int x = brick.box.lo.x; x < brick.box.hi.x; ++x) {
        const VoxelIndex voxel{x, y, z};
        const bool held = (fixed && table.fixed(brick.id(voxel))) ||
                          (at_face && (faces_of(voxel, size) & anchors_.faces));
        bits |= std::uint32_t{held} << (x & 31);
      }
      (*rows)[row] = bits;
      any |= bits;
    }
  }
  return any ? std::move(rows) : nullptr;
}

}  // namespace maille
