#include "resample/displacement_tile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/several_widths.h"

namespace maille {
namespace {

constexpr float kVoxelsFromUnits = 1.0f / kUnitsPerVoxel;

// Of the elements of a row, and of those a step on from them: four at a time.
MAILLE_FOR_SEVERAL_WIDTHS
void take_edges(const Float4* at, std::ptrdiff_t step, int count, std::size_t axis,
                EdgeBounds& bounds) {
  using Four = float __attribute__((vector_size(64)));
  Four lowest = Four{} + std::numeric_limits<float>::max();
  Four highest = -lowest;
  int x = 0;
  for (; x + 4 <= count; x += 4) {
    Four from, to;
    __builtin_memcpy(&from, at + x, sizeof from);
    __builtin_memcpy(&to, at + x + step, sizeof to);
    const Four edge = to - from;
    lowest = edge < lowest ? edge : lowest;
    highest = edge > highest ? edge : highest;
  }
  Float4 parts[2][4];
  __builtin_memcpy(parts[0], &lowest, sizeof lowest);
  __builtin_memcpy(parts[1], &highest, sizeof highest);
  Float4& lowest_of_all = bounds.lowest[axis];
  Float4& highest_of_all = bounds.highest[axis];
  for (int i = 0; i < 4; ++i) {
    lowest_of_all = least(lowest_of_all, parts[0][i]);
    highest_of_all = greatest(highest_of_all, parts[1][i]);
  }
  for (; x < count; ++x) {
    const Float4 edge = at[x + step] - at[x];
    lowest_of_all = least(lowest_of_all, edge);
    highest_of_all = greatest(highest_of_all, edge);
  }
}

// The fourth lane: 1 where it has moved.
MAILLE_FOR_SEVERAL_WIDTHS
void write_out(const std::int32_t (&u)[3][kBrickEdge], glm::ivec3 common, int count, Float4* to) {
  auto* const lanes = reinterpret_cast<float*>(to);
  for (int i = 0; i < count; ++i) {
    const bool moved = (u[0][i] | u[1][i] | u[2][i]) != 0;
    lanes[4 * i] = static_cast<float>(u[0][i] - common.x) * kVoxelsFromUnits;
    lanes[4 * i + 1] = static_cast<float>(u[1][i] - common.y) * kVoxelsFromUnits;
    lanes[4 * i + 2] = static_cast<float>(u[2][i] - common.z) * kVoxelsFromUnits;
    lanes[4 * i + 3] = moved ? 1.0f : 0.0f;
  }
}

}  // namespace

void DisplacementTile::fill(const Lattice& lattice, const VoxelBox& elements) {
  elements_ = elements;
  width_ = elements.size().x;
  height_ = elements.size().y;
  depth_ = elements.size().z;
  constexpr auto kBytes = static_cast<std::ptrdiff_t>(sizeof(Float4));
  step_x_ = width_ > 1 ? kBytes : 0;
  step_y_ = height_ > 1 ? kBytes * width_ : 0;
  step_z_ = depth_ > 1 ? kBytes * width_ * height_ : 0;
  last_ = glm::vec3(elements.size() - 1);
  last_cell_ = glm::max(last_ - 1.0f, glm::vec3(0));
  u_.resize(static_cast<std::size_t>(voxel_count(elements.size())));
  const BrickGrid& grid = lattice.grid();
  common_voxels_ = lattice.u((elements.lo + elements.hi) / 2) / kUnitsPerVoxel;
  const glm::ivec3 common = common_voxels_ * kUnitsPerVoxel;
  const Float4 at_rest =
      -Float4{static_cast<float>(common_voxels_.x), static_cast<float>(common_voxels_.y),
              static_cast<float>(common_voxels_.z), 0.0f};
  Float4* out = u_.data();
  for (int z = elements.lo.z; z < elements.hi.z; ++z) {
    for (int y = elements.lo.y; y < elements.hi.y; ++y) {
      for (int x = elements.lo.x; x < elements.hi.x;) {
        const int end = std::min(elements.hi.x, (x | 31) + 1);
        const LatticeBrick* const brick =
            lattice.brick(grid.linear(BrickGrid::brick_of({x, y, z})));
        if (!brick) {
          out = std::fill_n(out, end - x, at_rest);
          x = end;
          continue;
        }
        std::int32_t u[3][kBrickEdge];
        const int count = end - x;
        for (int c = 0; c < 3; ++c) brick->read_row(c, element_in_brick({x, y, z}), count, u[c]);
        write_out(u, common, count, out);
        out += count;
        x = end;
      }
    }
  }
}

DisplacementTile::Injection DisplacementTile::injection(bool with_beyond) const {
  EdgeBounds edges;
  const std::array<std::ptrdiff_t, 3> steps = {step_x_, step_y_, step_z_};
  const auto take = [&](const Float4* at, int count, std::size_t axis) {
    take_edges(at, steps[axis] / static_cast<std::ptrdiff_t>(sizeof(Float4)), count, axis, edges);
  };
  for (int z = 0; z < depth_; ++z) {
    for (int y = 0; y < height_; ++y) {
      const Float4* const at = row(y, z);
      take(at, width_ - 1, 0);
      if (y + 1 < height_) take(at, width_, 1);
      if (z + 1 < depth_) take(at, width_, 2);
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (with_beyond || steps[axis] == 0) edges.take(axis, Float4{});
  }
  return injection_of(edges);
}

DisplacementTile::Injection DisplacementTile::injection_of(const EdgeBounds& edges) {
  glm::dmat3 middle(1.0);
  glm::dmat3 away(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const Float4 lowest = edges.lowest[static_cast<std::size_t>(axis)];
    const Float4 highest = edges.highest[static_cast<std::size_t>(axis)];
    for (int c = 0; c < 3; ++c) {
      middle[axis][c] += 0.5 * (double{lowest[c]} + double{highest[c]});
      away[axis][c] = 0.5 * (double{highest[c]} - double{lowest[c]});
    }
  }
  constexpr double kFlat = 1e-6;
  if (!(std::abs(glm::determinant(middle)) > kFlat)) {
    Injection none;
    none.share = std::numeric_limits<double>::infinity();
    return none;
  }
  const glm::dmat3 inverse = glm::inverse(middle);
  const glm::dmat3 sizes(glm::abs(inverse[0]), glm::abs(inverse[1]), glm::abs(inverse[2]));
  Injection injection;
  injection.inverse = glm::mat3(inverse);
  injection.spread = sizes * away;
  for (int c = 0; c < 3; ++c) {
    const double sum = injection.spread[0][c] + injection.spread[1][c] + injection.spread[2][c];
    injection.share = std::max(injection.share, sum);
    double extent = 0.0;
    for (int axis = 0; axis < 3; ++axis) extent += std::abs(middle[axis][c]) + away[axis][c];
    injection.largest_cell_voxels[c] = static_cast<float>(extent);
  }
  return injection;
}

// max_c (spread w)_c / w_c bounds how much the spread can lengthen a vector in the norm
// max_c |v_c| / w_c; it is least for the spread's eigenvector of no negative component.
double DisplacementTile::Injection::contraction() const {
  if (!std::isfinite(share)) return share;
  constexpr int kSteps = 6;
  // No component is taken for more than so many times another, or what is near in this norm would
  // not be near.
  constexpr double kLeast = 1.0 / 16;
  glm::dvec3 weight(1.0);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kSteps; ++i) {
    const glm::dvec3 lengthened = spread * weight;
    const glm::dvec3 by = lengthened / weight;
    least = std::min(least, std::max({by.x, by.y, by.z}));
    const double largest = std::max({lengthened.x, lengthened.y, lengthened.z});
    if (!(largest > 0.0) || !std::isfinite(largest)) break;
    weight = glm::max(lengthened / largest, glm::dvec3(kLeast));
  }
  return least;
}

}  // namespace maille
