#include "measure/resample_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>

namespace maille {
namespace {

using std::numbers::pi;

// A plane wave in the volume or in its displacements.
struct Wave {
  glm::dvec3 direction;  // any length
  double wavelength_voxels;
  double phase;
  glm::dvec3 by{0};

  glm::dvec3 radians_a_voxel() const {
    return glm::normalize(direction) * (2.0 * pi / wavelength_voxels);
  }
};

// Moves all of a scene by parts of a voxel, so that few voxels come to lie on an element, where
// interpolation has no error. Whole in the lattice's fixed point.
constexpr glm::dvec3 kAside(3.0 / 32.0, 5.0 / 16.0, -7.0 / 16.0);

ResampleScene affine_scene(std::string name, std::string title, const glm::dmat3& map,
                           glm::dvec3 still) {
  ResampleScene scene{std::move(name), std::move(title), {}, {}};
  scene.displacement = [=](glm::dvec3 p) {
    return Displacement{(map - glm::dmat3(1)) * (p - still) + kAside, map - glm::dmat3(1)};
  };
  scene.rest_positions = [still, rest_from_now = glm::inverse(map)](glm::dvec3 point) {
    return std::vector{still + rest_from_now * (point - still - kAside)};
  };
  return scene;
}

// Waves of half an edge and less at a usual 128 voxels, but no shorter in smaller volumes: how far
// trilinear displacements stray from them must not depend on the edge.
ResampleScene mild() {
  constexpr double kSteepest = 0.3;  // of any component along any axis
  static const Wave kWaves[] = {{{1, 0.2, -0.3}, 64, 0.3, {0.8, 0.5, -0.4}},
                                {{-0.3, 1, 0.4}, 56, 1.9, {-0.5, 0.9, 0.6}},
                                {{0.2, -0.5, 1}, 72, 4.0, {0.6, -0.3, 0.9}},
                                {{0.7, 0.7, 0.5}, 90, 2.6, {0.9, 0.8, 0.7}}};
  glm::dmat3 slopes(0);
  for (const Wave& wave : kWaves) {
    slopes += glm::outerProduct(glm::abs(wave.by), glm::abs(wave.radians_a_voxel()));
  }
  double most = 0.0;
  for (int a = 0; a < 3; ++a) {
    for (int c = 0; c < 3; ++c) most = std::max(most, slopes[a][c]);
  }
  ResampleScene scene{"mild", "mild: waves, slopes up to 0.3", {}, {}};
  scene.displacement = [scale = kSteepest / most](glm::dvec3 p) {
    Displacement d;
    for (const Wave& wave : kWaves) {
      const glm::dvec3 k = wave.radians_a_voxel();
      const double at = glm::dot(k, p) + wave.phase;
      d.u += scale * std::sin(at) * wave.by;
      d.gradient += scale * std::cos(at) * glm::outerProduct(wave.by, k);
    }
    return d;
  };
  return scene;
}

// Along x: 4 times in the middle, and a quarter towards the ends, which stay where they are.
ResampleScene stretched_locally(int edge) {
  constexpr double kMost = 4.0;
  constexpr double kLeast = 0.25;
  const double half = 0.5 * (edge - 1);
  // x'(X) = kLeast + (kMost - kLeast) exp(-((X - half) / width)^2), its sum the whole length.
  const double root_pi = std::sqrt(pi);
  double width = half * (1.0 - kLeast) * 2.0 / ((kMost - kLeast) * root_pi);
  for (int i = 0; i < 50; ++i) {  // the Gaussian's tails, all but none of them missing
    width = half * (1.0 - kLeast) * 2.0 / ((kMost - kLeast) * root_pi * std::erf(half / width));
  }
  ResampleScene scene{"stretched_locally", "stretched 4x in the middle along x", {}, {}};
  scene.displacement = [=](glm::dvec3 p) {
    const double s = (p.x - half) / width;
    const double gained = (kMost - kLeast) * width * 0.5 * root_pi * std::erf(s);
    Displacement d;
    d.u = kAside;
    d.u.x += half + kLeast * (p.x - half) + gained - p.x;
    d.gradient[0][0] = kLeast + (kMost - kLeast) * std::exp(-s * s) - 1.0;
    return d;
  };
  return scene;
}

// Slopes down to -0.95, and each component coupled to the next, so that nothing is along an axis
// alone. Its determinant stays above 0: 1 + du_x/dx >= 0.05 less at most 0.95 * 0.25 * 0.1 * 0.2.
ResampleScene near_folding() {
  constexpr double kSteepest = 0.95;
  constexpr double kBend = 0.25;  // how far the crests run obliquely
  const double k = 2.0 * pi / 64.0;
  ResampleScene scene{"near_folding", "close to folding: slopes down to -0.95", {}, {}};
  scene.displacement = [=](glm::dvec3 p) {
    const double crest = k * (p.x + kBend * p.y);
    Displacement d;
    d.u = {kSteepest / k * std::sin(crest), 0.1 / k * std::sin(k * p.z),
           0.2 / k * std::sin(k * p.x)};
    d.gradient[0] = {kSteepest * std::cos(crest), 0.0, 0.2 * std::cos(k * p.x)};
    d.gradient[1] = {kSteepest * kBend * std::cos(crest), 0.0, 0.0};
    d.gradient[2] = {0.0, 0.1 * std::cos(k * p.z), 0.0};
    return d;
  };
  return scene;
}

// x(X) = X + 6 sin(2 pi X / 24), which turns twice in 24 voxels.
class Folds {
 public:
  Displacement displacement(glm::dvec3 p) const {
    Displacement d;
    d.u = kAside;
    d.u.x += kHeight * std::sin(k_ * p.x);
    d.gradient[0][0] = kHeight * k_ * std::cos(k_ * p.x);
    return d;
  }

