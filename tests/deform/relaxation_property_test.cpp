// Small scenes at random, each as far out as may ever be met, and what must hold in every state
// that a relaxation publishes of any of them: energy never rises, no cell folds, all is finite, and
// it ends.
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "deform/carving.h"
#include "deform/cutting.h"
#include "references/dense_problem.h"
#include "tests/deform/relaxing.h"

namespace maille {
namespace {

using testing::displacements_of;
using testing::for_each_voxel;
using testing::kCorners;
using testing::RelaxationScene;
using testing::workers;

constexpr int kMostIterations = 1000;

// A displacement in a lattice is off by half a unit in each component, and by what a float loses
// while it is relaxed: a few roundings, of a length from the least to the greatest in the volume.
double float_rounding_voxels(double reach_voxels) { return 4.0 * 0x1p-24 * (1.0 + reach_voxels); }
double rounding_voxels(double reach_voxels) {
  return 0.5 / kUnitsPerVoxel + float_rounding_voxels(reach_voxels);
}
// And sums of a float's products by this share.
constexpr double kSums = 1e-6;

// Energy and folds of a state in double precision, with how far the energy may be off because the
// state is rounded.
class Judge {
 public:
  Judge(const SpringProblem& problem, WorkerPool& pool)
      : problem_(problem), springs_(problem, pool) {
    glm::dvec3 low(0);
    glm::dvec3 high(0);
    for (const glm::dvec3& u : problem.start_voxels) {
      low = glm::min(low, u);
      high = glm::max(high, u);
    }
    const glm::dvec3 reach = high - low;
    reach_voxels_ = std::max({reach.x, reach.y, reach.z});
    off_mm_ = rounding_voxels(reach_voxels_) * problem.spacing_mm;
  }

  struct Verdict {
    double energy = 0.0;
    double off = 0.0;  // no state that rounds to this one has an energy further away
    bool finite = true;
  };
  Verdict of(const DisplacementField& u_voxels) const {
    const DisplacementField u = mm_of(u_voxels, problem_.spacing_mm);
    Verdict v;
    for (const glm::dvec3& at : u) {
      v.finite = v.finite && std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.z);
    }
    v.energy = springs_.energy(u);
    // To first order the gradient tells, beyond it each spring: with e the most that its ends may
    // be off and l its length, no more than k e^2 / 2 upwards, nor k d min(2 e, e^2 / 2 l) down.
    // A float's own rounding of the spring's vector comes on top, stretch and all.
    for (std::size_t i = 0; i < u.size(); ++i) {
      if (!springs_.held(i)) {
        v.off += glm::dot(glm::abs(springs_.spring_gradient_of(i, u)), off_mm_);
      }
      springs_.for_each_spring_of(i, [&](std::size_t j, const DenseSprings::SpringView& s) {
        if (j < i || (springs_.held(i) && springs_.held(j))) return;
        const glm::dvec3 du = u[j] - u[i];
        const double l = glm::length(s.rest_mm + du);
        const double e = 2.0 * glm::length(off_mm_);
        const double k = s.stiffness;
        v.off += std::max(0.5 * k * e * e,
                          k * s.length_mm * std::min(2.0 * e, l > 0.0 ? 0.5 * e * e / l : e * 2));
        const double f = 0x1p-22 * (l + s.length_mm + glm::length(du));
        v.off += k * (std::abs(l - s.length_mm) + glm::length(du)) * f + k * f * f;
      });
    }
    for_each_corner(u_voxels, [&](const Corner& corner) {
      v.off +=
          corner.kappa * (penalty(corner.determinant - corner.off) - penalty(corner.determinant));
    });
    v.off += kSums * v.energy;
    return v;
  }

  // Cells with a corner of J <= 0 in one state and none in the other; in floats, further from 0
  // than these may be off by.
  std::int64_t newly_folded(const DisplacementField& before, const DisplacementField& after,
                            bool floats) const {
    const auto was = folded_cells(before, floats ? 1.0 : 0.0);
    const auto is = folded_cells(after, floats ? -1.0 : 0.0);
    std::int64_t count = 0;
    for (std::size_t i = 0; i < was.size(); ++i) count += is[i] && !was[i];
    return count;
  }

