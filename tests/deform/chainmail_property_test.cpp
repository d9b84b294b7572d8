// The solver against Dijkstra's algorithm in plain arrays, bit by bit, on random scenes.
#include <algorithm>
#include <optional>
#include <random>

#include <gtest/gtest.h>

#include "deform/chainmail.h"
#include "deform/cuts_edit.h"
#include "deform/violations.h"
#include "references/exact_dijkstra.h"
#include "tests/deform/scenes.h"

namespace maille {
namespace {

using testing::Drag;
using testing::equal;
using testing::material;
using testing::random_volume;
using testing::table;

class RandomScene {
 public:
  RandomScene(unsigned seed, Size3 largest) : random_(seed) {
    const Size3 size{1 + below(largest.x), 1 + below(largest.y), 1 + below(largest.z)};
    const int kinds = 1 + below(4);
    volume_ = random_volume(size, kinds, 1 + below(6), seed);
    for (int k = 0; k < kinds; ++k) problem_.materials.push_back(random_material(k));
    field_.emplace(*volume_, table(problem_.materials));
    faces_ = static_cast<std::uint8_t>(below(3) == 0 ? 1 << below(6) : 0);
    lattice_ = Lattice(size);
    cuts_ = below(2) ? random_cuts(size) : Cuts(size);
    problem_.size = size;
    const auto samples = volume_->voxels<std::uint8_t>();
    problem_.ids.assign(samples.begin(), samples.end());
    problem_.start.assign(samples.size(), glm::ivec3(0));
    problem_.removed.resize(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const VoxelIndex v = voxel_of(i, size);
      for (int axis = 0; axis < 3; ++axis) {
        problem_.removed[i] |= static_cast<std::uint8_t>(cuts_.removed(v, axis) << axis);
      }
    }
  }

  // Another drag from where the last one ended, of at most so many units along each axis.
  void next_drag(glm::ivec3 most) {
    problem_.handle.clear();
    pinned_.clear();
    for (int n = 1 + below(5); n > 0; --n) problem_.handle.push_back(random_voxel());
    for (int n = below(3); n > 0; --n) {
      const VoxelIndex v = random_voxel();
      const auto& handle = problem_.handle;
      if (std::find(handle.begin(), handle.end(), v) == handle.end()) pinned_.push_back(v);
    }
    problem_.held = pinned_;
    for (std::size_t i = 0; i < problem_.ids.size(); ++i) {
      const VoxelIndex v = voxel_of(i, problem_.size);
      if (faces_of(v, problem_.size) & faces_) problem_.held.push_back(v);
    }
    for (int c = 0; c < 3; ++c) problem_.by[c] = below(2 * most[c]) - most[c];
    if (below(3) == 0) problem_.by.y = 0;
  }

  DenseAnswer expected() const { return exact_dijkstra(problem_); }
  ChainMailAnswer answer(int threads = 1, std::uint32_t brick_order = 0) const {
    const Drag drag{*field_,         lattice_, problem_.handle, pinned_,
                    {faces_, false}, cuts_,    threads,         brick_order};
    return drag.by(problem_.by);
  }
  void move_on(const ChainMailAnswer& answer, const DenseAnswer& expected) {
    lattice_ = answer.lattice;
    problem_.start = expected.u;
  }
  // The first element where they differ, or -1.
  std::int64_t difference(const Lattice& lattice, const DenseAnswer& expected) const {
    for (std::size_t i = 0; i < expected.u.size(); ++i) {
      if (lattice.u(voxel_of(i, problem_.size)) != expected.u[i]) {
        return static_cast<std::int64_t>(i);
      }
    }
    return -1;
  }
  Violations violations(const Lattice& lattice) const {
    return violations_of(lattice, *field_, cuts_);
  }
  glm::ivec3 by() const { return problem_.by; }

 private:
  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  VoxelIndex random_voxel() {
    const Size3 size = field_->size();
    return {below(size.x), below(size.y), below(size.z)};
  }

