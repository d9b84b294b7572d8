#include "tests/render/render_fixture.h"

namespace maille {
namespace {

constexpr PictureSize kSize{41, 31};

class Pick : public RenderTest, public ::testing::WithParamInterface<gpu::Store> {};
INSTANTIATE_TEST_SUITE_P(Stores, Pick, ::testing::Values(gpu::Store::dense, gpu::Store::sparse),
                         [](const auto& test) {
                           return test.param == gpu::Store::dense ? "dense" : "sparse";
                         });

TEST_P(Pick, FindsTheReferencesPointToAHundredthOfAVoxel) {
  MAILLE_OPEN(renderer, GetParam());
  const glm::dmat4 world_from_voxel = turned_and_stretched({0.7, 1.1, 2.3}, {-30, 12, 50});
  const Size3 size{50, 48, 45};
  const Volume volume =
      analytic(size, VoxelType::int16, world_from_voxel, ball({24, 22, 20}, 14, 6));
  const RenderSettings settings{.mode = RenderMode::iso, .iso_value = in_type(volume.type(), 0.1)};
  show(*renderer, volume, soft_transfer(volume.type()), settings);
  const Camera camera =
      zoomed(orbited(framing(size, world_from_voxel, kSize), kSize, {13, 6}), 1.8);
  int hits = 0;
  int misses = 0;
  for (int y = 0; y < kSize.y; y += 3) {
    for (int x = 0; x < kSize.x; x += 3) {
      const Ray ray = ray_through_pixel(camera, kSize, {x, y});
      const reference::March m = reference::march(volume, ray);
      const auto expected = reference::first_hit(volume, m, settings);
      // A ray that grazes the surface may go either way.
      const RenderSettings low{.iso_value = in_type(volume.type(), 0.09)};
      const RenderSettings high{.iso_value = in_type(volume.type(), 0.11)};
      const bool sure = reference::first_hit(volume, m, low).has_value() ==
                        reference::first_hit(volume, m, high).has_value();
      const auto found = renderer->pick(camera, kSize, {x, y});
      ASSERT_TRUE(found) << found.error().message;
      if (!sure) continue;
      ASSERT_EQ(found->has_value(), expected.has_value()) << x << ", " << y;
      if (!expected) {
        ++misses;
        continue;
      }
      ++hits;
      const PickHit& hit = **found;
      const glm::dvec3 voxel = m.entry + m.direction * *expected;
      EXPECT_LT(glm::length(hit.voxel - voxel), 0.01) << x << ", " << y;
      EXPECT_LT(glm::length(hit.world_mm - transform_point(world_from_voxel, voxel)), 0.025);
      EXPECT_NEAR(hit.value, settings.iso_value, 60.0);  // of 65536
      const glm::dvec3 gradient = reference::gradient_voxel(volume, voxel);
      glm::dvec3 normal =
          glm::normalize(glm::transpose(glm::dmat3(glm::inverse(world_from_voxel))) * gradient);
      if (glm::dot(normal, ray.direction) > 0.0) normal = -normal;
      EXPECT_GT(glm::dot(hit.normal, normal), 0.999);
      EXPECT_NEAR(glm::length(hit.normal), 1.0, 1e-9);
    }
  }
  EXPECT_GT(hits, 20);
  EXPECT_GT(misses, 10);
}

TEST_P(Pick, HitsWhatTheIsoPictureShows) {
  MAILLE_OPEN(renderer, GetParam());
  const Size3 size{50, 48, 45};
  const Volume volume =
      analytic(size, VoxelType::uint8, axis_aligned({1, 1, 1}), ball({24, 22, 20}, 14, 6));
  const RenderSettings settings{.mode = RenderMode::iso, .iso_value = 140, .shading = false};
  show(*renderer, volume, soft_transfer(volume.type()), settings);
  const Camera camera = framing(size, volume.world_from_voxel(), kSize);
  ASSERT_TRUE(renderer->render(camera, kSize));
  const auto picture = renderer->read_picture();
  ASSERT_TRUE(picture);
  for (int y = 0; y < kSize.y; y += 2) {
    for (int x = 0; x < kSize.x; x += 2) {
      const auto i = static_cast<std::size_t>((y * kSize.x + x) * 4);
      const bool shown = picture->rgba[i] != picture->rgba[0];
      const auto hit = renderer->pick(camera, kSize, {x, y});
      ASSERT_TRUE(hit);
      EXPECT_EQ(hit->has_value(), shown) << x << ", " << y;
    }
  }
  EXPECT_EQ(renderer->counters().pipelines, 2);
}

TEST_P(Pick, FromWithinAndFromTheOtherSide) {
  MAILLE_OPEN(renderer, GetParam());
  const Size3 size{64, 64, 64};
  const Volume volume = analytic(size, VoxelType::int16, axis_aligned({2, 2, 2}), [](glm::dvec3 p) {
    return -ball({32, 32, 32}, 20, 4)(p);  // a hollow
  });
  show(*renderer, volume, soft_transfer(volume.type()),
       {.mode = RenderMode::iso, .iso_value = in_type(volume.type(), 0.0)});
  for (const glm::dvec3 direction :
       {glm::dvec3(1, 0, 0), glm::dvec3(0, 0, -1), glm::normalize(glm::dvec3(1, -2, 3))}) {
    const auto hit = renderer->pick(Ray{{64, 64, 64}, direction});
    ASSERT_TRUE(hit);
    ASSERT_TRUE(hit->has_value());
    EXPECT_NEAR(glm::length((*hit)->voxel - 32.0), 20.0, 0.06);
    EXPECT_LT(glm::dot((*hit)->normal, direction), -0.99);
  }
  const auto behind = renderer->pick(Ray{{-500, 64, 64}, {-1, 0, 0}});
  ASSERT_TRUE(behind);
  EXPECT_FALSE(behind->has_value());
  // A ray that starts in material hits where it starts.
  const auto started = renderer->pick(Ray{{2, 64, 64}, {1, 0, 0}});
  ASSERT_TRUE(started);
  ASSERT_TRUE(started->has_value());
  EXPECT_NEAR((*started)->voxel.x, 1.0, 1e-3);
}

}  // namespace
}  // namespace maille
