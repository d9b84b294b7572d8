// The spring references against differences of their own energy, answers known on paper, and one
// another.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "references/dense_checks.h"
#include "references/dense_problem.h"
#include "references/dense_springs.h"
#include "references/guarded_sweeps.h"
#include "references/paper_relaxation.h"
#include "references/spring_equilibrium.h"

namespace maille {
namespace {

SpringProblem problem_of(Size3 size, std::vector<SpringMaterial> materials,
                         glm::dvec3 spacing_mm = glm::dvec3(1)) {
  const auto count = static_cast<std::size_t>(voxel_count(size));
  SpringProblem problem;
  problem.size = size;
  problem.spacing_mm = spacing_mm;
  problem.materials = std::move(materials);
  problem.held.assign(count, 0);
  problem.start_voxels.assign(count, glm::dvec3(0));
  return problem;
}

SpringMaterial spring_material(double stiffness, double blend) {
  SpringMaterial material;
  material.stiffness = stiffness;
  material.rest_vector_blend = blend;
  return material;
}

// Everything at once: three materials, cut links, held elements, anisotropic spacing, displaced so
// far that some corners are near folding and some have folded.
SpringProblem rough_problem(unsigned seed, FoldTerm fold, double shaken_voxels) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  SpringProblem problem = problem_of(
      {6, 5, 7}, {spring_material(1.0, 0.25), spring_material(7.0, 0.5), spring_material(0.2, 0.0)},
      {0.8, 1.3, 2.1});
  problem.materials[1].shear = {0.05, 0.1, 0.2};
  problem.fold = fold;
  for (std::size_t i = 0; i < problem.held.size(); ++i) {
    problem.ids.push_back(static_cast<MaterialId>(random() % 3));
    problem.removed.push_back(random() % 10 == 0 ? static_cast<std::uint8_t>(random() % 8) : 0);
    problem.held[i] = random() % 12 == 0;
    problem.start_voxels[i] =
        shaken_voxels * glm::dvec3(number(random), number(random), number(random));
  }
  return problem;
}

struct Case {
  FoldTerm fold;
  double shaken_voxels;
};
const Case kCases[] = {{{}, 0.3},
                       {{FoldRule::determinant, 0.6, 2.0, 0.05}, 0.2},
                       {{FoldRule::determinant, 0.3, 1.0, 0.3}, 0.5},
                       {{FoldRule::wall, 0.6, 2.0, 0.01}, 0.2},
                       {{FoldRule::wall, 0.3, 1.0, 0.01}, 0.5},
                       {{FoldRule::limits, 0.2, 3.0, 0.3}, 0.4}};

DisplacementField random_direction(const DenseSprings& springs, std::mt19937& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  DisplacementField direction(springs.count(), glm::dvec3(0));
  for (std::size_t i = 0; i < direction.size(); ++i) {
    if (!springs.held(i)) direction[i] = {number(random), number(random), number(random)};
  }
  return direction;
}

double dot(const DisplacementField& a, const DisplacementField& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += glm::dot(a[i], b[i]);
  return sum;
}

DisplacementField sum_of(const DisplacementField& a, double factor, const DisplacementField& b) {
  DisplacementField sum = a;
  for (std::size_t i = 0; i < a.size(); ++i) sum[i] += factor * b[i];
  return sum;
}

double length(const DisplacementField& a) { return std::sqrt(dot(a, a)); }

double largest_distance(const DisplacementField& a, const DisplacementField& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, glm::length(a[i] - b[i]));
  return most;
}

