#include "app/window.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <GLFW/glfw3.h>

#include "app/overlay.h"
#include "app/png.h"
#include "app/run_options.h"
#include "app/simulation.h"
#include "app/view.h"

namespace maille {
namespace {

constexpr PictureSize kFirstSize{1024, 768};
constexpr double kFrameGoal_ms = 50.0;
constexpr int kCoarsest = 4;            // window pixels a picture pixel
constexpr double kStill_seconds = 0.2;  // without a change: draw at full resolution
constexpr double kFirstRadius_voxels = 4.0;
constexpr double kLargestRadius_voxels = 64.0;

double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// GLFW is started only here: headless runs never touch it.
class GlfwWindow {
 public:
  static Result<GlfwWindow> open(const std::string& title) {
    static std::string reason;
    glfwSetErrorCallback([](int, const char* text) {
      reason = text;
      reason.erase(reason.find_last_not_of(' ') + 1);  // GLFW ends where a display's name would be
    });
    if (!glfwInit()) {
      return Error{ErrorKind::device, "no window can be opened: " + reason +
                                          "; maille render and maille demo need no display"};
    }
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    GLFWwindow* window =
        glfwCreateWindow(kFirstSize.x, kFirstSize.y, title.c_str(), nullptr, nullptr);
    if (!window) {
      glfwTerminate();
      return Error{ErrorKind::device, "no window can be opened: " + reason};
    }
    return GlfwWindow(window);
  }
  GlfwWindow(GlfwWindow&& other) noexcept : window_(std::exchange(other.window_, nullptr)) {}
  GlfwWindow& operator=(GlfwWindow&&) = delete;
  ~GlfwWindow() {
    if (!window_) return;
    glfwDestroyWindow(window_);
    glfwTerminate();
  }
  GLFWwindow* get() const { return window_; }

 private:
  explicit GlfwWindow(GLFWwindow* window) : window_(window) {}
  GLFWwindow* window_;
};

// One session at the window: turns what the person does into camera moves and wishes to the
// simulation, and draws when something has changed.
class Session {
 public:
  Session(GLFWwindow* window, Document& document, View& view, Overlay& overlay)
      : window_(window),
        view_(view),
        overlay_(overlay),
        simulation_(document, [] { glfwPostEmptyEvent(); }),
        volume_from_world_(glm::inverse(document.volume().world_from_voxel())),
        volume_(document.volume()),
        camera_settings_(document.scene().camera),
        scene_file_(document.scene().file) {
    glm::dvec2 at;
    glfwGetCursorPos(window_, &at.x, &at.y);
    pointer_ = framebuffer_position(at);
  }

  Result<void> run() {
    if (auto shown = view_.show({}); !shown) return shown;
    while (!glfwWindowShouldClose(window_)) {
      const bool pending = changed_ || scale_shown_ > 1;
      if (pending) {
        glfwWaitEventsTimeout(changed_ ? 0.0 : 0.05);
      } else {
        glfwWaitEvents();
      }
      if (auto update = simulation_.take_view()) {
        if (auto shown = view_.show(*std::move(update)); !shown) return shown;
        // Not a touch: a volume that relaxes on its own is shown sharp.
        changed_ = true;
      }
      if (simulation_.status() != status_shown_) changed_ = true;
      if (!failed_.ok()) return failed_;
      if (auto drawn = draw(); !drawn) return drawn;
    }
    return {};
  }

  // --- events ---

  void on_button(int button, int action, int modifiers) {
    if (action == GLFW_RELEASE) {
      if (button != button_) return;
      if (motion_ == Motion::grab) {
        simulation_.let_go();
        grab_position_.reset();
      }
      motion_ = Motion::none;
      touch();
      return;
    }
    if (motion_ != Motion::none || overlay_.wants_pointer()) return;
    message_.clear();
    button_ = button;
    if (button == GLFW_MOUSE_BUTTON_MIDDLE ||
        (button == GLFW_MOUSE_BUTTON_LEFT && modifiers & GLFW_MOD_SHIFT)) {
      motion_ = Motion::pan;
    } else if (button == GLFW_MOUSE_BUTTON_RIGHT) {
      motion_ = Motion::zoom;
    } else if (modifiers & GLFW_MOD_CONTROL) {
      motion_ = Motion::roll;
    } else if (modifiers & GLFW_MOD_ALT || !begin_grab()) {
      motion_ = Motion::orbit;
    }
    touch();
  }

