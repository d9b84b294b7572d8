#include "deform/chainmail.h"

#include <algorithm>
#include <array>
#include <queue>
#include <utility>

#include "core/trace.h"

namespace maille {
namespace {

constexpr int kStride[3] = {1, kBrickEdge, kBrickEdge* kBrickEdge};

int row_of(int y, int z) { return z * kBrickEdge + y; }

// The labels of a brick, and for each of its rows when a label last rose and which of those rises
// every step of the sweep has passed on already. What has nothing new to pass on is skipped.
struct Labels {
  enum Step { scan, to_higher_y, to_lower_y, to_higher_z, to_lower_z, steps };
  using RowStamps = std::array<std::uint32_t, kBrickEdge * kBrickEdge>;

  std::array<std::int32_t, kBrickVoxels> delta{};
  RowStamps risen{};
  std::array<RowStamps, steps> passed_on{};
  std::uint32_t clock = 0;

  void rise(int row) { risen[static_cast<std::size_t>(row)] = ++clock; }
  bool reached(int row) const { return risen[static_cast<std::size_t>(row)] != 0; }
  // Whether a step has something to do for a row, which it is then taken to have done.
  bool take(Step step, int row) {
    std::uint32_t& done = passed_on[step][static_cast<std::size_t>(row)];
    const std::uint32_t wanted = risen[static_cast<std::size_t>(row)];
    return std::exchange(done, wanted) != wanted;
  }
};

// How far an element may move along the drag before it pushes the one beside it. `up` is what the
// lower end of a link has towards the upper one, `down` the other way.
struct Slack {
  std::int32_t up = 0;
  std::int32_t down = 0;
};

// One round of max-plus sweeps over the elements of a brick: planes up, then planes down, in each
// plane along x and y both ways. Carries a label along every path that is monotone in z. Returns
// whether a label rose. SlackOf says up(axis, lower element), down(axis, lower element) and, first,
// prepare(y, z) for the links that start in a row.
template <class SlackOf>
bool sweep_round(Labels& labels, Size3 extent, SlackOf& slack) {
  std::int32_t* const delta = labels.delta.data();
  bool any_rose = false;
  const auto push_row = [&](Labels::Step step, int axis, int y, int z, int side) {
    if (!labels.take(step, row_of(y, z))) return;
    const int to_y = axis == 1 ? y + side : y;
    const int to_z = axis == 2 ? z + side : z;
    slack.prepare(std::min(y, to_y), std::min(z, to_z));
    const int from = row_of(y, z) * kBrickEdge;
    const int to = row_of(to_y, to_z) * kBrickEdge;
    const int lower = std::min(from, to);
    std::int32_t rose = 0;
    for (int x = 0; x < extent.x; ++x) {
      const std::int32_t pushed =
          delta[from + x] - (side > 0 ? slack.up(axis, lower + x) : slack.down(axis, lower + x));
      const std::int32_t old = delta[to + x];
      const std::int32_t now = std::max(old, pushed);
      rose |= now ^ old;
      delta[to + x] = now;
    }
    if (rose == 0) return;
    labels.rise(row_of(to_y, to_z));
    any_rose = true;
  };
  const auto scan_row = [&](int y, int z) {
    const int row = row_of(y, z);
    if (!labels.take(Labels::scan, row)) return;
    slack.prepare(y, z);
    const int first = row * kBrickEdge;
    std::int32_t rose = 0;
    std::int32_t carried = delta[first];
    for (int e = first + 1; e < first + extent.x; ++e) {
      carried = std::max(delta[e], carried - slack.up(0, e - 1));
      rose |= carried ^ delta[e];
      delta[e] = carried;
    }
    for (int e = first + extent.x - 2; e >= first; --e) {
      carried = std::max(delta[e], carried - slack.down(0, e));
      rose |= carried ^ delta[e];
      delta[e] = carried;
    }
    if (rose == 0) return;
    labels.rise(row);
    labels.take(Labels::scan, row);  // a row scanned both ways has nothing left to give itself
    any_rose = true;
  };
  const auto sweep_plane = [&](int z) {
    for (int y = 0; y < extent.y; ++y) scan_row(y, z);
    for (int y = 0; y < extent.y - 1; ++y) push_row(Labels::to_higher_y, 1, y, z, 1);
    for (int y = extent.y - 1; y > 0; --y) push_row(Labels::to_lower_y, 1, y, z, -1);
  };
  sweep_plane(0);
  for (int z = 1; z < extent.z; ++z) {
    for (int y = 0; y < extent.y; ++y) push_row(Labels::to_higher_z, 2, y, z - 1, 1);
    sweep_plane(z);
  }
  for (int z = extent.z - 2; z >= 0; --z) {
    for (int y = 0; y < extent.y; ++y) push_row(Labels::to_lower_z, 2, y, z + 1, -1);
    sweep_plane(z);
  }
  return any_rose;
}

// The table's limits of one component, seen along the drag: for each axis and pair of materials
// what the stretch of a link must stay between. A drag downwards sees the mirror image.
class DirectedLimits {
 public:
  DirectedLimits(const MaterialTable& table, int component, bool downwards)
      : downwards_(downwards), count_(static_cast<std::size_t>(table.count())) {
    const auto c = component;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      limits_[axis].resize(count_ * count_);
      for (std::size_t i = 0; i < count_; ++i) {
        for (std::size_t j = 0; j < count_; ++j) {
          const LinkLimits& link =
              table.link(static_cast<MaterialId>(i), static_cast<MaterialId>(j));
          limits_[axis][i * count_ + j] = {link.lower[axis][c], link.upper[axis][c]};
        }
      }
    }
  }