TEST(DenseSprings, TheGradientIsThatOfTheEnergy) {
  WorkerPool pool(2);
  std::mt19937 random(1);
  for (const Case& c : kCases) {
    for (const unsigned seed : {1u, 2u, 3u}) {
      SCOPED_TRACE("rule " + std::to_string(static_cast<int>(c.fold.rule)) + " seed " +
                   std::to_string(seed));
      const SpringProblem problem = rough_problem(seed, c.fold, c.shaken_voxels);
      const DenseSprings springs(problem, pool);
      const auto u = mm_of(problem.start_voxels, problem.spacing_mm);
      if (c.fold.rule != FoldRule::none) {
        EXPECT_GT(springs.fold_energy(u), 0.0);
      }
      if (c.fold.rule == FoldRule::determinant && c.shaken_voxels > 0.4) {
        EXPECT_LT(springs.least_determinant(u), 0.0) << "its straight part too";
      }
      DisplacementField gradient;
      springs.gradient(u, gradient);
      const auto direction = random_direction(springs, random);
      constexpr double kStep = 1e-5;
      const double difference = (springs.energy(sum_of(u, kStep, direction)) -
                                 springs.energy(sum_of(u, -kStep, direction))) /
                                (2 * kStep);
      EXPECT_NEAR(difference, dot(gradient, direction), 1e-6 * length(gradient));
      for (std::size_t i = 0; i < gradient.size(); ++i) {
        if (springs.held(i)) {
          EXPECT_EQ(gradient[i], glm::dvec3(0));
        }
      }
    }
  }
}

TEST(DenseSprings, TheHessianIsThatOfTheGradient) {
  WorkerPool pool(2);
  std::mt19937 random(2);
  for (const Case& c : kCases) {
    for (const unsigned seed : {4u, 5u, 6u}) {
      SCOPED_TRACE("rule " + std::to_string(static_cast<int>(c.fold.rule)) + " seed " +
                   std::to_string(seed));
      const SpringProblem problem = rough_problem(seed, c.fold, c.shaken_voxels);
      DenseSprings springs(problem, pool);
      const auto u = mm_of(problem.start_voxels, problem.spacing_mm);
      const auto direction = random_direction(springs, random);
      constexpr double kStep = 1e-6;
      DisplacementField above, below, product;
      springs.gradient(sum_of(u, kStep, direction), above);
      springs.gradient(sum_of(u, -kStep, direction), below);
      springs.linearise(u, false);
      springs.apply(direction, product);
      const auto difference = sum_of(above, -1.0, below);
      EXPECT_LT(length(sum_of(product, -1.0 / (2 * kStep), difference)), 2e-6 * length(product));

      // The blocks are the same matrix.
      DisplacementField by_blocks(u.size(), glm::dvec3(0));
      springs.for_each_block([&](std::size_t i, std::size_t j, const glm::dmat3& block) {
        if (!springs.held(i)) by_blocks[i] += block * direction[j];
      });
      EXPECT_LT(length(sum_of(product, -1.0, by_blocks)), 1e-12 * length(product));

      // And without its negative curvature it has none.
      springs.linearise(u, true);
      for (int n = 0; n < 20; ++n) {
        const auto x = random_direction(springs, random);
        springs.apply(x, product);
        EXPECT_GE(dot(x, product), 0.0);
      }
    }
  }
}

// E = 1/2 (1 - b) k (l - d)^2 + 1/2 b k |p - r|^2 by hand.
TEST(DenseSprings, APairsEnergyIsTheFormulas) {
  WorkerPool pool(1);
  SpringProblem problem =
      problem_of({2, 1, 1}, {spring_material(2.0, 0.2), spring_material(6.0, 0.4)}, {1.5, 1, 1});
  problem.ids = {0, 1};
  const DenseSprings springs(problem, pool);
  const double k = 2.0 / (1.0 / 2.0 + 1.0 / 6.0);
  const double b = 0.3;
  const glm::dvec3 du(0.5, 1.0, -0.5);
  const double l = std::sqrt(2.0 * 2.0 + 1.0 + 0.25);
  EXPECT_NEAR(springs.energy({glm::dvec3(0.1), glm::dvec3(0.1) + du}),
              0.5 * (1 - b) * k * (l - 1.5) * (l - 1.5) + 0.5 * b * k * glm::dot(du, du), 1e-13);
  // At zero distance there is a blend's pull and no other.
  DisplacementField gradient;
  springs.gradient({glm::dvec3(0), glm::dvec3(-1.5, 0, 0)}, gradient);
  EXPECT_NEAR(gradient[0].x, b * k * 1.5, 1e-13);
}

