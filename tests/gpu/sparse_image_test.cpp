#include "gpu/sparse_image.h"

#include <cstring>

#include "gpu/readback.h"
#include "gpu/upload_queue.h"
#include "tests/gpu/gpu_fixture.h"

namespace maille::gpu {
namespace {

class SparseImageTest : public GpuTest {
 protected:
  // 3 x 2 x 2 pages, whatever a page is here.
  bool prepare() {
    if (!open(Store::sparse)) return false;
    auto probe = make_image3d(*queue_, {256, 256, 128}, VK_FORMAT_R16_UNORM, "probe");
    EXPECT_TRUE(probe);
    page_ = (*probe)->page_texels();
    auto made = make_image3d(*queue_, page_ * glm::ivec3(3, 2, 2), VK_FORMAT_R16_UNORM, "volume");
    EXPECT_TRUE(made);
    image_ = std::move(*made);
    bytes_ = static_cast<std::size_t>(page_.x * page_.y * page_.z) * 2;
    auto ring = StagingRing::create(*queue_, bytes_, 2);
    EXPECT_TRUE(ring);
    ring_ = std::move(*ring);
    uploads_ = std::make_unique<UploadQueue>(*queue_, *ring_, *image_);
    return true;
  }
  void TearDown() override {
    uploads_.reset();
    ring_.reset();
    image_.reset();
    GpuTest::TearDown();
  }
  Result<void> upload(glm::ivec3 page, unsigned seed) {
    auto slot = ring_->acquire();
    if (!slot) return slot.error();
    const auto texels = noise(bytes_, seed);
    std::memcpy(slot->bytes().data(), texels.data(), bytes_);
    const TexelBox box = image_->page_box(page);
    if (auto added = uploads_->add(*slot, box, box); !added) return added;
    uploads_->finish(std::move(*slot));
    auto done = uploads_->submit();
    if (!done) return done.error();
    return {};
  }
  std::vector<std::byte> read(glm::ivec3 page) {
    auto texels = Readback(*queue_).image(*image_, image_->page_box(page));
    EXPECT_TRUE(texels);
    return *texels;
  }

