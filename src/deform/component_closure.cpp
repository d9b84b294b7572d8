#include "deform/component_closure.h"

#include <algorithm>
#include <limits>
#include <string>

#include "core/failure.h"
#include "core/stopwatch.h"
#include "deform/label_lines.h"

namespace maille {
namespace {

// A drag that is done sooner is done before another worker would be awake.
constexpr double kAlone_seconds = 2.5e-4;

// One line of a side of a brick, as BrickSlack::cross() numbers them: in line i the element at lane
// j is first + j * stride.
struct SideLine {
  int first;
  int stride;

  SideLine(int axis, int layer, int line) {
    switch (axis) {
      case 0:
        first = line * kBrickEdge * kBrickEdge + layer;
        stride = kBrickEdge;
        break;
      case 1:
        first = (line * kBrickEdge + layer) * kBrickEdge;
        stride = 1;
        break;
      default: first = (layer * kBrickEdge + line) * kBrickEdge; stride = 1;
    }
  }
};

bool line_reached(const DirtyRows& reached, int axis, int layer, int line) {
  const auto rows = [&](int z) { return reached.rows[static_cast<std::size_t>(z)]; };
  if (axis == 0) return rows(line) != 0;
  if (axis == 1) return (rows(line) >> layer) & 1;
  return (rows(layer) >> line) & 1;
}

template <class L>
const L* gathered(const L* labels, SideLine line, int lanes, L* scratch) {
  if (line.stride == 1) return labels + line.first;
  for (int j = 0; j < lanes; ++j) scratch[j] = labels[line.first + j * line.stride];
  std::fill(scratch + lanes, scratch + kBrickEdge, L{0});
  return scratch;
}

int lines_of(int axis, Size3 extent) { return axis == 2 ? extent.y : extent.z; }
int lanes_of(int axis, Size3 extent) { return axis == 0 ? extent.y : extent.x; }

}  // namespace

template <class L>
ComponentClosure<L>::ComponentClosure(const Lattice& start, StrokeBricks& bricks,
                                      const DirectedLimits<L>& limits, std::uint32_t brick_order,
                                      std::int64_t most_bytes)
    : start_(start),
      bricks_(bricks),
      grid_(bricks.grid()),
      limits_(limits),
      most_bytes_(most_bytes),
      order_(brick_order),
      any_order_(brick_order != 0) {}

template <class L>
void ComponentClosure<L>::solve(const ElementSet& handle, L drag, WorkerPool& pool) {
  for (const auto& [linear, mask] : handle.bricks()) {
    Node& node = nodes_[linear];
    node.linear = linear;
    node.labels = fresh_labels();
    for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
      for (int x = 0; x < kBrickEdge; ++x) {
        const auto e = static_cast<std::size_t>(row * kBrickEdge + x);
        if (!mask->test(e)) continue;
        node.labels[e] = drag;
        node.seeded.mark(row % kBrickEdge, row / kBrickEdge);
      }
    }
    wait_for(node, drag);
  }
  const double endless = std::numeric_limits<double>::infinity();
  if (pool.thread_count() == 1) {
    work(endless);
    return;
  }
  work(kAlone_seconds);
  if (waiting_.empty()) return;
  pool.for_each(pool.thread_count(), [&](std::int64_t, int) { work(endless); });
}

template <class L>
void ComponentClosure<L>::work(double seconds) {
  try {
    take_bricks(seconds);
  } catch (...) {
    // Or the others would wait for what this one was about to say.
    const std::lock_guard lock(mutex_);
    failed_ = true;
    changed_.notify_all();
    throw;
  }
}

