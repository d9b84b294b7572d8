// The volume on the device: bricks in, one 3D texture out. The one room that knows both.
//
//              any thread                               render thread
//   lend(brick) -> fill the span -> finish(brick)      submit(): pages, then one copy for all
//
// A batch submitted is seen whole by the next frame, or not at all. Voxels go into the span in
// **texture encoding**: the volume's own type, little endian, x fastest, tightly packed over the
// brick's box; signed integers with the sign bit flipped (flips_sign_bit()), because only unsigned
// normalised formats are filtered everywhere. finish() reads the span for its value ranges and may
// rewrite it, so staging memory is cached where the device has such (gpu::MemoryUse::staging).
//
// On a CPU device 8-bit samples become 16-bit texels. Mesa's lavapipe filters 8-bit texels with
// weights and results of 8 bits (and only in dense images: sparse ones take its float path), so
// that shading shows steps, and dense and sparse pictures differ by up to 4 of 255.
//
// What is seen is decided here per 8^3 block, from the value ranges that finish() took and from
// what the picture asks for (Visibility). The sparse store keeps pages only for visible blocks and
// as far around them as interpolation and gradients reach (two voxels), and around their halo where
// a picture looks at that too. So a brick can be missing: bricks_wanted() says which ones the next
// picture needs; Renderer::stream asks until none is.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "gpu/image3d.h"
#include "gpu/staging_ring.h"
#include "gpu/upload_queue.h"
#include "render/block_ranges.h"
#include "render/render_mode.h"
#include "render/skip_grid.h"
#include "render/transfer_function.h"
#include "volume/volume.h"

namespace maille {

// Which values show anything at all.
struct Visibility {
  RenderMode mode = RenderMode::composite;
  double iso_value = 0.0;
  TransferFunction transfer;
  int halo_blocks = 0;  // so many around what shows something are looked at too
};

// Value = texel * scale + offset, texel as the sampler returns it.
struct TexelScale {
  double scale = 1.0;
  double offset = 0.0;
};

class VolumeTexture {
 public:
  // Memory lent for one brick. Dropped without finish() it goes back unused.
  struct StagedBrick {
    std::int64_t brick;  // BrickGrid::linear
    VoxelBox box;
    std::span<std::byte> voxels;
    gpu::StagingRing::Slot slot;
  };

  // staging_slots: how many bricks may be on their way at once. lowest_value: of the volume's
  // finite samples, put where a float sample is not finite; a volume without any (nullopt) shows
  // nothing. Errors: device (a size or format it cannot do), out_of_memory.
  static Result<std::unique_ptr<VolumeTexture>> create(gpu::WorkQueue& queue, Size3 size,
                                                       VoxelType type, int staging_slots,
                                                       std::optional<double> lowest_value,
                                                       gpu::GpuTimers* timers = nullptr);

  bool flips_sign_bit() const { return type_ == VoxelType::int8 || type_ == VoxelType::int16; }
  TexelScale texel_scale() const;
  const BrickGrid& grid() const { return grid_; }
  VoxelType type() const { return type_; }
  int staging_slots() const { return ring_->slot_count(); }

  // Any thread. lend() blocks until a slot is free; see StagingRing about who may wait.
  Result<StagedBrick> lend(std::int64_t brick);
  void finish(StagedBrick staged);

  // --- the render thread's ---

  // Sends every finished brick and returns the timeline value of the copy. What of a brick has no
  // page is left out, and wanted again when it gets one.
  Result<std::uint64_t> submit();

  // What the picture shows from now on; reads no voxel. May make bricks wanted. Pages that nothing
  // visible needs any more are kept, in case it comes back, while they are no more than those that
  // are needed.
  Result<void> set_visibility(const Visibility& visibility);

  // Bricks to stream before a picture is right, in linear order: never seen so far, or in a page
  // that has come since.
  std::vector<std::int64_t> bricks_wanted() const;

  // Those of them that were seen before.
  std::vector<std::int64_t> bricks_wanted_again() const;

  // Where rays may go on without a look; and a number that grows when that changes. Brought up to
  // date by submit() and set_visibility().
  const SkipGrid& skip_grid() const { return skip_grid_; }
  std::uint64_t skip_version() const { return skip_version_; }
  Size3 blocks() const { return ranges_.blocks(); }
  int halo_blocks() const { return visibility_ ? visibility_->halo_blocks : 0; }

  const gpu::Image3D& image() const { return *image_; }
  gpu::Footprint footprint() const { return image_->footprint(); }
  std::uint64_t gpu_bytes() const;  // image and staging
  std::int64_t bricks_uploaded() const { return bricks_uploaded_; }
  std::uint64_t bytes_uploaded() const { return uploads_->bytes(); }

 private:
  enum class BrickState : std::uint8_t { unseen, wanted, current };
  struct Finished {
    StagedBrick staged;
    BrickRanges ranges;
  };

  VolumeTexture() = default;
  bool is_visible(const ValueRange& range) const;
  VoxelBox reach_of(glm::ivec3 block) const;
  // Looks at a range of blocks (cut off at the volume) again and commits the pages they need.
  // All of them where halos have grown.
  Result<void> refresh(glm::ivec3 first_block, glm::ivec3 end_block, bool halo_grew = false);
  Result<void> trim();

  BrickGrid grid_;
  VoxelType type_ = VoxelType::uint8;
  bool widened_ = false;   // 8-bit samples in 16-bit texels
  bool blank_ = false;     // no finite sample: nothing is ever visible
  float stand_in_ = 0.0f;  // shown where a sample is not finite
  std::unique_ptr<gpu::Image3D> image_;
  std::unique_ptr<gpu::StagingRing> ring_;
  std::unique_ptr<gpu::UploadQueue> uploads_;

  std::mutex finished_mutex_;
  std::vector<Finished> finished_;

  BlockRanges ranges_;
  std::vector<BrickState> states_;
  SkipGrid skip_grid_;
  std::uint64_t skip_version_ = 0;
  std::unique_ptr<Visibility> visibility_;
  std::vector<std::int32_t> opaque_before_;  // [i]: entries of the table before i with any opacity
  std::int64_t bricks_uploaded_ = 0;
};

// Fills a span with a brick of a volume at rest, in texture encoding: what resampling does where
// nothing moved.
void copy_brick(const Volume& volume, VoxelBox box, std::span<std::byte> voxels);

}  // namespace maille
