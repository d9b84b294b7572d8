// The elements around corners near folding, moved together to where their own energy is least.
//
// One step of Newton's method on all of them at once, everything around them held: springs and
// corners (fold_energy.h) in double precision, by a sparse LDLT; where the curvature is not
// positive in every direction, with that of each spring and corner made so. Shortened until it
// closes no open corner and the energy falls.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "deform/fold_energy.h"

namespace maille {

// Elements (rising) in parts without a cell in common.
std::vector<std::vector<std::int64_t>> connected_elements(const std::vector<std::int64_t>& elements,
                                                          Size3 extent);

class FoldCluster {
 public:
  // elements: free ones, rising. Throws std::bad_alloc.
  FoldCluster(const FoldEnergy& folds, std::vector<std::int64_t> elements);

  // False where there is no way down.
  bool step();
  void write_to(BoxVectors& u_mm) const;

 private:
  struct Spring {
    int a = 0;
    int b = -1;  // none: held at end_mm
    glm::dvec3 end_mm{0};
    glm::dvec3 rest_mm{0};  // from b to a
    glm::dvec3 kept_mm{0};  // of it, what material keeps that has yielded
    double length_mm = 0.0;
    double plain = 0.0;     // stiffness along its length alone
    double straight = 0.0;  // and in all directions
  };
  struct Corner {
    std::array<int, 4> at{-1, -1, -1, -1};
    std::array<glm::dvec3, 4> held_mm{};
    glm::dvec3 signs{1};
    double kappa = 0.0;
    bool guarded = true;
  };
  struct Newton;

  int index_of(std::int64_t element) const;
  void gather_springs();
  void gather_corners();
  glm::dmat3 edges(const Corner& corner, const std::vector<glm::dvec3>& u_mm) const;
  // Infinite where a corner is closed that `open` says was not.
  double energy(const std::vector<glm::dvec3>& u_mm, const std::vector<double>& open) const;
  void add_springs(Newton& newton, bool exact) const;
  void add_corners(Newton& newton, bool exact) const;
  std::optional<Eigen::VectorXd> full_step(bool exact) const;

  const FoldEnergy& folds_;
  glm::dvec3 voxels_from_mm_;
  std::vector<std::int64_t> elements_;
  std::vector<glm::dvec3> u_mm_;
  std::vector<Spring> springs_;
  std::vector<Corner> corners_;
};

}  // namespace maille