// Until none waits, or for some time.
template <class L>
void ComponentClosure<L>::take_bricks(double seconds) {
  const Stopwatch since;
  BrickSlack<L> slack;
  std::unique_lock lock(mutex_);
  while (!failed_ && since.seconds() < seconds) {
    const Task task = take_highest();
    if (!task.node) {
      if (running_.empty()) break;
      changed_.wait(lock);
      continue;
    }
    lock.unlock();
    const Wishes wishes = visit(task, slack);
    lock.lock();
    ++bricks_closed_;
    const BrickIndex here = task.node->brick->index;
    running_.erase(std::find(running_.begin(), running_.end(), here));
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        const L wished = wishes[static_cast<std::size_t>(2 * axis + (side > 0))];
        // Every label shrinks by the overshoot in the end: what is not above it ends at 0.
        if (wished <= overshoot()) continue;
        BrickIndex there = here;
        there[axis] += side;
        Node& node = nodes_[grid_.linear(there)];
        node.linear = grid_.linear(there);
        wait_for(node, wished);
      }
    }
    changed_.notify_all();
  }
  changed_.notify_all();
}

template <class L>
void ComponentClosure<L>::wait_for(Node& node, L label) {
  if (label <= node.pending) return;
  node.pending = label;
  waiting_.push({any_order_ ? order_() : label, label, node.linear});
}

template <class L>
bool ComponentClosure<L>::beside_a_running_one(BrickIndex brick) const {
  return std::any_of(running_.begin(), running_.end(), [&](BrickIndex other) {
    const glm::ivec3 apart = glm::abs(other - brick);
    return apart.x + apart.y + apart.z <= 1;
  });
}

template <class L>
typename ComponentClosure<L>::Task ComponentClosure<L>::take_highest() {
  Task task;
  held_back_.clear();
  while (!task.node && !waiting_.empty()) {
    const Wish wish = waiting_.top();
    waiting_.pop();
    Node& node = nodes_.find(wish.linear)->second;
    if (wish.label != node.pending) continue;  // an older wish
    if (wish.label <= overshoot()) {
      node.pending = 0;
    } else if (beside_a_running_one(grid_.brick(wish.linear))) {
      held_back_.push_back(wish);
    } else {
      task.node = &node;
    }
  }
  for (const Wish& wish : held_back_) waiting_.push(wish);
  if (!task.node) return task;
  task.node->pending = 0;
  const BrickIndex here = grid_.brick(task.node->linear);
  running_.push_back(here);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      BrickIndex there = here;
      there[axis] += side;
      if (!grid_.contains(there)) continue;
      const auto found = nodes_.find(grid_.linear(there));
      if (found == nodes_.end()) continue;
      task.neighbours[static_cast<std::size_t>(2 * axis + (side > 0))] = &found->second;
    }
  }
  return task;
}

template <class L>
AlignedArray<L> ComponentClosure<L>::fresh_labels() {
  constexpr std::int64_t kBytes = std::int64_t{sizeof(L)} * kBrickVoxels;
  if (label_bytes_.fetch_add(kBytes, std::memory_order_relaxed) + kBytes > most_bytes_) {
    throw Failure({ErrorKind::out_of_memory,
                   "what moves at once takes more than the lattice may take: " +
                       std::to_string(most_bytes_ >> 10) + " KiB (--lattice-memory)"});
  }
  auto labels = make_aligned_array<L>(kBrickVoxels);
  std::fill_n(labels.get(), kBrickVoxels, L{0});
  return labels;
}

template <class L>
typename ComponentClosure<L>::Wishes ComponentClosure<L>::visit(const Task& task,
                                                                BrickSlack<L>& slack) {
  Node& node = *task.node;
  if (!node.brick) node.brick = &bricks_.of(node.linear);
  if (!node.labels) node.labels = fresh_labels();
  slack.begin(bricks_, *node.brick, start_, limits_);
  DirtyRows dirty = std::exchange(node.seeded, {});
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) take_in(task, axis, side, slack, dirty);
  }
  Wishes wishes{};
  if (!dirty.any()) return wishes;
  close_brick(node.labels.get(), node.brick->box.size(), slack, dirty, node.reached);
  if (node.brick->held) raise_overshoot(node);
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      wishes[static_cast<std::size_t>(2 * axis + (side > 0))] = wish(task, axis, side, slack);
    }
  }
  return wishes;
}

