#include "gpu/swapchain.h"

#include <algorithm>
#include <array>

namespace maille::gpu {
namespace {

// A window that is not shown may never give an image back; a second is longer than any frame.
constexpr std::uint64_t kAcquireNanoseconds = 1'000'000'000;

bool encodes_srgb(VkFormat format) {
  return format == VK_FORMAT_B8G8R8A8_SRGB || format == VK_FORMAT_R8G8B8A8_SRGB ||
         format == VK_FORMAT_A8B8G8R8_SRGB_PACK32;
}

void move_image(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to,
                VkAccessFlags written, VkPipelineStageFlags after, VkAccessFlags then) {
  const VkImageMemoryBarrier move{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                  .pNext = nullptr,
                                  .srcAccessMask = written,
                                  .dstAccessMask = then,
                                  .oldLayout = from,
                                  .newLayout = to,
                                  .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                  .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                  .image = image,
                                  .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
  // Transfer: the stage that waits for the presentation engine to let go of the image.
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, after, 0, 0, nullptr, 0, nullptr,
                       1, &move);
}

}  // namespace

Result<std::unique_ptr<Swapchain>> Swapchain::create(WorkQueue& queue, VkSurfaceKHR surface,
                                                     bool vsync) {
  const Device& device = queue.device();
  std::unique_ptr<Swapchain> swapchain(new Swapchain(queue, surface));
  VkBool32 presents = VK_FALSE;
  vkGetPhysicalDeviceSurfaceSupportKHR(device.physical(), device.general().family, surface,
                                       &presents);
  if (!presents) {
    return Error{ErrorKind::device,
                 "device '" + device.info().name + "' cannot present to this window"};
  }
  std::uint32_t count = 0;
  vkGetPhysicalDeviceSurfacePresentModesKHR(device.physical(), surface, &count, nullptr);
  std::vector<VkPresentModeKHR> modes(count);
  vkGetPhysicalDeviceSurfacePresentModesKHR(device.physical(), surface, &count, modes.data());
  for (const VkPresentModeKHR mode : {VK_PRESENT_MODE_IMMEDIATE_KHR, VK_PRESENT_MODE_MAILBOX_KHR}) {
    if (!vsync && std::find(modes.begin(), modes.end(), mode) != modes.end()) {
      swapchain->mode_ = mode;
    }
  }
  if (auto chosen = swapchain->choose_format(); !chosen) return chosen.error();
  auto overlay = OverlayPass::create(queue, swapchain->format_.format);
  if (!overlay) return overlay.error();
  swapchain->overlay_ = std::move(*overlay);

  VkSurfaceCapabilitiesKHR surface_info{};
  if (const VkResult r =
          vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device.physical(), surface, &surface_info);
      r != VK_SUCCESS) {
    return vk_error(r, "asking about the window");
  }
  swapchain->image_count_ = surface_info.minImageCount + 1;
  if (surface_info.maxImageCount > 0) {
    swapchain->image_count_ = std::min(swapchain->image_count_, surface_info.maxImageCount);
  }
  return swapchain;
}

Swapchain::~Swapchain() {
  // The timeline does not know when the presentation engine is done with the last image.
  vkDeviceWaitIdle(queue_->device().get());
}

Result<void> Swapchain::choose_format() {
  const Device& device = queue_->device();
  std::uint32_t count = 0;
  vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical(), surface_, &count, nullptr);
  std::vector<VkSurfaceFormatKHR> formats(count);
  vkGetPhysicalDeviceSurfaceFormatsKHR(device.physical(), surface_, &count, formats.data());

  // Pictures are encoded already, so the surface had better take them as they are.
  const auto worth = [](const VkSurfaceFormatKHR& format) {
    if (format.colorSpace != VK_COLOR_SPACE_SRGB_NONLINEAR_KHR) return 0;
    if (format.format == VK_FORMAT_B8G8R8A8_UNORM || format.format == VK_FORMAT_R8G8B8A8_UNORM) {
      return 3;
    }
    return encodes_srgb(format.format) ? 2 : 1;
  };
  int best = -1;
  for (const VkSurfaceFormatKHR& format : formats) {
    VkFormatProperties features{};
    vkGetPhysicalDeviceFormatProperties(device.physical(), format.format, &features);
    const bool usable = (features.optimalTilingFeatures & VK_FORMAT_FEATURE_BLIT_DST_BIT) != 0;
    if (!usable || worth(format) <= best) continue;
    best = worth(format);
    format_ = format;
  }
  if (best < 0) {
    return Error{ErrorKind::device,
                 "device '" + device.info().name + "' cannot blit to this window's pixel formats"};
  }
  srgb_ = encodes_srgb(format_.format);
  return {};
}