  // Between two turns x(X) rises or falls throughout: halving finds the one answer there.
  std::vector<glm::dvec3> rest_positions(glm::dvec3 point_voxels) const {
    const glm::dvec3 point = point_voxels - kAside;
    const double turn = std::acos(-1.0 / (kHeight * k_)) / k_;
    std::vector<glm::dvec3> rest;
    for (double wave = std::floor((point.x - kHeight) / kWavelength) - 1.0;
         wave <= (point.x + kHeight) / kWavelength + 1.0; ++wave) {
      for (const auto& [from, to] : {std::pair(-turn, turn), std::pair(turn, kWavelength - turn)}) {
        double low = wave * kWavelength + from;
        double high = wave * kWavelength + to;
        const double rising = now(high) > now(low) ? 1.0 : -1.0;
        if (rising * (now(low) - point.x) > 0.0 || rising * (now(high) - point.x) <= 0.0) continue;
        for (int i = 0; i < 60; ++i) {
          const double middle = 0.5 * (low + high);
          (rising * (now(middle) - point.x) > 0.0 ? high : low) = middle;
        }
        rest.emplace_back(0.5 * (low + high), point.y, point.z);
      }
    }
    return rest;
  }

 private:
  static constexpr double kHeight = 6.0;
  static constexpr double kWavelength = 24.0;
  double now(double rest) const { return rest + kHeight * std::sin(k_ * rest); }
  double k_ = 2.0 * pi / kWavelength;
};

}  // namespace

ResampleScene whole_shift_scene(std::string name, std::string title, glm::ivec3 by_voxels) {
  const glm::dvec3 by(by_voxels);
  ResampleScene scene{std::move(name), std::move(title), {}, {}};
  scene.displacement = [=](glm::dvec3) { return Displacement{by, glm::dmat3(0)}; };
  scene.rest_positions = [=](glm::dvec3 point) { return std::vector{point - by}; };
  scene.moves = false;
  return scene;
}

std::vector<ResampleScene> resample_scenes(int edge) {
  const glm::dvec3 middle(edge / 2);  // whole: displacements stay multiples of what they are by
  std::vector<ResampleScene> scenes;
  scenes.push_back(whole_shift_scene("rest", "at rest", glm::ivec3(0)));
  scenes.push_back(whole_shift_scene("shifted", "shifted by (5, -3, 2) voxels", {5, -3, 2}));
  scenes.push_back(mild());
  scenes.push_back(
      affine_scene("stretched", "stretched 4x along x, y and z", glm::dmat3(4), middle));
  scenes.push_back(stretched_locally(edge));
  scenes.push_back(affine_scene("squeezed", "squeezed to a quarter along x",
                                glm::dmat3(0.25, 0, 0, 0, 1, 0, 0, 0, 1), glm::dvec3(0)));
  // Columns: where a voxel along x, y, z goes.
  scenes.push_back(affine_scene("sheared", "sheared by 1/2 and 1/4",
                                glm::dmat3(1, 0, 0, 0.5, 1, 0, 0.25, 0.25, 1), middle));
  scenes.push_back(near_folding());
  ResampleScene folded{"folded", "folded: three layers in places", {}, {}};
  folded.displacement = [folds = Folds()](glm::dvec3 p) { return folds.displacement(p); };
  folded.rest_positions = [folds = Folds()](glm::dvec3 p) { return folds.rest_positions(p); };
  folded.folds = true;
  scenes.push_back(std::move(folded));
  return scenes;
}

double analytic_value(glm::dvec3 rest_voxels) {
  static const Wave kWaves[] = {{{1, 0.3, 0.2}, 18, 0.4},
                                {{-0.2, 1, 0.5}, 16, 2.1},
                                {{0.4, -0.3, 1}, 22, 3.7},
                                {{1, -1, 1}, 14, 5.2}};
  static const auto kDirections = [] {
    std::array<glm::dvec3, std::size(kWaves)> directions;
    for (std::size_t i = 0; i < directions.size(); ++i) directions[i] = kWaves[i].radians_a_voxel();
    return directions;
  }();
  double sum = 0.0;
  for (std::size_t i = 0; i < kDirections.size(); ++i) {
    sum += std::sin(glm::dot(kDirections[i], rest_voxels) + kWaves[i].phase);
  }
  return 0.5 + 0.5 * sum / static_cast<double>(kDirections.size());
}

std::optional<glm::dvec3> rest_by_newton(const ResampleScene& scene, glm::dvec3 point_voxels,
                                         glm::dvec3 start_voxels) {
  constexpr int kSteps = 60;
  constexpr int kHalvings = 30;
  constexpr double kSettled_voxels = 1e-12;
  glm::dvec3 rest = start_voxels;
  Displacement here = scene.displacement(rest);
  glm::dvec3 away = rest + here.u - point_voxels;
  for (int step = 0; step < kSteps && glm::length(away) > kSettled_voxels; ++step) {
    const glm::dvec3 by = glm::inverse(glm::dmat3(1) + here.gradient) * away;
    double share = 1.0;
    bool nearer = false;
    for (int halving = 0; halving < kHalvings && !nearer; ++halving, share *= 0.5) {
      const glm::dvec3 next = rest - share * by;
      const Displacement there = scene.displacement(next);
      const glm::dvec3 left = next + there.u - point_voxels;
      nearer = glm::length(left) < glm::length(away);
      if (nearer) {
        rest = next;
        here = there;
        away = left;
      }
    }
    if (!nearer) break;  // as near as doubles bring it, or lost
  }
  if (!(glm::length(away) <= kTruth_voxels)) return std::nullopt;
  return rest;
}

Lattice lattice_of(const ResampleScene& scene, Size3 size, WorkerPool& pool) {
  Lattice lattice(size);
  const BrickGrid grid = lattice.grid();
  std::vector<Lattice::Change> changes(static_cast<std::size_t>(grid.count()));
  pool.for_each(grid.count(), [&](std::int64_t b, int) {
    const auto brick = std::make_unique<BrickDisplacements>();
    const VoxelBox box = grid.box(grid.brick(b));
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        for (int x = box.lo.x; x < box.hi.x; ++x) {
          const glm::dvec3 u = scene.displacement({x, y, z}).u * double{kUnitsPerVoxel};
          const auto element = static_cast<std::size_t>(element_in_brick({x, y, z}));
          for (int c = 0; c < 3; ++c) {
            brick->u[c][element] = static_cast<std::int32_t>(std::lround(u[c]));
          }
        }
      }
    }
    changes[static_cast<std::size_t>(b)] = {b, LatticeBrick::create(box, *brick)};
  });
  lattice.set(changes);
  return lattice;
}

}  // namespace maille
