#include "deform/open_rounding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/trace.h"
#include "deform/cell_rows.h"
#include "deform/spring_rows.h"

namespace maille {
namespace {

// J is a product of three edges; of each, either end may be off by half a unit along each axis.
double most_change(double longest_edge) {
  const double e = std::sqrt(3.0) / kUnitsPerVoxel;
  return ((3.0 * longest_edge + 3.0 * e) * longest_edge + e * e) * e;
}

std::vector<CellCorner> corners_at_risk(const FoldEnergy& folds, WorkerPool& pool) {
  const SpringBox& box = folds.box();
  const Size3 extent = box.extent();
  std::vector<std::vector<CellCorner>> found(static_cast<std::size_t>(extent.z));
  pool.for_each(extent.z - 1, [&](std::int64_t plane, int) {
    auto& corners = found[static_cast<std::size_t>(plane)];
    for (int y = 0; y < extent.y - 1; ++y) {
      const std::int64_t row = box.row(y, static_cast<int>(plane)) * extent.x;
      for (int x0 = 0; x0 < extent.x - 1; x0 += kLongestRun) {
        const int count = std::min(kLongestRun, extent.x - 1 - x0);
        float least[kLongestRun];
        const auto measure = measure_cells(box, row + x0, count, least);
        const double risk = most_change(double{measure.longest_edge});
        if (double{measure.least} > risk) continue;
        for (int x = 0; x < count; ++x) {
          if (double{least[x]} > risk) continue;
          folds.for_each_corner_of_cell(row + x0 + x, [&](const CellCorner& corner) {
            if (folds.determinant(corner) <= risk) corners.push_back(corner);
          });
        }
      }
    }
  });
  std::vector<CellCorner> all;
  for (const auto& corners : found) all.insert(all.end(), corners.begin(), corners.end());
  std::sort(all.begin(), all.end());
  return all;
}

bool is_open(const FoldEnergy& folds, std::int64_t cell) {
  bool open = true;
  folds.for_each_corner_of_cell(
      cell, [&](const CellCorner& corner) { open = open && folds.determinant(corner) > 0.0; });
  return open;
}

// The state in fixed point, as far as it has been looked at.
class RoundedState {
 public:
  explicit RoundedState(const FoldEnergy& folds) : folds_(folds), box_(folds.box()) {}

  glm::dvec3 nearest(std::int64_t e) const {
    return glm::round(glm::dvec3(box_.u_mm()[0][e], box_.u_mm()[1][e], box_.u_mm()[2][e]) /
                      box_.spacing_mm() * double{kUnitsPerVoxel});
  }
  glm::dvec3 units(std::int64_t e) const {
    const auto it = elsewhere_.find(e);
    return it == elsewhere_.end() ? nearest(e) : it->second;
  }
  void put(std::int64_t e, glm::dvec3 units) { elsewhere_[e] = units; }

  double determinant(const CellCorner& corner) const {
    const auto elements = folds_.elements_of(corner);
    const glm::dvec3 center = units(elements[0]);
    glm::dmat3 edges(1.0);
    for (int axis = 0; axis < 3; ++axis) {
      const double sign = (corner.signs >> axis) & 1 ? -1.0 : 1.0;
      edges[axis] +=
          sign / kUnitsPerVoxel * (units(elements[static_cast<std::size_t>(axis + 1)]) - center);
    }
    return glm::determinant(edges);
  }

  // The least of an element's corners that are open in the state as it is.
  double least_at(std::int64_t e) const {
    double least = std::numeric_limits<double>::infinity();
    folds_.for_each_corner_at(e, [&](const CellCorner& corner) {
      if (folds_.determinant(corner) > 0.0) least = std::min(least, determinant(corner));
    });
    return least;
  }

  const std::map<std::int64_t, glm::dvec3>& elsewhere() const { return elsewhere_; }

 private:
  const FoldEnergy& folds_;
  const SpringBox& box_;
  std::map<std::int64_t, glm::dvec3> elsewhere_;
};

// Moves the one of a corner's elements that opens most of what is around it.
void open(const CellCorner& corner, const FoldEnergy& folds, RoundedState& state) {
  std::int64_t best_element = -1;
  glm::dvec3 best_units(0.0);
  double best = -std::numeric_limits<double>::infinity();
  for (const std::int64_t e : folds.elements_of(corner)) {
    if (!folds.box().is_free(e)) continue;
    const glm::dvec3 nearest = state.nearest(e);
    const glm::dvec3 now = state.units(e);
    const double least = state.least_at(e);
    for (int choice = 0; choice < 27; ++choice) {
      const glm::dvec3 there =
          nearest + glm::dvec3(choice % 3 - 1, choice / 3 % 3 - 1, choice / 9 - 1);
      state.put(e, there);
      const double then = state.least_at(e);
      if (then > std::max(best, least)) {
        best = then;
        best_element = e;
        best_units = there;
      }
    }
    state.put(e, now);
  }
  if (best_element >= 0) state.put(best_element, best_units);
}

}  // namespace

OpenRounding open_rounding(const SpringBox& box, WorkerPool& pool) {
  const trace::Span span("rounding without folds");
  const FoldEnergy folds(box);
  OpenRounding rounding;
  rounding.at_risk = corners_at_risk(folds, pool);
  RoundedState state(folds);
  // Each may fold others again, or none of its choices be any better.
  constexpr int kMostRounds = 4;
  int attempts = 200;
  bool all_open = false;
  for (int round = 0; round < kMostRounds && !all_open; ++round) {
    all_open = true;
    for (const CellCorner& corner : rounding.at_risk) {
      if (state.determinant(corner) > 0.0 || !is_open(folds, folds.cell_of(corner))) continue;
      all_open = false;
      if (attempts-- > 0) open(corner, folds, state);
    }
  }
  for (const auto& [e, units] : state.elsewhere()) {
    if (units != state.nearest(e)) {
      rounding.elsewhere.emplace_back(e, units * box.spacing_mm() / double{kUnitsPerVoxel});
    }
  }
  return rounding;
}

}  // namespace maille