// Takes over what the labels of a neighbour push across a side.
template <class L>
void ComponentClosure<L>::take_in(const Task& task, int axis, int side, const BrickSlack<L>& slack,
                                  DirtyRows& dirty) const {
  const Node* theirs = task.neighbours[static_cast<std::size_t>(2 * axis + (side > 0))];
  if (!theirs || !theirs->labels) return;
  const Size3 extent = task.node->brick->box.size();
  const int layer = side < 0 ? 0 : extent[axis] - 1;
  const int their_layer = side < 0 ? kBrickEdge - 1 : 0;
  const int lanes = lanes_of(axis, extent);
  L* const labels = task.node->labels.get();
  typename BrickSlack<L>::Crossing crossing;
  alignas(64) L from_scratch[kBrickEdge];
  alignas(64) L to[kBrickEdge];
  for (int i = 0; i < lines_of(axis, extent); ++i) {
    if (!line_reached(theirs->reached, axis, their_layer, i)) continue;
    const L* from =
        gathered(theirs->labels.get(), SideLine(axis, their_layer, i), lanes, from_scratch);
    const SideLine own(axis, layer, i);
    if (own.stride == 1) {
      L* const row = labels + own.first;
      if (!any_greater(from, row)) continue;
      slack.cross(axis, side, i, crossing);
      if (!push_line(from, crossing.into, row)) continue;
      dirty.mark(axis == 1 ? layer : i, axis == 1 ? i : layer);
    } else {
      gathered(labels, own, lanes, to);
      if (!any_greater(from, to)) continue;
      slack.cross(axis, side, i, crossing);
      if (!push_line(from, crossing.into, to)) continue;
      for (int j = 0; j < lanes; ++j) {
        L& label = labels[own.first + j * own.stride];
        if (to[j] == label) continue;
        label = to[j];
        dirty.mark(j, i);
      }
    }
  }
}

// The highest label that ours would give a neighbour across a side.
template <class L>
L ComponentClosure<L>::wish(const Task& task, int axis, int side,
                            const BrickSlack<L>& slack) const {
  const Node& node = *task.node;
  BrickIndex there = node.brick->index;
  there[axis] += side;
  if (!grid_.contains(there)) return 0;
  const Node* theirs = task.neighbours[static_cast<std::size_t>(2 * axis + (side > 0))];
  const Size3 extent = node.brick->box.size();
  const int layer = side < 0 ? 0 : extent[axis] - 1;
  const int their_layer = side < 0 ? kBrickEdge - 1 : 0;
  const int lanes = lanes_of(axis, extent);
  static constexpr L kNothing[kBrickEdge] = {};
  typename BrickSlack<L>::Crossing crossing;
  alignas(64) L from_scratch[kBrickEdge];
  alignas(64) L to_scratch[kBrickEdge];
  L highest = 0;
  for (int i = 0; i < lines_of(axis, extent); ++i) {
    if (!line_reached(node.reached, axis, layer, i)) continue;
    const L* from = gathered(node.labels.get(), SideLine(axis, layer, i), lanes, from_scratch);
    const L* to =
        theirs && theirs->labels
            ? gathered(theirs->labels.get(), SideLine(axis, their_layer, i), lanes, to_scratch)
            : kNothing;
    if (!any_greater(from, to)) continue;
    slack.cross(axis, side, i, crossing);
    highest = std::max(highest, highest_push(from, crossing.out_of, to));
  }
  return highest;
}

template <class L>
void ComponentClosure<L>::raise_overshoot(const Node& node) {
  L highest = 0;
  for (int z = 0; z < kBrickEdge; ++z) {
    for (std::uint32_t rows = node.reached.rows[static_cast<std::size_t>(z)]; rows != 0;
         rows &= rows - 1) {
      const int row = z * kBrickEdge + __builtin_ctz(rows);
      const std::uint32_t held = (*node.brick->held)[static_cast<std::size_t>(row)];
      if (held == 0) continue;
      highest =
          std::max(highest, highest_of(&node.labels[static_cast<std::size_t>(row) * 32], held));
    }
  }
  L known = overshoot();
  while (highest > known &&
         !overshoot_.compare_exchange_weak(known, highest, std::memory_order_relaxed)) {
  }
}

template class ComponentClosure<std::uint16_t>;
template class ComponentClosure<std::uint32_t>;

}  // namespace maille