  const DenseSprings& springs() const { return springs_; }

 private:
  struct Corner {
    std::size_t cell = 0;  // its lowest element
    double determinant = 0.0;
    double off = 0.0;         // no state that rounds to this one has one further away
    double floats_off = 0.0;  // or no float of it
    double kappa = 0.0;
  };

  static double penalty(double determinant) {
    const double q = determinant / kCorners.reach;
    if (q >= 1.0) return 0.0;
    const double at = std::max(q, kCorners.straight_below);
    const double wall = 3.0 * at < 1.0 ? -std::pow(1.0 - 3.0 * at, 2) * std::log(3.0 * at) : 0.0;
    return std::pow(1.0 - at, 2) + wall + 2.0 * (at - q);
  }

  template <class F>
  void for_each_corner(const DisplacementField& u, F&& f) const {
    const Size3 size = problem_.size;
    const double area =
        std::pow(problem_.spacing_mm.x * problem_.spacing_mm.y * problem_.spacing_mm.z, 2.0 / 3.0);
    for_each_voxel(size - 1, [&](VoxelIndex low) {
      for (int high = 0; high < 8; ++high) {
        const VoxelIndex at = low + VoxelIndex(high & 1, (high >> 1) & 1, high >> 2);
        Corner corner;
        corner.cell = element_of(low, size);
        std::array<glm::dvec3, 3> edge;
        bool whole = true;
        bool free = !springs_.held(element_of(at, size));
        for (int a = 0; a < 3; ++a) {
          VoxelIndex lower = at;
          lower[a] = low[a];
          VoxelIndex upper = lower;
          ++upper[a];
          const std::size_t i = element_of(lower, size);
          whole = whole && !((problem_.removed[i] >> a) & 1);
          free = free || !springs_.held(i) || !springs_.held(element_of(upper, size));
          auto& e = edge[static_cast<std::size_t>(a)];
          e = u[element_of(upper, size)] - u[i];
          e[a] += 1.0;
          corner.kappa += whole ? springs_.stiffness(i, spring_along(a)) / 3.0 * area : 0.0;
        }
        if (!whole || !free) continue;
        corner.determinant = glm::dot(edge[0], glm::cross(edge[1], edge[2]));
        const std::array<double, 3> l{glm::length(edge[0]), glm::length(edge[1]),
                                      glm::length(edge[2])};
        const std::array<double, 3> n{glm::length(glm::cross(edge[1], edge[2])),
                                      glm::length(glm::cross(edge[2], edge[0])),
                                      glm::length(glm::cross(edge[0], edge[1]))};
        const auto off = [&](double u_voxels) {
          const double e = 2.0 * std::sqrt(3.0) * u_voxels;
          return e * (n[0] + n[1] + n[2]) + e * e * (l[0] + l[1] + l[2]) + e * e * e;
        };
        corner.off = off(rounding_voxels(reach_voxels_));
        corner.floats_off = off(float_rounding_voxels(reach_voxels_));
        f(corner);
      }
    });
  }

  static int spring_along(int axis) { return axis; }  // the first three of DenseSprings

  std::vector<bool> folded_cells(const DisplacementField& u, double floats) const {
    std::vector<bool> folded(u.size(), false);
    for_each_corner(u, [&](const Corner& corner) {
      if (corner.determinant <= floats * corner.floats_off) folded[corner.cell] = true;
    });
    return folded;
  }

  const SpringProblem& problem_;
  DenseSprings springs_;
  double reach_voxels_ = 0.0;  // between the least and the greatest displacement
  glm::dvec3 off_mm_{0};
};

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  bool once_in(int n) { return below(n) == 0; }
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  glm::dvec3 vector(double size) {
    const double x = between(-size, size);
    const double y = between(-size, size);
    return {x, y, between(-size, size)};
  }
  VoxelIndex voxel(Size3 size) {
    const int x = below(size.x);
    const int y = below(size.y);
    return {x, y, below(size.z)};
  }

 private:
  std::mt19937 random_;
};

Size3 any_size(Dice& dice) {
  if (dice.once_in(5)) {  // a rod, or a plate
    Size3 size(1 + dice.below(3));
    size[dice.below(3)] = 20 + dice.below(40);
    if (dice.once_in(3)) size[dice.below(3)] = 10;
    return size;
  }
  const int x = 4 + dice.below(7);
  const int y = 4 + dice.below(6);
  return {x, y, 4 + dice.below(6)};
}