  void on_move(glm::dvec2 window_position) {
    const glm::dvec2 at = framebuffer_position(window_position);
    const glm::dvec2 move = at - pointer_;
    pointer_ = at;
    const PictureSize size = window_pixels();
    const Camera& camera = view_.camera();
    switch (motion_) {
      case Motion::none: return;
      case Motion::orbit: view_.set_camera(orbited(camera, size, move)); break;
      case Motion::pan: view_.set_camera(panned(camera, size, move)); break;
      case Motion::zoom: view_.set_camera(zoomed(camera, std::exp(-move.y / 200.0))); break;
      case Motion::roll: view_.set_camera(rolled(camera, move.x * 0.3)); break;
      case Motion::grab: drag(at); break;
    }
    touch();
  }

  void on_wheel(double clicks) {
    if (overlay_.wants_pointer()) return;
    view_.set_camera(zoomed(view_.camera(), std::exp(0.15 * clicks)));
    touch();
  }

  void on_key(int key, int action, int modifiers) {
    if (action == GLFW_RELEASE) return;
    const bool control = modifiers & GLFW_MOD_CONTROL;
    message_.clear();
    switch (key) {
      case GLFW_KEY_ESCAPE:
        if (motion_ == Motion::grab) {
          simulation_.cancel();
          grab_position_.reset();
          motion_ = Motion::none;
        }
        break;
      case GLFW_KEY_DELETE: simulation_.release_pins(); break;
      case GLFW_KEY_Z:
        if (control && modifiers & GLFW_MOD_SHIFT) simulation_.redo();
        if (control && !(modifiers & GLFW_MOD_SHIFT)) simulation_.undo();
        break;
      case GLFW_KEY_SPACE: simulation_.pause_or_resume_relaxation(); break;
      case GLFW_KEY_EQUAL:
      case GLFW_KEY_KP_ADD:
        radius_voxels_ = std::min(radius_voxels_ + 1.0, kLargestRadius_voxels);
        break;
      case GLFW_KEY_MINUS:
      case GLFW_KEY_KP_SUBTRACT: radius_voxels_ = std::max(radius_voxels_ - 1.0, 0.0); break;
      case GLFW_KEY_M: reload_materials(); break;
      case GLFW_KEY_I: switch_mode(); break;
      case GLFW_KEY_ENTER:
        view_.set_camera(camera_of(camera_settings_, volume_, window_pixels()));
        break;
      case GLFW_KEY_H: help_ = !help_; break;
      case GLFW_KEY_F12: save_picture(); break;
      case GLFW_KEY_Q: glfwSetWindowShouldClose(window_, GLFW_TRUE); break;
      default: return;
    }
    touch();
  }

  void touch() {
    changed_ = true;
    touched_seconds_ = now_seconds();
  }

 private:
  enum class Motion { none, orbit, pan, zoom, roll, grab };

  PictureSize window_pixels() const {
    PictureSize size{0};
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return size;
  }

  // GLFW's own coordinates may be coarser than framebuffer pixels.
  glm::dvec2 framebuffer_position(glm::dvec2 window_position) const {
    glm::ivec2 size{0};
    glfwGetWindowSize(window_, &size.x, &size.y);
    return window_position * glm::dvec2(window_pixels()) /
           glm::dvec2(glm::max(size, glm::ivec2(1)));
  }