  Slack slack(int axis, MaterialId lower_id, MaterialId upper_id, std::int32_t stretch) const {
    const Bounds b = limits_[static_cast<std::size_t>(axis)][lower_id * count_ + upper_id];
    const std::int32_t up = std::max(0, stretch - b.least);
    const std::int32_t down = std::max(0, b.most - stretch);
    return downwards_ ? Slack{down, up} : Slack{up, down};
  }

 private:
  struct Bounds {
    std::int32_t least;
    std::int32_t most;
  };
  bool downwards_;
  std::size_t count_;
  std::vector<Bounds> limits_[3];
};

// A brick of one material at rest has one slack an axis, and no array to read.
struct UniformSlack {
  std::array<Slack, 3> slack;
  void prepare(int, int) const {}
  std::int32_t up(int axis, int) const { return slack[static_cast<std::size_t>(axis)].up; }
  std::int32_t down(int axis, int) const { return slack[static_cast<std::size_t>(axis)].down; }
};

// Any other brick: the slack of every link, worked out by rows when a label first reaches them.
class VaryingSlack {
 public:
  VaryingSlack() {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      up_[axis].resize(kBrickVoxels);
      down_[axis].resize(kBrickVoxels);
    }
  }

  void begin(const VoxelBox& box, const MaterialHalo& halo, const std::int32_t* u,
             const DirectedLimits& limits) {
    box_ = box;
    halo_ = &halo;
    u_ = u;
    limits_ = &limits;
    ready_.fill(0);
  }

  void prepare(int y, int z) {
    auto& ready = ready_[static_cast<std::size_t>(row_of(y, z))];
    if (ready) return;
    ready = 1;
    const Size3 extent = box_.size();
    const VoxelIndex first = box_.lo + VoxelIndex(0, y, z);
    fill(0, first, row_of(y, z), extent.x - 1);
    if (y + 1 < extent.y) fill(1, first, row_of(y, z), extent.x);
    if (z + 1 < extent.z) fill(2, first, row_of(y, z), extent.x);
  }

  std::int32_t up(int axis, int lower) const { return up_[axis][static_cast<std::size_t>(lower)]; }
  std::int32_t down(int axis, int lower) const {
    return down_[axis][static_cast<std::size_t>(lower)];
  }

 private:
  void fill(int axis, VoxelIndex first, int row, int links) {
    VoxelIndex next = first;
    ++next[axis];
    if (links <= 0) return;
    const MaterialId* lower_id = halo_->row(first);
    const MaterialId* upper_id = halo_->row(next);
    const int element = row * kBrickEdge;
    std::int32_t* up = &up_[axis][static_cast<std::size_t>(element)];
    std::int32_t* down = &down_[axis][static_cast<std::size_t>(element)];
    for (int x = 0; x < links; ++x) {
      const int e = element + x;
      const std::int32_t stretch = u_ ? u_[e + kStride[axis]] - u_[e] : 0;
      const Slack slack = limits_->slack(axis, lower_id[x], upper_id[x], stretch);
      up[x] = slack.up;
      down[x] = slack.down;
    }
  }

