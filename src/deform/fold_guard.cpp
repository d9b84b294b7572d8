#include "deform/fold_guard.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <limits>
#include <span>

#include "core/trace.h"
#include "deform/cell_rows.h"
#include "deform/fold_batch.h"
#include "deform/fold_cluster.h"
#include "deform/spring_rows.h"

namespace maille {
namespace {

// Elements at corners below this are moved one by one.
constexpr double kNear = 1.05 * kFoldReach;
// Of J of floats, a product of three edges, in units of the longest edge cubed.
constexpr double kDeterminantRounding = 16 * 0x1p-24;
constexpr int kMostSweeps = 20;
// Of elements in all sweeps of one step, unless some sweeps take more: far from equilibrium many
// are near folding that will not be for long.
constexpr std::size_t kMostMoves = 80'000;
constexpr int kFewSweeps = 4;
// Moves one by one go on in the same direction from sweep to sweep: 20 sweeps that go further win
// as much as 200 that do not (1.3, 1.6 and 1.8 measured). The last ones leave nothing over; around
// folded cells, where the energy has a kink, it would never come to rest.
constexpr double kFurther = 1.6;
constexpr int kPlainSweeps = 2;
constexpr std::size_t kLargestCluster = 200;

double largest_component_voxels(const SpringBox& box, WorkerPool& pool) {
  const Size3 extent = box.extent();
  std::vector<float> largest(static_cast<std::size_t>(extent.z));
  pool.for_each(extent.z, [&](std::int64_t plane, int) {
    const std::int64_t begin = plane * extent.x * extent.y;
    largest[static_cast<std::size_t>(plane)] =
        largest_square(&box.u_mm()[0][begin], &box.u_mm()[1][begin], &box.u_mm()[2][begin],
                       glm::vec3(1.0 / box.spacing_mm()), extent.x * extent.y);
  });
  return std::sqrt(double{*std::max_element(largest.begin(), largest.end())});
}

// A row of a direction in floats, whatever it is kept as.
class RowOfDirection {
 public:
  explicit RowOfDirection(int columns) : columns_(columns) {}

  std::array<const float*, 3> of(const BoxVectors& direction, std::int64_t row) {
    const std::int64_t begin = row * columns_;
    return {&direction[0][begin], &direction[1][begin], &direction[2][begin]};
  }
  std::array<const float*, 3> of(const BoxDirection& direction, std::int64_t row) {
    const auto columns = static_cast<std::size_t>(columns_);
    buffer_.resize(3 * columns);
    float* const x = buffer_.data();
    direction.get_row(row, x, x + columns, x + 2 * columns);
    return {x, x + columns, x + 2 * columns};
  }

