#include "deform/chainmail.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/trace.h"
#include "deform/component_closure.h"

namespace maille {
namespace {

// With fewer bricks, waking the other workers takes longer than the work.
constexpr std::size_t kWorthSharing = 32;

// What a drag has made of a brick so far.
struct TouchedBrick {
  std::array<bool, 3> changed{};
  LatticeBrick::Planes planes;  // of the components that changed
  // A bit for each element with a label above 0, where several components may move it.
  std::unique_ptr<StrokeBrick::Rows> moved;
  std::int64_t elements_moved = 0;
};

class DragSolver {
 public:
  DragSolver(const ChainMailProblem& problem, glm::ivec3 by, WorkerPool& pool)
      : problem_(problem),
        pool_(pool),
        several_components_((by.x != 0) + (by.y != 0) + (by.z != 0) > 1) {}

  void solve(int component, std::int32_t by) {
    if (fits_16_bits(by)) {
      solve_with<std::uint16_t>(component, by);
    } else {
      solve_with<std::uint32_t>(component, by);
    }
  }

  ChainMailAnswer answer() {
    const Lattice& start = problem_.start;
    answer_.lattice = start;
    std::vector<Lattice::Change> changes;
    for (auto& [linear, touched] : touched_) {
      // A new brick that holds the same would be resampled, and kept for undo, for nothing.
      if (touched->changed == std::array<bool, 3>{}) continue;
      LatticeBrick::Planes planes;
      const LatticeBrick* before = start.brick(linear);
      for (int c = 0; c < 3; ++c) {
        const auto i = static_cast<std::size_t>(c);
        if (touched->changed[i]) {
          planes[i] = std::move(touched->planes[i]);
        } else if (before) {
          planes[i] = before->plane(c);
        }
      }
      changes.emplace_back(linear, LatticeBrick::create(std::move(planes)));
      answer_.elements_moved += touched->elements_moved;
    }
    answer_.lattice.set(changes);
    return std::move(answer_);
  }

 private:
  bool fits_16_bits(std::int32_t by) const {
    constexpr int kMost = std::numeric_limits<std::uint16_t>::max();
    if (std::abs(by) > kMost) return false;
    const MaterialTable& table = problem_.bricks.table();
    for (int i = 0; i < table.count(); ++i) {
      const ElementLimits& own = table.limits(static_cast<MaterialId>(i));
      const glm::ivec3 widest = glm::max(glm::max(own.compress, own.stretch), own.shear);
      if (glm::any(glm::greaterThan(widest, glm::ivec3(kMost)))) return false;
    }
    return true;
  }

  template <class L>
  void solve_with(int component, std::int32_t by) {
    const DirectedLimits<L> limits(problem_.bricks.table(), component, by < 0);
    ComponentClosure<L> closure(problem_.start, problem_.bricks, limits, problem_.brick_order,
                                problem_.most_label_bytes);
    const auto drag = static_cast<L>(std::abs(by));
    closure.solve(problem_.handle, drag, pool_);
    const L overshoot = closure.overshoot();
    answer_.moved_by[component] = limits.sign * static_cast<std::int32_t>(drag - overshoot);
    answer_.clamped = answer_.clamped || overshoot > 0;
    answer_.bricks_swept += closure.bricks_closed();

    using Node = typename ComponentClosure<L>::Node;
    std::vector<std::pair<Node*, TouchedBrick*>> work;
    std::int64_t label_bytes = 0;
    for (auto& [linear, node] : closure.nodes()) {
      label_bytes += static_cast<std::int64_t>(sizeof(Node));
      if (!node.labels || !node.brick) continue;
      label_bytes += static_cast<std::int64_t>(sizeof(L)) * kBrickVoxels;
      auto& touched = touched_[linear];
      if (!touched) {
        touched = std::make_unique<TouchedBrick>();
        if (several_components_) touched->moved = std::make_unique<StrokeBrick::Rows>();
      }
      work.emplace_back(&node, touched.get());
    }
    const auto finish = [&](std::int64_t i, int) {
      const auto& [node, touched] = work[static_cast<std::size_t>(i)];
      take_labels(*node, *touched, component, limits.sign, overshoot);
    };
    if (work.size() < kWorthSharing) {
      for (std::size_t i = 0; i < work.size(); ++i) finish(static_cast<std::int64_t>(i), 0);
    } else {
      pool_.for_each(static_cast<std::int64_t>(work.size()), finish);
    }
    // Brick by brick, labels turn into planes or give way to them.
    const std::int64_t made = made_bytes();
    answer_.working_bytes = std::max({answer_.working_bytes, made_before_ + label_bytes, made});
    made_before_ = made;
  }

