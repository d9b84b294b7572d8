#include "render/volume_texture.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "shared/pass_constants.h"

namespace maille {
namespace {

static_assert(kBlockEdge == shader::k_block_edge);

VkFormat format_of(VoxelType type) {
  switch (type) {
    case VoxelType::uint8:
    case VoxelType::int8: return VK_FORMAT_R8_UNORM;
    case VoxelType::uint16:
    case VoxelType::int16: return VK_FORMAT_R16_UNORM;
    case VoxelType::float32: break;
  }
  return VK_FORMAT_R32_SFLOAT;
}

// Turns the 8-bit samples at the front of a slot into as many 16-bit texels: v/255 = 257 v/65535.
void widen(std::span<std::byte> slot, std::size_t samples) {
  for (std::size_t i = samples; i-- > 0;) {
    const auto texel = static_cast<std::uint16_t>(257 * std::to_integer<int>(slot[i]));
    std::memcpy(&slot[2 * i], &texel, sizeof texel);
  }
}

gpu::TexelBox texels(const VoxelBox& box) { return {box.lo, box.hi}; }

template <class F>
void for_each_in(glm::ivec3 lo, glm::ivec3 hi, F&& f) {
  for (int z = lo.z; z < hi.z; ++z) {
    for (int y = lo.y; y < hi.y; ++y) {
      for (int x = lo.x; x < hi.x; ++x) f(glm::ivec3{x, y, z});
    }
  }
}

}  // namespace

Result<std::unique_ptr<VolumeTexture>> VolumeTexture::create(gpu::WorkQueue& queue, Size3 size,
                                                             VoxelType type, int staging_slots,
                                                             std::optional<double> lowest_value,
                                                             gpu::GpuTimers* timers) {
  std::unique_ptr<VolumeTexture> texture(new VolumeTexture);
  texture->grid_ = BrickGrid(size);
  texture->type_ = type;
  texture->widened_ =
      bytes_per_voxel(type) == 1 && queue.device().info().type == VK_PHYSICAL_DEVICE_TYPE_CPU;
  texture->blank_ = !lowest_value;
  texture->stand_in_ = static_cast<float>(lowest_value.value_or(0.0));
  const VkFormat format = texture->widened_ ? VK_FORMAT_R16_UNORM : format_of(type);
  auto image = gpu::make_image3d(queue, size, format, "volume");
  if (!image) return image.error();
  texture->image_ = std::move(*image);
  const auto slots = static_cast<int>(std::clamp<std::int64_t>(
      staging_slots, 2, std::max<std::int64_t>(2, texture->grid_.count())));
  auto ring = gpu::StagingRing::create(queue, kBrickVoxels * gpu::texel_bytes(format), slots);
  if (!ring) return ring.error();
  texture->ring_ = std::move(*ring);
  texture->uploads_ =
      std::make_unique<gpu::UploadQueue>(queue, *texture->ring_, *texture->image_, timers);
  texture->ranges_ = BlockRanges(size);
  texture->states_.assign(static_cast<std::size_t>(texture->grid_.count()), BrickState::unseen);
  texture->skip_grid_ = SkipGrid(texture->ranges_.blocks());
  return texture;
}

TexelScale VolumeTexture::texel_scale() const {
  switch (type_) {
    case VoxelType::uint8: return {255.0, 0.0};
    case VoxelType::int8: return {255.0, -128.0};
    case VoxelType::uint16: return {65535.0, 0.0};
    case VoxelType::int16: return {65535.0, -32768.0};
    case VoxelType::float32: break;
  }
  return {1.0, 0.0};
}

std::uint64_t VolumeTexture::gpu_bytes() const {
  return image_->footprint().bytes + ring_->bytes();
}

Result<VolumeTexture::StagedBrick> VolumeTexture::lend(std::int64_t brick) {
  auto slot = ring_->acquire();
  if (!slot) return slot.error();
  const VoxelBox box = grid_.box(grid_.brick(brick));
  const auto bytes = static_cast<std::size_t>(voxel_count(box.size())) * bytes_per_voxel(type_);
  const auto voxels = slot->bytes().first(bytes);
  return StagedBrick{brick, box, voxels, std::move(*slot)};
}

void VolumeTexture::finish(StagedBrick staged) {
  const BrickRanges ranges = ranges_of_brick(staged.box.size(), staged.voxels, type_, stand_in_);
  if (widened_) widen(staged.slot.bytes(), staged.voxels.size());
  std::lock_guard lock(finished_mutex_);
  finished_.push_back({std::move(staged), ranges});
}

// The voxels that samples in a block and its halo touch: the cells' corners, and one voxel further
// on each side for central differences.
VoxelBox VolumeTexture::reach_of(glm::ivec3 block) const {
  const glm::ivec3 lo = (block - halo_blocks()) * kBlockEdge;
  const glm::ivec3 hi = (block + 1 + halo_blocks()) * kBlockEdge;
  return {glm::max(lo - 1, glm::ivec3(0)), glm::min(hi + 2, grid_.volume_size())};
}

bool VolumeTexture::is_visible(const ValueRange& range) const {
  if (!visibility_ || blank_ || range.empty()) return false;
  // Interpolated values stray from their range by rounding.
  const double stray = type_ == VoxelType::float32
                           ? 1e-5 * std::max(std::abs(range.lowest), std::abs(range.highest))
                           : 0.01;
  const TransferFunction& transfer = visibility_->transfer;
  const RenderMode mode = visibility_->mode;
  if (mode == RenderMode::mip || mode == RenderMode::average) {
    return range.highest >= transfer.lowest() - stray;
  }
  if (shows_iso(mode) && range.highest >= visibility_->iso_value - stray) return true;
  if (!composites(mode)) return false;
  constexpr int last = shader::k_transfer_entries - 1;
  const double span = transfer.highest() - transfer.lowest();
  const auto entry = [&](double value) {
    return span > 0.0 ? std::clamp((value - transfer.lowest()) / span * last, 0.0, double{last})
                      : 0.0;
  };
  const int from = std::max(static_cast<int>(entry(range.lowest - stray)) - 1, 0);
  const int to = std::min(static_cast<int>(entry(range.highest + stray)) + 2, last);
  return opaque_before_[static_cast<std::size_t>(to) + 1] >
         opaque_before_[static_cast<std::size_t>(from)];
}

Result<void> VolumeTexture::refresh(glm::ivec3 first, glm::ivec3 end, bool halo_grew) {
  const Size3 blocks = ranges_.blocks();
  std::vector<glm::ivec3> fresh;
  Result<void> result;
  for_each_in(glm::max(first, glm::ivec3(0)), glm::min(end, blocks), [&](glm::ivec3 block) {
    const bool now = is_visible(ranges_.range(block));
    if (now == skip_grid_.shows(block) && !halo_grew) return;
    skip_grid_.set(block, now);
    if (now && result) {
      result = image_->commit(texels(reach_of(block)), fresh);
    }
  });
  // What a page holds is undefined until each brick in it has been uploaded anew.
  for (const glm::ivec3 page : fresh) {
    const gpu::TexelBox box = image_->page_box(page);
    for_each_in(BrickGrid::brick_of(box.lo), BrickGrid::brick_of(box.hi - 1) + 1,
                [&](BrickIndex brick) {
                  BrickState& state = states_[static_cast<std::size_t>(grid_.linear(brick))];
                  if (state == BrickState::current) state = BrickState::wanted;
                });
  }
  return result;
}

Result<void> VolumeTexture::set_visibility(const Visibility& visibility) {
  const bool halo_grew = visibility.halo_blocks > halo_blocks();
  visibility_ = std::make_unique<Visibility>(visibility);
  opaque_before_.assign(1, 0);
  for (const glm::vec4& entry : visibility.transfer.table(shader::k_transfer_entries, 1.0)) {
    opaque_before_.push_back(opaque_before_.back() + (entry.a > 0.0f ? 1 : 0));
  }
  if (auto done = refresh(glm::ivec3(0), ranges_.blocks(), halo_grew); !done) return done.error();
  if (skip_grid_.update()) ++skip_version_;
  return trim();
}

Result<std::uint64_t> VolumeTexture::submit() {
  std::vector<Finished> batch;
  {
    std::lock_guard lock(finished_mutex_);
    batch.swap(finished_);
  }
  for (const Finished& brick : batch) {
    ranges_.set(grid_.brick(brick.staged.brick), brick.ranges);
    // Until its copy is recorded below; an error on the way leaves it wanted.
    states_[static_cast<std::size_t>(brick.staged.brick)] = BrickState::wanted;
  }
  for (const Finished& brick : batch) {
    // The blocks one lower look into this brick with their ninth layer.
    const glm::ivec3 first = grid_.brick(brick.staged.brick) * kBrickBlocks;
    if (auto done = refresh(first - 1, first + kBrickBlocks); !done) return done.error();
  }
  if (skip_grid_.update()) ++skip_version_;
  for (Finished& brick : batch) {
    const gpu::TexelBox whole = texels(brick.staged.box);
    const gpu::TexelBox pages = image_->pages_touching(whole);
    Result<void> added;
    bool any = false;
    if (image_->committed(whole)) {
      added = uploads_->add(brick.staged.slot, whole, whole);
      any = true;
    } else {
      for_each_in(pages.lo, pages.hi, [&](glm::ivec3 page) {
        if (!added || !image_->page_committed(page)) return;
        const gpu::TexelBox box = image_->page_box(page);
        added = uploads_->add(brick.staged.slot, whole,
                              {glm::max(box.lo, whole.lo), glm::min(box.hi, whole.hi)});
        any = true;
      });
    }
    if (!added) return added.error();
    states_[static_cast<std::size_t>(brick.staged.brick)] = BrickState::current;
    if (!any) continue;  // nothing of it is visible: its slot goes back unused
    ++bricks_uploaded_;
    uploads_->finish(std::move(brick.staged.slot));
  }
  return uploads_->submit();
}

std::vector<std::int64_t> VolumeTexture::bricks_wanted() const {
  std::vector<std::int64_t> bricks;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (states_[i] != BrickState::current) bricks.push_back(static_cast<std::int64_t>(i));
  }
  return bricks;
}