glm::dvec3 any_spacing(Dice& dice) {
  switch (dice.below(4)) {
    case 0: return {1, 1, 10};
    case 1: return {dice.between(0.3, 3), dice.between(0.3, 3), dice.between(0.3, 3)};
    default: return glm::dvec3(1);
  }
}

std::vector<Material> any_materials(Dice& dice) {
  // Limits that a drag of a million voxels takes along as far as 16 bits let it.
  constexpr double kWidest = 120.0;
  const bool wide = dice.once_in(3);
  const double decades = dice.once_in(3) ? 9.0 : dice.between(0.0, 4.0);
  const double one_blend = dice.below(5) * 0.25;
  const bool blends = dice.once_in(2);
  std::vector<Material> materials;
  const int count = 1 + dice.below(4);
  for (int m = 0; m < count; ++m) {
    const double stiffness = std::pow(10.0, dice.between(-0.5, 0.5) * decades);
    Material one = wide ? testing::material(m, m + 1, 0.0, kWidest, kWidest, stiffness)
                        : testing::material(m, m + 1, 0.5, 1.6, 0.24, stiffness);
    one.rest_vector_blend = blends ? dice.below(5) * 0.25 : one_blend;
    one.rigid = m > 0 && dice.once_in(8);
    one.fixed = m > 0 && dice.once_in(12);
    materials.push_back(one);
  }
  return materials;
}

// Drags by ChainMail; or elements put where no drag could.
void displace(RelaxationScene& scene, Dice& dice) {
  const Size3 size = scene.size();
  const double far = dice.once_in(4) ? 1e6 : dice.once_in(3) ? 30.0 : 2.0;
  switch (dice.below(5)) {
    default: {
      for (int drags = 1 + dice.below(2); drags > 0; --drags) {
        const ElementSet handle =
            ball_of_elements(dice.voxel(size), dice.between(0.0, 2.0), scene.start.grid());
        const Cuts whole(size);
        StrokeBricks bricks(scene.field, whole, scene.held, {});
        scene.start =
            solve_chainmail({scene.start, bricks, handle, 0},
                            glm::ivec3(dice.vector(far) * double{kUnitsPerVoxel}), workers())
                .lattice;
        scene.held.insert(handle);
      }
      break;
    }
    case 0: {  // one far out, nothing else
      const VoxelIndex at = dice.voxel(size);
      const glm::dvec3 by = dice.vector(far);
      scene.displace([&](VoxelIndex v) { return v == at ? by : glm::dvec3(0); });
      if (dice.once_in(2)) scene.hold([&](VoxelIndex v) { return v == at; });
      break;
    }
    case 1: {  // several in one place
      const VoxelIndex at = dice.voxel(size);
      const int within = 1 + dice.below(2);
      scene.displace([&](VoxelIndex v) {
        const glm::ivec3 away = glm::abs(v - at);
        return std::max({away.x, away.y, away.z}) <= within ? glm::dvec3(at - v) : glm::dvec3(0);
      });
      break;
    }
    case 2: {  // shaken, to folds and beyond
      const double most = dice.between(0.05, 1.0);
      scene.displace([&](VoxelIndex) { return dice.vector(most); });
      break;
    }
  }
}

void hold(RelaxationScene& scene, Dice& dice) {
  switch (dice.below(6)) {
    case 0: scene.anchors = {}; break;
    case 1: scene.anchors = {static_cast<std::uint8_t>(1 + dice.below(63)), false}; break;
    case 2: {  // all but one
      const VoxelIndex at = dice.voxel(scene.size());
      scene.hold([&](VoxelIndex v) { return v != at; });
      break;
    }
    case 3:
      if (dice.once_in(4)) scene.hold([](VoxelIndex) { return true; });
      break;
    default: break;
  }
  if (dice.once_in(5)) {
    const auto disc = CutSurface::disc(glm::dvec3(dice.voxel(scene.size())) + 0.31,
                                       dice.vector(1.0), dice.between(1.0, 8.0), glm::dvec3(1));
    if (disc.ok()) scene.cuts = *cut_along(scene.cuts, Lattice(scene.size()), *disc);
    if (dice.once_in(2)) {
      scene.cuts = carve(scene.cuts, Lattice(scene.size()), glm::dvec3(dice.voxel(scene.size())),
                         dice.between(0.0, 2.0));
    }
  }
}