 private:
  int columns_;
  std::vector<float> buffer_;
};

template <class T>
void sort_once(std::vector<T>& v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
}

}  // namespace

FoldGuard::FoldGuard(SpringBox& box, WorkerPool& pool)
    : box_(box),
      pool_(pool),
      folds_(box, largest_component_voxels(box, pool)),
      rows_(static_cast<std::size_t>(box.extent().y) * static_cast<std::size_t>(box.extent().z)) {
  find_bent(find_near(0.0), {});
}

std::vector<CellCorner> FoldGuard::find_near(double furthest_voxels) {
  travelled_voxels_ += furthest_voxels;
  const trace::Span span("cells near folding");
  const Size3 extent = box_.extent();
  std::vector<std::vector<CellCorner>> found(static_cast<std::size_t>(extent.z));
  pool_.for_each(extent.z - 1, [&](std::int64_t plane, int) {
    auto& corners = found[static_cast<std::size_t>(plane)];
    for (int y = 0; y < extent.y - 1; ++y) {
      const std::int64_t r = box_.row(y, static_cast<int>(plane));
      RowMeasure& row = rows_[static_cast<std::size_t>(r)];
      if (row.travelled >= 0.0) {
        // An edge changes by what both its ends have moved; J is a product of three.
        const double d = 2.0 * (travelled_voxels_ - row.travelled);
        const double e = double{row.longest_edge};
        const double rounding = kDeterminantRounding * e * e * e;
        if (double{row.least} - rounding - ((3.0 * e + 3.0 * d) * e + d * d) * d > kNear) continue;
      }
      row = {std::numeric_limits<float>::max(), 0.0f, travelled_voxels_};
      for (int x0 = 0; x0 < extent.x - 1; x0 += kLongestRun) {
        const int count = std::min(kLongestRun, extent.x - 1 - x0);
        float least[kLongestRun];
        const auto measure = measure_cells(box_, r * extent.x + x0, count, least);
        row.least = std::min(row.least, measure.least);
        row.longest_edge = std::max(row.longest_edge, measure.longest_edge);
        const double longest = double{measure.longest_edge};
        const double near = kNear + kDeterminantRounding * longest * longest * longest;
        if (double{measure.least} >= near) continue;
        for (int x = 0; x < count; ++x) {
          if (double{least[x]} >= near) continue;
          folds_.for_each_corner_of_cell(r * extent.x + x0 + x, [&](const CellCorner& corner) {
            if (folds_.determinant(corner) < kNear) corners.push_back(corner);
          });
        }
      }
    }
  });
  std::vector<CellCorner> near;
  for (const auto& corners : found) near.insert(near.end(), corners.begin(), corners.end());
  return near;
}

template <class Vectors>
double FoldGuard::advance(const Vectors& direction, double step, double furthest_voxels,
                          double enough_voxels) {
  constexpr double kFurthest = 4.0;
  step = std::min(step, kFurthest * (1.0 + folds_.largest_u_voxels()) / furthest_voxels);
  add(direction, step);
  std::vector<CellCorner> near = find_near(step * furthest_voxels);
  // Where not a few corners close but many, the step was too long for all.
  constexpr int kMostHalvings = 5;
  // More of them are not few however large the box: what is taken back from them closes others,
  // until half of it is (measured at ten million elements).
  const auto few =
      static_cast<std::size_t>(std::min<std::int64_t>(240, 100 + box_.free_elements() / 20'000));
  for (int halving = 0; halving < kMostHalvings; ++halving) {
    if (closed_by(near, direction, step) <= few) break;
    step *= 0.5;
    add(direction, -step);
    near = find_near(step * furthest_voxels);
  }
  std::vector<std::int64_t> elements = take_back(near, direction, step);
  const std::vector<std::int64_t> others = free_elements_of(near);
  elements.insert(elements.end(), others.begin(), others.end());
  sort_once(elements);
  settle(elements, enough_voxels);
  find_bent(near, elements);
  return step;
}
template double FoldGuard::advance(const BoxVectors&, double, double, double);
template double FoldGuard::advance(const BoxDirection&, double, double, double);

bool FoldGuard::leap(const BoxVectors& direction, double furthest_voxels, double enough_voxels,
                     BoxVectors& scratch) {
  const trace::Span span("leap");
  for (std::size_t c = 0; c < 3; ++c) scratch[c].take_values_of(box_.u_mm()[c]);
  add(direction, 1.0);
  folds_.set_folded_slope(kOpeningSlope);
  const bool open = open_folded(find_near(furthest_voxels), enough_voxels);
  folds_.set_folded_slope(kFoldedSlope);
  if (open) {
    find_bent(find_near(0.0), {});
    return true;
  }
  std::swap(box_.u_mm(), scratch);
  for (RowMeasure& row : rows_) row.travelled = -1.0;
  return false;
}

// Settles what is near folding, then what is around the corners that are still folded, further
// around where that opens too few.
bool FoldGuard::open_folded(std::vector<CellCorner> near, double enough_voxels) {
  constexpr int kMostRounds = 16;
  constexpr std::size_t kFew = 8;  // corners: worth opening however slowly
  constexpr double kStalled = 0.75;
  std::vector<std::int64_t> elements = free_elements_of(near);
  int rings = 2;
  int stalled = 0;
  std::size_t last = std::numeric_limits<std::size_t>::max();
  for (int round = 0; round < kMostRounds; ++round) {
    settle(elements, enough_voxels);
    std::vector<CellCorner> folded = find_near(0.0);
    std::erase_if(folded, [&](const CellCorner& corner) {
      const glm::dmat3 edges = folds_.edges(corner);
      const double least = folds_.least_open(FoldEnergy::cofactors(edges));
      return !folds_.is_guarded(corner) || glm::determinant(edges) > least;
    });
    if (folded.empty()) return true;
    if (static_cast<double>(folded.size()) > kStalled * static_cast<double>(last)) {
      ++rings;
      if (++stalled > 1 && folded.size() > kFew) return false;
    }
    last = folded.size();
    elements = free_elements_of(folded);
    for (int ring = 0; ring < rings; ++ring) add_neighbours(elements);
  }
  return false;
}

std::vector<std::int64_t> FoldGuard::free_elements_of(
    const std::vector<CellCorner>& corners) const {
  std::vector<std::int64_t> elements;
  for (const CellCorner& corner : corners) {
    for (const std::int64_t e : folds_.elements_of(corner)) {
      if (box_.is_free(e)) elements.push_back(e);
    }
  }
  sort_once(elements);
  return elements;
}

// Those that are free along the axes.
void FoldGuard::add_neighbours(std::vector<std::int64_t>& elements) const {
  const std::size_t count = elements.size();
  for (std::size_t i = 0; i < count; ++i) {
    for (int s = 0; s < 6; ++s) {
      const std::int64_t e = elements[i] + box_.step(s);
      if (box_.is_free(e)) elements.push_back(e);
    }
  }
  sort_once(elements);
}

template <class Vectors>
void FoldGuard::add(const Vectors& direction, double step) {
  const Size3 extent = box_.extent();
  const auto by = static_cast<float>(step);
  pool_.for_each(extent.z, [&](std::int64_t plane, int) {
    RowOfDirection row_of(extent.x);
    for (std::int64_t row = plane * extent.y; row < (plane + 1) * extent.y; ++row) {
      const std::int64_t begin = row * extent.x;
      const auto parts = row_of.of(direction, row);
      for (std::size_t c = 0; c < 3; ++c) {
        float* const u = &box_.u_mm()[c][begin];
        const float* const d = parts[c];
        for (int x = 0; x < extent.x; ++x) u[x] += by * d[x];
      }
    }
  });
}

template <class Vectors>
std::size_t FoldGuard::closed_by(const std::vector<CellCorner>& near, const Vectors& direction,
                                 double step) const {
  return static_cast<std::size_t>(std::count_if(near.begin(), near.end(), [&](const auto& corner) {
    if (!folds_.is_guarded(corner)) return false;
    const glm::dmat3 now = folds_.edges(corner);
    const glm::dmat3 before = now - step * folds_.edges_of(corner, direction);
    return closes(glm::determinant(before), glm::determinant(now), kLeft,
                  folds_.least_open(FoldEnergy::cofactors(now)));
  }));
}

// Halves the step of the elements of corners that it closed; after a few halvings none of it is
// left. Returns them.
template <class Vectors>
std::vector<std::int64_t> FoldGuard::take_back(const std::vector<CellCorner>& near,
                                               const Vectors& direction, double step) {
  constexpr std::array<double, 6> kShares = {1.0, 0.5, 0.25, 0.125, 0.0625, 0.0};
  std::vector<std::pair<std::int64_t, int>> taken_back;  // element and how often, by element
  const auto times = [&](std::int64_t e) {
    const auto it = std::lower_bound(taken_back.begin(), taken_back.end(), std::pair{e, 0});
    return it != taken_back.end() && it->first == e ? it->second : 0;
  };
  // Where an element was: what is left of its step taken off again.
  const auto before = [&](const CellCorner& corner) {
    glm::dmat3 edges = folds_.edges(corner);
    const auto elements = folds_.elements_of(corner);
    for (int axis = 0; axis < 3; ++axis) {
      const double sign = (corner.signs >> axis) & 1 ? -1.0 : 1.0;
      const std::int64_t other = elements[static_cast<std::size_t>(axis + 1)];
      const glm::dvec3 moved =
          step * (kShares[static_cast<std::size_t>(times(other))] * at_element(direction, other) -
                  kShares[static_cast<std::size_t>(times(elements[0]))] *
                      at_element(direction, elements[0]));
      edges[axis] -= sign * moved / box_.spacing_mm();
    }
    return glm::determinant(edges);
  };
  const auto is_closed = [&](const CellCorner& corner) {
    if (!folds_.is_guarded(corner)) return false;
    const glm::dmat3 now = folds_.edges(corner);
    return closes(before(corner), glm::determinant(now), kLeft,
                  folds_.least_open(FoldEnergy::cofactors(now)));
  };
  std::vector<CellCorner> closed;
  for (const CellCorner& corner : near) {
    if (is_closed(corner)) closed.push_back(corner);
  }
  while (!closed.empty()) {
    std::vector<std::int64_t> halve;
    for (const CellCorner& corner : closed) {
      for (const std::int64_t e : folds_.elements_of(corner)) {
        if (box_.is_free(e) && times(e) + 1 < static_cast<int>(kShares.size())) halve.push_back(e);
      }
    }
    sort_once(halve);
    if (halve.empty()) break;
    std::vector<std::pair<std::int64_t, int>> merged;
    auto old = taken_back.begin();
    for (const std::int64_t e : halve) {
      const int n = times(e);
      const double off =
          kShares[static_cast<std::size_t>(n)] - kShares[static_cast<std::size_t>(n + 1)];
      const glm::dvec3 back_mm = step * off * at_element(direction, e);
      for (int c = 0; c < 3; ++c) {
        box_.u_mm()[static_cast<std::size_t>(c)][e] -= static_cast<float>(back_mm[c]);
      }
      while (old != taken_back.end() && old->first < e) merged.push_back(*old++);
      if (old != taken_back.end() && old->first == e) ++old;
      merged.emplace_back(e, n + 1);
    }
    merged.insert(merged.end(), old, taken_back.end());
    taken_back = std::move(merged);
    std::vector<CellCorner> candidates;
    for (const std::int64_t e : halve) {
      folds_.for_each_corner_at(e, [&](const CellCorner& corner) { candidates.push_back(corner); });
    }
    sort_once(candidates);
    closed.clear();
    for (const CellCorner& corner : candidates) {
      if (is_closed(corner)) closed.push_back(corner);
    }
  }
  std::vector<std::int64_t> elements;
  elements.reserve(taken_back.size());
  for (const auto& [e, n] : taken_back) elements.push_back(e);
  return elements;
}

void FoldGuard::settle(const std::vector<std::int64_t>& elements, double enough_voxels) {
  if (elements.empty()) return;
  const trace::Span span("elements near folding");
  std::array<std::vector<std::int64_t>, 8> elements_of_color;
  for (const std::int64_t e : elements) {
    elements_of_color[static_cast<std::size_t>(FoldBatch::color_of(box_, e))].push_back(e);
  }
  std::array<std::vector<FoldBatch>, 8> batches_of_color;
  pool_.for_each(8, [&](std::int64_t color, int) {
    const std::span<const std::int64_t> all = elements_of_color[static_cast<std::size_t>(color)];
    auto& batches = batches_of_color[static_cast<std::size_t>(color)];
    constexpr std::size_t kLanes = FoldBatch::kLanes;
    batches.reserve((all.size() + kLanes - 1) / kLanes);
    for (std::size_t i = 0; i < all.size(); i += kLanes) {
      batches.emplace_back(folds_, all.subspan(i, std::min(kLanes, all.size() - i)));
    }
  });
  const int most_sweeps =
      std::clamp(static_cast<int>(kMostMoves / elements.size()), kFewSweeps, kMostSweeps);
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    const double share = folded_ == 0 && sweep < most_sweeps - kPlainSweeps ? kFurther : 1.0;
    double largest = 0.0;
    for (const auto& batches : batches_of_color) {
      std::vector<double> moves(batches.size());
      const auto one = [&](std::int64_t i, int) {
        moves[static_cast<std::size_t>(i)] =
            batches[static_cast<std::size_t>(i)].move_to_least_energy(folds_, box_.u_mm(), share);
      };
      // Waking workers takes as long as some hundred elements.
      constexpr std::size_t kAlone = 48;
      const auto count = static_cast<std::int64_t>(batches.size());
      if (batches.size() <= kAlone) {
        for (std::int64_t i = 0; i < count; ++i) one(i, 0);
      } else {
        pool_.for_each(count, one);
      }
      for (const double move : moves) largest = std::max(largest, move);
    }
    if (largest <= enough_voxels) break;
  }
  settle_clusters(elements);
  note_moved(elements);
}

// Moves of single elements hardly get anywhere where a pull presses layers flat between others:
// there four must move together. In larger clusters a Newton step costs more than it wins.
void FoldGuard::settle_clusters(const std::vector<std::int64_t>& elements) {
  std::vector<std::vector<std::int64_t>> clusters = connected_elements(elements, box_.extent());
  std::erase_if(clusters, [](const auto& cluster) { return cluster.size() > kLargestCluster; });
  pool_.for_each(static_cast<std::int64_t>(clusters.size()), [&](std::int64_t i, int) {
    FoldCluster cluster(folds_, std::move(clusters[static_cast<std::size_t>(i)]));
    cluster.step();
    cluster.write_to(box_.u_mm());
  });
}

// What one by one has moved is measured anew, whatever the way of all others was.
void FoldGuard::note_moved(const std::vector<std::int64_t>& elements) {
  const Size3 extent = box_.extent();
  for (const std::int64_t e : elements) {
    const std::int64_t r = e / extent.x;
    for (const std::int64_t back : {std::int64_t{0}, std::int64_t{1}}) {
      for (const std::int64_t down : {std::int64_t{0}, std::int64_t{extent.y}}) {
        rows_[static_cast<std::size_t>(r - back - down)].travelled = -1.0;
      }
    }
  }
}

void FoldGuard::find_bent(const std::vector<CellCorner>& near,
                          const std::vector<std::int64_t>& moved) {
  // By their own elements, so that none is looked at twice.
  std::vector<std::int64_t> elements;
  elements.reserve(near.size() + 7 * moved.size());
  for (const CellCorner& corner : near) elements.push_back(corner.element);
  for (const std::int64_t e : moved) {
    elements.push_back(e);
    for (int axis = 0; axis < 3; ++axis) {
      elements.push_back(e - box_.step(2 * axis));
      elements.push_back(e + box_.step(2 * axis));
    }
  }
  sort_once(elements);
  constexpr std::size_t kPart = 512;
  const std::size_t parts = (elements.size() + kPart - 1) / kPart;
  std::vector<std::vector<CellCorner>> found(parts);
  std::vector<std::int64_t> folded(parts, 0);
  pool_.for_each(static_cast<std::int64_t>(parts), [&](std::int64_t part, int) {
    const auto p = static_cast<std::size_t>(part);
    for (std::size_t i = p * kPart; i < std::min(elements.size(), (p + 1) * kPart); ++i) {
      for (std::uint8_t signs = 0; signs < 8; ++signs) {
        const CellCorner corner{elements[i], signs};
        if (!folds_.counts(corner)) continue;
        const double j = folds_.determinant(corner);
        if (j < kFoldReach) found[p].push_back(corner);
        folded[p] += j <= 0.0;
      }
    }
  });
  bent_.clear();
  folded_ = 0;
  for (std::size_t p = 0; p < parts; ++p) {
    bent_.insert(bent_.end(), found[p].begin(), found[p].end());
    folded_ += folded[p];
  }
  std::vector<std::int64_t> cells;
  for (const CellCorner& corner : bent_) {
    if (folds_.determinant(corner) <= 0.0) cells.push_back(folds_.cell_of(corner));
  }
  sort_once(cells);
  folds_.set_folded_cells(std::move(cells));
}

double FoldGuard::energy() const {
  double sum = 0.0;
  for (const CellCorner& corner : bent_) sum += folds_.energy(corner);
  return sum;
}

void FoldGuard::add_forces(BoxVectors& forces) const {
  for (const CellCorner& corner : bent_) folds_.add_forces(corner, forces);
}

double FoldGuard::curvature(const BoxDirection& direction) const {
  double sum = 0.0;
  for (const CellCorner& corner : bent_) sum += folds_.curvature(corner, direction);
  return sum;
}

std::vector<FoldGuard::SpringShare> FoldGuard::spring_shares() const {
  std::vector<std::pair<std::int64_t, double>> walls;  // element and stiffness
  for (const CellCorner& corner : bent_) {
    const glm::dmat3 by_edges = FoldEnergy::cofactors(folds_.edges(corner));
    const double j = folds_.determinant(corner);
    if (j >= kFoldReach) continue;
    const double stiffness =
        folds_.kappa(corner) * fold_penalty(j).curvature / (kFoldReach * kFoldReach);
    for (const std::int64_t e : folds_.elements_of(corner)) {
      if (!box_.is_free(e)) continue;
      const glm::dvec3 slope = by_edges * folds_.shares(corner, e) / box_.spacing_mm();
      walls.emplace_back(e, stiffness * glm::dot(slope, slope));
    }
  }
  std::sort(walls.begin(), walls.end());
  std::vector<SpringShare> shares;
  for (std::size_t i = 0; i < walls.size();) {
    const std::int64_t e = walls[i].first;
    double wall = 0.0;
    for (; i < walls.size() && walls[i].first == e; ++i) wall += walls[i].second;
    double springs = 0.0;
    for (int s = 0; s < kSprings; ++s) springs += double{box_.stiffness(e, s)};
    shares.push_back({e, static_cast<float>(std::sqrt(springs / (springs + wall)))});
  }
  return shares;
}

}  // namespace maille
