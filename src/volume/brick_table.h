// Something immutable for each of a few bricks of a volume: shared between copies of the table, and
// so are the groups of 64 it hangs in. A copy costs a pointer a group, a change of k bricks the
// groups they are in, and a walk over what is there only that: nothing costs as much as the volume
// has bricks.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "volume/brick.h"

namespace maille {

template <class Brick>
class BrickTable {
 public:
  using Pointer = std::shared_ptr<const Brick>;
  using Change = std::pair<std::int64_t, Pointer>;

  BrickTable() = default;
  explicit BrickTable(Size3 volume_size)
      : grid_(volume_size), groups_(static_cast<std::size_t>((grid_.count() + 63) / 64)) {}

  const BrickGrid& grid() const { return grid_; }

  // Null: nothing. linear must lie in the grid.
  const Pointer& shared(std::int64_t linear) const {
    const auto& group = groups_[static_cast<std::size_t>(linear >> 6)];
    return group ? (*group)[static_cast<std::size_t>(linear & 63)] : kNone;
  }
  const Brick* brick(std::int64_t linear) const { return shared(linear).get(); }

  // Each brick at most once.
  void set(std::span<const Change> changes) {
    std::vector<std::pair<std::int64_t, std::size_t>> by_group;
    by_group.reserve(changes.size());
    for (std::size_t i = 0; i < changes.size(); ++i) {
      by_group.emplace_back(changes[i].first >> 6, i);
    }
    std::sort(by_group.begin(), by_group.end());
    for (auto first = by_group.begin(); first != by_group.end();) {
      const std::int64_t number = first->first;
      auto& slot = groups_[static_cast<std::size_t>(number)];
      // Never changed in place: another table, perhaps of another thread, may share it.
      auto group = slot ? std::make_shared<Group>(*slot) : std::make_shared<Group>();
      for (; first != by_group.end() && first->first == number; ++first) {
        const auto& [linear, brick] = changes[first->second];
        (*group)[static_cast<std::size_t>(linear & 63)] = brick;
      }
      const bool empty =
          std::all_of(group->begin(), group->end(), [](const auto& b) { return !b; });
      slot = empty ? nullptr : std::move(group);
    }
  }
  void set(std::int64_t linear, Pointer brick) {
    const Change change{linear, std::move(brick)};
    set({&change, 1});
  }

  // Calls f(linear, brick) by rising index.
  template <class F>
  void for_each_brick(F&& f) const {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (!groups_[g]) continue;
      for (std::size_t i = 0; i < 64; ++i) {
        if (const auto& b = (*groups_[g])[i]) f(static_cast<std::int64_t>(g * 64 + i), *b);
      }
    }
  }
  // Calls f(linear) for the bricks that are not the same object in two tables of one volume, by
  // rising index.
  template <class F>
  static void for_each_difference(const BrickTable& a, const BrickTable& b, F&& f) {
    for (std::size_t g = 0; g < a.groups_.size(); ++g) {
      if (a.groups_[g] == b.groups_[g]) continue;
      const auto first = static_cast<std::int64_t>(g) * 64;
      for (auto i = first, end = std::min(first + 64, a.grid_.count()); i < end; ++i) {
        if (a.shared(i) != b.shared(i)) f(i);
      }
    }
  }

  bool empty() const {
    return std::all_of(groups_.begin(), groups_.end(), [](const auto& g) { return !g; });
  }

 private:
  using Group = std::array<Pointer, 64>;
  inline static const Pointer kNone;

  BrickGrid grid_;
  std::vector<std::shared_ptr<const Group>> groups_;
};

}  // namespace maille
