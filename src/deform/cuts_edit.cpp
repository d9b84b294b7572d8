#include "deform/cuts_edit.h"

#include <algorithm>
#include <vector>

namespace maille {
namespace {

std::size_t row_of(VoxelIndex voxel) {
  return static_cast<std::size_t>(element_in_brick(voxel) / kBrickEdge);
}

std::uint32_t bit_of(VoxelIndex voxel) { return std::uint32_t{1} << (voxel.x & 31); }

void set_bit(CutBrick::Rows& rows, VoxelIndex voxel, bool on) {
  std::uint32_t& row = rows[row_of(voxel)];
  row = on ? row | bit_of(voxel) : row & ~bit_of(voxel);
}

bool nothing_removed(const CutBrick& brick) {
  const auto clear = [](const CutBrick::Rows& rows) {
    return std::all_of(rows.begin(), rows.end(), [](std::uint32_t row) { return row == 0; });
  };
  return clear(brick.carved) && std::all_of(brick.removed.begin(), brick.removed.end(), clear);
}

}  // namespace

const CutBrick* CutsEdit::brick(VoxelIndex voxel) const {
  const std::int64_t linear = cuts_.grid().linear(BrickGrid::brick_of(voxel));
  if (linear != current_.linear) {
    const auto found = changed_.find(linear);
    CutBrick* own = found == changed_.end() ? nullptr : found->second.get();
    current_ = {linear, own ? own : cuts_.brick(linear), own};
  }
  return current_.brick;
}

CutBrick& CutsEdit::changing(VoxelIndex voxel) {
  const CutBrick* before = brick(voxel);
  if (!current_.changing) {
    auto own = before ? std::make_shared<CutBrick>(*before) : std::make_shared<CutBrick>();
    current_ = {current_.linear, own.get(), own.get()};
    changed_[current_.linear] = std::move(own);
  }
  return *current_.changing;
}

bool CutsEdit::carved(VoxelIndex voxel) const {
  const CutBrick* b = brick(voxel);
  return b && (b->carved[row_of(voxel)] & bit_of(voxel));
}

bool CutsEdit::removed(VoxelIndex lower, int axis) const {
  const CutBrick* b = brick(lower);
  return b && (b->removed[static_cast<std::size_t>(axis)][row_of(lower)] & bit_of(lower));
}

void CutsEdit::set_removed(VoxelIndex lower, int axis, bool removed_now) {
  if (removed(lower, axis) == removed_now) return;
  set_bit(changing(lower).removed[static_cast<std::size_t>(axis)], lower, removed_now);
}

void CutsEdit::set_carved(VoxelIndex voxel, bool carved_now) {
  if (carved(voxel) == carved_now) return;
  set_bit(changing(voxel).carved, voxel, carved_now);
}

Cuts CutsEdit::finish() {
  std::vector<Cuts::Change> changes;
  for (auto& [linear, brick] : changed_) {
    if (nothing_removed(*brick)) {
      changes.emplace_back(linear, nullptr);
    } else {
      changes.emplace_back(linear, std::move(brick));
    }
  }
  changed_.clear();
  current_ = {};
  cuts_.set(changes);
  return cuts_;
}

}  // namespace maille
