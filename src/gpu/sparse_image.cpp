#include "gpu/sparse_image.h"

#include <algorithm>
#include <cassert>

namespace maille::gpu {

Result<std::unique_ptr<Image3D>> SparseImage::create(WorkQueue& queue, glm::ivec3 extent,
                                                     VkFormat format, std::string_view name) {
  const Device& device = queue.device();
  std::unique_ptr<SparseImage> image(new SparseImage(queue));
  if (auto made = image->make_image(device, extent, format, true, name); !made) {
    return made.error();
  }
  VkMemoryRequirements needs{};
  vkGetImageMemoryRequirements(device.get(), image->get(), &needs);
  if (needs.size > device.limits().sparseAddressSpaceSize) {
    return too_large_for_one_piece(device, needs.size, device.limits().sparseAddressSpaceSize,
                                   " of sparse address space");
  }
  std::uint32_t count = 0;
  vkGetImageSparseMemoryRequirements(device.get(), image->get(), &count, nullptr);
  std::vector<VkSparseImageMemoryRequirements> parts(count);
  vkGetImageSparseMemoryRequirements(device.get(), image->get(), &count, parts.data());

  bool has_color = false;
  for (const VkSparseImageMemoryRequirements& part : parts) {
    const bool metadata = (part.formatProperties.aspectMask & VK_IMAGE_ASPECT_METADATA_BIT) != 0;
    if (metadata) {
      // The driver's own bookkeeping: bound whole, once.
      if (auto bound = image->bind_tail(part, needs, true); !bound) return bound.error();
    } else if ((part.formatProperties.aspectMask & VK_IMAGE_ASPECT_COLOR_BIT) != 0) {
      has_color = true;
      const VkExtent3D page = part.formatProperties.imageGranularity;
      image->page_texels_ = {page.width, page.height, page.depth};
      if (part.imageMipTailFirstLod == 0) {
        if (auto bound = image->bind_tail(part, needs, false); !bound) return bound.error();
        image->all_in_tail_ = true;
        image->page_texels_ = extent;
      }
    }
  }
  if (!has_color || glm::any(glm::lessThan(image->page_texels_, glm::ivec3(1)))) {
    return Error{ErrorKind::device, "device '" + device.info().name +
                                        "' tells no page size for sparse 3D textures of this kind"};
  }
  if (!image->all_in_tail_) image->pool_.emplace(device, needs, std::string(name));
  const glm::ivec3 pages = image->pages();
  image->resident_.resize(static_cast<std::size_t>(pages.x) * static_cast<std::size_t>(pages.y) *
                          static_cast<std::size_t>(pages.z));
  if (auto made = image->make_view(device, name); !made) return made.error();
  const VkImage handle = image->get();
  auto moved = queue.run([&](VkCommandBuffer commands) { to_general(commands, handle); });
  if (!moved) return moved.error();
  return std::unique_ptr<Image3D>(std::move(image));
}

SparseImage::~SparseImage() {
  // Pages must not be freed under work that still samples them.
  (void)queue_->wait_all();
}

Result<void> SparseImage::bind_tail(const VkSparseImageMemoryRequirements& part,
                                    const VkMemoryRequirements& needs, bool metadata) {
  VkMemoryRequirements tail = needs;
  tail.size = part.imageMipTailSize;
  auto memory = allocate(queue_->device(), tail, MemoryUse::device,
                         metadata ? "sparse texture metadata" : "sparse texture mip tail");
  if (!memory) return memory.error();
  const VkSparseMemoryBind bind{
      .resourceOffset = part.imageMipTailOffset,
      .size = part.imageMipTailSize,
      .memory = memory->get(),
      .memoryOffset = 0,
      .flags = metadata ? VkSparseMemoryBindFlags{VK_SPARSE_MEMORY_BIND_METADATA_BIT} : 0};
  const VkSparseImageOpaqueMemoryBindInfo image{.image = get(), .bindCount = 1, .pBinds = &bind};
  VkBindSparseInfo info{};
  info.imageOpaqueBindCount = 1;
  info.pImageOpaqueBinds = &image;
  auto bound = queue_->bind(info);
  tails_.push_back(std::move(*memory));
  tail_bytes_ += tail.size;
  if (!bound) return bound.error();
  return {};
}

std::size_t SparseImage::index(glm::ivec3 page) const {
  const glm::ivec3 count = pages();
  assert(glm::all(glm::greaterThanEqual(page, glm::ivec3(0))) &&
         glm::all(glm::lessThan(page, count)));
  return (static_cast<std::size_t>(page.z) * static_cast<std::size_t>(count.y) +
          static_cast<std::size_t>(page.y)) *
             static_cast<std::size_t>(count.x) +
         static_cast<std::size_t>(page.x);
}

bool SparseImage::page_committed(glm::ivec3 page) const {
  return all_in_tail_ || resident_[index(page)].has_value();
}

void SparseImage::queue_bind(glm::ivec3 page, std::optional<Page> memory) {
  const TexelBox box = page_box(page);
  const glm::ivec3 size = box.size();
  // A page committed and released (or the reverse) before it was sent must not be bound twice in
  // one call: the order within a call is nobody's promise.
  std::erase_if(binds_, [&](const VkSparseImageMemoryBind& bind) {
    return bind.offset.x == box.lo.x && bind.offset.y == box.lo.y && bind.offset.z == box.lo.z;
  });
  binds_.push_back(
      {.subresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0},
       .offset = {box.lo.x, box.lo.y, box.lo.z},
       .extent = {static_cast<std::uint32_t>(size.x), static_cast<std::uint32_t>(size.y),
                  static_cast<std::uint32_t>(size.z)},
       .memory = memory ? pool_->memory(*memory) : VK_NULL_HANDLE,
       .memoryOffset = memory ? pool_->offset(*memory) : 0,
       .flags = 0});
}

