// Whatever a person does to a volume, in any order: what it is resampled to.
#include <cmath>

#include <gtest/gtest.h>

#include "deform/deformer.h"
#include "tests/deform/scenes.h"
#include "tests/resample/faults.h"
#include "tests/resample/random_scenes.h"
#include "tests/resample/resampled.h"
#include "tests/resample/true_answers.h"

namespace maille {
namespace {

using namespace testing;

constexpr double kLowest = 100.0;  // of the values that are resampled
constexpr double kHighest = 200.0;

class Person {
 public:
  explicit Person(unsigned seed)
      : chance_(seed),
        size_(34 + chance_.below(12), 12 + chance_.below(10), 9 + chance_.below(10)),
        spacing_mm_(chance_.spacing_mm()),
        deformer_(
            random_volume(size_, 3, 1 + chance_.below(5), seed, spacing_mm_), materials(),
            {static_cast<std::uint8_t>(chance_.below(3) == 0 ? 1 << chance_.below(6) : 0), false}) {
  }

  // Some are refused (a handle all of which is carved): no matter.
  void do_something() {
    switch (chance_.below(9)) {
      case 0:
      case 1:
      case 2:
      case 3: drag(); break;
      case 4: {
        const auto disc =
            CutSurface::disc(anywhere(), chance_.vector(1.0), chance_.between(3, 25), spacing_mm_);
        if (disc.ok()) done_ += deformer_.cut(*disc).ok();
        break;
      }
      case 5: done_ += deformer_.carve(anywhere(), chance_.between(0.5, 5)).ok(); break;
      case 6: done_ += deformer_.restore(anywhere(), chance_.between(1, 6)).ok(); break;
      case 7: relax(); break;
      default:
        if (chance_.below(2) == 0) {
          deformer_.release_all();
        } else {
          deformer_.undo();
        }
    }
  }

  const Deformer& deformer() const { return deformer_; }
  Size3 size() const { return size_; }
  int done() const { return done_; }

  Volume values() {
    return volume_from<float>(size_, VoxelType::float32, spacing_mm_, [&](VoxelIndex) {
      return chance_.below(10) == 0 ? kLowest : chance_.between(kLowest, kHighest);
    });
  }

 private:
  MaterialTable materials() {
    std::vector<Material> all;
    for (int k = 0; k < 3; ++k) {
      all.push_back(material(k, k + 1, chance_.between(0.1, 1.0), chance_.between(1.0, 3.0),
                             chance_.between(0.0, 0.6), chance_.between(0.2, 5.0)));
    }
    return table(std::move(all));
  }
  glm::dvec3 anywhere() {
    return 0.5 * glm::dvec3(size_ - 1) + 0.5 * glm::dvec3(size_) * chance_.vector(1.0);
  }
  void drag() {
    const VoxelIndex from(chance_.below(size_.x), chance_.below(size_.y), chance_.below(size_.z));
    if (!deformer_.begin_stroke(from, chance_.between(0, 3)).ok()) return;
    const double most = chance_.below(6) == 0 ? 60.0 : 8.0;
    for (int i = 1 + chance_.below(2); i > 0; --i) {
      done_ += deformer_.drag_to(chance_.vector(most), workers()).ok();
    }
    deformer_.end_stroke();
  }
  void relax() {
    Relaxation relaxation = deformer_.relax(workers(), {});
    for (int i = 1 + chance_.below(3); i > 0; --i) relaxation.iterate();
    deformer_.mark_undo_step();
    deformer_.adopt(relaxation.lattice());
    ++done_;
  }

  Chance chance_;
  Size3 size_;
  glm::dvec3 spacing_mm_;
  Deformer deformer_;
  int done_ = 0;
};

// Between the cells that the method has and those of the reference, this far apart at most: bent
// faces that it takes to be triangles.
double between_cells_voxels(ResampleMethod method) {
  return method == ResampleMethod::barycentric ? 0.5 : 1e-3;
}

class Strokes : public ::testing::TestWithParam<unsigned> {};

TEST_P(Strokes, EndInValuesOfTheirRangeAndNothingUnfilled) {
  Person person(GetParam());
  const Volume volume = person.values();
  std::int64_t moved = 0;
  for (int look = 0; look < 3; ++look) {
    for (int i = 0; i < 3; ++i) person.do_something();
    const Lattice& lattice = person.deformer().lattice();
    const Cuts& cuts = person.deformer().cuts();
    const TrueAnswers truth(lattice, &cuts);
    for (const ResampleMethod method : kResampleMethods) {
      SCOPED_TRACE(std::string(name_of(method)) + ", look " + std::to_string(look));
      const auto out = resampled(volume, lattice, cuts, method, 1);
      EXPECT_EQ(out.counts.unfilled_voxels, 0);
      EXPECT_EQ(out.counts.voxels, voxel_count(person.size()));
      EXPECT_TRUE(same_bytes(out.volume, resampled(volume, lattice, cuts, method, 2).volume));
      moved += out.counts.moved_voxels;
      Faults beyond_range;
      Faults missing;
      std::int64_t background = 0;
      for_each_voxel(person.size(), [&](VoxelIndex v) {
        const double value = out.volume.value_at(v);
        if (value != kBackground) {
          if (!(value >= kLowest && value <= kHighest)) beyond_range.add(text(v), ": ", value);
          return;
        }
        ++background;
        // What is cut apart has other ends; where it is whole it is all of its cells.
        const auto answers = truth.at(v);
        if (answers.rest.empty() || truth.may_be_uncovered(v, between_cells_voxels(method))) return;
        missing.add(text(v), " of ", text(answers.rest[0]));
      });
      EXPECT_EQ(beyond_range.count(), 0) << beyond_range.first();
      EXPECT_EQ(missing.count(), 0) << missing.first();
      EXPECT_EQ(background, out.counts.background_voxels);
    }
  }
  EXPECT_GT(person.done(), 3);
  EXPECT_GT(moved, 0);
}
INSTANTIATE_TEST_SUITE_P(Seeds, Strokes, ::testing::Range(1u, 17u));

}  // namespace
}  // namespace maille
