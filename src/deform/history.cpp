#include "deform/history.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace maille {
namespace {

// The bricks that a table must get back to be what it was before.
template <class Table>
std::vector<typename Table::Change> replaced(const Table& before, const Table& now) {
  std::vector<typename Table::Change> changes;
  Table::for_each_difference(before, now,
                             [&](std::int64_t i) { changes.emplace_back(i, before.shared(i)); });
  return changes;
}

// Puts bricks in their places and returns those that were there.
template <class Table>
std::vector<typename Table::Change> exchange(const std::vector<typename Table::Change>& bricks,
                                             Table& table) {
  std::vector<typename Table::Change> taken;
  taken.reserve(bricks.size());
  for (const auto& [linear, ignored] : bricks) taken.emplace_back(linear, table.shared(linear));
  table.set(bricks);
  return taken;
}

// Of a brick that both have replaced, what was there first: set_union takes it from the first.
std::vector<Lattice::Change> first_of_both(const std::vector<Lattice::Change>& before,
                                           const std::vector<Lattice::Change>& after) {
  std::vector<Lattice::Change> all;
  std::set_union(before.begin(), before.end(), after.begin(), after.end(), std::back_inserter(all),
                 [](const auto& a, const auto& b) { return a.first < b.first; });
  return all;
}

std::int64_t unshared_bytes(const LatticeBrick* brick, const LatticeBrick* in_its_place) {
  if (brick == nullptr || brick == in_its_place) return 0;
  std::int64_t bytes = sizeof(LatticeBrick);
  for (int c = 0; c < 3; ++c) {
    const auto& plane = brick->plane(c);
    if (!plane || (in_its_place != nullptr && plane == in_its_place->plane(c))) continue;
    bytes += std::int64_t{sizeof(DisplacementPlane)} + plane->array_bytes();
  }
  return bytes;
}

}  // namespace

void History::record(const Deformation& before, const Deformation& now) {
  for (const Step& step : redo_) bytes_ -= step.bytes;
  redo_.clear();
  Step step;
  step.lattice = replaced(before.lattice, now.lattice);
  step.cuts = replaced(before.cuts, now.cuts);
  step.kept = replaced(before.kept, now.kept);
  if (before.handles != now.handles) step.handles = before.handles;
  if (before.released != now.released) step.released = before.released;
  if (before.materials != now.materials) step.materials = before.materials;
  step.disturbance = before.disturbance;
  count_bytes(step, now);
  push(undo_, std::move(step));
}

void History::extend(const Deformation& before, const Deformation& now) {
  if (!undo_.empty()) extend(undo_.back(), before, now);
  if (!redo_.empty()) extend(redo_.back(), before, now);
  hold_budget();
}

void History::extend(Step& step, const Deformation& before, const Deformation& now) {
  step.lattice = first_of_both(step.lattice, replaced(before.lattice, now.lattice));
  step.kept = first_of_both(step.kept, replaced(before.kept, now.kept));
  if (!step.released && before.released != now.released) step.released = before.released;
  bytes_ -= step.bytes;
  count_bytes(step, now);
  bytes_ += step.bytes;
}

bool History::undo(Deformation& now) { return move(undo_, redo_, now); }

bool History::redo(Deformation& now) { return move(redo_, undo_, now); }

bool History::move(std::deque<Step>& from, std::deque<Step>& to, Deformation& now) {
  if (from.empty()) return false;
  const Step step = std::move(from.back());
  from.pop_back();
  bytes_ -= step.bytes;
  push(to, take(step, now));
  return true;
}

History::Step History::take(const Step& step, Deformation& now) {
  Step back;
  back.lattice = exchange(step.lattice, now.lattice);
  back.cuts = exchange(step.cuts, now.cuts);
  back.kept = exchange(step.kept, now.kept);
  if (step.handles) back.handles = std::exchange(now.handles, *step.handles);
  if (step.released) back.released = std::exchange(now.released, *step.released);
  if (step.materials) back.materials = std::exchange(now.materials, step.materials);
  back.disturbance = std::exchange(now.disturbance, step.disturbance);
  count_bytes(back, now);
  return back;
}

void History::count_bytes(Step& step, const Deformation& now) {
  step.bytes = sizeof(Step);
  const auto count = [&](const std::vector<Lattice::Change>& bricks,
                         const Lattice& in_their_place) {
    for (const auto& [linear, brick] : bricks) {
      step.bytes += std::int64_t{sizeof(Lattice::Change)} +
                    unshared_bytes(brick.get(), in_their_place.brick(linear));
    }
  };
  count(step.lattice, now.lattice);
  count(step.kept, now.kept);
  for (const auto& [linear, brick] : step.cuts) {
    step.bytes += std::int64_t{sizeof(Cuts::Change)} + (brick ? std::int64_t{sizeof(CutBrick)} : 0);
  }
  // A handle that has been released is first another of the state's, then none.
  const auto is_in = [](const Handles& handles, const std::shared_ptr<const Handle>& handle) {
    return std::find(handles.begin(), handles.end(), handle) != handles.end();
  };
  Handles gone = step.handles.value_or(Handles{});
  for (const auto& handle : step.released.value_or(Handles{})) {
    if (!is_in(gone, handle)) gone.push_back(handle);
  }
  for (const auto& handle : gone) {
    if (!is_in(now.handles, handle) && !is_in(now.released, handle)) step.bytes += handle->bytes();
  }
  if (step.materials) step.bytes += step.materials->bytes();
}

void History::push(std::deque<Step>& steps, Step step) {
  bytes_ += step.bytes;
  steps.push_back(std::move(step));
  hold_budget();
}

void History::hold_budget() {
  while (bytes_ > budget_bytes_) {
    auto& steps = undo_.empty() ? redo_ : undo_;
    bytes_ -= steps.front().bytes;
    steps.pop_front();
    ++dropped_steps_;
  }
}

}  // namespace maille
