#include "measure/fold_study.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/stopwatch.h"
#include "measure/drag_scene.h"
#include "measure/spring_scene.h"
#include "measure/text_table.h"
#include "references/dense_checks.h"
#include "references/guarded_sweeps.h"
#include "references/spring_equilibrium.h"

namespace maille {
namespace {

// Strokes in a volume, all of which stay pinned.
struct Strokes {
  std::string name;
  std::string title;
  Volume volume;
  std::vector<Material> materials;
  std::vector<Grab> grabs;
};

Material fold_free_material() {
  Material material;
  material.name = "tissue";
  material.value_low = 0.0;
  material.value_high = 1.0;
  material.compress = glm::dvec3(0.6);
  material.stretch = glm::dvec3(1.5);
  material.shear = glm::dvec3(0.25);
  return material;
}

Strokes ball_drag(int radius) {
  const int edge = 6 * radius;
  return {"ball",
          "a ball dragged by 0.8 of its radius",
          empty_volume(Size3(edge)),
          {fold_free_material()},
          {{VoxelIndex(edge / 2), static_cast<double>(radius), {0.8 * radius, 0, 0}}}};
}

Strokes opposed_drags(int radius) {
  const int edge = 6 * radius;
  const double small = 0.5 * radius;
  const VoxelIndex middle(edge / 2);
  const VoxelIndex aside(radius + radius / 2, 0, 0);
  const glm::dvec3 by(0.45 * radius, 0.1 * radius, 0);
  return {"opposed",
          "two balls pushed towards each other",
          empty_volume(Size3(edge)),
          {fold_free_material()},
          {{middle - aside, small, by}, {middle + aside, small, -by}}};
}

// The CT materials in layers: bone below, tissue and fat on it, air above. They shear further than
// the no-fold rule allows, and the drag is oblique.
Strokes layered_ct(int radius) {
  const int edge = 6 * radius;
  std::vector<std::int16_t> samples;
  for (int z = 0; z < edge; ++z) {
    const double height = static_cast<double>(z) / edge;
    const std::int16_t value = height < 0.2    ? 700
                               : height < 0.55 ? 60
                               : height < 0.65 ? -100
                                               : -1000;
    samples.insert(samples.end(), static_cast<std::size_t>(edge) * static_cast<std::size_t>(edge),
                   value);
  }
  return {
      "ct_layers",
      "CT materials in layers, skin dragged obliquely",
      Volume::of(Size3(edge), VoxelType::int16, axis_aligned(glm::dvec3(1)), std::move(samples)),
      MaterialTable::ct().materials(),
      {{VoxelIndex(edge / 2, edge / 2, edge * 5 / 9), 0.4 * radius,
        glm::dvec3(0.7, 0.4, 0.6) * static_cast<double>(radius)}}};
}

// In the middle a ball that is stiff, in a medium that all six faces shear.
SpringProblem sheared_ball(int edge, double blend, double blend_of_ball, double shear) {
  SpringProblem problem;
  problem.size = Size3(edge);
  SpringMaterial soft;
  soft.rest_vector_blend = blend;
  SpringMaterial stiff = soft;
  stiff.stiffness = 1000.0;
  stiff.rest_vector_blend = blend_of_ball;
  problem.materials = {soft, stiff};
  const double middle = 0.5 * (edge - 1);
  for (std::int64_t i = 0; i < voxel_count(problem.size); ++i) {
    const VoxelIndex at = voxel_of(static_cast<std::size_t>(i), problem.size);
    const glm::dvec3 away = glm::dvec3(at) - middle;
    problem.ids.push_back(glm::length(away) <= edge / 6.0 ? 1 : 0);
    problem.held.push_back(faces_of(at, problem.size) != 0);
    problem.start_voxels.emplace_back(shear * away.z, 0.0, 0.0);
  }
  return problem;
}

// The angle about y that fits the ball's elements best, in radians.
double turn_of_ball(const SpringProblem& problem, const DisplacementField& u_voxels) {
  const double middle = 0.5 * (problem.size.x - 1);
  double crossed = 0.0;
  double along = 0.0;
  for (std::size_t i = 0; i < u_voxels.size(); ++i) {
    if (problem.ids[i] != 1) continue;
    const glm::dvec3 rest = glm::dvec3(voxel_of(i, problem.size)) - middle;
    const glm::dvec3 now = rest + u_voxels[i];
    crossed += rest.z * now.x - rest.x * now.z;
    along += rest.z * now.z + rest.x * now.x;
  }
  return std::atan2(crossed, along);
}

constexpr FoldTerm kBarrier{FoldRule::determinant, 0.2, 1.0, 0.3};

// For a program and for a person.
std::pair<std::string, std::string> names_of(const FoldTerm& energy) {
  const std::string weight = short_number(energy.weight);
  if (energy.rule == FoldRule::limits) {
    return {"limit_springs_" + weight, "limits as springs of " + weight + " k"};
  }
  const std::string reach = fixed_number(energy.reach, 2);
  if (energy.rule == FoldRule::wall) {
    return {"wall_" + reach + "_" + weight, "Maille's: wall " + reach + ", weight " + weight};
  }
  std::string name = "barrier_" + reach + "_" + weight;
  std::string title = "barrier " + reach + ", weight " + weight;
  if (energy.straight_below != kBarrier.straight_below) {
    name += "_straight_below_" + short_number(energy.straight_below);
    title += ", straight below q = " + short_number(energy.straight_below);
  }
  return {std::move(name), std::move(title)};
}

class Study {
 public:
  Study(const FoldStudyOptions& options, WorkerPool& pool) : options_(options), pool_(pool) {}