  glm::ivec3 page_{0};
  std::size_t bytes_ = 0;
  std::unique_ptr<Image3D> image_;
  std::unique_ptr<StagingRing> ring_;
  std::unique_ptr<UploadQueue> uploads_;
};

#define PREPARE()                                          \
  if (!prepare()) {                                        \
    if (HasFailure()) return;                              \
    GTEST_SKIP() << "this device has no sparse 3D images"; \
  }                                                        \
  static_assert(true)

TEST_F(SparseImageTest, CommitsOnlyWhatABoxTouches) {
  PREPARE();
  EXPECT_EQ(image_->pages(), glm::ivec3(3, 2, 2));
  EXPECT_EQ(image_->footprint().pages_total, 12);
  EXPECT_EQ(image_->footprint().pages_resident, 0);
  std::vector<glm::ivec3> fresh;
  ASSERT_TRUE(image_->commit({page_ - 1, page_ + 1}, fresh));  // around a corner of 8 pages
  EXPECT_EQ(fresh.size(), 8u);
  fresh.clear();
  ASSERT_TRUE(image_->commit({glm::ivec3(0), page_}, fresh));
  EXPECT_TRUE(fresh.empty());
  EXPECT_EQ(image_->footprint().pages_resident, 8);
  EXPECT_TRUE(image_->committed({glm::ivec3(0), page_ * 2}));
  EXPECT_FALSE(image_->committed({glm::ivec3(0), page_ * 2 + glm::ivec3(1, 0, 0)}));
  ASSERT_TRUE(image_->flush());
}

TEST_F(SparseImageTest, PagesKeepTheirTexelsWhileOthersComeAndGo) {
  PREPARE();
  std::vector<glm::ivec3> fresh;
  const glm::ivec3 a{0, 0, 0};
  const glm::ivec3 b{2, 1, 1};
  const glm::ivec3 c{1, 0, 1};
  ASSERT_TRUE(image_->commit(image_->page_box(a), fresh));
  ASSERT_TRUE(image_->commit(image_->page_box(b), fresh));
  ASSERT_TRUE(upload(a, 1));
  ASSERT_TRUE(upload(b, 2));
  EXPECT_EQ(read(a), noise(bytes_, 1));
  EXPECT_EQ(read(b), noise(bytes_, 2));

  // b's memory goes to c; a stays as it is; b comes back, fresh, and is written anew.
  image_->release(b);
  ASSERT_TRUE(image_->flush());
  EXPECT_FALSE(image_->page_committed(b));
  fresh.clear();
  ASSERT_TRUE(image_->commit(image_->page_box(c), fresh));
  EXPECT_EQ(fresh, std::vector<glm::ivec3>{c});
  ASSERT_TRUE(upload(c, 3));
  EXPECT_EQ(read(a), noise(bytes_, 1));
  EXPECT_EQ(read(c), noise(bytes_, 3));
  fresh.clear();
  ASSERT_TRUE(image_->commit(image_->page_box(b), fresh));
  EXPECT_EQ(fresh, std::vector<glm::ivec3>{b});
  ASSERT_TRUE(upload(b, 4));
  EXPECT_EQ(read(b), noise(bytes_, 4));
  EXPECT_EQ(read(c), noise(bytes_, 3));
}

TEST_F(SparseImageTest, ReleaseAndCommitBeforeAFlushEndsWithThePageThere) {
  PREPARE();
  std::vector<glm::ivec3> fresh;
  const glm::ivec3 page{1, 1, 0};
  ASSERT_TRUE(image_->commit(image_->page_box(page), fresh));
  ASSERT_TRUE(image_->flush());
  image_->release(page);
  ASSERT_TRUE(image_->commit(image_->page_box(page), fresh));
  EXPECT_EQ(fresh.size(), 2u);
  ASSERT_TRUE(upload(page, 5));
  EXPECT_EQ(read(page), noise(bytes_, 5));
  ASSERT_TRUE(image_->commit(image_->page_box({0, 1, 0}), fresh));
  image_->release({0, 1, 0});
  ASSERT_TRUE(image_->flush());
  EXPECT_EQ(image_->footprint().pages_resident, 1);
}

// On lavapipe such a write sticks and reads back well; on a GPU it is lost. So it must not happen.
TEST_F(SparseImageTest, ACopyIntoAnUnboundPageIsRefused) {
  PREPARE();
  const auto refused = upload({1, 1, 1}, 6);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::failed);
  EXPECT_NE(refused.error().message.find("no page is bound"), std::string::npos);

  std::vector<glm::ivec3> fresh;
  ASSERT_TRUE(image_->commit(image_->page_box({1, 1, 1}), fresh));
  EXPECT_TRUE(upload({1, 1, 1}, 6));
  image_->release({1, 1, 1});
  EXPECT_FALSE(upload({1, 1, 1}, 7));
  ASSERT_TRUE(image_->flush());
}

TEST_F(SparseImageTest, MemoryComesInBlocksAndIsUsedAgain) {
  PREPARE();
  std::vector<glm::ivec3> fresh;
  ASSERT_TRUE(image_->commit({glm::ivec3(0), image_->extent()}, fresh));
  ASSERT_TRUE(image_->flush());
  const std::uint64_t bytes = image_->footprint().bytes;
  EXPECT_EQ(bytes, 12 * bytes_);  // a block is no larger than the whole image
  for (int round = 0; round < 3; ++round) {
    for (const glm::ivec3 page : fresh) image_->release(page);
    ASSERT_TRUE(image_->flush());
    fresh.clear();
    ASSERT_TRUE(image_->commit({glm::ivec3(0), image_->extent()}, fresh));
    ASSERT_TRUE(image_->flush());
  }
  EXPECT_EQ(image_->footprint().bytes, bytes);
}

}  // namespace
}  // namespace maille::gpu