Result<bool> Swapchain::rebuild(VkExtent2D window) {
  const Device& device = queue_->device();
  vkDeviceWaitIdle(device.get());
  VkSurfaceCapabilitiesKHR surface_info{};
  if (const VkResult r =
          vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device.physical(), surface_, &surface_info);
      r != VK_SUCCESS) {
    return vk_error(r, "asking about the window");
  }
  asked_ = window;
  extent_ = surface_info.currentExtent;
  if (extent_.width == 0xFFFFFFFFu) {  // the swapchain decides
    extent_ = {std::clamp(window.width, surface_info.minImageExtent.width,
                          surface_info.maxImageExtent.width),
               std::clamp(window.height, surface_info.minImageExtent.height,
                          surface_info.maxImageExtent.height)};
  }
  if (extent_.width == 0 || extent_.height == 0) return false;

  constexpr VkImageUsageFlags usage =
      VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  if ((surface_info.supportedUsageFlags & usage) != usage) {
    return Error{ErrorKind::device, "this window takes no blits"};
  }
  VkCompositeAlphaFlagBitsKHR alpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
  while ((surface_info.supportedCompositeAlpha & alpha) == 0) {
    alpha = static_cast<VkCompositeAlphaFlagBitsKHR>(alpha << 1);
  }
  const VkSwapchainCreateInfoKHR info{.sType = VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR,
                                      .pNext = nullptr,
                                      .flags = 0,
                                      .surface = surface_,
                                      .minImageCount = image_count_,
                                      .imageFormat = format_.format,
                                      .imageColorSpace = format_.colorSpace,
                                      .imageExtent = extent_,
                                      .imageArrayLayers = 1,
                                      .imageUsage = usage,
                                      .imageSharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                      .queueFamilyIndexCount = 0,
                                      .pQueueFamilyIndices = nullptr,
                                      .preTransform = surface_info.currentTransform,
                                      .compositeAlpha = alpha,
                                      .presentMode = mode_,
                                      .clipped = VK_TRUE,
                                      .oldSwapchain = swapchain_.get()};
  VkSwapchainKHR handle = VK_NULL_HANDLE;
  const VkResult created = vkCreateSwapchainKHR(device.get(), &info, nullptr, &handle);
  targets_.clear();
  acquires_.clear();
  swapchain_.reset();
  if (created != VK_SUCCESS) return vk_error(created, "making the swapchain");
  swapchain_ = {device.get(), handle};
  device.set_name(handle, VK_OBJECT_TYPE_SWAPCHAIN_KHR, "swapchain");

  std::uint32_t count = 0;
  vkGetSwapchainImagesKHR(device.get(), handle, &count, nullptr);
  std::vector<VkImage> images(count);
  vkGetSwapchainImagesKHR(device.get(), handle, &count, images.data());
  for (const VkImage image : images) {
    auto target = make_target(image);
    if (!target) return target.error();
    targets_.push_back(std::move(*target));
    auto semaphore = make_semaphore("swapchain image acquired");
    if (!semaphore) return semaphore.error();
    acquires_.push_back({std::move(*semaphore), 0});
  }
  // One more than images: an acquire may wait for its semaphore while all images are out.
  auto semaphore = make_semaphore("swapchain image acquired");
  if (!semaphore) return semaphore.error();
  acquires_.push_back({std::move(*semaphore), 0});
  next_acquire_ = 0;
  stale_ = false;
  return true;
}

