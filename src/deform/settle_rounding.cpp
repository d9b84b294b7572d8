#include "deform/settle_rounding.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/trace.h"

namespace maille {
namespace {

// Of the springs at an element, displaced by u: stiffness * mm^2.
double energy_at(const SpringBox& box, const BoxVectors& u_mm, std::int64_t e, glm::dvec3 u) {
  double sum = 0.0;
  for (int s = 0; s < kSprings; ++s) {
    const double k = double{box.stiffness(e, s)};
    if (!(k > 0.0)) continue;
    const std::int64_t j = e + box.step(s);
    const glm::dvec3 rest_mm(box.springs()[static_cast<std::size_t>(s)].rest_mm);
    const glm::dvec3 kept_mm = box.kept_mm(e, s);
    const glm::dvec3 du = u - at_element(u_mm, j);
    const double stretch = glm::length(rest_mm + du) - glm::length(rest_mm + kept_mm);
    const glm::dvec3 off = du - kept_mm;
    const double b = 0.5 * (double{box.blend(e)} + double{box.blend(j)});
    sum += 0.5 * k * ((1.0 - b) * stretch * stretch + b * glm::dot(off, off));
  }
  return sum;
}

}  // namespace

void settle_rounding(const SpringBox& box, const std::vector<CellCorner>& kept,
                     BoxVectors& rounded_mm, WorkerPool& pool) {
  const trace::Span span("settled rounding");
  constexpr int kMostSweeps = 12;
  const FoldEnergy folds(box);
  std::vector<std::int64_t> left_alone;
  for (const CellCorner& corner : kept) {
    for (const std::int64_t e : folds.elements_of(corner)) left_alone.push_back(e);
  }
  std::sort(left_alone.begin(), left_alone.end());
  const Size3 extent = box.extent();
  const glm::dvec3 unit_mm = box.spacing_mm() / double{kUnitsPerVoxel};
  const auto settle = [&](std::int64_t e) {
    const glm::dvec3 exact = at_element(box.u_mm(), e);
    glm::dvec3 best = at_element(rounded_mm, e);
    const glm::dvec3 before = best;
    double least = energy_at(box, rounded_mm, e, best);
    for (int c = 0; c < 3; ++c) {
      for (const double by : {-1.0, 1.0}) {
        glm::dvec3 there = best;
        there[c] += by * unit_mm[c];
        if (std::abs(there[c] - exact[c]) > unit_mm[c]) continue;
        const double energy = energy_at(box, rounded_mm, e, there);
        if (energy < least) {
          least = energy;
          best = there;
        }
      }
    }
    for (int c = 0; c < 3; ++c) {
      // On the same float as a displacement that is rounded straight away.
      const auto units = static_cast<float>(std::nearbyint(best[c] / unit_mm[c]));
      rounded_mm[static_cast<std::size_t>(c)][e] = units * static_cast<float>(unit_mm[c]);
    }
    return best != before;
  };
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    std::atomic<bool> any = false;
    // No two of a colour share a spring.
    for (int colour = 0; colour < 8; ++colour) {
      pool.for_each((extent.z - 1) / 2, [&](std::int64_t i, int) {
        const int z = 1 + 2 * static_cast<int>(i) + (colour >> 2);
        if (z >= extent.z - 1) return;
        for (int y = 1 + ((colour >> 1) & 1); y < extent.y - 1; y += 2) {
          if (box.kind(box.row(y, z)) == RowKind::held) continue;
          for (int x = 1 + (colour & 1); x < extent.x - 1; x += 2) {
            const std::int64_t e = box.element(x, y, z);
            if (!box.is_free(e) || std::binary_search(left_alone.begin(), left_alone.end(), e))
              continue;
            if (settle(e)) any.store(true, std::memory_order_relaxed);
          }
        }
      });
    }
    if (!any) break;
  }
}

}  // namespace maille
