// What springs do to a run of neighbouring elements of a row: the inner loops of relaxation.
//
// Compiled for several vector widths, chosen when the program is loaded. Every operation is rounded
// alike in all of them, and sums are kept in eight lanes of double whatever the width, so all give
// the same bits.
#pragma once

#include <array>
#include <cstdint>

#include "deform/box_direction.h"
#include "deform/spring_box.h"

namespace maille {

inline constexpr int kLongestRun = 128;

struct SpringRun {
  RowKind kind = RowKind::plain;
  std::int64_t first = 0;                  // element
  int count = 0;                           // <= kLongestRun
  const std::uint32_t* missing = nullptr;  // of the first, for kind cut
  bool with_free_around = false;           // every spring of its elements has a free end
  bool keeps = false;                      // some of its springs rest elsewhere (springs.h)
};

// Calls f(run) for a row's elements from x = begin to x = end, cut into runs.
template <class F>
void for_each_run(const SpringBox& box, std::int64_t row, int begin, int end, F&& f) {
  const std::uint32_t* const missing = box.missing(row);
  const bool free = begin > 0 && box.all_free(row);
  const bool keeps = box.keeps(row);
  for (int x = begin; x < end; x += kLongestRun) {
    f(SpringRun{box.kind(row), row * box.extent().x + x, std::min(kLongestRun, end - x),
                missing ? missing + x : nullptr, free, keeps});
  }
}

struct RunVectors {
  alignas(64) float x[kLongestRun];
  alignas(64) float y[kLongestRun];
  alignas(64) float z[kLongestRun];
};

// Forces -dE/du on the run's elements (stiffness * mm), free or not.
void spring_forces(const SpringBox& box, const SpringRun& run, RunVectors& forces);

// Over the run's even springs with a free end, at a state and along a direction d from it.
struct SpringSums {
  double energy = 0.0;     // stiffness * mm^2
  double curvature = 0.0;  // d . H d
};
SpringSums spring_sums(const SpringBox& box, const SpringRun& run, const BoxDirection& direction);
// The sum of k |d_i - d_j|^2 over the same springs, which no curvature exceeds at any stretch.
double spring_bound(const SpringBox& box, const SpringRun& run, const BoxDirection& direction);

// The largest x^2 + y^2 + z^2 of a run of vectors, each component scaled first.
float largest_square(const float* x, const float* y, const float* z, glm::vec3 scale, int count);

// sum of a * b, and of the vectors' dot products, over the elements of a run.
double dot_of_run(const float* a, const float* b, int count);

// w_i - w_j along the springs of a run, times their stiffness, all added up: the stiffness-weighted
// graph Laplacian, the same for each component. rows[s]: w at the run's first element plus offset s
// of a 3 x 3 neighbourhood of rows, (dz + 1) * 3 + dy + 1.
struct RowsAround {
  std::array<const float*, 9> at{};
};
void laplacian(const SpringBox& box, const SpringRun& run, const std::array<RowsAround, 3>& w,
               RunVectors& out);
// Stiffness of one of the springs of each element of a run, 0 where there is none.
void stiffnesses(const SpringBox& box, const SpringRun& run, int spring, float* k);

}  // namespace maille