Result<OwnedSemaphore> Swapchain::make_semaphore(std::string_view name) const {
  const Device& device = queue_->device();
  VkSemaphoreCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
  VkSemaphore semaphore = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateSemaphore(device.get(), &info, nullptr, &semaphore);
      r != VK_SUCCESS) {
    return vk_error(r, "making the swapchain");
  }
  device.set_name(semaphore, VK_OBJECT_TYPE_SEMAPHORE, name);
  return OwnedSemaphore(device.get(), semaphore);
}

Result<Swapchain::Target> Swapchain::make_target(VkImage image) const {
  const Device& device = queue_->device();
  Target target;
  target.image = image;
  device.set_name(image, VK_OBJECT_TYPE_IMAGE, "swapchain image");
  VkImageViewCreateInfo view_info{};
  view_info.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
  view_info.image = image;
  view_info.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view_info.format = format_.format;
  view_info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  VkImageView view = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateImageView(device.get(), &view_info, nullptr, &view);
      r != VK_SUCCESS) {
    return vk_error(r, "making the swapchain");
  }
  target.view = {device.get(), view};
  device.set_name(view, VK_OBJECT_TYPE_IMAGE_VIEW, "swapchain image");
  VkFramebufferCreateInfo framebuffer_info{};
  framebuffer_info.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO;
  framebuffer_info.renderPass = overlay_.render_pass();
  framebuffer_info.attachmentCount = 1;
  framebuffer_info.pAttachments = &view;
  framebuffer_info.width = extent_.width;
  framebuffer_info.height = extent_.height;
  framebuffer_info.layers = 1;
  VkFramebuffer framebuffer = VK_NULL_HANDLE;
  if (const VkResult r =
          vkCreateFramebuffer(device.get(), &framebuffer_info, nullptr, &framebuffer);
      r != VK_SUCCESS) {
    return vk_error(r, "making the swapchain");
  }
  target.framebuffer = {device.get(), framebuffer};
  device.set_name(framebuffer, VK_OBJECT_TYPE_FRAMEBUFFER, "swapchain image");
  auto rendered = make_semaphore("swapchain image rendered");
  if (!rendered) return rendered.error();
  target.rendered = std::move(*rendered);
  return target;
}

void Swapchain::record(VkCommandBuffer commands, const Image2D* picture, const Target& target,
                       const DrawOverlay& overlay) const {
  move_image(commands, target.image, VK_IMAGE_LAYOUT_UNDEFINED,
             VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 0, VK_PIPELINE_STAGE_TRANSFER_BIT,
             VK_ACCESS_TRANSFER_WRITE_BIT);
  if (picture == nullptr) {
    const VkClearColorValue black{};
    const VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdClearColorImage(commands, target.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &black, 1,
                         &all);
  } else {
    const VkExtent2D size = picture->extent();
    const VkImage source = srgb_ ? srgb_copy_.get() : picture->get();
    if (srgb_) {
      VkImageCopy copy{};
      copy.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
      copy.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
      copy.extent = {size.width, size.height, 1};
      vkCmdCopyImage(commands, picture->get(), VK_IMAGE_LAYOUT_GENERAL, source,
                     VK_IMAGE_LAYOUT_GENERAL, 1, &copy);
      barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
              VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
    }
    VkImageBlit blit{};
    blit.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    blit.srcOffsets[1] = {static_cast<std::int32_t>(size.width),
                          static_cast<std::int32_t>(size.height), 1};
    blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    blit.dstOffsets[1] = {static_cast<std::int32_t>(extent_.width),
                          static_cast<std::int32_t>(extent_.height), 1};
    const bool same = size.width == extent_.width && size.height == extent_.height;
    vkCmdBlitImage(commands, source, VK_IMAGE_LAYOUT_GENERAL, target.image,
                   VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit,
                   same ? VK_FILTER_NEAREST : VK_FILTER_LINEAR);
  }
  if (!overlay) {
    move_image(commands, target.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
               VK_IMAGE_LAYOUT_PRESENT_SRC_KHR, VK_ACCESS_TRANSFER_WRITE_BIT,
               VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, 0);
    return;
  }
  move_image(commands, target.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
             VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_ACCESS_TRANSFER_WRITE_BIT,
             VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
             VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT);
  VkRenderPassBeginInfo begin{};
  begin.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO;
  begin.renderPass = overlay_.render_pass();
  begin.framebuffer = target.framebuffer.get();
  begin.renderArea = {{0, 0}, extent_};
  vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
  overlay(commands);
  vkCmdEndRenderPass(commands);
}

