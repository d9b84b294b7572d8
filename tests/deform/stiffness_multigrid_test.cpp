// The multigrid as an operator, with plain loops for the Laplacian that it approximately inverts.
#include "deform/stiffness_multigrid.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/deform/spring_row_scenes.h"

namespace maille {
namespace {

using testing::for_each_voxel;
using testing::RelaxationScene;
using testing::springy;
using testing::workers;

class Operator {
 public:
  Operator(const SpringBox& box, WorkerPool& pool)
      : box_(box), pool_(pool), multigrid_(box, pool) {}

  BoxVectors zero() const { return make_box_vectors(box_.extent(), pool_); }
  BoxVectors random(unsigned seed) const {
    std::mt19937 random(seed);
    std::normal_distribution<float> number;
    BoxVectors v = zero();
    for_each([&](std::int64_t e) {
      for (auto& c : v) c[e] = number(random);
    });
    return v;
  }
  BoxVectors solved(const BoxVectors& forces) {
    BoxVectors moves = zero();
    multigrid_.solve(forces, moves);
    return moves;
  }
  BoxVectors laplacian_of(const BoxVectors& v) const {
    BoxVectors out = zero();
    for_each([&](std::int64_t e) {
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0.0;
        for (int s = 0; s < kSprings; ++s) {
          const double k = double{box_.stiffness(e, s)};
          if (k > 0.0) sum += k * (double{v[c][e]} - double{v[c][e + box_.step(s)]});
        }
        out[c][e] = static_cast<float>(sum);
      }
    });
    return out;
  }
  double dot(const BoxVectors& a, const BoxVectors& b) const {
    double sum = 0.0;
    for_each([&](std::int64_t e) {
      for (std::size_t c = 0; c < 3; ++c) sum += double{a[c][e]} * double{b[c][e]};
    });
    return sum;
  }
  template <class F>
  void for_each(F&& f) const {
    const std::int64_t count = voxel_count(box_.extent());
    for (std::int64_t e = 0; e < count; ++e) {
      if (box_.is_free(e)) f(e);
    }
  }

 private:
  const SpringBox& box_;
  WorkerPool& pool_;
  StiffnessMultigrid multigrid_;
};

struct Scene {
  const char* what;
  Size3 size;
  double ratio;
  bool cut;
  double contraction;  // of the error's norm by the slowest of the first steps
  bool symmetric;      // two levels: nothing in it minds what it is given
};
std::ostream& operator<<(std::ostream& out, const Scene& s) { return out << s.what; }

std::unique_ptr<RelaxationScene> made(const Scene& s) {
  const double radius = 0.3 * std::min({s.size.x, s.size.y, s.size.z});
  std::vector<std::uint8_t> samples;
  for_each_voxel(s.size, [&](VoxelIndex v) {
    samples.push_back(s.ratio > 1.0 &&
                      glm::length(glm::dvec3(v) - 0.5 * glm::dvec3(s.size)) < radius);
  });
  auto scene = std::make_unique<RelaxationScene>(
      Volume::of(s.size, VoxelType::uint8, axis_aligned(glm::dvec3(1)), std::move(samples)),
      std::vector<Material>{springy(0, 1.0), springy(1, s.ratio)});
  scene->anchors = {};
  if (s.cut) {
    const auto disc =
        CutSurface::disc(glm::dvec3(s.size) * 0.5 + 0.3, {1, 2, -1}, 9.0, glm::dvec3(1));
    scene->cuts = *cut_along(scene->cuts, Lattice(s.size), *disc);
  }
  return scene;
}

class Multigrid : public ::testing::TestWithParam<Scene> {
 protected:
  Multigrid()
      : scene_(made(GetParam())),
        box_({scene_->start, scene_->field, scene_->cuts, scene_->held, scene_->anchors},
             {VoxelIndex(1), scene_->size() - 1}, workers()),
        operator_(box_, workers()) {}

