// Relaxation as the paper has it (Schulze, Bühler, Hadwiger, GRAPP 2007, section 4.2), with its
// eq. (4) mended: as printed it pushes a stretched pair apart, and its step shrinks with the square
// of the distance.
//
// All listed elements take one step u_i += alpha * f_i at once, with one alpha for all materials.
// The list starts with the elements that ChainMail moved; one that moves less than epsilon drops
// out, and the neighbours of one that moves more come in (those that a spring joins it to). It ends
// when the list is empty: that is no distance to the equilibrium.
//
// One thread, the arithmetic in Real.
#pragma once

#include <vector>

#include "references/dense_springs.h"

namespace maille {

template <class Real>
class PaperRelaxation {
 public:
  struct Options {
    // Of 1 / the largest stiffness sum of any element. Below 1 no step ever raises the energy; from
    // rest up to 2.5 goes well in one material.
    double alpha = 1.0;
    double epsilon_voxels = 0.0;
  };

  // moved: 1 for each element that ChainMail moved. The problem must outlive this; its fold rule is
  // of no account.
  PaperRelaxation(const SpringProblem& problem, const std::vector<std::uint8_t>& moved,
                  WorkerPool& pool, const Options& options);

  bool finished() const { return list_.empty(); }
  void iterate();
  std::int64_t iterations() const { return iterations_; }
  std::int64_t element_updates() const { return element_updates_; }
  DisplacementField displacements_voxels() const;

 private:
  using Vector = glm::vec<3, Real>;
  Vector force_on(std::size_t element) const;

  const SpringProblem& problem_;
  DenseSprings springs_;  // for which springs there are and what they are made of
  double alpha_ = 0.0;
  double epsilon_voxels_ = 0.0;
  std::vector<Vector> u_mm_;
  std::vector<Vector> move_mm_;  // by place in the list
  std::vector<std::uint8_t> listed_;
  std::vector<std::uint32_t> list_;
  std::int64_t iterations_ = 0;
  std::int64_t element_updates_ = 0;
};

extern template class PaperRelaxation<float>;
extern template class PaperRelaxation<double>;

}  // namespace maille