  // Whether there is something under the pointer to grab.
  bool begin_grab() {
    const PictureSize size = window_pixels();
    const auto hit = view_.pick(glm::ivec2(pointer_), size);
    if (!hit) {
      failed_ = hit.error();
      return true;
    }
    if (!*hit) return false;
    anchor_mm_ = (*hit)->world_mm;
    const auto on_plane = point_on_facing_plane(view_.camera(), size, pointer_, anchor_mm_);
    if (!on_plane) return false;
    drag_start_mm_ = *on_plane;
    const VoxelIndex element = glm::clamp(VoxelIndex(glm::round(view_.rest_voxel((*hit)->voxel))),
                                          VoxelIndex(0), volume_.size() - 1);
    simulation_.grab(element, radius_voxels_);
    grab_position_ = pointer_;
    motion_ = Motion::grab;
    return true;
  }

  void drag(glm::dvec2 at) {
    const auto target = point_on_facing_plane(view_.camera(), window_pixels(), at, anchor_mm_);
    if (!target) return;
    simulation_.drag_to(transform_vector(volume_from_world_, *target - drag_start_mm_));
    grab_position_ = at;
  }

  void switch_mode() {
    RenderSettings settings = view_.renderer().settings();
    settings.mode = settings.mode == RenderMode::iso ? RenderMode::composite : RenderMode::iso;
    if (auto set = view_.renderer().set_settings(settings); !set) failed_ = set;
    // The other mode may show bricks that this one had no need of.
    wants_bricks_ = true;
  }

  void reload_materials() {
    if (scene_file_.empty()) {
      message_ = "materials come from a scene file, and none is open";
      return;
    }
    const auto scene = open_scene(scene_file_);
    if (!scene) {
      message_ = scene.error().message;
    } else if (const auto* table = std::get_if<MaterialTable>(&scene->materials)) {
      simulation_.set_materials(*table);
      message_ = "materials read again";
    } else {
      message_ = scene_file_.string() + ": has no materials.table";
    }
  }

  void save_picture() {
    // Sharp, even where what is on the screen is coarse because something moves.
    const PictureSize size = glm::max(window_pixels(), PictureSize(1));
    const auto rendered = view_.renderer().render(view_.camera(), size);
    const auto picture = rendered ? view_.renderer().read_picture() : rendered.error();
    std::filesystem::path path;
    for (int n = 1; path.empty() || std::filesystem::exists(path); ++n) {
      path = "maille-" + std::to_string(n) + ".png";
    }
    const auto written = picture ? write_png(path, *picture) : Result<void>(picture.error());
    message_ = written ? "saved " + path.string() : written.error().message;
  }

  Result<void> draw() {
    const PictureSize window = window_pixels();
    if (window.x < 1 || window.y < 1) {
      changed_ = false;
      return {};
    }
    const bool still = now_seconds() - touched_seconds_ > kStill_seconds;
    const int scale = still && motion_ == Motion::none ? 1 : moving_scale_;
    if (!changed_ && scale == scale_shown_) return {};
    if (std::exchange(wants_bricks_, false)) {
      if (auto shown = view_.show_wanted(); !shown) return shown;
    }
    const double begin = now_seconds();
    const PictureSize picture = glm::max(window / scale, PictureSize(1));
    if (auto drawn = view_.renderer().render(view_.camera(), picture); !drawn) return drawn;
    OverlayContent content;
    content.simulation = status_shown_ = simulation_.status();
    content.device = view_.renderer().device().info().name;
    content.frame_ms = frame_ms_;
    content.pixel_scale = scale;
    content.radius_voxels = radius_voxels_;
    content.help = help_;
    content.message = message_;
    content.grab = grab_position_;
    const auto presented = view_.renderer().present(window, overlay_.draw(content));
    if (!presented) return presented.error();
    if (auto idle = view_.renderer().wait_idle(); !idle) return idle;
    frame_ms_ = 1e3 * (now_seconds() - begin);
    changed_ = !*presented;
    scale_shown_ = scale;
    adapt(scale);
    return {};
  }

