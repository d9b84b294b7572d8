// Boxes of springs of every kind of row, with a direction at random.
#pragma once

#include <optional>
#include <random>

#include "deform/carving.h"
#include "deform/cutting.h"
#include "deform/spring_rows.h"
#include "tests/deform/relaxing.h"

namespace maille::testing {

inline bool contains_voxel(const VoxelBox& box, VoxelIndex v) {
  return glm::all(glm::greaterThanEqual(v, box.lo)) && glm::all(glm::lessThan(v, box.hi));
}

// As a direction; the vectors become what is kept of them.
inline BoxDirection keep_as_direction(BoxVectors& vectors, Size3 extent, WorkerPool& pool) {
  BoxDirection direction(extent, pool);
  for (std::int64_t row = 0; row < std::int64_t{extent.y} * extent.z; ++row) {
    const std::int64_t begin = row * extent.x;
    float* const x = &vectors[0][begin];
    float* const y = &vectors[1][begin];
    float* const z = &vectors[2][begin];
    direction.set_row(row, x, y, z);
    direction.get_row(row, x, y, z);
  }
  return direction;
}

class RowScene {
 public:
  // One material and several, alike and different blends, cut or not, in a box with the volume's
  // border in it or far from it; the last one a row longer than the longest run. Then all of them
  // again with material that has yielded: all over, or in a corner only.
  static constexpr int kPlain = 13;
  static constexpr int kCount = 2 * kPlain;

  explicit RowScene(int number) : RowScene(number % kPlain, number >= kPlain) {}
  RowScene(int number, bool keeps)
      : scene_(volume_of(number), materials_of(number)),
        free_(number % 2 ? VoxelBox{{2, 1, 1}, scene_.size() - 2} : VoxelBox{{}, scene_.size()}) {
    std::mt19937 random(static_cast<unsigned>(number));
    std::uniform_real_distribution<double> off(-0.3, 0.3);
    scene_.displace([&](VoxelIndex) {
      return glm::dvec3(off(random), off(random), off(random)) + glm::dvec3(7, 0, -3);
    });
    scene_.hold([&](VoxelIndex) { return random() % 9 == 0; });
    if (number / 6 == 1) {
      const Size3 size = scene_.size();
      const auto disc =
          CutSurface::disc(glm::dvec3(size) * 0.5 + 0.3, {1, 2, -1}, 6.0, glm::dvec3(1));
      scene_.cuts = *cut_along(scene_.cuts, Lattice(size), *disc);
      scene_.cuts = carve(scene_.cuts, Lattice(size), {5, 6, 4}, 1.5);
    }
    if (keeps) {
      scene_.keep([&](VoxelIndex v) {
        const bool here = number % 4 < 2 || glm::all(glm::lessThan(v, VoxelIndex(8)));
        return here ? glm::dvec3(off(random), off(random), off(random)) : glm::dvec3(0);
      });
    }
    box_ =
        std::make_unique<SpringBox>(SpringBox::Problem{scene_.start, scene_.field, scene_.cuts,
                                                       scene_.held, scene_.anchors, &scene_.kept},
                                    free_, workers());
    direction_ = make_box_vectors(box_->extent(), workers());
    std::uniform_real_distribution<float> along(-1, 1);
    for_each_voxel(free_.size(), [&](VoxelIndex v) {
      const std::int64_t e = box_->element(v + free_.lo);
      for (std::size_t c = 0; c < 3; ++c) {
        direction_[c][e] = box_->is_free(e) ? along(random) : 0.0f;
      }
    });
    way_ = keep_as_direction(direction_, box_->extent(), workers());
  }

  const RelaxationScene& scene() const { return scene_; }
  const SpringBox& box() const { return *box_; }
  SpringBox& box() { return *box_; }
  const BoxVectors& direction() const { return direction_; }
  const BoxDirection& way() const { return *way_; }  // the same

  std::size_t element_of_volume(std::int64_t e) const {
    const Size3 extent = box_->extent();
    const VoxelIndex at(static_cast<int>(e % extent.x), static_cast<int>(e / extent.x % extent.y),
                        static_cast<int>(e / extent.x / extent.y));
    return static_cast<std::size_t>(linear_index(at + box_->lo(), scene_.size()));
  }
  // What lies outside of the box holds.
  SpringProblem twin() const {
    SpringProblem twin = scene_.twin();
    twin.fold = {};
    for_each_voxel(scene_.size(), [&](VoxelIndex v) {
      if (!contains_voxel(free_, v)) {
        twin.held[static_cast<std::size_t>(linear_index(v, scene_.size()))] = 1;
      }
    });
    return twin;
  }
  DisplacementField direction_of_volume() const {
    DisplacementField d(static_cast<std::size_t>(voxel_count(scene_.size())), glm::dvec3(0));
    for_each_voxel(free_.size(), [&](VoxelIndex v) {
      const std::int64_t e = box_->element(v + free_.lo);
      d[static_cast<std::size_t>(linear_index(v + free_.lo, scene_.size()))] = {
          direction_[0][e], direction_[1][e], direction_[2][e]};
    });
    return d;
  }

 private:
  static Volume volume_of(int number) {
    const Size3 size = number == kPlain - 1 ? Size3(300, 5, 5) : Size3(21, 13, 11);
    return random_volume(size, number / 2 % 3 == 0 ? 1 : 2, 4, 7, {1, 0.8, 1.5});
  }
  static std::vector<Material> materials_of(int number) {
    switch (number / 2 % 3) {
      case 0: return {springy(0, 3.0, 0.25)};
      case 1: return {springy(0, 1.0, 0.25), springy(1, 40.0, 0.25)};
      default: return {springy(0, 1.0, 0.25), springy(1, 40.0, 0.6)};
    }
  }

  RelaxationScene scene_;
  VoxelBox free_;
  std::unique_ptr<SpringBox> box_;
  BoxVectors direction_;
  std::optional<BoxDirection> way_;
};

// Calls f(run) for all rows, without the outermost `margin` elements.
template <class F>
void for_each_row_of(const SpringBox& box, int margin, F&& f) {
  const Size3 extent = box.extent();
  for (int z = margin; z < extent.z - margin; ++z) {
    for (int y = margin; y < extent.y - margin; ++y) {
      for_each_run(box, box.row(y, z), margin, extent.x - margin, f);
    }
  }
}

}  // namespace maille::testing
