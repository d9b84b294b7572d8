// The GPU's pictures against the reference's, and against each other.
//
// Tolerance against the reference: at most 3 of 255 in any channel, for all but 0.5 % of the
// pixels; the others lie on silhouettes, where a rounding decides between surface and background.

#include <cstring>
#include <thread>

#include "tests/render/render_fixture.h"

namespace maille {
namespace {

constexpr int kTolerance = 3;
constexpr double kShare = 0.005;
constexpr PictureSize kSize{61, 47};  // no multiple of a work group

struct Case {
  const char* name;
  gpu::Store store;
  VoxelType type;
  RenderMode mode;
  bool shading;
  double step;
  bool turned;  // anisotropic and rotated
  bool inside;  // the camera is within the volume
  bool integrated = true;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class Raycast : public RenderTest, public ::testing::WithParamInterface<Case> {};

TEST_P(Raycast, AgreesWithTheReference) {
  const Case& c = GetParam();
  MAILLE_OPEN(renderer, c.store);
  const Size3 size{45, 40, 37};
  const glm::dmat4 world_from_voxel = c.turned
                                          ? turned_and_stretched({0.7, 1.1, 2.3}, {-30, 12, 50})
                                          : axis_aligned({1, 1, 1}, {10, 20, 30});
  const Volume volume = analytic(size, c.type, world_from_voxel, [](glm::dvec3 p) {
    return std::max(ball({22, 20, 18}, 13, 5)(p), 0.5 * std::sin(0.4 * p.x) * std::sin(0.5 * p.y));
  });
  const TransferFunction transfer = soft_transfer(c.type);
  const RenderSettings settings{.mode = c.mode,
                                .iso_value = in_type(c.type, 0.1),
                                .step_voxels = c.step,
                                .shading = c.shading,
                                .preintegration = c.integrated};
  show(*renderer, volume, transfer, settings);
  Camera camera = framing(size, world_from_voxel, kSize);
  camera = orbited(camera, kSize, {20, 9});
  if (c.inside) {
    camera.eye_mm = transform_point(world_from_voxel, {4, 30, 8});
    camera.vertical_fov_degrees = 70.0;
  }
  const Picture drawn = draw(*renderer, camera, kSize);
  const Picture expected = reference::picture(volume, transfer, settings, camera, kSize);
  const Difference d = difference(drawn, expected, kTolerance);
  EXPECT_LE(d.share_above, kShare) << "largest difference " << d.largest;
  // And it is a picture of something.
  EXPECT_GT(
      difference(drawn, {kSize, std::vector<std::uint8_t>(drawn.rgba.size(), 26)}, 30).share_above,
      0.1);
}

using enum RenderMode;
constexpr auto dense = gpu::Store::dense;
constexpr auto sparse = gpu::Store::sparse;

INSTANTIATE_TEST_SUITE_P(
    Modes, Raycast,
    ::testing::Values(
        Case{"composite", dense, VoxelType::int16, composite, true, 1.0, false, false},
        Case{"composite_flat", dense, VoxelType::int16, composite, false, 1.0, false, false},
        Case{"composite_fine", dense, VoxelType::int16, composite, true, 0.37, false, false},
        Case{"composite_coarse", dense, VoxelType::int16, composite, true, 2.7, true, false},
        Case{"composite_coarse_sparse", sparse, VoxelType::int16, composite, true, 9.5, true,
             false},
        Case{"composite_of_points", dense, VoxelType::int16, composite, true, 1.0, true, false,
             false},
        Case{"composite_of_points_sparse", sparse, VoxelType::int16, composite, true, 0.7, true,
             false, false},
        Case{"composite_turned", dense, VoxelType::int16, composite, true, 1.0, true, false},
        Case{"composite_inside", dense, VoxelType::int16, composite, true, 1.0, true, true},
        Case{"composite_uint8", dense, VoxelType::uint8, composite, true, 1.0, true, false},
        Case{"composite_int8", dense, VoxelType::int8, composite, true, 1.0, true, false},
        Case{"composite_uint16", dense, VoxelType::uint16, composite, true, 1.0, true, false},
        Case{"composite_float", dense, VoxelType::float32, composite, true, 1.0, true, false},
        Case{"composite_sparse", sparse, VoxelType::int16, composite, true, 1.0, true, false},
        Case{"composite_sparse_uint8", sparse, VoxelType::uint8, composite, true, 1.0, true, false},
        Case{"composite_sparse_float", sparse, VoxelType::float32, composite, true, 1.0, true,
             true},
        Case{"iso", dense, VoxelType::int16, iso, true, 1.0, false, false},
        Case{"iso_flat", dense, VoxelType::int16, iso, false, 1.0, false, false},
        Case{"iso_turned", dense, VoxelType::int16, iso, true, 0.5, true, false},
        Case{"iso_inside", dense, VoxelType::int16, iso, true, 1.0, true, true},
        Case{"iso_float", dense, VoxelType::float32, iso, true, 1.0, true, false},
        Case{"iso_sparse", sparse, VoxelType::int16, iso, true, 1.0, true, false},
        Case{"with_iso", dense, VoxelType::int16, composite_with_iso, true, 1.0, true, false},
        Case{"with_iso_sparse", sparse, VoxelType::int16, composite_with_iso, true, 0.6, true,
             false},
        Case{"average", dense, VoxelType::int16, average, false, 1.0, true, false},
        Case{"average_sparse", sparse, VoxelType::uint16, average, false, 1.0, true, false},
        Case{"mip", dense, VoxelType::int16, mip, false, 1.0, true, false},
        Case{"mip_sparse", sparse, VoxelType::uint8, mip, false, 1.0, true, false}),
    [](const auto& test) { return std::string(test.param.name); });

using RaycastTest = RenderTest;

// Three balls in a volume of mostly nothing, across brick and page borders.
Volume three_balls(VoxelType type = VoxelType::int16) {
  return analytic({100, 70, 66}, type, turned_and_stretched({1, 1.4, 0.8}, {0, 0, 0}),
                  [](glm::dvec3 p) {
                    return std::max({ball({30, 30, 30}, 9, 3)(p), ball({70, 32, 20}, 6, 2)(p),
                                     ball({90, 60, 62}, 5, 2)(p)});
                  });
}

class RaycastTypes : public RenderTest, public ::testing::WithParamInterface<VoxelType> {};
INSTANTIATE_TEST_SUITE_P(Types, RaycastTypes,
                         ::testing::Values(VoxelType::uint8, VoxelType::int8, VoxelType::uint16,
                                           VoxelType::int16, VoxelType::float32),
                         [](const auto& test) { return std::string(name_of(test.param)); });

TEST_P(RaycastTypes, SparseAndDensePicturesAreTheSameBits) {
  MAILLE_OPEN(sparse_renderer, gpu::Store::sparse);
  MAILLE_OPEN(dense_renderer, gpu::Store::dense);
  const Volume volume = three_balls(GetParam());
  const TransferFunction transfer = soft_transfer(volume.type());
  const Camera camera = framing(volume.size(), volume.world_from_voxel(), kSize);
  for (const RenderMode mode : kRenderModes) {
    const RenderSettings settings{.mode = mode, .iso_value = in_type(volume.type(), 0.0)};
    show(*sparse_renderer, volume, transfer, settings);
    show(*dense_renderer, volume, transfer, settings);
    EXPECT_EQ(draw(*sparse_renderer, camera, kSize).rgba,
              draw(*dense_renderer, camera, kSize).rgba);
    if (mode != mip && mode != average) {
      const RenderCounters counters = sparse_renderer->counters();
      EXPECT_LT(counters.pages_resident, counters.pages_total);
      EXPECT_GT(counters.pages_resident, 0);
    }
  }
}

TEST_F(RaycastTest, SkippingChangesNoBit) {
  MAILLE_OPEN(renderer, gpu::Store::dense);
  const Volume volume = three_balls();
  const TransferFunction transfer = soft_transfer(volume.type());
  for (const RenderMode mode : kRenderModes) {
    for (const double step : {1.0, 0.23, 3.7}) {
      RenderSettings settings{
          .mode = mode, .iso_value = in_type(volume.type(), 0.0), .step_voxels = step};
      show(*renderer, volume, transfer, settings);
      for (const glm::dvec2 turn : {glm::dvec2(0, 0), glm::dvec2(30, 0), glm::dvec2(11, -17)}) {
        const Camera camera =
            orbited(framing(volume.size(), volume.world_from_voxel(), kSize), kSize, turn);
        settings.skip_empty = true;
        ASSERT_TRUE(renderer->set_settings(settings));
        const Picture skipped = draw(*renderer, camera, kSize);
        settings.skip_empty = false;
        ASSERT_TRUE(renderer->set_settings(settings));
        EXPECT_EQ(skipped.rgba, draw(*renderer, camera, kSize).rgba)
            << "mode " << static_cast<int>(mode) << " step " << step;
      }
    }
  }
}

// What shows lies between what does not on both sides, and is thinner than a step: none of the
// samples may see it, and what lies between them counts all the same.
TEST_F(RaycastTest, SkippingChangesNoBitOfThinShells) {
  MAILLE_OPEN(renderer, gpu::Store::dense);
  const Volume volume = analytic({90, 80, 70}, VoxelType::int16, axis_aligned({1, 1, 1}),
                                 ball({44, 41, 36}, 27, 1.2));
  const auto at = [&](double unit) { return in_type(VoxelType::int16, unit); };
  const glm::dvec3 red(0.9, 0.4, 0.3);
  const auto shell = TransferFunction::of({{at(-1), red, 0.0},
                                           {at(-0.3), red, 0.0},
                                           {at(0), red, 0.5},
                                           {at(0.3), red, 0.0},
                                           {at(1), red, 0.0}});
  ASSERT_TRUE(shell);
  for (const RenderMode mode : {composite, composite_with_iso}) {
    for (const double step : {0.6, 2.3, 7.9, 15.0}) {
      RenderSettings settings{.mode = mode, .iso_value = at(0.9), .step_voxels = step};
      settings.shading = false;
      show(*renderer, volume, *shell, settings);
      const Camera camera =
          orbited(framing(volume.size(), volume.world_from_voxel(), kSize), kSize, {7, 5});
      const Picture skipped = draw(*renderer, camera, kSize);
      settings.skip_empty = false;
      ASSERT_TRUE(renderer->set_settings(settings));
      const Picture all = draw(*renderer, camera, kSize);
      EXPECT_EQ(skipped.rgba, all.rgba) << "step " << step;
      // It is seen: through each wall about as much, however coarse the step.
      const Picture expected = reference::picture(volume, *shell, settings, camera, kSize);
      EXPECT_LE(difference(all, expected, kTolerance).share_above, kShare) << "step " << step;
    }
  }
}

// Rays along the axes and along block walls are where skipping divides by zero.
TEST_F(RaycastTest, RaysAlongTheAxesSkipTheSameBits) {
  MAILLE_OPEN(renderer, gpu::Store::dense);
  const Volume volume =
      analytic({64, 64, 64}, VoxelType::uint8, axis_aligned({1, 1, 1}), ball({32, 32, 32}, 14, 3));
  RenderSettings settings{.iso_value = 128};
  show(*renderer, volume, soft_transfer(volume.type()), settings);
  for (const glm::dvec3 from : {glm::dvec3(1, 0, 0), glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 1)}) {
    Camera camera;
    camera.target_mm = {32, 32, 32};
    camera.eye_mm = camera.target_mm + from * 150.0;
    camera.up = glm::dvec3(from.z, from.x, from.y);
    settings.skip_empty = true;
    ASSERT_TRUE(renderer->set_settings(settings));
    const Picture skipped = draw(*renderer, camera, {33, 33});
    settings.skip_empty = false;
    ASSERT_TRUE(renderer->set_settings(settings));
    EXPECT_EQ(skipped.rgba, draw(*renderer, camera, {33, 33}).rgba);
    const Picture expected =
        reference::picture(volume, soft_transfer(volume.type()), settings, camera, {33, 33});
    EXPECT_LE(difference(skipped, expected, kTolerance).share_above, kShare);
  }
}

class RaycastStores : public RenderTest, public ::testing::WithParamInterface<gpu::Store> {};
INSTANTIATE_TEST_SUITE_P(Stores, RaycastStores, ::testing::Values(dense, sparse),
                         [](const auto& test) { return test.param == dense ? "dense" : "sparse"; });

TEST_P(RaycastStores, ATransferFunctionEditShowsWhatAFreshStartShows) {
  MAILLE_OPEN(edited, GetParam());
  MAILLE_OPEN(fresh, GetParam());
  const Volume volume =
      analytic({70, 66, 64}, VoxelType::int16, axis_aligned({1, 1, 1}), [](glm::dvec3 p) {
        return ball({33, 33, 30}, 5, 25)(p);
      });
  const VoxelType type = volume.type();
  // First only the core is visible, then the halo, then the core again: of the halo's pages no more
  // are kept than the core needs.
  const TransferFunction core = *TransferFunction::of({{in_type(type, -1), {1, 0, 0}, 0.0},
                                                       {in_type(type, 0.1), {1, 0, 0}, 0.0},
                                                       {in_type(type, 0.2), {1, 1, 0}, 0.4}});
  const TransferFunction halo = *TransferFunction::of({{in_type(type, -1), {0, 0, 1}, 0.0},
                                                       {in_type(type, -0.8), {0, 1, 1}, 0.03},
                                                       {in_type(type, 0.2), {1, 1, 0}, 0.4}});
  const RenderSettings settings;
  const Camera camera = framing(volume.size(), volume.world_from_voxel(), kSize);

  show(*edited, volume, core, settings);
  const Picture core_picture = draw(*edited, camera, kSize);
  const RenderCounters with_core = edited->counters();
  ASSERT_TRUE(edited->set_transfer_function(halo));
  EXPECT_EQ(edited->bricks_wanted().empty(), GetParam() == dense);
  stream(*edited, volume, edited->bricks_wanted());
  const Picture halo_picture = draw(*edited, camera, kSize);
  if (GetParam() == sparse) {
    EXPECT_GT(edited->counters().pages_resident, 2 * with_core.pages_resident);
  }
  show(*fresh, volume, halo, settings);
  EXPECT_EQ(halo_picture.rgba, draw(*fresh, camera, kSize).rgba);
  EXPECT_NE(halo_picture.rgba, core_picture.rgba);

  ASSERT_TRUE(edited->set_transfer_function(core));
  EXPECT_TRUE(edited->bricks_wanted().empty());
  EXPECT_EQ(draw(*edited, camera, kSize).rgba, core_picture.rgba);
  EXPECT_LE(edited->counters().pages_resident, 2 * with_core.pages_resident);
  ASSERT_TRUE(edited->set_transfer_function(halo));
  stream(*edited, volume, edited->bricks_wanted());
  EXPECT_EQ(draw(*edited, camera, kSize).rgba, halo_picture.rgba);
}

// A coarser step looks further around what shows, another mode at other blocks.
TEST_P(RaycastStores, EditedSettingsShowWhatAFreshStartShows) {
  MAILLE_OPEN(edited, GetParam());
  MAILLE_OPEN(fresh, gpu::Store::dense);
  const Volume volume = three_balls();
  const VoxelType type = volume.type();
  const TransferFunction transfer = soft_transfer(type);
  const Camera camera = framing(volume.size(), volume.world_from_voxel(), kSize);
  RenderSettings settings{.mode = composite, .iso_value = in_type(type, 0.2)};
  settings.preintegration = false;
  show(*edited, volume, transfer, settings);
  const auto expect_same = [&](const char* what) {
    SCOPED_TRACE(what);
    ASSERT_TRUE(edited->set_settings(settings));
    stream(*edited, volume, edited->bricks_wanted());
    show(*fresh, volume, transfer, settings);
    EXPECT_EQ(draw(*edited, camera, kSize).rgba, draw(*fresh, camera, kSize).rgba);
  };
  expect_same("as it was");
  settings.preintegration = true;
  expect_same("pre-integrated");
  settings.step_voxels = 11.0;
  expect_same("coarse");
  settings.mode = average;
  expect_same("average");
  settings.mode = composite_with_iso;
  settings.step_voxels = 2.0;
  expect_same("with a surface");
  settings.shading = false;
  settings.background = {0.5, 0.2, 0.1};
  expect_same("flat");
  settings.mode = iso;
  expect_same("a surface alone");
}

TEST_P(RaycastStores, AMovedObjectLooksAsIfItHadAlwaysBeenThere) {
  MAILLE_OPEN(moving, GetParam());
  MAILLE_OPEN(fresh, GetParam());
  const Size3 size{100, 70, 66};
  const auto at = [&](glm::dvec3 center) {
    return analytic(size, VoxelType::uint16, axis_aligned({1, 1, 1}), ball(center, 10, 3));
  };
  const TransferFunction transfer = soft_transfer(VoxelType::uint16);
  const RenderSettings settings;
  const Camera camera = framing(size, axis_aligned({1, 1, 1}), kSize);
  const Volume before = at({20, 20, 20});
  show(*moving, before, transfer, settings);
  const BrickGrid grid(size);
  for (const glm::dvec3 center :
       {glm::dvec3(31, 31, 31), glm::dvec3(60, 40, 33), glm::dvec3(20, 20, 20)}) {
    const Volume now = at(center);
    // Everything is streamed, in an order that is not the grid's.
    std::vector<std::int64_t> bricks;
    for (std::int64_t b = 0; b < grid.count(); ++b) bricks.push_back((b * 7) % grid.count());
    stream(*moving, now, bricks);
    const Picture picture = draw(*moving, camera, kSize);
    show(*fresh, now, transfer, settings);
    EXPECT_EQ(picture.rgba, draw(*fresh, camera, kSize).rgba);
  }
}

TEST_P(RaycastStores, WorkersMayFillWhileTheRenderThreadSubmits) {
  MAILLE_OPEN(renderer, GetParam());
  MAILLE_OPEN(fresh, GetParam());
  const Volume volume = three_balls();
  const TransferFunction transfer = soft_transfer(volume.type());
  ASSERT_TRUE(renderer->set_volume(volume));
  ASSERT_TRUE(renderer->set_transfer_function(transfer));
  VolumeTexture& texture = *renderer->texture();
  const std::int64_t count = texture.grid().count();
  std::atomic<std::int64_t> next{0};
  std::atomic<std::int64_t> finished{0};
  {
    std::vector<std::jthread> fillers;
    for (int thread = 0; thread < 2; ++thread) {
      fillers.emplace_back([&] {
        for (std::int64_t brick = next++; brick < count; brick = next++) {
          auto lent = texture.lend(brick);
          ASSERT_TRUE(lent);
          copy_brick(volume, lent->box, lent->voxels);
          texture.finish(std::move(*lent));
          ++finished;
        }
      });
    }
    while (finished < count) {
      ASSERT_TRUE(texture.submit());
      std::this_thread::yield();
    }
  }
  ASSERT_TRUE(texture.submit());
  stream(*renderer, volume, renderer->bricks_wanted());
  const Camera camera = framing(volume.size(), volume.world_from_voxel(), kSize);
  show(*fresh, volume, transfer, renderer->settings());
  EXPECT_EQ(draw(*renderer, camera, kSize).rgba, draw(*fresh, camera, kSize).rgba);
}

TEST_P(RaycastStores, ThinAndTinyVolumesAreSeen) {
  for (const Size3 size : {Size3{1, 1, 1}, Size3{40, 40, 1}, Size3{1, 40, 3}, Size3{33, 1, 65}}) {
    MAILLE_OPEN(renderer, GetParam());
    const Volume volume =
        analytic(size, VoxelType::uint8, axis_aligned({1, 1, 1}), [](glm::dvec3) { return 0.5; });
    const RenderSettings settings{.mode = iso, .iso_value = 10, .step_voxels = 0.25};
    const TransferFunction transfer = soft_transfer(volume.type());
    show(*renderer, volume, transfer, settings);
    const Camera camera = orbited(framing(size, volume.world_from_voxel(), kSize), kSize, {7, 5});
    const Picture drawn = draw(*renderer, camera, kSize);
    EXPECT_LE(difference(drawn, reference::picture(volume, transfer, settings, camera, kSize), 3)
                  .share_above,
              kShare);
    std::vector<std::uint8_t> nothing(drawn.rgba.size());
    for (std::size_t i = 0; i < nothing.size(); ++i) nothing[i] = drawn.rgba[i % 4];
    EXPECT_NE(drawn.rgba, nothing);
  }
}

// Padding of a float CT: NaN where the scanner saw nothing. 0 would be soft tissue.
TEST_P(RaycastStores, WhatIsNotFiniteIsShownAsTheLowestValue) {
  MAILLE_OPEN(renderer, GetParam());
  const Size3 size{40, 40, 40};
  const auto padded_with = [&](float padding, float elsewhere) {
    return analytic(size, VoxelType::float32, axis_aligned({1, 1, 1}), [&](glm::dvec3 p) {
      const double radius = glm::length(p - 19.5);
      return radius < 9 ? 300.0 : radius < 15 ? -1000.0 : p.x < 20 ? padding : elsewhere;
    });
  };
  const TransferFunction transfer = *TransferFunction::of(
      {{-1000, {1, 1, 1}, 0.0}, {-500, {1, 0, 0}, 0.0}, {300, {1, 1, 0}, 0.3}});
  const Camera camera = framing(size, axis_aligned({1, 1, 1}), kSize);
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  for (const RenderMode mode : kRenderModes) {
    const RenderSettings settings{.mode = mode, .iso_value = -300};
    const Volume air = padded_with(-1000, -1000);
    show(*renderer, air, transfer, settings);
    const Picture expected = draw(*renderer, camera, kSize);
    for (const float elsewhere : {nan, infinity, -infinity}) {
      show(*renderer, padded_with(nan, elsewhere), transfer, settings);
      EXPECT_EQ(draw(*renderer, camera, kSize).rgba, expected.rgba);
    }
    const auto hit = renderer->pick(camera, kSize, kSize / 2);
    ASSERT_TRUE(hit);
    ASSERT_TRUE(hit->has_value());
    EXPECT_NEAR(glm::length((*hit)->voxel - 19.5), 9.0, 1.0);
  }
}

TEST_P(RaycastStores, AVolumeWithoutAFiniteSampleShowsNothing) {
  MAILLE_OPEN(renderer, GetParam());
  const Volume volume = analytic({20, 20, 20}, VoxelType::float32, axis_aligned({1, 1, 1}),
                                 [](glm::dvec3) { return std::nan(""); });
  const TransferFunction opaque =
      *TransferFunction::of({{-1, {1, 1, 1}, 0.5}, {1, {1, 1, 1}, 0.5}});
  const Camera camera = framing(volume.size(), volume.world_from_voxel(), kSize);
  for (const RenderMode mode : kRenderModes) {
    show(*renderer, volume, opaque, {.mode = mode, .iso_value = -0.5});
    const Picture drawn = draw(*renderer, camera, kSize);
    for (std::size_t i = 0; i < drawn.rgba.size(); ++i) {
      ASSERT_EQ(drawn.rgba[i], drawn.rgba[i % 4]);
    }
    const auto hit = renderer->pick(camera, kSize, kSize / 2);
    ASSERT_TRUE(hit);
    EXPECT_FALSE(hit->has_value());
  }
}

TEST_F(RaycastTest, BoneShinesThroughSkinInTheCtPreset) {
  MAILLE_OPEN(renderer, gpu::Store::dense);
  const Size3 size{64, 64, 64};
  const auto head = [&](double bone) {
    std::vector<std::int16_t> samples;
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
          const double r = glm::length(glm::dvec3(x, y, z) - 31.5);
          const double skin = std::clamp((28.0 - r) / 1.5, 0.0, 1.0);
          const double skull = std::clamp((22.0 - r) / 1.5, 0.0, 1.0);
          samples.push_back(static_cast<std::int16_t>(-1000 + 1040 * skin + bone * skull));
        }
      }
    }
    return Volume::of<std::int16_t>(size, VoxelType::int16, axis_aligned({1, 1, 1}),
                                    std::move(samples));
  };
  const TransferFunction transfer = *TransferFunction::preset("ct-skin", -1000, 3000);
  const RenderSettings settings{.iso_value = transfer.surface_value()};
  const Camera camera = framing(size, axis_aligned({1, 1, 1}), kSize);
  const auto center = [&](const Volume& volume) {
    show(*renderer, volume, transfer, settings);
    const Picture picture = draw(*renderer, camera, kSize);
    const auto i = static_cast<std::size_t>((kSize.y / 2 * kSize.x + kSize.x / 2) * 4);
    return glm::ivec3(picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]);
  };
  const glm::ivec3 with_bone = center(head(1000));
  const glm::ivec3 without = center(head(0));
  EXPECT_GT(without.r, without.g + 20);  // skin
  EXPECT_GT(with_bone.r, with_bone.b);   // still skin
  EXPECT_GT(with_bone.b, without.b + 10);
  const auto hit = renderer->pick(camera, kSize, kSize / 2);
  ASSERT_TRUE(hit);
  ASSERT_TRUE(hit->has_value());
  EXPECT_NEAR((*hit)->value, -300.0, 20.0);
  EXPECT_NEAR(glm::length((*hit)->voxel - 31.5), 27.0, 0.5);
}