std::vector<std::int64_t> VolumeTexture::bricks_wanted_again() const {
  std::vector<std::int64_t> bricks;
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (states_[i] == BrickState::wanted) bricks.push_back(static_cast<std::int64_t>(i));
  }
  return bricks;
}

Result<void> VolumeTexture::trim() {
  const glm::ivec3 pages = image_->pages();
  std::vector<bool> needed(static_cast<std::size_t>(voxel_count(pages)), false);
  for_each_in(glm::ivec3(0), ranges_.blocks(), [&](glm::ivec3 block) {
    if (!skip_grid_.shows(block)) return;
    const gpu::TexelBox touched = image_->pages_touching(texels(reach_of(block)));
    for_each_in(touched.lo, touched.hi, [&](glm::ivec3 page) {
      needed[static_cast<std::size_t>(linear_index(page, pages))] = true;
    });
  });
  const auto most = 2 * std::count(needed.begin(), needed.end(), true);
  if (image_->footprint().pages_resident <= most) return {};
  for_each_in(glm::ivec3(0), pages, [&](glm::ivec3 page) {
    if (!needed[static_cast<std::size_t>(linear_index(page, pages))]) image_->release(page);
  });
  return image_->flush();
}

void copy_brick(const Volume& volume, VoxelBox box, std::span<std::byte> voxels) {
  const std::size_t bytes = bytes_per_voxel(volume.type());
  const std::size_t row = static_cast<std::size_t>(box.size().x) * bytes;
  std::byte* out = voxels.data();
  for (int z = box.lo.z; z < box.hi.z; ++z) {
    for (int y = box.lo.y; y < box.hi.y; ++y) {
      const auto first =
          static_cast<std::size_t>(linear_index({box.lo.x, y, z}, volume.size())) * bytes;
      std::memcpy(out, volume.bytes().data() + first, row);
      out += row;
    }
  }
  if (volume.type() != VoxelType::int8 && volume.type() != VoxelType::int16) return;
  // The sign bit is in the last byte of a sample, little endian.
  for (std::size_t i = bytes - 1; i < voxels.size(); i += bytes) voxels[i] ^= std::byte{0x80};
}

}  // namespace maille
