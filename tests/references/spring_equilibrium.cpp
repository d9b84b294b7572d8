#include "references/spring_equilibrium.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Sparse>

#include "core/stopwatch.h"
#include "references/laplacian_multigrid.h"

namespace maille {
namespace {

constexpr double kSufficientFall = 1e-4;   // of what the slope promises (Armijo)
constexpr double kEnergyRounding = 1e-12;  // of the energy: a change below says nothing
constexpr int kMostHalvings = 50;

class Newton {
 public:
  Newton(const SpringProblem& problem, WorkerPool& pool, const EquilibriumOptions& options)
      : problem_(problem), pool_(pool), options_(options), springs_(problem, pool) {}

  Equilibrium run() {
    const Stopwatch start;
    u_ = mm_of(problem_.start_voxels, problem_.spacing_mm);
    energy_ = springs_.energy(u_);
    springs_.gradient(u_, gradient_);
    // With nothing free the start is the answer.
    out_.converged = out_.stable = springs_.free_elements() == 0;
    while (!out_.converged && out_.newton_steps < options_.most_newton_steps) {
      ++out_.newton_steps;
      find_step();
      out_.distance_voxels = longest_voxels(step_);
      const bool moved = take_step();
      out_.converged = full_step_ && out_.distance_voxels <= options_.tolerance_voxels &&
                       gradient_voxels() <= options_.tolerance_voxels;
      if (!moved) break;
    }
    out_.gradient_voxels = gradient_voxels();
    out_.energy = energy_;
    out_.spring_energy = springs_.spring_energy(u_);
    out_.u_voxels = voxels_of(u_, problem_.spacing_mm);
    out_.seconds = start.seconds();
    return std::move(out_);
  }

 private:
  double longest_voxels(const DisplacementField& mm) const {
    double most = 0.0;
    for (const glm::dvec3& v : mm) most = std::max(most, glm::length(v / problem_.spacing_mm));
    return most;
  }

  double gradient_voxels() const {
    double most = 0.0;
    for (std::size_t i = 0; i < gradient_.size(); ++i) {
      if (springs_.held(i)) continue;
      most = std::max(most,
                      glm::length(gradient_[i] / problem_.spacing_mm) / springs_.stiffness_sum(i));
    }
    return most;
  }

  double dot(const DisplacementField& a, const DisplacementField& b) const {
    const std::size_t layer = a.size() / static_cast<std::size_t>(problem_.size.z);
    return springs_.sum_of_layers([&](int z) {
      double sum = 0.0;
      const std::size_t first = layer * static_cast<std::size_t>(z);
      for (std::size_t i = first; i < first + layer; ++i) sum += glm::dot(a[i], b[i]);
      return sum;
    });
  }

  // out = a + factor b
  void add(const DisplacementField& a, double factor, const DisplacementField& b,
           DisplacementField& out) const {
    const std::size_t layer = a.size() / static_cast<std::size_t>(problem_.size.z);
    out.resize(a.size());
    springs_.for_each_layer([&](int z) {
      const std::size_t first = layer * static_cast<std::size_t>(z);
      for (std::size_t i = first; i < first + layer; ++i) out[i] = a[i] + factor * b[i];
    });
  }

  void find_step() {
    const bool factorise = springs_.free_elements() <= options_.largest_factorised;
    step_.assign(springs_.count(), glm::dvec3(0.0));  // where neither way finds one
    for (const bool positive : {false, true}) {
      springs_.linearise(u_, positive);
      const bool definite = factorise ? solve_by_factors(positive) : solve_by_cg();
      out_.stable = definite && !positive;
      if (definite) break;
    }
    if (!(dot(gradient_, step_) < 0.0)) {  // rounding: the plain way down
      for (std::size_t i = 0; i < step_.size(); ++i) {
        step_[i] = springs_.held(i) ? glm::dvec3(0.0) : -gradient_[i] / springs_.stiffness_sum(i);
      }
    }
  }