TEST_F(RaycastTest, WhatCannotBeDrawnIsAnError) {
  MAILLE_OPEN(renderer, gpu::Store::dense);
  EXPECT_FALSE(renderer->render({}, {10, 10}));
  EXPECT_FALSE(renderer->read_picture());
  EXPECT_FALSE(renderer->present({10, 10}));
  EXPECT_FALSE(renderer->pick({}, {10, 10}, {5, 5}));
  EXPECT_EQ(renderer->counters().pipelines, 0);
  const Volume volume = three_balls();
  show(*renderer, volume, soft_transfer(volume.type()), {});
  EXPECT_FALSE(renderer->render({}, {0, 10}));
  EXPECT_TRUE(renderer->render({}, {10, 10}));
  EXPECT_EQ(renderer->counters().pipelines, 1);
  EXPECT_EQ(renderer->counters().frames, 1);
  EXPECT_EQ(renderer->counters().bricks_uploaded, renderer->texture()->grid().count());
  EXPECT_EQ(renderer->counters().bytes_uploaded, volume.bytes().size());
  if (renderer->device().info().type == VK_PHYSICAL_DEVICE_TYPE_CPU) {
    const auto result = renderer->set_volume({2048, 2048, 1024}, VoxelType::int16, glm::dmat4(1.0));
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().kind, ErrorKind::out_of_memory);
    // And the renderer goes on with the next one.
    show(*renderer, volume, soft_transfer(volume.type()), {});
    EXPECT_TRUE(renderer->render({}, {10, 10}));
  }
}

TEST_F(RaycastTest, TimesOfEachPass) {
  MAILLE_OPEN(renderer, gpu::Store::dense);
  const Volume volume = three_balls();
  show(*renderer, volume, soft_transfer(volume.type()), {});
  draw(*renderer, framing(volume.size(), volume.world_from_voxel(), kSize), kSize);
  ASSERT_TRUE(renderer->pick({}, {10, 10}, {5, 5}));
  if (renderer->device().timestamp_bits() == 0) GTEST_SKIP() << "this device has no timestamps";
  const auto times = renderer->gpu_times();
  for (const char* pass : {"raycast", "upload", "pick"}) {
    ASSERT_TRUE(times.contains(pass)) << pass;
    EXPECT_GT(times.at(pass).total_ms, 0.0) << pass;
  }
}

}  // namespace
}  // namespace maille