Result<bool> Swapchain::present(const Image2D* picture, VkExtent2D window,
                                const DrawOverlay& overlay) {
  if (window.width == 0 || window.height == 0) return false;
  if (stale_ || window.width != asked_.width || window.height != asked_.height) {
    auto rebuilt = rebuild(window);
    if (!rebuilt || !*rebuilt) return rebuilt;
  }
  if (srgb_ && picture != nullptr &&
      (srgb_copy_.extent().width != picture->extent().width ||
       srgb_copy_.extent().height != picture->extent().height)) {
    if (auto done = queue_->wait_all(); !done) return done.error();
    auto made = Image2D::create(*queue_, picture->extent(), "picture, encoding declared",
                                VK_FORMAT_R8G8B8A8_SRGB);
    if (!made) return made.error();
    srgb_copy_ = std::move(*made);
  }

  Acquire& acquire = acquires_[next_acquire_];
  next_acquire_ = (next_acquire_ + 1) % acquires_.size();
  if (auto waited = queue_->wait(acquire.value); !waited) return waited.error();
  std::uint32_t index = 0;
  const VkResult acquired =
      vkAcquireNextImageKHR(queue_->device().get(), swapchain_.get(), kAcquireNanoseconds,
                            acquire.semaphore.get(), VK_NULL_HANDLE, &index);
  if (acquired == VK_ERROR_OUT_OF_DATE_KHR) {
    stale_ = true;
    return false;
  }
  if (acquired == VK_TIMEOUT || acquired == VK_NOT_READY) return false;
  if (acquired != VK_SUCCESS && acquired != VK_SUBOPTIMAL_KHR) {
    return vk_error(acquired, "taking an image of the window");
  }
  if (acquired == VK_SUBOPTIMAL_KHR) stale_ = true;

  const Target& target = targets_[index];
  auto commands = queue_->begin();
  if (!commands) return commands.error();
  record(*commands, picture, target, overlay);
  auto submitted = queue_->submit(*commands, {acquire.semaphore.get(), target.rendered.get()});
  if (!submitted) return submitted.error();
  acquire.value = *submitted;

  const VkSemaphore rendered = target.rendered.get();
  const VkSwapchainKHR swapchain = swapchain_.get();
  const VkPresentInfoKHR info{.sType = VK_STRUCTURE_TYPE_PRESENT_INFO_KHR,
                              .pNext = nullptr,
                              .waitSemaphoreCount = 1,
                              .pWaitSemaphores = &rendered,
                              .swapchainCount = 1,
                              .pSwapchains = &swapchain,
                              .pImageIndices = &index,
                              .pResults = nullptr};
  const VkResult presented = vkQueuePresentKHR(queue_->device().general().handle, &info);
  if (presented == VK_SUBOPTIMAL_KHR) stale_ = true;
  if (presented == VK_ERROR_OUT_OF_DATE_KHR) {
    stale_ = true;
    return false;
  }
  if (presented != VK_SUCCESS && presented != VK_SUBOPTIMAL_KHR) {
    return vk_error(presented, "presenting");
  }
  return true;
}

OverlayTarget Swapchain::overlay_target() const { return overlay_.target(image_count_); }

}  // namespace maille::gpu
