#include "app/overlay.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_vulkan.h>
#include <imgui.h>

#include "app/bindings.h"
#include "app/relaxation_text.h"

namespace maille {
namespace {

constexpr ImGuiWindowFlags kPanel = ImGuiWindowFlags_NoDecoration |
                                    ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoInputs |
                                    ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing;

void status_panel(const OverlayContent& content) {
  const SimulationStatus& s = content.simulation;
  ImGui::SetNextWindowPos({10, 10});
  ImGui::SetNextWindowBgAlpha(0.55f);
  ImGui::Begin("status", nullptr, kPanel);
  ImGui::TextUnformatted(content.device.c_str());
  ImGui::Text("frame %.0f ms%s   grab radius %.0f voxels", content.frame_ms,
              content.pixel_scale > 1 ? " (coarse while moving)" : "", content.radius_voxels);
  if (s.elements_moved > 0) {
    ImGui::Text("ChainMail: %lld elements in %.1f ms%s", static_cast<long long>(s.elements_moved),
                s.drag_ms, s.clamped ? ", held by an anchor" : "");
  }
  for (const std::string& line : relaxation_text(s)) ImGui::TextUnformatted(line.c_str());
  if (s.pins > 0) ImGui::Text("%d pinned handle%s", s.pins, s.pins == 1 ? "" : "s");
  if (s.undo_steps_dropped > 0) {
    ImGui::Text("undo: the %lld oldest steps were dropped (--undo-memory)",
                static_cast<long long>(s.undo_steps_dropped));
  }
  if (!s.refused.empty()) ImGui::Text("%s", s.refused.c_str());
  if (!content.message.empty()) ImGui::TextUnformatted(content.message.c_str());
  ImGui::TextDisabled("H: help");
  ImGui::End();
}

void help_panel() {
  const ImVec2 center = ImGui::GetMainViewport()->GetCenter();
  ImGui::SetNextWindowPos(center, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowBgAlpha(0.85f);
  ImGui::Begin("help", nullptr, kPanel);
  if (ImGui::BeginTable("bindings", 2)) {
    for (const Binding& binding : kBindings) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(binding.input);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(binding.action);
    }
    ImGui::EndTable();
  }
  ImGui::End();
}

}  // namespace

Result<std::unique_ptr<Overlay>> Overlay::create(GLFWwindow* window, Renderer& renderer) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // a viewer leaves no files behind
  ImGui_ImplGlfw_InitForVulkan(window, true);
  const gpu::OverlayTarget target = renderer.overlay_target();
  ImGui_ImplVulkan_InitInfo info{};
  info.Instance = target.instance;
  info.PhysicalDevice = target.physical;
  info.Device = target.device;
  info.QueueFamily = target.queue_family;
  info.Queue = target.queue;
  info.DescriptorPool = target.descriptor_pool;
  info.MinImageCount = target.min_image_count;
  info.ImageCount = target.image_count;
  info.MSAASamples = VK_SAMPLE_COUNT_1_BIT;
  ImGui_ImplVulkan_Init(&info, target.render_pass);
  std::unique_ptr<Overlay> overlay(new Overlay(renderer));
  const auto uploaded = renderer.run_commands(
      [](VkCommandBuffer commands) { ImGui_ImplVulkan_CreateFontsTexture(commands); });
  if (!uploaded) return uploaded.error();
  ImGui_ImplVulkan_DestroyFontUploadObjects();
  return overlay;
}

Overlay::~Overlay() {
  // Frames in flight draw with what is about to go.
  static_cast<void>(renderer_.wait_idle());
  ImGui_ImplVulkan_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

bool Overlay::wants_pointer() const { return ImGui::GetIO().WantCaptureMouse; }

gpu::DrawOverlay Overlay::draw(const OverlayContent& content) {
  ImGui_ImplVulkan_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  status_panel(content);
  if (content.help) help_panel();
  if (content.grab) {
    ImGui::GetForegroundDrawList()->AddCircle(
        {static_cast<float>(content.grab->x), static_cast<float>(content.grab->y)}, 7.0f,
        content.simulation.clamped ? IM_COL32(255, 110, 60, 255) : IM_COL32(255, 230, 120, 255), 0,
        2.0f);
  }
  ImGui::Render();
  return [](VkCommandBuffer commands) {
    ImGui_ImplVulkan_RenderDrawData(ImGui::GetDrawData(), commands);
  };
}

}  // namespace maille
