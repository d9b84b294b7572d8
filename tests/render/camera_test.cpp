#include "render/camera.h"

#include <gtest/gtest.h>

#include "volume/volume.h"

namespace maille {
namespace {

constexpr PictureSize kSize{320, 200};

TEST(Camera, TheMiddleOfThePictureLooksAtTheTarget) {
  const Camera camera{{10, -600, 20}, {1, 2, 3}, {0, 0, 1}, 40};
  const Ray ray = ray_through(camera, kSize, {160, 100});
  EXPECT_EQ(ray.origin_mm, camera.eye_mm);
  EXPECT_LT(glm::length(ray.direction - glm::normalize(camera.target_mm - camera.eye_mm)), 1e-12);
}

TEST(Camera, FromTheFrontPatientLeftIsOnTheRightAndHeadUp) {
  const Camera camera;  // looks along +y
  const Ray right = ray_through_pixel(camera, kSize, {319, 100});
  const Ray top = ray_through_pixel(camera, kSize, {160, 0});
  EXPECT_GT(right.direction.x, 0.1);
  EXPECT_GT(top.direction.z, 0.1);
  EXPECT_GT(right.direction.y, 0.5);
}

TEST(Camera, FieldOfViewIsThePicturesHeight) {
  Camera camera;
  camera.vertical_fov_degrees = 90;
  const Ray top = ray_through(camera, kSize, {160, 0});
  const Ray bottom = ray_through(camera, kSize, {160, 200});
  EXPECT_NEAR(glm::dot(top.direction, bottom.direction), 0.0, 1e-12);
}

TEST(Camera, ProjectUndoesRays) {
  const Camera camera{{10, -600, 20}, {1, 2, 3}, {0.3, 0.1, 1}, 25};
  for (const glm::dvec2 at : {glm::dvec2(0, 0), glm::dvec2(17.5, 180.25), glm::dvec2(320, 200)}) {
    const Ray ray = ray_through(camera, kSize, at);
    const auto back = project(camera, kSize, ray.origin_mm + 321.0 * ray.direction);
    ASSERT_TRUE(back);
    EXPECT_LT(glm::length(*back - at), 1e-9);
  }
  EXPECT_FALSE(project(camera, kSize, camera.eye_mm));
  EXPECT_FALSE(project(camera, kSize, camera.eye_mm - (camera.target_mm - camera.eye_mm)));
}

TEST(Camera, AGrabbedPointStaysUnderThePointerAtItsDepth) {
  const Camera camera{{10, -600, 20}, {1, 2, 3}, {0, 0, 1}, 25};
  const glm::dvec3 anchor{20, -40, 12};
  const auto start = project(camera, kSize, anchor);
  ASSERT_TRUE(start);
  const auto same = point_on_facing_plane(camera, kSize, *start, anchor);
  ASSERT_TRUE(same);
  EXPECT_LT(glm::length(*same - anchor), 1e-9);
  const auto moved = point_on_facing_plane(camera, kSize, *start + glm::dvec2(30, -8), anchor);
  ASSERT_TRUE(moved);
  EXPECT_NEAR(glm::dot(*moved - anchor, basis_of(camera).forward), 0.0, 1e-9);
  EXPECT_LT(glm::length(*project(camera, kSize, *moved) - *start - glm::dvec2(30, -8)), 1e-9);
  EXPECT_FALSE(point_on_facing_plane(camera, kSize, {0, 0}, camera.eye_mm));
}

TEST(Camera, FramingShowsEveryCornerAndFillsThePicture) {
  for (const PictureSize size : {PictureSize{320, 200}, PictureSize{100, 400}}) {
    for (const Size3 volume : {Size3{512, 512, 333}, Size3{10, 300, 20}, Size3{1, 1, 1}}) {
      const glm::dmat4 world_from_voxel = axis_aligned({0.5, 0.7, 1.5}, {-100, 30, 7});
      const Camera camera = framing(volume, world_from_voxel, size);
      double extent = 0.0;
      for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 voxel =
            glm::dvec3(corner & 1, (corner >> 1) & 1, corner >> 2) * glm::dvec3(volume) - 0.5;
        const auto at = project(camera, size, transform_point(world_from_voxel, voxel));
        ASSERT_TRUE(at);
        EXPECT_GE(at->x, 0.0);
        EXPECT_LE(at->x, size.x);
        EXPECT_GE(at->y, 0.0);
        EXPECT_LE(at->y, size.y);
        extent = std::max({extent, std::abs(at->x / size.x - 0.5), std::abs(at->y / size.y - 0.5)});
      }
      EXPECT_GT(extent, 0.3);
      EXPECT_GT(basis_of(camera).forward.y, 0.999);
    }
  }
}

TEST(Camera, MovesFollowThePointer) {
  const Camera camera{{0, -600, 0}, {0, 0, 0}, {0, 0, 1}, 30};
  // A point in front moves with the pointer in an orbit, the target in a pan.
  const glm::dvec3 nose{0, -50, 0};
  const auto before = *project(camera, kSize, nose);
  const auto orbit = *project(orbited(camera, kSize, {10, 5}), kSize, nose);
  EXPECT_GT(orbit.x, before.x);
  EXPECT_GT(orbit.y, before.y);
  EXPECT_NEAR(glm::length(orbited(camera, kSize, {10, 5}).eye_mm), 600, 1e-9);
  const auto pan = *project(panned(camera, kSize, {10, 5}), kSize, camera.target_mm);
  EXPECT_NEAR(pan.x, 170, 1e-9);
  EXPECT_NEAR(pan.y, 105, 1e-9);
  EXPECT_NEAR(glm::length(zoomed(camera, 2).eye_mm), 300, 1e-9);
  // A quarter turn clockwise brings what was on top to the right.
  const auto roll = *project(rolled(camera, 90), kSize, {0, 0, 50});
  EXPECT_GT(roll.x, 170);
  EXPECT_NEAR(roll.y, 100, 1e-9);
}

TEST(Camera, OrbitsAllTheWayRoundWithoutLosingItself) {
  Camera camera{{0, -600, 0}, {5, 6, 7}, {0, 0, 1}, 30};
  const double distance = glm::length(camera.eye_mm - camera.target_mm);
  for (int i = 0; i < 1000; ++i) camera = orbited(camera, kSize, {3, 7});
  EXPECT_NEAR(glm::length(camera.eye_mm - camera.target_mm), distance, 1e-6);
  EXPECT_NEAR(glm::dot(glm::normalize(camera.up), basis_of(camera).forward), 0.0, 1e-6);
}

TEST(Camera, ABasisEvenWhenUpIsOfNoUse) {
  for (const Camera& camera :
       {Camera{{0, 0, 0}, {0, 0, 5}, {0, 0, 1}, 30}, Camera{{1, 2, 3}, {1, 2, 3}, {0, 0, 1}, 30},
        Camera{{0, 0, 0}, {0, 1, 0}, {0, 0, 0}, 30}}) {
    const CameraBasis basis = basis_of(camera);
    EXPECT_NEAR(glm::dot(basis.right, basis.forward), 0.0, 1e-12);
    EXPECT_NEAR(glm::length(basis.right), 1.0, 1e-12);
    EXPECT_NEAR(glm::length(basis.down), 1.0, 1e-12);
  }
}

}  // namespace
}  // namespace maille