  FoldStudy run() {
    for (const double blend : options_.scene_blends)
      add_scene(ball_drag(options_.ball_radius), blend);
    add_scene(opposed_drags(options_.ball_radius), 0.25);
    add_scene(layered_ct(options_.ball_radius), 0.25);
    for (const double blend : options_.blends) add_blend(blend);
    return std::move(study_);
  }

 private:
  SpringProblem chainmail_of(const Strokes& strokes, double blend) {
    Deformer deformer(strokes.volume, std::move(MaterialTable::create(strokes.materials)).value(),
                      {});
    play(strokes.grabs, deformer);
    return spring_problem_of(deformer, strokes.grabs, {}, blend);
  }

  void play(const std::vector<Grab>& grabs, Deformer& deformer) {
    for (const Grab& grab : grabs) {
      // Scenes of this file: nothing in them is refused.
      static_cast<void>(deformer.begin_stroke(grab.element, grab.radius_voxels).ok());
      static_cast<void>(deformer.drag_to(grab.by_voxels, pool_).ok());
      deformer.end_stroke();
    }
  }

  Equilibrium solve(const SpringProblem& problem, bool may_turn_corners = false) {
    EquilibriumOptions options;
    options.may_turn_corners = may_turn_corners;
    options.tolerance_voxels = 1e-6;
    options.largest_factorised = 500;  // conjugate gradients are faster from there on
    options.most_newton_steps = options_.most_newton_steps;
    return spring_equilibrium(problem, pool_, options);
  }

  void add_scene(const Strokes& strokes, double blend) {
    SpringProblem problem = chainmail_of(strokes, blend);
    FoldStudy::Scene scene;
    scene.name = strokes.name + "_blend_" + fixed_number(blend, 3);
    scene.title = strokes.title + ", blend " + fixed_number(blend, 3);
    scene.blend = blend;
    const DenseSprings springs(problem, pool_);
    scene.free_elements = springs.free_elements();
    scene.folded_at_start = dense_folded_cells(problem.size, problem.start_voxels);
    std::vector<std::uint8_t> counted;
    for (std::size_t i = 0; i < springs.count(); ++i) counted.push_back(!springs.held(i));

    options_.progress(scene.title + ": springs alone");
    const Equilibrium pure = solve(problem);
    const auto at_start = distance_between(problem.start_voxels, pure.u_voxels, counted);
    scene.start_rms_voxels = at_start.rms_voxels;
    scene.start_max_voxels = at_start.max_voxels;
    const double start_excess =
        springs.spring_energy(mm_of(problem.start_voxels, problem.spacing_mm)) - pure.energy;
    const auto judge = [&](FoldStudy::Way way, const DisplacementField& u_voxels) {
      const auto distance = distance_between(u_voxels, pure.u_voxels, counted);
      const auto u_mm = mm_of(u_voxels, problem.spacing_mm);
      way.rms_voxels = distance.rms_voxels;
      way.max_voxels = distance.max_voxels;
      way.folded_cells = dense_folded_cells(problem.size, u_voxels);
      way.least_determinant = springs.least_determinant(u_mm);
      way.energy_excess = (springs.spring_energy(u_mm) - pure.energy) / start_excess;
      scene.ways.push_back(std::move(way));
    };
    const auto by_newton = [&](std::string name, std::string title, const Equilibrium& found) {
      FoldStudy::Way way;
      way.name = std::move(name);
      way.title = std::move(title);
      way.steps = found.newton_steps;
      way.inner_steps = found.cg_steps;
      way.seconds = found.seconds;
      way.finished = found.converged;
      judge(std::move(way), found.u_voxels);
    };
    by_newton("none", "none", pure);
    const auto by_sweeps = [&](std::string name, std::string title, GuardedOptions guarded) {
      options_.progress(scene.title + ": " + title);
      guarded.most_sweeps = options_.most_sweeps;
      const GuardedAnswer answer = relax_guarded(problem, pool_, guarded);
      FoldStudy::Way way;
      way.name = std::move(name);
      way.title = std::move(title);
      way.steps = answer.sweeps;
      way.seconds = answer.seconds;
      way.finished = answer.still;
      judge(std::move(way), answer.u_voxels);
    };
    GuardedOptions clamped;
    by_sweeps("clamped", "every step clamped to the limits", clamped);
    for (const FoldTerm& energy : options_.energies) {
      problem.fold = energy;
      const auto [name, title] = names_of(energy);
      options_.progress(scene.title + ": " + title);
      by_newton(name, title, solve(problem));
    }
    problem.fold = kBarrier;
    options_.progress(scene.title + ": barrier, corners may turn");
    by_newton("barrier_may_turn", "barrier 0.20, weight 1, corners may turn on the way",
              solve(problem, true));
    problem.fold = {};
    GuardedOptions shortened;
    shortened.guard = StepGuard::determinant;
    for (const double least : {0.05, 0.2}) {
      shortened.least_determinant = least;
      by_sweeps("shortened_" + fixed_number(least, 2),
                "steps shortened at J = " + fixed_number(least, 2), shortened);
    }
    study_.scenes.push_back(std::move(scene));
  }