  VoxelBox box_;
  const MaterialHalo* halo_ = nullptr;
  const std::int32_t* u_ = nullptr;
  const DirectedLimits* limits_ = nullptr;
  std::array<std::uint8_t, kBrickEdge * kBrickEdge> ready_{};
  std::vector<std::int32_t> up_[3];
  std::vector<std::int32_t> down_[3];
};

// The closure of one component of the drag.
class ComponentSolver {
 public:
  ComponentSolver(const ChainMailProblem& problem, int component, std::int32_t by)
      : problem_(problem),
        grid_(problem.start.grid()),
        limits_(problem.halos.table(), component, by < 0),
        component_(component),
        drag_(std::abs(by)),
        downwards_(by < 0),
        labels_(static_cast<std::size_t>(grid_.count())),
        pending_(static_cast<std::size_t>(grid_.count()), 0) {}

  void solve() {
    for (const auto& [linear, mask] : problem_.handle.bricks()) {
      Labels& labels = labels_of(linear);
      for (std::size_t e = 0; e < mask->size(); ++e) {
        if (!mask->test(e)) continue;
        labels.delta[e] = drag_;
        labels.rise(static_cast<int>(e) / kBrickEdge);
      }
      enqueue(linear, drag_);
    }
    while (!queue_.empty()) {
      const auto [priority, linear] = queue_.top();
      queue_.pop();
      if (priority != pending_[static_cast<std::size_t>(linear)]) continue;  // an older wish
      pending_[static_cast<std::size_t>(linear)] = 0;
      // Every label shrinks by the overshoot in the end: what is not above it ends at 0.
      if (priority > overshoot_) visit(linear);
    }
  }

  std::int32_t overshoot() const { return overshoot_; }
  std::int32_t moved_by() const { return sign() * (drag_ - overshoot_); }
  std::int64_t bricks_swept() const { return bricks_swept_; }
  std::int32_t sign() const { return downwards_ ? -1 : 1; }
  const Labels* labels(std::int64_t linear) const {
    return labels_[static_cast<std::size_t>(linear)].get();
  }

 private:
  Labels& labels_of(std::int64_t linear) {
    auto& labels = labels_[static_cast<std::size_t>(linear)];
    if (!labels) labels = std::make_unique<Labels>();
    return *labels;
  }

  void enqueue(std::int64_t linear, std::int32_t priority) {
    std::int32_t& pending = pending_[static_cast<std::size_t>(linear)];
    if (priority <= pending) return;
    pending = priority;
    queue_.push({priority, linear});
  }

