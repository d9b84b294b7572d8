// What is written over the picture: the help, the grab radius, what the machine is doing. Dear
// ImGui draws it.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "app/simulation.h"
#include "render/renderer.h"

namespace maille {

struct OverlayContent {
  SimulationStatus simulation;
  std::string device;
  double frame_ms = 0.0;
  int pixel_scale = 1;  // picture pixels are this many window pixels wide
  double radius_voxels = 0.0;
  bool help = false;
  std::string message;             // what just happened
  std::optional<glm::dvec2> grab;  // window position of what is held
};

class Overlay {
 public:
  // Installs its own GLFW callbacks behind those already set. Errors: device.
  static Result<std::unique_ptr<Overlay>> create(GLFWwindow* window, Renderer& renderer);
  ~Overlay();

  bool wants_pointer() const;
  // Lays the content out and gives what draws it, valid until the next call.
  gpu::DrawOverlay draw(const OverlayContent& content);

 private:
  explicit Overlay(Renderer& renderer) : renderer_(renderer) {}
  Renderer& renderer_;
};

}  // namespace maille