  void add_blend(double blend) {
    const Stopwatch start;
    options_.progress("blend " + fixed_number(blend, 3));
    FoldStudy::Blend out;
    out.blend = blend;
    const Strokes strokes = ball_drag(options_.ball_radius);
    SpringProblem problem = chainmail_of(strokes, blend);
    const Equilibrium direct = solve(problem);
    out.converged = direct.converged;
    out.stable = direct.stable;
    out.folded_cells = dense_folded_cells(problem.size, direct.u_voxels);
    std::vector<std::uint8_t> everywhere(problem.held.size(), 1);
    const auto apart = [&](const Equilibrium& a, const Equilibrium& b) {
      return distance_between(a.u_voxels, b.u_voxels, everywhere).max_voxels;
    };

    // There by another way: half of it and aside, then back aside and the rest.
    Deformer deformer(strokes.volume, std::move(MaterialTable::create(strokes.materials)).value(),
                      {});
    Grab aside = strokes.grabs[0];
    Grab rest = aside;
    aside.by_voxels = {0.5 * aside.by_voxels.x, 0.4 * aside.by_voxels.x, 0.0};
    rest.by_voxels -= aside.by_voxels;
    play({aside, rest}, deformer);
    SpringProblem detour = spring_problem_of(deformer, strokes.grabs, {}, blend);
    // The border holds what ChainMail made of it: the same for both.
    for (std::size_t i = 0; i < detour.held.size(); ++i) {
      if (detour.held[i]) detour.start_voxels[i] = problem.start_voxels[i];
    }
    out.detour_apart_voxels = apart(direct, solve(detour));

    SpringProblem from_rest = problem;
    for (std::size_t i = 0; i < from_rest.held.size(); ++i) {
      if (!from_rest.held[i]) from_rest.start_voxels[i] = glm::dvec3(0);
    }
    const Equilibrium rested = solve(from_rest);
    out.rest_apart_voxels = apart(direct, rested);
    out.rest_folded_cells = dense_folded_cells(problem.size, rested.u_voxels);

    problem.fold = detour.fold = kBarrier;
    const Equilibrium guarded = solve(problem);
    out.guarded_detour_apart_voxels = apart(guarded, solve(detour));
    out.guarded_folded_cells = dense_folded_cells(problem.size, guarded.u_voxels);

    const double shear = 0.3;
    const auto turn = [&](double of_ball) {
      const SpringProblem ball = sheared_ball(4 * options_.ball_radius, blend, of_ball, shear);
      return turn_of_ball(ball, solve(ball).u_voxels) / (0.5 * shear);
    };
    out.ball_turn = turn(blend);
    out.ball_turn_blend_in_soft = turn(blend / 1000.0);
    out.seconds = start.seconds();
    study_.blends.push_back(out);
  }

  const FoldStudyOptions& options_;
  WorkerPool& pool_;
  FoldStudy study_;
};

}  // namespace

std::vector<FoldTerm> default_energies() {
  std::vector<FoldTerm> energies;
  for (const double weight : {1.0, 4.0, 16.0}) {
    energies.push_back({FoldRule::limits, 0.0, weight, kBarrier.straight_below});
  }
  energies.push_back(kRelaxationFold);
  for (const double reach : {0.1, 0.2, 0.3}) {
    energies.push_back({FoldRule::determinant, reach, 1.0, kBarrier.straight_below});
  }
  for (const double weight : {0.1, 10.0}) {
    energies.push_back({FoldRule::determinant, 0.2, weight, kBarrier.straight_below});
  }
  return energies;
}

FoldStudy study_folds(const FoldStudyOptions& options, WorkerPool& pool) {
  return Study(options, pool).run();
}

}  // namespace maille