// A block sheared by gamma: E of a cell is the sum over the 9 springs that belong to an element.
TEST(DenseSprings, AShearedBlocksEnergyIsTheFormulas) {
  WorkerPool pool(1);
  const glm::dvec3 h(1.0, 0.7, 1.6);
  const double gamma = 0.3;
  for (const double blend : {0.0, 0.25}) {
    SpringProblem problem = problem_of({6, 5, 4}, {spring_material(3.0, blend)}, h);
    const DenseSprings springs(problem, pool);
    DisplacementField u;
    double expected = 0.0;
    for (std::size_t i = 0; i < springs.count(); ++i) {
      const VoxelIndex at = voxel_of(i, problem.size);
      u.emplace_back(gamma * h.y * at.y, 0.0, 0.0);
      for (const glm::ivec3 o : DenseSprings::kOffsets) {
        if (!contains(problem.size, at + o)) continue;
        const glm::dvec3 rest = glm::dvec3(o) * h;
        const glm::dvec3 sheared = rest + glm::dvec3(gamma * rest.y, 0, 0);
        const double longer = glm::length(sheared) - glm::length(rest);
        const glm::dvec3 moved = sheared - rest;
        expected += 0.5 * 3.0 * ((1 - blend) * longer * longer + blend * glm::dot(moved, moved));
      }
    }
    EXPECT_NEAR(springs.energy(u), expected, 1e-11 * expected);
  }
}

// Turned as a whole: nothing without a blend; with one, half of b k |R r - r|^2 a spring.
TEST(DenseSprings, ARotationCostsTheBlendAlone) {
  WorkerPool pool(1);
  const double angle = 0.7;
  for (const double blend : {0.0, 0.25}) {
    SpringProblem problem = problem_of({5, 6, 4}, {spring_material(2.0, blend)}, {1, 0.8, 1.5});
    const DenseSprings springs(problem, pool);
    const auto turned = [&](glm::dvec3 p) {
      return glm::dvec3(std::cos(angle) * p.x - std::sin(angle) * p.y,
                        std::sin(angle) * p.x + std::cos(angle) * p.y, p.z);
    };
    DisplacementField u;
    double expected = 0.0;
    for (std::size_t i = 0; i < springs.count(); ++i) {
      const VoxelIndex at = voxel_of(i, problem.size);
      const glm::dvec3 place = glm::dvec3(at) * problem.spacing_mm;
      u.push_back(turned(place) - place);
      for (const glm::ivec3 o : DenseSprings::kOffsets) {
        if (!contains(problem.size, at + o)) continue;
        const glm::dvec3 rest = glm::dvec3(o) * problem.spacing_mm;
        const glm::dvec3 moved = turned(rest) - rest;
        expected += 0.5 * blend * 2.0 * glm::dot(moved, moved);
      }
    }
    EXPECT_NEAR(springs.energy(u), expected, 1e-11 * (1.0 + expected));
  }
}

// The barrier is what the formula says where one corner of one cell is pressed in.
TEST(DenseSprings, ThePressedCornerPaysTheBarrier) {
  WorkerPool pool(1);
  SpringProblem problem = problem_of({2, 2, 2}, {spring_material(2.0, 0.25)}, {1, 2, 0.5});
  problem.fold = {FoldRule::determinant, 0.2, 1.5, 0.3};
  const DenseSprings springs(problem, pool);
  DisplacementField u(8, glm::dvec3(0));
  u[0].x = 0.9;
  EXPECT_NEAR(springs.least_determinant(u), 0.1, 1e-14);
  const double kappa = 2.0 * (1.0 + 4.0 + 0.25) / 3.0;
  const double q = 0.5;
  // Corners at element 0 (J = 0.1) and at its neighbour along x (the same edge, J = 0.1); the
  // neighbours along y and z have sheared edges and J = 1.
  EXPECT_NEAR(springs.fold_energy(u), 2 * 1.5 * kappa * -(1 - q) * (1 - q) * std::log(q), 1e-12);
  // Folded: on along the tangent at q = 0.3.
  u[0].x = 1.1;
  const double at = 0.3;
  const double gap = 1 - at;
  const double tangent =
      -gap * gap * std::log(at) + (-0.1 / 0.2 - at) * (2 * gap * std::log(at) - gap * gap / at);
  EXPECT_NEAR(springs.fold_energy(u), 2 * 1.5 * kappa * tangent, 1e-9);
  problem.removed.assign(8, 0);
  problem.removed[0] = 1;  // the link along x
  EXPECT_EQ(DenseSprings(problem, pool).fold_energy(u), 0.0) << "nothing folds across a cut";
}