// What is asked of folds: of each state as it is, or of the fixed point that it is rounded to. They
// are two questions because of one unit: a corner of less than 0.01 may be open in one and not in
// the other.
enum class Folds { as_it_is, as_published };

bool relax_and_judge(unsigned seed, Folds folds) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  Dice dice(seed);
  const Size3 size = any_size(dice);
  const auto spacing_mm = any_spacing(dice);
  const auto materials = any_materials(dice);
  RelaxationScene scene(testing::random_volume(size, static_cast<int>(materials.size()),
                                               1 + dice.below(3), seed, spacing_mm),
                        materials);
  displace(scene, dice);
  hold(scene, dice);

  const SpringProblem twin = scene.twin();
  const Judge judge(twin, workers());
  RelaxationOptions options;
  options.tolerance_voxels = dice.once_in(2) ? 0.01 : 0.001;
  Relaxation relaxation = scene.relaxation(workers(), options);
  const RelaxationProgress& progress = relaxation.progress();
  DisplacementField u = displacements_of(relaxation.lattice());
  DisplacementField unrounded = relaxation.displacements_voxels();
  Judge::Verdict now = judge.of(u);
  const Judge::Verdict first = now;
  const double energy_first = progress.energy_first;
  bool good = std::isfinite(energy_first);
  EXPECT_TRUE(good);
  const auto expect = [&](bool well, const char* what) {
    good = good && well;
    EXPECT_TRUE(well) << what << " at iteration " << progress.iterations;
  };
  while (good && !progress.finished() && progress.iterations < kMostIterations) {
    // A window takes a state when it draws, not after each iteration.
    for (unsigned i = 0; i <= seed % 3; ++i) relaxation.iterate();
    DisplacementField next = displacements_of(relaxation.lattice());
    DisplacementField next_unrounded = relaxation.displacements_voxels();
    if (folds == Folds::as_published) {
      expect(judge.newly_folded(u, next, false) == 0, "a cell is folded");
    } else {
      const Judge::Verdict then = judge.of(next);
      expect(then.finite && std::isfinite(progress.energy_last) &&
                 std::isfinite(progress.residual_voxels) &&
                 std::isfinite(progress.residual_rms_voxels),
             "all is finite: not so");
      expect(!progress.energy_ever_rose, "it says that its energy rose");
      expect(then.energy <= now.energy + now.off + then.off, "energy rose");
      expect(std::abs((first.energy - then.energy) - (energy_first - progress.energy_last)) <=
                 first.off + then.off,
             "it says another energy");
      expect(judge.newly_folded(unrounded, next_unrounded, true) == 0, "a cell is folded");
      for (std::size_t i = 0; i < u.size(); ++i) {
        if (judge.springs().held(i) && u[i] != next[i]) expect(false, "what is held moved");
      }
      now = then;
    }
    u = std::move(next);
    unrounded = std::move(next_unrounded);
  }
  if (folds == Folds::as_it_is && good) expect(progress.finished(), "it has not ended");
  return good;
}

class RelaxationProperty : public ::testing::TestWithParam<int> {
 protected:
  void judge_fifty(Folds folds) {
    for (int i = 0; i < 50; ++i) {
      const auto seed = static_cast<unsigned>(50 * GetParam() + i);
      try {
        relax_and_judge(seed, folds);
      } catch (const std::exception& e) {
        ADD_FAILURE() << "seed " << seed << ": " << e.what();
      }
    }
  }
};

TEST_P(RelaxationProperty, NeverRisesNeverFoldsAndEnds) { judge_fifty(Folds::as_it_is); }
TEST_P(RelaxationProperty, NothingFoldsInWhatIsPublished) { judge_fifty(Folds::as_published); }

INSTANTIATE_TEST_SUITE_P(Fifties, RelaxationProperty, ::testing::Range(0, 10));

}  // namespace
}  // namespace maille