  // Coarser or finer while something moves, so that a frame stays near its goal: its time goes with
  // the number of pixels.
  void adapt(int scale) {
    const double full_ms = frame_ms_ * scale * scale;
    moving_scale_ = 1;
    while (moving_scale_ < kCoarsest && full_ms / (moving_scale_ * moving_scale_) > kFrameGoal_ms) {
      ++moving_scale_;
    }
  }

  GLFWwindow* window_;
  View& view_;
  Overlay& overlay_;
  Simulation simulation_;
  glm::dmat4 volume_from_world_;
  Volume volume_;
  CameraSettings camera_settings_;
  std::filesystem::path scene_file_;

  Motion motion_ = Motion::none;
  int button_ = 0;
  // Where it was when the event now looked at happened; asking GLFW tells where it is by now.
  glm::dvec2 pointer_{0};
  glm::dvec3 anchor_mm_{0};
  glm::dvec3 drag_start_mm_{0};
  std::optional<glm::dvec2> grab_position_;
  double radius_voxels_ = kFirstRadius_voxels;
  bool help_ = false;
  std::string message_;
  Result<void> failed_;

  bool changed_ = true;
  bool wants_bricks_ = false;
  double touched_seconds_ = 0.0;
  double frame_ms_ = 0.0;
  int moving_scale_ = 2;
  int scale_shown_ = 0;
  SimulationStatus status_shown_;
};

template <class F>
void with_session(GLFWwindow* window, F&& f) {
  if (void* session = glfwGetWindowUserPointer(window)) f(*static_cast<Session*>(session));
}

// Before the overlay's callbacks, which call these on.
void install_callbacks(GLFWwindow* window) {
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int modifiers) {
    with_session(w, [&](Session& s) { s.on_button(button, action, modifiers); });
  });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    with_session(w, [&](Session& s) { s.on_move({x, y}); });
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double clicks) {
    with_session(w, [&](Session& s) { s.on_wheel(clicks); });
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int modifiers) {
    with_session(w, [&](Session& s) { s.on_key(key, action, modifiers); });
  });
  glfwSetFramebufferSizeCallback(
      window, [](GLFWwindow* w, int, int) { with_session(w, [](Session& s) { s.touch(); }); });
  glfwSetWindowRefreshCallback(
      window, [](GLFWwindow* w) { with_session(w, [](Session& s) { s.touch(); }); });
}

std::string title_of(const Scene& scene) {
  if (!scene.file.empty()) return "Maille - " + scene.file.filename().string();
  const auto* file = std::get_if<std::filesystem::path>(&scene.volume);
  return file ? "Maille - " + file->filename().string() : "Maille";
}

}  // namespace

Result<void> run_window(Scene scene, const GlobalOptions& global) {
  // The input first: what is wrong with a file is more use to know than that there is no display.
  auto loaded = load_volume(scene, global.seed);
  if (!loaded) return loaded.error();
  auto window = GlfwWindow::open(title_of(scene));
  if (!window) return window.error();
  DocumentOptions options = headless_options("window", global).document;
  options.purpose = {.pictures = true, .window = true, .picks = true};
  auto document = Document::open(std::move(scene), *std::move(loaded), options);
  if (!document) return document.error();
  ViewOptions picture = view_options(kFirstSize, global);
  picture.renderer.window = window->get();
  auto view = View::create(**document, picture);
  if (!view) return view.error();
  install_callbacks(window->get());
  Result<void> ended;
  {
    auto overlay = Overlay::create(window->get(), (*view)->renderer());
    if (!overlay) return overlay.error();
    Session session(window->get(), **document, **view, **overlay);
    glfwSetWindowUserPointer(window->get(), &session);
    ended = session.run();
    glfwSetWindowUserPointer(window->get(), nullptr);
  }
  if (!ended) return ended;
  const auto messages = (*view)->renderer().take_validation_messages();
  if (messages.empty()) return {};
  return Error{ErrorKind::failed, "the validation layer spoke: " + messages.front()};
}

}  // namespace maille