TEST(SpringMaterials, WideGapsAreNarrowedAndRigidIsAThousandTimesTheStiffest) {
  std::vector<Material> materials(4);
  materials[0].stiffness = 1e6;
  materials[1].stiffness = 2.0;
  materials[2].stiffness = 1e-3;
  materials[3].rigid = true;
  const auto springs = spring_materials(materials, 0.5);
  EXPECT_DOUBLE_EQ(springs[2].stiffness, 1e-3);
  EXPECT_DOUBLE_EQ(springs[1].stiffness, 1.0);
  EXPECT_DOUBLE_EQ(springs[0].stiffness, 1e3);
  EXPECT_DOUBLE_EQ(springs[3].stiffness, 1e6);
  EXPECT_EQ(springs[0].rest_vector_blend, 0.5);
}

// --- the equilibrium

// Two springs in series: the middle settles at D k2 / (k1 + k2).
TEST(SpringEquilibrium, Pair) {
  WorkerPool pool(1);
  for (const double blend : {0.0, 0.25, 1.0}) {
    for (const std::int64_t factorised : {0, 1000}) {
      SpringProblem problem = problem_of(
          {3, 1, 1}, {spring_material(2.0, blend), spring_material(6.0, blend)}, {0.7, 1, 1});
      problem.ids = {0, 0, 1};
      problem.held = {1, 0, 1};
      problem.start_voxels[2].x = 3.0;
      EquilibriumOptions options;
      options.largest_factorised = factorised;
      const Equilibrium found = spring_equilibrium(problem, pool, options);
      EXPECT_TRUE(found.converged);
      EXPECT_TRUE(found.stable);
      EXPECT_NEAR(found.u_voxels[1].x, 3.0 * 3.0 / (2.0 + 3.0), 1e-9);
    }
  }
}

// A chain under a pinned displacement: each spring takes its share in proportion to its compliance.
TEST(SpringEquilibrium, Chain) {
  WorkerPool pool(1);
  std::mt19937 random(3);
  const int n = 40;
  SpringProblem problem = problem_of(
      {1, 1, n},
      {spring_material(1.0, 0.25), spring_material(4.0, 0.25), spring_material(20, 0.25)},
      {1, 1, 0.8});
  for (int z = 0; z < n; ++z) problem.ids.push_back(static_cast<MaterialId>(random() % 3));
  problem.held.front() = problem.held.back() = 1;
  problem.start_voxels.back().z = 6.0;
  const Equilibrium found = spring_equilibrium(problem, pool);
  EXPECT_TRUE(found.converged);
  const auto compliance = [&](int z) {
    return 0.5 / problem.materials[problem.ids[static_cast<std::size_t>(z)]].stiffness;
  };
  double total = 0.0;
  for (int z = 1; z < n; ++z) total += compliance(z) + compliance(z - 1);
  double share = 0.0;
  for (int z = 1; z < n; ++z) {
    share += compliance(z) + compliance(z - 1);
    EXPECT_NEAR(found.u_voxels[static_cast<std::size_t>(z)].z, 6.0 * share / total, 1e-9);
  }
}

// A bar in uniaxial stretch, its sides free. With 6 + 12 springs of equal k Poisson's ratio is 1/4:
// for a small stretch and no blend it thins by a quarter of it, in the middle, far from its ends,
// where springs at the surface (which lack half of their diagonals) change little.
TEST(SpringEquilibrium, ABarThinsByPoissonsRatio) {
  WorkerPool pool(2);
  const int w = 9;
  const int n = 37;
  SpringProblem problem = problem_of({w, w, n}, {spring_material(1.0, 0.0)});
  const double stretch = 1e-4;
  for (std::size_t i = 0; i < problem.held.size(); ++i) {
    const VoxelIndex at = voxel_of(i, problem.size);
    problem.start_voxels[i].z = stretch * at.z;
    problem.held[i] = at.z == 0 || at.z == n - 1;
  }
  const Equilibrium found = spring_equilibrium(problem, pool);
  EXPECT_TRUE(found.converged);
  const auto u = [&](int x) {
    return found.u_voxels[element_of({x, w / 2, n / 2}, problem.size)].x;
  };
  const double thinner = (u(w / 2 - 2) - u(w / 2 + 2)) / 4.0 / stretch;
  EXPECT_NEAR(thinner, 0.25, 0.02);
}

