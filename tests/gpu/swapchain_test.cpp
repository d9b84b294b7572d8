#include "gpu/swapchain.h"

#include "gpu/gpu_timers.h"
#include "gpu/readback.h"
#include "tests/gpu/gpu_fixture.h"

namespace maille::gpu {
namespace {

using SwapchainTest = GpuTest;

TEST_F(SwapchainTest, PresentsClearsResizesAndDrawsOverIt) {
  if (!Instance::create({.headless_surface = true})) {
    GTEST_SKIP() << "this machine has no headless surfaces";
  }
  ASSERT_TRUE(open(Store::dense, true));
  auto surface = Surface::create_headless(*instance_);
  ASSERT_TRUE(surface) << surface.error().message;
  auto picture = Image2D::create(*queue_, {64, 48}, "picture");
  ASSERT_TRUE(picture);
  auto swapchain = Swapchain::create(*queue_, surface->get(), true);
  ASSERT_TRUE(swapchain) << swapchain.error().message;

  const auto nothing = (*swapchain)->present(nullptr, {0, 0}, {});
  ASSERT_TRUE(nothing);
  EXPECT_FALSE(*nothing);
  int overlays = 0;
  const OverlayTarget target = (*swapchain)->overlay_target();
  EXPECT_NE(target.render_pass, VkRenderPass{});
  for (const VkExtent2D window : {VkExtent2D{64, 48}, VkExtent2D{100, 30}, VkExtent2D{64, 48}}) {
    for (int frame = 0; frame < 5; ++frame) {
      auto shown = (*swapchain)
                       ->present(
                           frame == 0 ? nullptr : &*picture, window,
                           frame % 2 == 0 ? DrawOverlay{} : [&](VkCommandBuffer) { ++overlays; });
      ASSERT_TRUE(shown) << shown.error().message;
      EXPECT_TRUE(*shown);
    }
  }
  EXPECT_EQ(overlays, 6);
  EXPECT_EQ((*swapchain)->overlay_target().render_pass, target.render_pass);
  swapchain->reset();
}

using PictureTest = GpuTest;

TEST_F(PictureTest, ComesBackAsItWasCleared) {
  ASSERT_TRUE(open(Store::dense));
  auto picture = Image2D::create(*queue_, {33, 7}, "picture");
  ASSERT_TRUE(picture);
  ASSERT_TRUE(queue_->run([&](VkCommandBuffer commands) {
    const VkClearColorValue color{{1.0f, 0.0f, 0.2f, 1.0f}};
    const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdClearColorImage(commands, picture->get(), VK_IMAGE_LAYOUT_GENERAL, &color, 1, &all);
  }));
  Readback readback(*queue_);
  const auto pixels = readback.image(*picture);
  ASSERT_TRUE(pixels);
  ASSERT_EQ(pixels->size(), 33u * 7u * 4u);
  EXPECT_EQ((*pixels)[0], std::byte{255});
  EXPECT_EQ((*pixels)[2], std::byte{51});
  EXPECT_FALSE(Image2D::create(*queue_, {0, 7}, "picture"));
  EXPECT_FALSE(Image2D::create(*queue_, {1u << 30, 7}, "picture"));
}

TEST_F(PictureTest, PassesAreTimed) {
  ASSERT_TRUE(open(Store::dense));
  auto timers = GpuTimers::create(*queue_);
  ASSERT_TRUE(timers);
  auto buffer = Buffer::create(*device_, 1 << 20, VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                               MemoryUse::device, "buffer");
  ASSERT_TRUE(buffer);
  for (int i = 0; i < 200; ++i) {  // more than there are queries
    auto commands = queue_->begin();
    ASSERT_TRUE(commands);
    const int timer = (*timers)->start(*commands, "fill");
    vkCmdFillBuffer(*commands, buffer->get(), 0, VK_WHOLE_SIZE, 7);
    (*timers)->stop(*commands, timer);
    auto value = queue_->submit(*commands);
    ASSERT_TRUE(value);
    (*timers)->submitted(*value);
  }
  ASSERT_TRUE(queue_->wait_all());
  if (device_->timestamp_bits() == 0) GTEST_SKIP() << "this device has no timestamps";
  const auto& times = (*timers)->times();
  ASSERT_TRUE(times.contains("fill"));
  EXPECT_EQ(times.at("fill").count, 200);
  EXPECT_GT(times.at("fill").total_ms, 0.0);
}

}  // namespace
}  // namespace maille::gpu
