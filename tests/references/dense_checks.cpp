#include "references/dense_checks.h"

#include <algorithm>

#include "references/link_bounds.h"

namespace maille {

namespace {

// voxel: 1 voxel in the unit of u.
template <class Vector>
std::int64_t folded_cells(Size3 size, std::span<const Vector> u,
                          typename Vector::value_type voxel) {
  std::int64_t folded = 0;
  for (int z = 0; z + 1 < size.z; ++z) {
    for (int y = 0; y + 1 < size.y; ++y) {
      for (int x = 0; x + 1 < size.x; ++x) {
        const auto corner = [&](int bits) {
          return VoxelIndex(x + (bits & 1), y + (bits >> 1 & 1), z + (bits >> 2));
        };
        const auto u_of = [&](int bits) { return u[element_of(corner(bits), size)]; };
        // Most cells move as one, and those are never folded.
        bool rigid = true;
        for (int bits = 1; bits < 8; ++bits) rigid = rigid && u_of(bits) == u_of(0);
        if (rigid) continue;
        bool inside_out = false;
        for (int bits = 0; bits < 8; ++bits) {
          const auto edge = [&](int axis) {
            const int low = bits & ~(1 << axis);
            const int high = bits | 1 << axis;
            return glm::dvec3(voxel * Vector(corner(high) - corner(low)) + u_of(high) - u_of(low));
          };
          inside_out = inside_out || glm::determinant(glm::dmat3(edge(0), edge(1), edge(2))) <= 0.0;
        }
        folded += inside_out;
      }
    }
  }
  return folded;
}

}  // namespace

DenseViolations dense_violations(const DenseProblem& problem, std::span<const glm::ivec3> u) {
  const LinkBounds bounds(problem.materials);
  DenseViolations found;
  int worst = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    for_each_neighbour(i, problem.size, [&](std::size_t j, int axis, int side) {
      if (side < 0) return;  // counted from the other end
      const LinkBound& bound = bounds.of(axis, problem.ids[i], problem.ids[j]);
      const glm::ivec3 link = u[j] - u[i];
      const glm::ivec3 excess = glm::max(link - bound.upper, bound.lower - link);
      const int most = std::max({excess.x, excess.y, excess.z});
      found.links += most > 0;
      worst = std::max(worst, most);
    });
  }
  found.worst_voxels = static_cast<double>(worst) / kUnitsPerVoxel;
  return found;
}

std::int64_t dense_folded_cells(Size3 size, std::span<const glm::ivec3> u) {
  return folded_cells(size, u, kUnitsPerVoxel);
}

std::int64_t dense_folded_cells(Size3 size, std::span<const glm::dvec3> u_voxels) {
  return folded_cells(size, u_voxels, 1.0);
}

}  // namespace maille