SpringProblem dragged_block(double blend, FoldTerm fold, double by_voxels) {
  SpringProblem problem = problem_of(
      {13, 12, 11}, {spring_material(1.0, blend), spring_material(20.0, blend)}, {1, 0.9, 1.2});
  problem.fold = fold;
  for (std::size_t i = 0; i < problem.held.size(); ++i) {
    const VoxelIndex at = voxel_of(i, problem.size);
    const glm::dvec3 away = glm::dvec3(at) - glm::dvec3(6, 6, 5);
    const double distance = glm::length(away);
    problem.ids.push_back(at.x > 9 ? 1 : 0);
    const bool border =
        glm::any(glm::equal(at, VoxelIndex(0))) || glm::any(glm::equal(at, problem.size - 1));
    problem.held[i] = border || distance <= 1.5;
    if (!border) problem.start_voxels[i].x = by_voxels * std::max(0.0, 1.0 - distance / 6.0);
    if (distance <= 1.5) problem.start_voxels[i].x = by_voxels;
  }
  return problem;
}

TEST(SpringEquilibrium, FactorsAndConjugateGradientsAgree) {
  WorkerPool pool(2);
  for (const FoldTerm fold : {FoldTerm{}, FoldTerm{FoldRule::determinant, 0.5, 1.0, 0.3},
                              FoldTerm{FoldRule::limits, 0.2, 4.0, 0.3}}) {
    SCOPED_TRACE("rule " + std::to_string(static_cast<int>(fold.rule)));
    const SpringProblem problem = dragged_block(0.25, fold, 1.6);
    EquilibriumOptions options;
    const Equilibrium by_factors = spring_equilibrium(problem, pool, options);
    options.largest_factorised = 0;
    const Equilibrium by_cg = spring_equilibrium(problem, pool, options);
    EXPECT_EQ(by_factors.cg_steps, 0);
    EXPECT_GT(by_cg.cg_steps, 0);
    for (const Equilibrium* e : {&by_factors, &by_cg}) {
      EXPECT_TRUE(e->converged);
      EXPECT_TRUE(e->stable);
      EXPECT_LE(e->distance_voxels, options.tolerance_voxels);
    }
    EXPECT_LT(largest_distance(by_factors.u_voxels, by_cg.u_voxels), 2e-7);
    EXPECT_NEAR(by_factors.energy, by_cg.energy, 1e-10 * by_factors.energy);
    if (fold.rule != FoldRule::none) {
      EXPECT_GT(by_cg.energy, by_cg.spring_energy) << "the rule does matter here";
    }
  }
}

// Started from a state near it, as the measurement does with the product's own answer.
TEST(SpringEquilibrium, PolishesWhatIsNear) {
  WorkerPool pool(2);
  SpringProblem problem = dragged_block(0.25, {}, 1.2);
  EquilibriumOptions options;
  options.largest_factorised = 0;
  const Equilibrium far = spring_equilibrium(problem, pool, options);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  problem.start_voxels = far.u_voxels;
  for (std::size_t i = 0; i < problem.held.size(); ++i) {
    if (!problem.held[i]) {
      problem.start_voxels[i] += 1e-3 * glm::dvec3(number(random), number(random), number(random));
    }
  }
  const Equilibrium near = spring_equilibrium(problem, pool, options);
  EXPECT_TRUE(near.converged);
  EXPECT_LT(largest_distance(near.u_voxels, far.u_voxels), 2e-7);
  EXPECT_LT(near.cg_steps, far.cg_steps);
}

// From a state in which cells are folded, and turn others on their way: all come out, and no corner
// that was right is wrong in between.
TEST(SpringEquilibrium, TheBarrierUnfoldsAndNeverFolds) {
  WorkerPool pool(2);
  SpringProblem problem = dragged_block(0.25, {FoldRule::determinant, 0.2, 1.0, 0.3}, 2.0);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> number(-0.45, 0.45);
  for (std::size_t i = 0; i < problem.held.size(); ++i) {
    if (!problem.held[i]) {
      problem.start_voxels[i] += glm::dvec3(number(random), number(random), number(random));
    }
  }
  EXPECT_GT(dense_folded_cells(problem.size, problem.start_voxels), 10);
  const Equilibrium end = spring_equilibrium(problem, pool);
  EXPECT_TRUE(end.converged);
  EXPECT_EQ(dense_folded_cells(problem.size, end.u_voxels), 0);
  const DenseSprings springs(problem, pool);
  DisplacementField before = mm_of(problem.start_voxels, problem.spacing_mm);
  EquilibriumOptions one_step;
  one_step.most_newton_steps = 1;
  for (int step = 0; step < 10; ++step) {
    problem.start_voxels = spring_equilibrium(problem, pool, one_step).u_voxels;
    DisplacementField after = mm_of(problem.start_voxels, problem.spacing_mm);
    EXPECT_TRUE(springs.turning(before, after).empty()) << step;
    before.swap(after);
  }
}