  // Of what is there of the answer.
  std::int64_t made_bytes() const {
    std::int64_t sum = 0;
    for (const auto& [linear, touched] : touched_) {
      sum += static_cast<std::int64_t>(sizeof(TouchedBrick));
      if (touched->moved) sum += static_cast<std::int64_t>(sizeof(StrokeBrick::Rows));
      for (const auto& plane : touched->planes) sum += plane ? plane->bytes() : 0;
    }
    return sum;
  }

  // u of a component after the drag: what it was, and the labels above the overshoot.
  template <class L>
  void take_labels(typename ComponentClosure<L>::Node& node, TouchedBrick& touched, int component,
                   int sign, L overshoot) const {
    const VoxelBox& box = node.brick->box;
    const MovedLabels<L> moved =
        lower_labels(node.labels.get(), box.size(), node.reached, overshoot,
                     touched.moved ? touched.moved->data() : nullptr);
    if (!moved.any) return;
    touched.elements_moved += moved.newly_moved;
    const auto c = static_cast<std::size_t>(component);
    touched.changed[c] = true;
    const LatticeBrick* before = problem_.start.brick(node.linear);
    const DisplacementPlane* plane = before ? before->plane(component).get() : nullptr;
    if constexpr (sizeof(L) == sizeof(std::uint16_t)) {
      if (!plane) {
        // From rest the labels are the offsets.
        DisplacementPlane::Known known{
            0, sign, moved.lowest, moved.highest, {box.lo + moved.box.lo, box.lo + moved.box.hi}};
        if (sign < 0) {
          known.lowest = -std::int32_t{moved.highest};
          known.highest = -std::int32_t{moved.lowest};
        }
        touched.planes[c] = DisplacementPlane::adopt(known, std::move(node.labels));
        return;
      }
    }
    touched.planes[c] = moved_plane_of(node.labels.get(), plane, sign, box);
    node.labels.reset();
  }

  template <class L>
  static DisplacementPlane::Pointer moved_plane_of(const L* labels, const DisplacementPlane* plane,
                                                   int sign, const VoxelBox& box) {
    const auto u = make_aligned_array<std::int32_t>(kBrickVoxels);
    for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
      std::int32_t* out = &u[static_cast<std::size_t>(row * kBrickEdge)];
      const L* label = labels + row * kBrickEdge;
      if (plane) {
        plane->read_row(row * kBrickEdge, kBrickEdge, out);
      } else {
        std::fill_n(out, kBrickEdge, 0);
      }
      for (int x = 0; x < kBrickEdge; ++x) out[x] += sign * static_cast<std::int32_t>(label[x]);
    }
    return DisplacementPlane::encode(box, u.get());
  }

  const ChainMailProblem& problem_;
  WorkerPool& pool_;
  bool several_components_;
  ChainMailAnswer answer_;
  std::int64_t made_before_ = 0;  // bytes of the components that are done
  std::unordered_map<std::int64_t, std::unique_ptr<TouchedBrick>> touched_;
};

}  // namespace

ChainMailAnswer solve_chainmail(const ChainMailProblem& problem, glm::ivec3 by, WorkerPool& pool) {
  const trace::Span span("chainmail");
  DragSolver solver(problem, by, pool);
  for (int c = 0; c < 3; ++c) {
    if (by[c] != 0) solver.solve(c, by[c]);
  }
  return solver.answer();
}

}  // namespace maille
