// Staging ring, upload queue, images and read-back: what goes in comes out.

#include <algorithm>
#include <atomic>
#include <cstring>
#include <span>
#include <thread>

#include "gpu/readback.h"
#include "gpu/upload_queue.h"
#include "tests/gpu/gpu_fixture.h"

namespace maille::gpu {
namespace {

class Memory : public GpuTest {};

// Staged bricks are read again, for their value ranges.
TEST_F(Memory, ForStagingIsCachedWhereThereIsSuch) {
  MAILLE_NEEDS(Store::automatic);
  constexpr VkMemoryPropertyFlags wished = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                           VK_MEMORY_PROPERTY_HOST_COHERENT_BIT |
                                           VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  const auto& memory = device_->memory();
  const std::span types(memory.memoryTypes, memory.memoryTypeCount);
  const bool any = std::any_of(types.begin(), types.end(), [](const VkMemoryType& type) {
    return (type.propertyFlags & wished) == wished;
  });
  const auto chosen = memory_type_for(*device_, ~0u, MemoryUse::staging);
  ASSERT_TRUE(chosen);
  EXPECT_EQ((types[*chosen].propertyFlags & wished) == wished, any);
}

struct Case {
  Store store;
  VkFormat format;
  glm::ivec3 extent;
};

class Upload : public GpuTest, public ::testing::WithParamInterface<Case> {};

std::vector<std::byte> cut(const std::vector<std::byte>& all, glm::ivec3 extent, TexelBox box,
                           std::size_t texel) {
  std::vector<std::byte> out;
  for (int z = box.lo.z; z < box.hi.z; ++z) {
    for (int y = box.lo.y; y < box.hi.y; ++y) {
      const auto first = static_cast<std::size_t>((z * extent.y + y) * extent.x + box.lo.x) * texel;
      out.insert(out.end(), all.begin() + static_cast<std::ptrdiff_t>(first),
                 all.begin() + static_cast<std::ptrdiff_t>(
                                   first + static_cast<std::size_t>(box.size().x) * texel));
    }
  }
  return out;
}

TEST_P(Upload, RoundTripsEveryFormatBrickByBrick) {
  MAILLE_NEEDS(GetParam().store);
  const glm::ivec3 extent = GetParam().extent;
  const VkFormat format = GetParam().format;
  const std::size_t texel = texel_bytes(format);
  auto image = make_image3d(*queue_, extent, format, "volume");
  ASSERT_TRUE(image) << image.error().message;
  auto ring = StagingRing::create(*queue_, 32 * 32 * 32 * texel, 3);
  ASSERT_TRUE(ring);
  UploadQueue uploads(*queue_, **ring, **image);

  // Noise, but no NaN: a copy may quieten one.
  const auto count = static_cast<std::size_t>(extent.x * extent.y * extent.z);
  auto all = noise(count * texel, 7);
  if (format == VK_FORMAT_R32_SFLOAT) {
    for (std::size_t i = 0; i < count; ++i) {
      const float value = static_cast<float>(i) * 0.37f - 1000.0f;
      std::memcpy(all.data() + 4 * i, &value, 4);
    }
  }
  std::vector<glm::ivec3> fresh;
  ASSERT_TRUE((*image)->commit({glm::ivec3(0), extent}, fresh));
  int in_batch = 0;
  for (int z = 0; z < extent.z; z += 32) {
    for (int y = 0; y < extent.y; y += 32) {
      for (int x = 0; x < extent.x; x += 32) {
        const TexelBox box{{x, y, z}, glm::min(glm::ivec3{x, y, z} + 32, extent)};
        auto slot = (*ring)->acquire();
        ASSERT_TRUE(slot);
        const auto brick = cut(all, extent, box, texel);
        std::memcpy(slot->bytes().data(), brick.data(), brick.size());
        // In two parts, at a border that no page and no word respects.
        TexelBox left = box;
        TexelBox right = box;
        left.hi.x = right.lo.x = std::min(box.lo.x + 5, box.hi.x);
        if (!left.empty()) {
          ASSERT_TRUE(uploads.add(*slot, box, left));
        }
        if (!right.empty()) {
          ASSERT_TRUE(uploads.add(*slot, box, right));
        }
        uploads.finish(std::move(*slot));
        if (++in_batch % 2 == 0) {
          ASSERT_TRUE(uploads.submit());
        }
      }
    }
  }
  ASSERT_TRUE(uploads.submit());
  EXPECT_EQ(uploads.bytes(), all.size());

  Readback readback(*queue_);
  const auto whole = readback.image(**image, {glm::ivec3(0), extent});
  ASSERT_TRUE(whole);
  EXPECT_EQ(*whole, all);
  const TexelBox odd{glm::ivec3(1), extent - 1};
  if (!odd.empty()) {
    const auto part = readback.image(**image, odd);
    ASSERT_TRUE(part);
    EXPECT_EQ(*part, cut(all, extent, odd, texel));
  }
}

INSTANTIATE_TEST_SUITE_P(Stores, Upload,
                         ::testing::Values(Case{Store::dense, VK_FORMAT_R8_UNORM, {67, 33, 40}},
                                           Case{Store::dense, VK_FORMAT_R16_UNORM, {67, 33, 40}},
                                           Case{Store::dense, VK_FORMAT_R32_SFLOAT, {67, 33, 40}},
                                           Case{Store::dense, VK_FORMAT_R16_UNORM, {5, 1, 2}},
                                           Case{Store::sparse, VK_FORMAT_R8_UNORM, {67, 33, 40}},
                                           Case{Store::sparse, VK_FORMAT_R16_UNORM, {67, 33, 40}},
                                           Case{Store::sparse, VK_FORMAT_R32_SFLOAT, {67, 33, 40}},
                                           Case{Store::sparse, VK_FORMAT_R16_UNORM, {5, 7, 2}},
                                           Case{Store::sparse, VK_FORMAT_R16_UNORM, {64, 64, 3}}),
                         [](const auto& test) {
                           const Case& c = test.param;
                           return std::string(c.store == Store::sparse ? "sparse" : "dense") +
                                  std::to_string(8 * texel_bytes(c.format)) + "bit_" +
                                  std::to_string(c.extent.x) + "x" + std::to_string(c.extent.y) +
                                  "x" + std::to_string(c.extent.z);
                         });

using StagingRingTest = GpuTest;

TEST_F(StagingRingTest, SlotsComeBackWithTheTimelineThroughManyBatchesAndTwoThreads) {
  ASSERT_TRUE(open(Store::dense));
  constexpr int kBricks = 300;
  constexpr int kEdge = 8;
  auto image =
      make_image3d(*queue_, {kEdge, kEdge, kEdge * kBricks}, VK_FORMAT_R16_UNORM, "volume");
  ASSERT_TRUE(image);
  constexpr std::size_t kBytes = kEdge * kEdge * kEdge * 2;
  auto ring = StagingRing::create(*queue_, kBytes, 5);
  ASSERT_TRUE(ring);
  UploadQueue uploads(*queue_, **ring, **image);

  struct Filled {
    int brick;
    StagingRing::Slot slot;
  };
  std::mutex mutex;
  std::vector<Filled> filled;
  std::atomic<int> next{0};
  {
    std::vector<std::jthread> fillers;
    for (int thread = 0; thread < 2; ++thread) {
      fillers.emplace_back([&] {
        for (int brick = next++; brick < kBricks; brick = next++) {
          auto slot = (*ring)->acquire();
          ASSERT_TRUE(slot);
          const auto voxels = noise(kBytes, static_cast<unsigned>(brick));
          std::memcpy(slot->bytes().data(), voxels.data(), kBytes);
          std::lock_guard lock(mutex);
          filled.push_back({brick, std::move(*slot)});
        }
      });
    }
    for (int done = 0; done < kBricks;) {
      std::vector<Filled> batch;
      {
        std::lock_guard lock(mutex);
        batch.swap(filled);
      }
      if (batch.empty()) std::this_thread::yield();
      for (Filled& brick : batch) {
        const TexelBox box{{0, 0, brick.brick * kEdge}, {kEdge, kEdge, (brick.brick + 1) * kEdge}};
        ASSERT_TRUE(uploads.add(brick.slot, box, box));
        uploads.finish(std::move(brick.slot));
        ++done;
      }
      ASSERT_TRUE(uploads.submit());
    }
  }
  Readback readback(*queue_);
  const auto all = readback.image(**image, {glm::ivec3(0), {kEdge, kEdge, kEdge * kBricks}});
  ASSERT_TRUE(all);
  for (int brick = 0; brick < kBricks; ++brick) {
    const auto voxels = noise(kBytes, static_cast<unsigned>(brick));
    ASSERT_EQ(
        std::memcmp(all->data() + static_cast<std::size_t>(brick) * kBytes, voxels.data(), kBytes),
        0)
        << "brick " << brick;
  }
}

TEST_F(StagingRingTest, ADroppedSlotIsFreeAgain) {
  ASSERT_TRUE(open(Store::dense));
  auto ring = StagingRing::create(*queue_, 1000, 2);
  ASSERT_TRUE(ring);
  for (int i = 0; i < 10; ++i) {
    auto a = (*ring)->acquire();
    auto b = (*ring)->acquire();
    ASSERT_TRUE(a && b);
    EXPECT_NE(a->bytes().data(), b->bytes().data());
    EXPECT_EQ(a->bytes().size(), 1000u);
    auto none = (*ring)->try_acquire();
    ASSERT_TRUE(none);
    EXPECT_FALSE(none->has_value());
  }
}

TEST_F(StagingRingTest, ABlockedAcquireWakesWhenASlotIsDropped) {
  ASSERT_TRUE(open(Store::dense));
  auto ring = StagingRing::create(*queue_, 1000, 1);
  ASSERT_TRUE(ring);
  auto held = (*ring)->acquire();
  ASSERT_TRUE(held);
  std::optional<StagingRing::Slot> slot(std::move(*held));
  std::atomic<bool> got{false};
  std::jthread waiter([&] {
    auto next = (*ring)->acquire();
    EXPECT_TRUE(next);
    got = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_FALSE(got);
  slot.reset();
  waiter.join();
  EXPECT_TRUE(got);
}

using DenseImageTest = GpuTest;

TEST_F(DenseImageTest, StartsAsZerosAndIsAlwaysThere) {
  ASSERT_TRUE(open(Store::dense));
  auto image = make_image3d(*queue_, {20, 10, 5}, VK_FORMAT_R16_UNORM, "volume");
  ASSERT_TRUE(image);
  EXPECT_TRUE((*image)->committed({{3, 2, 1}, {20, 10, 5}}));
  EXPECT_FALSE((*image)->committed({{3, 2, 1}, {21, 10, 5}}));
  Readback readback(*queue_);
  const auto texels = readback.image(**image, {{0, 0, 0}, {20, 10, 5}});
  ASSERT_TRUE(texels);
  EXPECT_EQ(*texels, std::vector<std::byte>(2000, std::byte{0}));
}

TEST_F(DenseImageTest, TooLargeIsAnErrorWithASentence) {
  ASSERT_TRUE(open(Store::dense));
  if (device_->info().type != VK_PHYSICAL_DEVICE_TYPE_CPU) GTEST_SKIP() << "it may well fit here";
  const auto too_much = make_image3d(*queue_, {2048, 2048, 1024}, VK_FORMAT_R16_UNORM, "volume");
  ASSERT_FALSE(too_much);
  EXPECT_EQ(too_much.error().kind, ErrorKind::out_of_memory);
  EXPECT_NE(too_much.error().message.find("8192 MiB"), std::string::npos)
      << too_much.error().message;
  const auto too_long = make_image3d(*queue_, {1 << 20, 1, 1}, VK_FORMAT_R8_UNORM, "volume");
  ASSERT_FALSE(too_long);
  EXPECT_EQ(too_long.error().kind, ErrorKind::device);
}

}  // namespace
}  // namespace maille::gpu