// --- rules for each step

TEST(GuardedSweeps, KeepWhatTheyPromiseAndLowerTheEnergy) {
  WorkerPool pool(1);
  const SpringProblem problem = dragged_block(0.25, {}, 1.6);
  const Equilibrium springs_alone = spring_equilibrium(problem, pool);
  const DenseSprings springs(problem, pool);
  const auto start_mm = mm_of(problem.start_voxels, problem.spacing_mm);
  ASSERT_GT(springs.least_determinant(start_mm), 0.4);
  GuardedOptions options;
  options.guard = StepGuard::determinant;
  options.least_determinant = 0.4;
  const GuardedAnswer by_determinant = relax_guarded(problem, pool, options);
  const auto end_mm = mm_of(by_determinant.u_voxels, problem.spacing_mm);
  EXPECT_GE(springs.least_determinant(end_mm), 0.4 - 1e-9);
  EXPECT_GT(by_determinant.stopped, 0) << "the guard does matter here";
  // Without a guard to mind, the sweeps find the equilibrium.
  options.least_determinant = -1e9;
  const GuardedAnswer unguarded = relax_guarded(problem, pool, options);
  EXPECT_TRUE(unguarded.still);
  EXPECT_LT(largest_distance(unguarded.u_voxels, springs_alone.u_voxels), 1e-3);

  options.guard = StepGuard::limits;
  const GuardedAnswer by_limits = relax_guarded(problem, pool, options);
  EXPECT_GT(by_limits.stopped, 0);
  SpringProblem beyond = problem;
  beyond.fold = {FoldRule::limits, 0.2, 1.0, 0.3};
  const DenseSprings limits(beyond, pool);
  EXPECT_LE(limits.fold_energy(mm_of(by_limits.u_voxels, problem.spacing_mm)),
            limits.fold_energy(start_mm) + 1e-12);
  for (const GuardedAnswer* answer : {&by_determinant, &by_limits}) {
    EXPECT_LT(answer->spring_energy, springs.spring_energy(start_mm));
    EXPECT_GT(answer->spring_energy, springs_alone.energy);
  }
}

// --- the paper's own

TEST(PaperRelaxation, GoesToTheEquilibriumWhereItsListNeverEmpties) {
  WorkerPool pool(1);
  const SpringProblem problem = dragged_block(0.25, {}, 1.2);
  const Equilibrium expected = spring_equilibrium(problem, pool);
  std::vector<std::uint8_t> moved;
  for (const glm::dvec3& u : problem.start_voxels) moved.push_back(u != glm::dvec3(0));
  PaperRelaxation<double> all(problem, moved, pool, {1.9, 0.0});
  PaperRelaxation<float> in_floats(problem, moved, pool, {1.9, 0.0});
  for (int i = 0; i < 3000; ++i) {
    all.iterate();
    in_floats.iterate();
  }
  EXPECT_LT(largest_distance(all.displacements_voxels(), expected.u_voxels), 1e-5);
  EXPECT_LT(largest_distance(in_floats.displacements_voxels(), expected.u_voxels), 1e-4);

  // With an epsilon it stops, far from there.
  PaperRelaxation<double> listed(problem, moved, pool, {1.0, 0.01});
  while (!listed.finished() && listed.iterations() < 3000) listed.iterate();
  EXPECT_TRUE(listed.finished());
  EXPECT_LT(listed.element_updates(), all.element_updates());
  EXPECT_GT(largest_distance(listed.displacements_voxels(), expected.u_voxels), 0.02);
}

}  // namespace
}  // namespace maille
