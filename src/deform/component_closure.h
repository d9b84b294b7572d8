// The closure of one component of a drag over all the bricks it reaches (design: ChainMail).
//
// Bricks wait in a queue by the highest label that something beside them would give them, and
// workers take the highest first: most bricks are then closed once or twice. No two bricks beside
// each other are ever worked on at once, so a worker may read its neighbours' labels as they are;
// which worker takes which brick does not matter, because the fixed point is unique.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <queue>
#include <random>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/aligned_array.h"
#include "core/parallel.h"
#include "deform/brick_closure.h"
#include "deform/brick_slack.h"

namespace maille {

template <class L>
class ComponentClosure {
 public:
  struct Node {
    std::int64_t linear = 0;
    const StrokeBrick* brick = nullptr;  // from the first visit on
    AlignedArray<L> labels;              // 32^3; null: nothing has pushed yet
    DirtyRows seeded;                    // rows that the handle has raised
    DirtyRows reached;
    L pending = 0;  // highest label that waits for a visit; 0: none
  };

  // brick_order: 0, or the seed of a random order. most_bytes: of labels (see ChainMailProblem).
  ComponentClosure(const Lattice& start, StrokeBricks& bricks, const DirectedLimits<L>& limits,
                   std::uint32_t brick_order, std::int64_t most_bytes);

  // Raises the labels of the handle's elements to the drag and closes everything. Throws as
  // solve_chainmail().
  void solve(const ElementSet& handle, L drag, WorkerPool& pool);

  L overshoot() const { return overshoot_.load(std::memory_order_relaxed); }
  std::int64_t bricks_closed() const { return bricks_closed_; }
  // All that were reached.
  std::unordered_map<std::int64_t, Node>& nodes() { return nodes_; }

 private:
  using Neighbours = std::array<const Node*, 6>;  // [2 * axis + (side > 0)]; null: none yet
  struct Wish {
    std::uint64_t rank = 0;  // the highest is taken first
    L label = 0;
    std::int64_t linear = 0;
    bool operator<(const Wish& other) const {
      return std::tie(rank, linear) < std::tie(other.rank, other.linear);
    }
  };
  struct Task {
    Node* node = nullptr;
    Neighbours neighbours{};
  };
  using Wishes = std::array<L, 6>;  // what a brick would raise its neighbours to, at most

  void work(double seconds);
  void take_bricks(double seconds);
  Task take_highest();  // under the mutex
  void wait_for(Node& node, L label);
  bool beside_a_running_one(BrickIndex brick) const;
  AlignedArray<L> fresh_labels();
  Wishes visit(const Task& task, BrickSlack<L>& slack);
  void take_in(const Task& task, int axis, int side, const BrickSlack<L>& slack,
               DirtyRows& dirty) const;
  L wish(const Task& task, int axis, int side, const BrickSlack<L>& slack) const;
  void raise_overshoot(const Node& node);

  const Lattice& start_;
  StrokeBricks& bricks_;
  const BrickGrid& grid_;
  const DirectedLimits<L>& limits_;
  std::int64_t most_bytes_;
  std::atomic<std::int64_t> label_bytes_{0};
  std::atomic<L> overshoot_{0};

  std::mutex mutex_;  // of all that follows
  std::condition_variable changed_;
  std::unordered_map<std::int64_t, Node> nodes_;
  std::priority_queue<Wish> waiting_;
  std::vector<BrickIndex> running_;
  std::vector<Wish> held_back_;
  std::mt19937 order_;
  bool any_order_;
  std::int64_t bricks_closed_ = 0;
  bool failed_ = false;
};

extern template class ComponentClosure<std::uint16_t>;
extern template class ComponentClosure<std::uint32_t>;

}  // namespace maille
