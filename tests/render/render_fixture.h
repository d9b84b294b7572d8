// Small analytic volumes, a renderer for them, and how pictures are compared.
#pragma once

#include <cmath>
#include <cstdlib>
#include <functional>

#include <gtest/gtest.h>

#include "render/renderer.h"
#include "tests/render/reference.h"

namespace maille {

inline glm::dmat4 turned_and_stretched(glm::dvec3 spacing_mm, glm::dvec3 origin_mm) {
  // A rotation that mixes all axes; columns are orthonormal.
  const glm::dvec3 a = glm::normalize(glm::dvec3(0.8, 0.5, -0.2));
  const glm::dvec3 b = glm::normalize(glm::cross(glm::dvec3(0.1, 0.3, 0.9), a));
  const glm::dvec3 c = glm::cross(a, b);
  glm::dmat4 m(1.0);
  m[0] = glm::dvec4(a * spacing_mm.x, 0.0);
  m[1] = glm::dvec4(b * spacing_mm.y, 0.0);
  m[2] = glm::dvec4(c * spacing_mm.z, 0.0);
  m[3] = glm::dvec4(origin_mm, 1.0);
  return m;
}

// f(voxel) in -1..1, spread over the type's own range of values (float: -1..1).
inline Volume analytic(Size3 size, VoxelType type, const glm::dmat4& world_from_voxel,
                       const std::function<double(glm::dvec3)>& f) {
  return with_voxel_type(type, [&]<class T>() {
    std::vector<T> samples;
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
          const double value = f({x, y, z});
          if constexpr (std::is_floating_point_v<T>) {
            samples.push_back(static_cast<T>(value));
          } else {
            const double low = std::numeric_limits<T>::lowest();
            const double high = std::numeric_limits<T>::max();
            samples.push_back(static_cast<T>(
                std::lround(low + (std::clamp(value, -1.0, 1.0) + 1.0) / 2.0 * (high - low))));
          }
        }
      }
    }
    return Volume::of<T>(size, type, world_from_voxel, std::move(samples));
  });
}

// Where -1..1 of analytic() lies in a type's values.
inline double in_type(VoxelType type, double unit) {
  return with_voxel_type(type, [&]<class T>() -> double {
    if constexpr (std::is_floating_point_v<T>) return unit;
    const double low = static_cast<double>(std::numeric_limits<T>::lowest());
    const double high = static_cast<double>(std::numeric_limits<T>::max());
    return low + (unit + 1.0) / 2.0 * (high - low);
  });
}

// A ball with a soft edge, 0 on its surface.
inline std::function<double(glm::dvec3)> ball(glm::dvec3 center, double radius, double softness) {
  return [=](glm::dvec3 p) {
    return std::clamp((radius - glm::length(p - center)) / softness, -1.0, 1.0);
  };
}

// Clear below 0, reddish above, whiter inside.
inline TransferFunction soft_transfer(VoxelType type) {
  return *TransferFunction::of({{in_type(type, -1.0), {0.2, 0.2, 0.9}, 0.0},
                                {in_type(type, -0.2), {0.6, 0.3, 0.2}, 0.0},
                                {in_type(type, 0.3), {0.9, 0.5, 0.3}, 0.08},
                                {in_type(type, 1.0), {1.0, 1.0, 0.8}, 0.15}});
}

struct Difference {
  int largest = 0;
  double share_above = 0.0;  // of pixels, in any channel
};

inline Difference difference(const Picture& a, const Picture& b, int tolerance) {
  Difference d;
  EXPECT_EQ(a.size, b.size);
  EXPECT_EQ(a.rgba.size(), b.rgba.size());
  std::size_t above = 0;
  for (std::size_t i = 0; i + 3 < std::min(a.rgba.size(), b.rgba.size()); i += 4) {
    int worst = 0;
    for (std::size_t c = 0; c < 4; ++c)
      worst = std::max(worst, std::abs(a.rgba[i + c] - b.rgba[i + c]));
    d.largest = std::max(d.largest, worst);
    if (worst > tolerance) ++above;
  }
  d.share_above = static_cast<double>(above) / static_cast<double>(a.rgba.size() / 4);
  return d;
}

class RenderTest : public ::testing::Test {
 protected:
  std::unique_ptr<Renderer> make(gpu::Store store, int staging_slots = 8) {
    const char* name = std::getenv("MAILLE_TEST_DEVICE");
    auto made = Renderer::create({.device = name != nullptr ? name : "",
                                  .store = store,
                                  .validation_log = log_,
                                  .staging_slots = staging_slots});
    if (!made) {
      if (store != gpu::Store::sparse) ADD_FAILURE() << made.error().message;
      return nullptr;
    }
    return std::move(*made);
  }
  // A renderer that the fixture keeps and asks for complaints at the end.
  Renderer* open(gpu::Store store, int staging_slots = 8) {
    auto made = make(store, staging_slots);
    if (!made) return nullptr;
    renderers_.push_back(std::move(made));
    return renderers_.back().get();
  }
  void TearDown() override {
    renderers_.clear();
    for (const std::string& message : log_->take()) {
      ADD_FAILURE() << "validation layer: " << message;
    }
  }

  void show(Renderer& renderer, const Volume& volume, const TransferFunction& transfer,
            const RenderSettings& settings) {
    ASSERT_TRUE(renderer.set_volume(volume));
    ASSERT_TRUE(renderer.set_transfer_function(transfer));
    ASSERT_TRUE(renderer.set_settings(settings));
    stream(renderer, volume, renderer.bricks_wanted());
  }
  void stream(Renderer& renderer, const Volume& volume, const std::vector<std::int64_t>& bricks) {
    const auto done = renderer.stream(
        bricks, pool_, [&](std::int64_t, VoxelBox box, std::span<std::byte> voxels, bool, int) {
          copy_brick(volume, box, voxels);
        });
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(renderer.bricks_wanted().empty());
  }
  static Picture draw(Renderer& renderer, const Camera& camera, PictureSize size) {
    const auto rendered = renderer.render(camera, size);
    EXPECT_TRUE(rendered) << rendered.error().message;
    auto picture = renderer.read_picture();
    EXPECT_TRUE(picture);
    return std::move(*picture);
  }

  WorkerPool pool_{2};
  std::shared_ptr<gpu::ValidationLog> log_ = std::make_shared<gpu::ValidationLog>();
  std::vector<std::unique_ptr<Renderer>> renderers_;
};

#define MAILLE_OPEN(renderer, store)                       \
  Renderer* renderer = open(store);                        \
  if (renderer == nullptr) {                               \
    if (HasFailure()) return;                              \
    GTEST_SKIP() << "this device has no sparse 3D images"; \
  }                                                        \
  static_assert(true)

}  // namespace maille