  const std::int32_t* unpacked(const LatticeBrick& brick) {
    unpacked_.resize(kBrickVoxels);
    for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
      brick.read_row(component_, row, &unpacked_[static_cast<std::size_t>(row * kBrickEdge)]);
    }
    return unpacked_.data();
  }

  // u of the component at an element of a brick that may be absent.
  static std::int32_t u_of(const LatticeBrick* brick, int component, int element) {
    const DisplacementPlane* plane = brick ? brick->plane(component).get() : nullptr;
    return plane ? plane->at(element) : 0;
  }

  void visit(std::int64_t linear) {
    ++bricks_swept_;
    const BrickIndex brick = grid_.brick(linear);
    const VoxelBox box = grid_.box(brick);
    const LatticeBrick* here = problem_.start.brick(linear);
    const MaterialHalo& halo = problem_.halos.of(linear);
    Labels& labels = labels_of(linear);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) pull(brick, box, halo, axis, side, labels);
    }
    if (halo.uniform && !here) {
      UniformSlack slack;
      for (int axis = 0; axis < 3; ++axis) {
        slack.slack[static_cast<std::size_t>(axis)] =
            limits_.slack(axis, *halo.uniform, *halo.uniform, 0);
      }
      while (sweep_round(labels, box.size(), slack)) {
      }
    } else {
      slack_.begin(box, halo, here ? unpacked(*here) : nullptr, limits_);
      while (sweep_round(labels, box.size(), slack_)) {
      }
    }
    raise_overshoot(linear, box, halo, labels);
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) wish(brick, box, halo, axis, side, labels);
    }
  }

  // Calls f(own element, element beside it in the neighbour, function giving the link's slack) for
  // the links that cross one side of a brick.
  template <class F>
  void for_each_crossing(const VoxelBox& box, const MaterialHalo& halo, int axis, int side,
                         std::int64_t neighbour, F&& f) const {
    const LatticeBrick* here = problem_.start.brick(grid_.linear(BrickGrid::brick_of(box.lo)));
    const LatticeBrick* there = problem_.start.brick(neighbour);
    const int b = (axis + 1) % 3;
    const int c = (axis + 2) % 3;
    VoxelIndex own;
    own[axis] = side < 0 ? box.lo[axis] : box.hi[axis] - 1;
    for (own[c] = box.lo[c]; own[c] < box.hi[c]; ++own[c]) {
      for (own[b] = box.lo[b]; own[b] < box.hi[b]; ++own[b]) {
        VoxelIndex beside = own;
        beside[axis] += side;
        const int e = element_in_brick(own);
        const int n = element_in_brick(beside);
        f(static_cast<std::size_t>(e), static_cast<std::size_t>(n), [&] {
          const std::int32_t difference = u_of(there, component_, n) - u_of(here, component_, e);
          const MaterialId own_id = halo.at(own);
          const MaterialId beside_id = halo.at(beside);
          return side < 0 ? limits_.slack(axis, beside_id, own_id, -difference)
                          : limits_.slack(axis, own_id, beside_id, difference);
        });
      }
    }
  }

  std::int64_t neighbour_of(BrickIndex brick, int axis, int side) const {
    brick[axis] += side;
    return grid_.contains(brick) ? grid_.linear(brick) : -1;
  }

  // Takes what the labels of a neighbour push across a side.
  void pull(BrickIndex brick, const VoxelBox& box, const MaterialHalo& halo, int axis, int side,
            Labels& labels) const {
    const std::int64_t neighbour = neighbour_of(brick, axis, side);
    if (neighbour < 0 || !labels_[static_cast<std::size_t>(neighbour)]) return;
    const Labels& theirs = *labels_[static_cast<std::size_t>(neighbour)];
    for_each_crossing(box, halo, axis, side, neighbour,
                      [&](std::size_t e, std::size_t n, const auto& slack) {
                        if (theirs.delta[n] <= labels.delta[e]) return;
                        const Slack s = slack();
                        const std::int32_t pushed = theirs.delta[n] - (side < 0 ? s.up : s.down);
                        if (pushed <= labels.delta[e]) return;
                        labels.delta[e] = pushed;
                        labels.rise(static_cast<int>(e) / kBrickEdge);
                      });
  }

  // Asks for a visit of a neighbour if a label would rise there.
  void wish(BrickIndex brick, const VoxelBox& box, const MaterialHalo& halo, int axis, int side,
            const Labels& labels) {
    const std::int64_t neighbour = neighbour_of(brick, axis, side);
    if (neighbour < 0) return;
    const Labels* theirs = labels_[static_cast<std::size_t>(neighbour)].get();
    std::int32_t highest = 0;
    for_each_crossing(box, halo, axis, side, neighbour,
                      [&](std::size_t e, std::size_t n, const auto& slack) {
                        const std::int32_t label = theirs ? theirs->delta[n] : 0;
                        if (labels.delta[e] <= std::max(label, highest)) return;
                        const Slack s = slack();
                        const std::int32_t pushed = labels.delta[e] - (side < 0 ? s.down : s.up);
                        if (pushed > label) highest = std::max(highest, pushed);
                      });
    if (highest > 0) enqueue(neighbour, highest);
  }

  void raise_overshoot(std::int64_t linear, const VoxelBox& box, const MaterialHalo& halo,
                       const Labels& labels) {
    if (const ElementSet::Mask* pinned = problem_.pinned.brick(linear)) {
      for (std::size_t e = 0; e < pinned->size(); ++e) {
        if (pinned->test(e)) overshoot_ = std::max(overshoot_, labels.delta[e]);
      }
    }
    const MaterialTable& table = problem_.halos.table();
    const bool fixed_material = table.any_fixed() && (!halo.uniform || table.fixed(*halo.uniform));
    const Size3 size = grid_.volume_size();
    const bool at_face =
        problem_.anchors.faces != 0 && (glm::any(glm::equal(box.lo, VoxelIndex(0))) ||
                                        glm::any(glm::equal(box.hi, VoxelIndex(size))));
    if (!fixed_material && !at_face) return;
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        if (!labels.reached(row_of(y & 31, z & 31))) continue;
        const MaterialId* ids = halo.row({box.lo.x, y, z});
        for (int x = box.lo.x; x < box.hi.x; ++x) {
          const VoxelIndex voxel{x, y, z};
          const std::int32_t label =
              labels.delta[static_cast<std::size_t>(element_in_brick(voxel))];
          if (label <= overshoot_) continue;
          if ((fixed_material && table.fixed(ids[x - box.lo.x])) ||
              (at_face && (faces_of(voxel, size) & problem_.anchors.faces))) {
            overshoot_ = label;
          }
        }
      }
    }
  }

  const ChainMailProblem& problem_;
  const BrickGrid& grid_;
  DirectedLimits limits_;
  int component_;
  std::int32_t drag_;
  bool downwards_;
  std::int32_t overshoot_ = 0;
  std::int64_t bricks_swept_ = 0;
  std::vector<std::unique_ptr<Labels>> labels_;
  std::vector<std::int32_t> pending_;
  std::priority_queue<std::pair<std::int32_t, std::int64_t>> queue_;
  VaryingSlack slack_;
  std::vector<std::int32_t> unpacked_;
};

}  // namespace