  // False where the Hessian is not positive definite.
  bool solve_by_factors(bool positive) {
    std::vector<int> row(springs_.count(), -1);
    int rows = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (!springs_.held(i)) row[i] = 3 * rows++;
    }
    std::vector<Eigen::Triplet<double>> entries;
    springs_.for_each_block([&](std::size_t i, std::size_t j, const glm::dmat3& block) {
      if (row[i] < 0 || row[j] < 0 || row[i] < row[j]) return;  // the lower triangle is enough
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
          if (row[i] + a >= row[j] + b) entries.emplace_back(row[i] + a, row[j] + b, block[b][a]);
        }
      }
    });
    if (positive) {
      // What is left without curvature still needs a step.
      for (std::size_t i = 0; i < row.size(); ++i) {
        if (row[i] < 0) continue;
        const double little = 1e-9 * springs_.stiffness_sum(i);
        for (int a = 0; a < 3; ++a) entries.emplace_back(row[i] + a, row[i] + a, little);
      }
    }
    Eigen::SparseMatrix<double> hessian(3 * rows, 3 * rows);
    hessian.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factors(hessian);
    if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0.0)) return false;
    Eigen::VectorXd right(3 * rows);
    for (std::size_t i = 0; i < row.size(); ++i) {
      for (int a = 0; a < 3 && row[i] >= 0; ++a) right[row[i] + a] = -gradient_[i][a];
    }
    const Eigen::VectorXd solution = factors.solve(right);
    step_.assign(springs_.count(), glm::dvec3(0.0));
    for (std::size_t i = 0; i < row.size(); ++i) {
      for (int a = 0; a < 3 && row[i] >= 0; ++a) step_[i][a] = solution[row[i] + a];
    }
    return true;
  }

  // The better the nearer the equilibrium (Dembo, Eisenstat and Steihaug 1982). False where it
  // meets negative curvature.
  bool solve_by_cg() {
    const double accuracy = std::clamp(std::sqrt(gradient_voxels()), 1e-3, 0.1);
    LaplacianMultigrid multigrid(springs_, pool_);
    step_.assign(springs_.count(), glm::dvec3(0.0));
    DisplacementField residual(springs_.count());
    for (std::size_t i = 0; i < residual.size(); ++i) residual[i] = -gradient_[i];
    DisplacementField z, h, direction;
    multigrid.apply(residual, z);
    direction = z;
    double rz = dot(residual, z);
    const double enough = accuracy * accuracy * rz;
    for (int k = 0; k < options_.most_cg_steps && rz > enough; ++k) {
      ++out_.cg_steps;
      springs_.apply(direction, h);
      const double curvature = dot(direction, h);
      if (!(curvature > 0.0)) {
        if (k == 0) step_ = direction;
        return false;
      }
      const double length = rz / curvature;
      add(step_, length, direction, step_);
      add(residual, -length, h, residual);
      multigrid.apply(residual, z);
      const double rz_before = std::exchange(rz, dot(residual, z));
      add(z, rz / rz_before, direction, direction);
    }
    return true;
  }

  // Takes back, of a step, what carries corners across J = 0: there alone, since one corner that
  // cannot go further would otherwise hold up all the others. False if it had to.
  bool keep_from_turning(DisplacementField& u) const {
    constexpr int kShorter = 4;  // times; after that the element stays
    std::vector<std::uint8_t> shortened(u.size(), 0);
    bool whole = true;
    for (;;) {
      auto turning = springs_.turning(u_, u);
      if (turning.empty()) return whole;
      whole = false;
      std::sort(turning.begin(), turning.end());
      turning.erase(std::unique(turning.begin(), turning.end()), turning.end());
      for (const std::size_t i : turning) {
        u[i] = shortened[i]++ < kShorter ? 0.5 * (u_[i] + u[i]) : u_[i];
      }
    }
  }

  // False where no length of the step is any better than none.
  bool take_step() {
    const double slope = dot(gradient_, step_);
    DisplacementField u, gradient;
    double length = 1.0;
    for (int halving = 0; halving < kMostHalvings; ++halving, length *= 0.5) {
      full_step_ = halving == 0;
      add(u_, length, step_, u);
      if ((problem_.fold.rule == FoldRule::determinant || problem_.fold.rule == FoldRule::wall) &&
          !options_.may_turn_corners) {
        full_step_ = keep_from_turning(u) && full_step_;
      }
      const double energy = springs_.energy(u);
      const double noise = kEnergyRounding * std::abs(energy_);
      bool good = energy <= energy_ + kSufficientFall * length * slope;
      bool known = false;
      if (!good && std::abs(energy - energy_) <= noise) {
        // The energy's rounding hides the fall: let the slope tell (Hager and Zhang 2005).
        springs_.gradient(u, gradient);
        known = true;
        good = std::abs(dot(gradient, step_)) <= 0.9 * std::abs(slope);
      }
      if (!good) continue;
      if (!known) springs_.gradient(u, gradient);
      u_.swap(u);
      gradient_.swap(gradient);
      energy_ = energy;
      return true;
    }
    return false;
  }

  const SpringProblem& problem_;
  WorkerPool& pool_;
  EquilibriumOptions options_;
  DenseSprings springs_;
  Equilibrium out_;
  DisplacementField u_;
  DisplacementField gradient_;
  DisplacementField step_;
  double energy_ = 0.0;
  bool full_step_ = false;
};

}  // namespace

Equilibrium spring_equilibrium(const SpringProblem& problem, WorkerPool& pool,
                               const EquilibriumOptions& options) {
  return Newton(problem, pool, options).run();
}

}  // namespace maille
