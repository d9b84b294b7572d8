// The equilibrium of the springs, independent of what relaxation makes of them.
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Sparse>

#include "deform/cuts.h"
#include "volume/volume.h"

namespace maille::testing {

inline bool linked(const Cuts& cuts, VoxelIndex a, VoxelIndex b) {
  const glm::ivec3 step = glm::abs(b - a);
  const int axis = step.x ? 0 : step.y ? 1 : 2;
  return !cuts.removed(a[axis] < b[axis] ? a : b, axis);
}

// Whether there is a spring between two elements: along a link that is left, or across a face with
// a corner that both are linked to.
inline bool spring_left(const Cuts& cuts, VoxelIndex a, VoxelIndex b) {
  std::vector<VoxelIndex> corners;
  for (int axis = 0; axis < 3; ++axis) {
    if (a[axis] == b[axis]) continue;
    VoxelIndex corner = a;
    corner[axis] = b[axis];
    corners.push_back(corner);
  }
  if (corners.size() == 1) return linked(cuts, a, b);
  return std::any_of(corners.begin(), corners.end(), [&](VoxelIndex corner) {
    return linked(cuts, a, corner) && linked(cuts, corner, b);
  });
}

// Newton's method in double precision with a sparse factorisation, written from the energy alone.
inline std::vector<glm::dvec3> equilibrium(const Volume& volume,
                                           const std::vector<double>& stiffness, const Cuts& cuts,
                                           const std::vector<bool>& held,
                                           std::vector<glm::dvec3> u_mm, double blend) {
  const Size3 size = volume.size();
  const auto index = [&](VoxelIndex v) { return static_cast<int>(linear_index(v, size)); };
  struct Spring {
    int i, j;
    double k;
    glm::dvec3 rest;  // X_j - X_i
  };
  std::vector<Spring> springs;
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        const VoxelIndex i{x, y, z};
        for (const glm::ivec3 o :
             {glm::ivec3(1, 0, 0), glm::ivec3(0, 1, 0), glm::ivec3(0, 0, 1), glm::ivec3(1, 1, 0),
              glm::ivec3(1, -1, 0), glm::ivec3(1, 0, 1), glm::ivec3(1, 0, -1), glm::ivec3(0, 1, 1),
              glm::ivec3(0, 1, -1)}) {
          const VoxelIndex j = i + o;
          if (!contains(size, j) || !spring_left(cuts, i, j)) continue;
          const double si = 1.0 / stiffness[static_cast<std::size_t>(volume.value_at(i))];
          const double sj = 1.0 / stiffness[static_cast<std::size_t>(volume.value_at(j))];
          springs.push_back(
              {index(i), index(j), 2.0 / (si + sj), glm::dvec3(o) * volume.spacing_mm()});
        }
      }
    }
  }
  const int n = static_cast<int>(u_mm.size());
  for (int step = 0; step < 60; ++step) {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * n);
    std::vector<Eigen::Triplet<double>> entries;
    for (const Spring& s : springs) {
      const glm::dvec3 du =
          u_mm[static_cast<std::size_t>(s.j)] - u_mm[static_cast<std::size_t>(s.i)];
      const glm::dvec3 p = s.rest + du;
      const double l = glm::length(p);
      const double d = glm::length(s.rest);
      const glm::dvec3 direction = p / l;
      const glm::dvec3 f = s.k * ((1 - blend) * (l - d) * direction + blend * du);
      for (int a = 0; a < 3; ++a) {
        force[3 * s.i + a] += f[a];
        force[3 * s.j + a] -= f[a];
        for (int b = 0; b < 3; ++b) {
          const double same = a == b ? 1.0 : 0.0;
          const double h = s.k * ((1 - blend) * (direction[a] * direction[b] * (d / l) +
                                                 same * std::max(0.0, 1 - d / l)) +
                                  blend * same);
          entries.emplace_back(3 * s.i + a, 3 * s.i + b, h);
          entries.emplace_back(3 * s.j + a, 3 * s.j + b, h);
          entries.emplace_back(3 * s.i + a, 3 * s.j + b, -h);
          entries.emplace_back(3 * s.j + a, 3 * s.i + b, -h);
        }
      }
    }
    for (auto& entry : entries) {
      const bool row = held[static_cast<std::size_t>(entry.row() / 3)];
      const bool column = held[static_cast<std::size_t>(entry.col() / 3)];
      if (row || column) entry = {entry.row(), entry.col(), 0.0};
    }
    for (int i = 0; i < n; ++i) {
      if (!held[static_cast<std::size_t>(i)]) continue;
      for (int a = 0; a < 3; ++a) {
        force[3 * i + a] = 0.0;
        entries.emplace_back(3 * i + a, 3 * i + a, 1.0);
      }
    }
    Eigen::SparseMatrix<double> hessian(3 * n, 3 * n);
    hessian.setFromTriplets(entries.begin(), entries.end());
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(hessian);
    const Eigen::VectorXd move = solver.solve(force);
    for (int i = 0; i < n; ++i) {
      for (int a = 0; a < 3; ++a) u_mm[static_cast<std::size_t>(i)][a] += move[3 * i + a];
    }
    if (move.norm() < 1e-11) break;
  }
  return u_mm;
}

}  // namespace maille::testing
