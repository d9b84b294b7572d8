// Deformations of an analytic volume, from formulas: what resampling should show is known at any
// point, and not from the lattice.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "deform/lattice.h"

namespace maille {

// Of a rest position, anywhere, in voxels.
struct Displacement {
  glm::dvec3 u{0};
  glm::dmat3 gradient{0};  // column a: du by voxels along axis a
};

struct ResampleScene {
  std::string name;
  std::string title;
  std::function<Displacement(glm::dvec3 rest_voxels)> displacement;
  // All rest positions of what lies at a point, where there is a way to them of its own. Empty: a
  // point has one, and rest_by_newton() finds it.
  std::function<std::vector<glm::dvec3>(glm::dvec3 point_voxels)> rest_positions;
  bool moves = true;  // by other than one number of whole voxels
  bool folds = false;
};

// At rest, shifted, in waves, stretched, squeezed, sheared, close to folding, and folded: volumes
// of edge^3 voxels. Affine ones come out exact in the lattice's fixed point.
std::vector<ResampleScene> resample_scenes(int edge);

ResampleScene whole_shift_scene(std::string name, std::string title, glm::ivec3 by_voxels);

// The volume's value at a rest position: 0..1, in waves of 14 to 22 voxels, so that trilinear
// interpolation has an error that can be seen and is still small.
double analytic_value(glm::dvec3 rest_voxels);

inline constexpr double kTruth_voxels = 1e-9;  // as near a rest position's own place must be

// The rest position of a point by Newton's method on the formula, with steps halved while they lead
// away. None: it came no nearer than kTruth_voxels.
std::optional<glm::dvec3> rest_by_newton(const ResampleScene& scene, glm::dvec3 point_voxels,
                                         glm::dvec3 start_voxels);

// The displacements of a scene as the product stores them.
Lattice lattice_of(const ResampleScene& scene, Size3 size, WorkerPool& pool);

}  // namespace maille