  Material random_material(int k) {
    Material m = material(k, k + 1, 1, 1, 0);
    if (below(4) != 0) {
      for (int axis = 0; axis < 3; ++axis) {
        m.compress[axis] = uniform(0.0, 1.0);
        m.stretch[axis] = 1.0 + uniform(0.0, below(3) == 0 ? 3.0 : 0.5);
        m.shear[axis] = below(4) == 0 ? 0.0 : uniform(0.0, 0.6);
      }
    }
    m.fixed = k == 3;
    return m;
  }

  // Links gone at random, most of a plane gone, and a few elements carved.
  Cuts random_cuts(Size3 size) {
    CutsEdit edit{Cuts(size)};
    const int plane_axis = below(3);
    const int plane = below(size[plane_axis]);
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
          const VoxelIndex v{x, y, z};
          for (int axis = 0; axis < 3; ++axis) {
            if (v[axis] + 1 >= size[axis]) continue;
            const bool on_plane = axis == plane_axis && v[axis] == plane && below(10) != 0;
            if (on_plane || below(40) == 0) edit.set_removed(v, axis, true);
          }
          if (below(200) != 0) continue;
          edit.set_carved(v, true);
          for_each_link(v, size, [&](VoxelIndex lower, int axis, VoxelIndex) {
            edit.set_removed(lower, axis, true);
          });
        }
      }
    }
    return edit.finish();
  }

  std::mt19937 random_;
  std::optional<Volume> volume_;
  std::optional<MaterialField> field_;
  std::uint8_t faces_ = 0;
  Lattice lattice_;
  Cuts cuts_;
  std::vector<VoxelIndex> pinned_;
  DenseProblem problem_;
};

class ChainMailProperty : public ::testing::TestWithParam<int> {};

// Random materials, anchors, cuts and sequences of drags from where the last one ended: the solver
// and the reference agree in every bit, and nothing is violated.
TEST_P(ChainMailProperty, EqualsDijkstra) {
  const auto seed = static_cast<unsigned>(GetParam());
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomScene scene(seed, {70, 50, 40});
  for (int drag = 0; drag < 5; ++drag) {
    SCOPED_TRACE("drag " + std::to_string(drag));
    // The fourth drag is too long for labels of 16 bits; the last one starts from where it led.
    scene.next_drag(drag == 3 ? glm::ivec3(90000, 70000, 200) : glm::ivec3(10000, 4000, 200));
    const DenseAnswer expected = scene.expected();
    const ChainMailAnswer answer = scene.answer();
    ASSERT_EQ(answer.moved_by, expected.moved_by);
    EXPECT_EQ(answer.clamped, expected.moved_by != scene.by());
    ASSERT_EQ(scene.difference(answer.lattice, expected), -1);
    ASSERT_EQ(scene.violations(answer.lattice).links, 0);
    scene.move_on(answer, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, ChainMailProperty, ::testing::Range(1, 61));

class ChainMailOrder : public ::testing::TestWithParam<int> {};

// Neither the number of workers nor the order of bricks changes a bit.
TEST_P(ChainMailOrder, ChangesNoBit) {
  const auto seed = static_cast<unsigned>(GetParam());
  SCOPED_TRACE("seed " + std::to_string(seed));
  RandomScene scene(seed, {150, 120, 90});
  for (int drag = 0; drag < 2; ++drag) {
    scene.next_drag({20000, 8000, 6000});
    const DenseAnswer expected = scene.expected();
    const ChainMailAnswer one = scene.answer();
    ASSERT_EQ(scene.difference(one.lattice, expected), -1) << "drag " << drag;
    for (const int threads : {1, 2, 3, 8}) {
      for (const std::uint32_t order : {0u, 7u, seed + 100u}) {
        const ChainMailAnswer other = scene.answer(threads, order);
        ASSERT_EQ(other.moved_by, one.moved_by);
        ASSERT_EQ(other.elements_moved, one.elements_moved);
        ASSERT_TRUE(equal(other.lattice, one.lattice)) << threads << " threads, order " << order;
      }
    }
    scene.move_on(one, expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, ChainMailOrder, ::testing::Range(101, 111));

}  // namespace
}  // namespace maille
