// Deformed volumes at random, by their seed.
#pragma once

#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "tests/measure/deformed_scenes.h"
#include "tests/resample/scenes.h"

namespace maille::testing {

enum class Shape {
  smooth,  // long waves; no two points of it lie in one place
  rough,   // every element by itself; no two points of it lie in one place either
  steep,   // layers stretched 4 times beside layers squeezed to a quarter; one answer everywhere
  folded,  // waves that fold over
  wild     // every element by itself, far past folding, many at rest
};

struct RandomScene {
  Size3 size;
  glm::dvec3 spacing_mm;
  Lattice lattice;
  bool folds;
};

class Chance {
 public:
  explicit Chance(unsigned seed) : random_(seed) {}

  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  glm::dvec3 vector(double most) {
    const double x = between(-most, most);
    const double y = between(-most, most);
    return {x, y, between(-most, most)};
  }
  // A few thousand voxels: one axis longer than a brick, the others as they come; each third is
  // thin.
  Size3 size() {
    constexpr int kVoxels = 6000;
    Size3 size;
    size.x = 33 + below(30);
    const int across = kVoxels / size.x;
    size.y = below(3) == 0 ? 1 + below(3) : 8 + below(across / 8 - 8);
    size.z = std::min(across / size.y, 40) - below(3);
    const int turn = below(3);
    return {size[turn], size[(turn + 1) % 3], size[(turn + 2) % 3]};
  }
  glm::dvec3 spacing_mm() {
    if (below(3) == 0) return glm::dvec3(1);
    const double x = between(0.5, 2.0);
    const double y = between(0.5, 2.0);
    return {x, y, between(0.5, 3.0)};
  }

 private:
  std::mt19937 random_;
};

// x = a(X) + b(Y) + c(Z), y = d(Y) + e(Z), z = f(Z), with a, d, f rising by a quarter to 4 from one
// layer to the next: that has one answer, and it is exactly what a lattice holds.
inline Field steep(Chance& chance, Size3 size) {
  using Layers = std::vector<double>;
  const auto layers = [&](int count, auto&& step) {
    Layers at(static_cast<std::size_t>(count), 0.0);
    for (std::size_t i = 1; i < at.size(); ++i) at[i] = at[i - 1] + step();
    const double middle = at[at.size() / 2];
    for (double& a : at) a -= middle;
    return at;
  };
  Layers own[3];
  for (int c = 0; c < 3; ++c) {
    own[c] = layers(size[c], [&] {
      return chance.below(2) == 0 ? chance.between(0.25, 1.0) : chance.between(1.0, 4.0);
    });
  }
  const auto slope = [&] { return chance.between(-0.5, 0.5); };
  const Layers x_by_y = layers(size.y, slope);
  const Layers x_by_z = layers(size.z, slope);
  const Layers y_by_z = layers(size.z, slope);
  const glm::dvec3 middle(size / 2);
  return [=](glm::dvec3 p) {
    const auto x = static_cast<std::size_t>(p.x);
    const auto y = static_cast<std::size_t>(p.y);
    const auto z = static_cast<std::size_t>(p.z);
    return middle - p +
           glm::dvec3(own[0][x] + x_by_y[y] + x_by_z[z], own[1][y] + y_by_z[z], own[2][z]);
  };
}

inline RandomScene random_scene(Shape shape, unsigned seed, std::optional<Size3> of_size = {}) {
  Chance chance(seed);
  const Size3 size = of_size ? *of_size : chance.size();
  const glm::dvec3 spacing_mm = chance.spacing_mm();
  const glm::dvec3 shift =
      chance.below(2) == 0 ? glm::dvec3(0) : chance.vector(0.2) * glm::dvec3(glm::min(size, 15));
  Field u;
  switch (shape) {
    case Shape::smooth:
      // Along three axes, 0.3 each, less than 1.
      u = [waves = smooth_waves(seed, 0.3), shift](glm::dvec3 p) { return waves(p) + shift; };
      break;
    case Shape::rough:
      // Edges differ from those at rest by at most twice that in each component.
      u = [&chance, shift](glm::dvec3) { return chance.vector(0.16) + shift; };
      break;
    case Shape::steep: u = steep(chance, size); break;
    case Shape::folded:
      u = [waves = smooth_waves(seed, 1.6), shift](glm::dvec3 p) { return waves(p) + shift; };
      break;
    case Shape::wild: {
      const bool border_rests = chance.below(2) == 0;
      u = [&chance, border_rests, size](glm::dvec3 p) {
        const bool at_border =
            glm::any(glm::equal(p, glm::dvec3(0))) || glm::any(glm::equal(p, glm::dvec3(size - 1)));
        const bool rests = (at_border && border_rests) || chance.below(4) == 0;
        return rests ? glm::dvec3(0) : chance.vector(1.4);
      };
      break;
    }
  }
  return {size, spacing_mm, lattice_from(size, u), shape == Shape::folded || shape == Shape::wild};
}

inline std::string text(VoxelIndex v) {
  return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}
inline std::string text(glm::dvec3 p) {
  return "(" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " + std::to_string(p.z) + ")";
}

inline std::vector<glm::dvec3> displacements_of(const Lattice& lattice) {
  std::vector<glm::dvec3> u_voxels;
  for_each_voxel(lattice.grid().volume_size(),
                 [&](VoxelIndex v) { u_voxels.push_back(lattice.displacement_voxels(v)); });
  return u_voxels;
}

inline std::string name_of_scene(
    const ::testing::TestParamInfo<std::tuple<Shape, unsigned>>& info) {
  constexpr const char* kShapes[] = {"smooth", "rough", "steep", "folded", "wild"};
  return std::string(kShapes[static_cast<int>(std::get<0>(info.param))]) +
         std::to_string(std::get<1>(info.param));
}

}  // namespace maille::testing