  std::unique_ptr<RelaxationScene> scene_;
  SpringBox box_;
  Operator operator_;
};

TEST_P(Multigrid, IsSymmetricAndPositive) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const BoxVectors f1 = operator_.random(2 * seed);
    const BoxVectors f2 = operator_.random(2 * seed + 1);
    const BoxVectors z1 = operator_.solved(f1);
    const BoxVectors z2 = operator_.solved(f2);
    const double size = std::sqrt(operator_.dot(z1, f1) * operator_.dot(z2, f2));
    EXPECT_GT(operator_.dot(z1, f1), 0.0);
    EXPECT_GT(operator_.dot(z2, f2), 0.0);
    // Conjugate gradients on the coarse levels choose their steps by what they are given, so from
    // the third level on it is symmetric only as far as they converge.
    EXPECT_NEAR(operator_.dot(z1, f2), operator_.dot(z2, f1),
                (GetParam().symmetric ? 1e-5 : 0.05) * size);
    // Twice the force is twice the moves, to the bit.
    BoxVectors twice = operator_.random(2 * seed);
    for (auto& c : twice) {
      operator_.for_each([&](std::int64_t e) { c[e] *= 2.0f; });
    }
    const BoxVectors moves = operator_.solved(twice);
    operator_.for_each([&](std::int64_t e) {
      if (moves[0][e] != 2.0f * z1[0][e]) ADD_FAILURE() << e;
    });
  }
}

// Each step along the moves for what force is left, to the least energy, takes from the error in
// energy at least a stated share.
TEST_P(Multigrid, ContractsTheError) {
  BoxVectors error = operator_.random(7);
  double norm = operator_.dot(error, operator_.laplacian_of(error));
  for (int step = 0; step < 12; ++step) {
    const BoxVectors force = operator_.laplacian_of(error);
    const BoxVectors moves = operator_.solved(force);
    const double length =
        operator_.dot(moves, force) / operator_.dot(moves, operator_.laplacian_of(moves));
    operator_.for_each([&](std::int64_t e) {
      for (std::size_t c = 0; c < 3; ++c) error[c][e] -= static_cast<float>(length) * moves[c][e];
    });
    const double left = operator_.dot(error, operator_.laplacian_of(error));
    EXPECT_LT(std::sqrt(left / norm), GetParam().contraction) << "step " << step;
    norm = left;
    if (norm < 1e-9) break;
  }
}

TEST_P(Multigrid, HoldsWhatIsHeldAndMindsNoThreads) {
  const BoxVectors force = operator_.random(5);
  const BoxVectors moves = operator_.solved(force);
  for (const int threads : {2, 3, 8}) {
    WorkerPool pool(threads);
    StiffnessMultigrid other(box_, pool);
    BoxVectors theirs = operator_.zero();
    other.solve(force, theirs);
    std::int64_t different = 0;
    for (std::int64_t e = 0; e < voxel_count(box_.extent()); ++e) {
      for (std::size_t c = 0; c < 3; ++c) {
        different += theirs[c][e] != moves[c][e];
        if (!box_.is_free(e)) {
          ASSERT_EQ(moves[c][e], 0.0f);
        }
      }
    }
    EXPECT_EQ(different, 0) << threads << " threads";
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, Multigrid,
    ::testing::Values(Scene{"two levels", Size3(10), 1, false, 0.6, true},
                      Scene{"two levels, stiff ball", Size3(10), 1000, false, 0.6, true},
                      Scene{"alike", Size3(33), 1, false, 0.6, false},
                      Scene{"stiff ball", Size3(33), 1000, false, 0.6, false},
                      Scene{"very stiff ball", Size3(33), 1e6, false, 0.6, false},
                      Scene{"cut", Size3(27, 30, 25), 50, true, 0.95, false},
                      Scene{"sheet", Size3(60, 50, 5), 1, false, 0.6, false},
                      Scene{"rod", Size3(140, 6, 7), 30, false, 0.6, false}));

}  // namespace
}  // namespace maille