Result<void> SparseImage::commit(const TexelBox& box, std::vector<glm::ivec3>& fresh) {
  if (all_in_tail_) return {};
  const TexelBox touched =
      pages_touching({glm::max(box.lo, glm::ivec3(0)), glm::min(box.hi, extent())});
  for (int z = touched.lo.z; z < touched.hi.z; ++z) {
    for (int y = touched.lo.y; y < touched.hi.y; ++y) {
      for (int x = touched.lo.x; x < touched.hi.x; ++x) {
        const glm::ivec3 page{x, y, z};
        std::optional<Page>& resident = resident_[index(page)];
        if (resident) continue;
        auto memory = pool_->take();
        if (!memory) return memory.error();
        resident = *memory;
        ++resident_count_;
        queue_bind(page, resident);
        fresh.push_back(page);
      }
    }
  }
  return {};
}

void SparseImage::release(glm::ivec3 page) {
  if (all_in_tail_) return;
  std::optional<Page>& resident = resident_[index(page)];
  if (!resident) return;
  leaving_.push_back(*resident);
  resident.reset();
  --resident_count_;
  queue_bind(page, std::nullopt);
}

Result<void> SparseImage::flush() {
  if (binds_.empty()) return {};
  const VkSparseImageMemoryBindInfo image{.image = get(),
                                          .bindCount = static_cast<std::uint32_t>(binds_.size()),
                                          .pBinds = binds_.data()};
  VkBindSparseInfo info{};
  info.imageBindCount = 1;
  info.pImageBinds = &image;
  auto bound = queue_->bind(info);
  if (!bound) return bound.error();
  binds_.clear();
  // Whoever gets these pages is bound by a later call, and every call waits for the one before.
  for (const Page page : leaving_) pool_->give(page);
  leaving_.clear();
  return {};
}

Footprint SparseImage::footprint() const {
  if (all_in_tail_) return {1, 1, tail_bytes_};
  return {resident_count_, static_cast<std::int64_t>(resident_.size()),
          tail_bytes_ + pool_->bytes()};
}

}  // namespace maille::gpu