ChainMailAnswer solve_chainmail(const ChainMailProblem& problem, glm::ivec3 by) {
  const trace::Span span("chainmail");
  const BrickGrid& grid = problem.start.grid();
  ChainMailAnswer answer;
  answer.lattice = problem.start;
  std::vector<std::unique_ptr<ComponentSolver>> solvers;
  std::array<const ComponentSolver*, 3> solver_of{};
  for (int c = 0; c < 3; ++c) {
    if (by[c] == 0) continue;
    solvers.push_back(std::make_unique<ComponentSolver>(problem, c, by[c]));
    solvers.back()->solve();
    solver_of[static_cast<std::size_t>(c)] = solvers.back().get();
    answer.moved_by[c] = solvers.back()->moved_by();
    answer.clamped = answer.clamped || solvers.back()->overshoot() > 0;
    answer.bricks_swept += solvers.back()->bricks_swept();
  }
  if (solvers.empty()) return answer;

  std::vector<std::uint8_t> moved(kBrickVoxels);
  for (std::int64_t linear = 0; linear < grid.count(); ++linear) {
    std::unique_ptr<BrickDisplacements> brick;
    for (std::size_t c = 0; c < 3; ++c) {
      const Labels* labels = solver_of[c] ? solver_of[c]->labels(linear) : nullptr;
      if (!labels) continue;
      const std::int32_t overshoot = solver_of[c]->overshoot();
      const std::int32_t sign = solver_of[c]->sign();
      const auto& delta = labels->delta;
      for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
        if (!labels->reached(row)) continue;
        const auto begin = static_cast<std::size_t>(row) * kBrickEdge;
        const auto end = begin + kBrickEdge;
        if (*std::max_element(&delta[begin], &delta[begin] + kBrickEdge) <= overshoot) continue;
        if (!brick) {
          const LatticeBrick* start = problem.start.brick(linear);
          brick = std::make_unique<BrickDisplacements>();
          for (int c2 = 0; start && c2 < 3; ++c2) {
            for (int r = 0; r < kBrickEdge * kBrickEdge; ++r) {
              start->read_row(c2, r, &brick->u[c2][r * kBrickEdge]);
            }
          }
          std::fill(moved.begin(), moved.end(), std::uint8_t{0});
        }
        for (std::size_t e = begin; e < end; ++e) {
          const std::int32_t by_label = std::max(0, delta[e] - overshoot);
          brick->u[c][e] += sign * by_label;
          moved[e] |= by_label > 0;
        }
      }
    }
    if (!brick) continue;
    answer.elements_moved += std::count(moved.begin(), moved.end(), std::uint8_t{1});
    answer.lattice.set(linear, LatticeBrick::create(grid.box(grid.brick(linear)), *brick));
  }
  return answer;
}

}  // namespace maille
