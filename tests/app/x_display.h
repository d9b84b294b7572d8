// A display of the test's own (Xvfb), and a person at it: pointer, buttons and keys by plain Xlib.
//
// Motion is the server's own; buttons and keys are events sent to the window, which spares the
// XTEST extension. Both reach the window in the order of the calls.
#pragma once

#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/app/picture.h"

#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/keysym.h>

namespace maille::test {

// For a loaded machine under the thread sanitizer; what passes takes seconds.
inline constexpr std::chrono::seconds kPatience{120};

// Whether it came true within kPatience.
inline bool comes_true(const std::function<bool()>& it) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!it()) {
    if (std::chrono::steady_clock::now() > end) return false;
    usleep(20'000);
  }
  return true;
}

// A program that does not outlive the test.
class Child {
 public:
  Child() = default;
  // in_child runs between fork and exec.
  Child(std::vector<std::string> words, const std::function<void()>& in_child) {
    std::vector<char*> arguments;
    for (auto& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    in_child();
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  Child(Child&& other) noexcept : pid_(std::exchange(other.pid_, 0)) {}
  Child& operator=(Child&& other) noexcept {
    std::swap(pid_, other.pid_);
    return *this;
  }
  ~Child() { kill_now(); }

  void kill_now() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(std::exchange(pid_, 0), nullptr, 0);
  }
  // The exit code; 128 and the signal's number where one ended it; -1: it still runs after
  // kPatience.
  int wait() {
    int status = 0;
    if (pid_ <= 0 || !comes_true([&] { return waitpid(pid_, &status, WNOHANG) != 0; })) return -1;
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  bool runs() {
    siginfo_t info{};
    return pid_ > 0 &&
           waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid == 0;
  }

 private:
  pid_t pid_ = 0;
};

class XDisplay {
 public:
  // Errors are told by name(), which is empty then, and missing().
  XDisplay() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return;
    const int told = ends[1];
    const auto number = std::to_string(told);
    server_ = Child({"Xvfb", "-displayfd", number, "-screen", "0", "1280x1024x24", "-nolisten",
                     "tcp", "-noreset"},
                    [told] {
                      fcntl(told, F_SETFD, 0);
                      const int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC);
                      dup2(nothing, STDERR_FILENO);
                    });
    close(told);
    std::string line;
    for (char c = 0; read(ends[0], &c, 1) == 1 && c != '\n';) line += c;
    close(ends[0]);
    if (line.empty()) {
      missing_ = server_.wait() == 127;
      return;
    }
    name_ = ":" + line;
    display_ = XOpenDisplay(name_.c_str());
    if (display_ == nullptr) name_.clear();
  }
  ~XDisplay() {
    if (display_ != nullptr) XCloseDisplay(display_);
  }
  XDisplay(const XDisplay&) = delete;
  XDisplay& operator=(const XDisplay&) = delete;

  const std::string& name() const { return name_; }
  bool missing() const { return missing_; }  // no Xvfb on this machine

  // Takes the window whose title begins so; false while there is none that can be seen.
  bool find_window(const std::string& title) {
    Window root = 0;
    Window parent = 0;
    Window* children = nullptr;
    unsigned count = 0;
    if (XQueryTree(display_, DefaultRootWindow(display_), &root, &parent, &children, &count) == 0) {
      return false;
    }
    for (unsigned i = 0; i < count; ++i) {
      char* name = nullptr;
      if (XFetchName(display_, children[i], &name) == 0 || name == nullptr) continue;
      XWindowAttributes attributes{};
      if (std::string(name).rfind(title, 0) == 0 &&
          XGetWindowAttributes(display_, children[i], &attributes) != 0 &&
          attributes.map_state == IsViewable) {
        window_ = children[i];
        width_ = attributes.width;
        height_ = attributes.height;
      }
      XFree(name);
    }
    if (children != nullptr) XFree(children);
    return window_ != 0;
  }

  void move_to(int x, int y) {
    XWarpPointer(display_, 0, window_, 0, 0, 0, 0, x, y);
    XFlush(display_);
  }
  void press() { send_button(ButtonPress); }
  void release() { send_button(ButtonRelease); }
  // modifiers: ControlMask and its like.
  void key(KeySym symbol, unsigned modifiers = 0) {
    XEvent event{};
    event.xkey.window = window_;
    event.xkey.root = DefaultRootWindow(display_);
    event.xkey.same_screen = True;
    event.xkey.keycode = XKeysymToKeycode(display_, symbol);
    event.xkey.state = modifiers;
    for (const int type : {KeyPress, KeyRelease}) {
      event.type = type;
      event.xkey.time = ++time_;
      XSendEvent(display_, window_, True, type == KeyPress ? KeyPressMask : KeyReleaseMask, &event);
    }
    XFlush(display_);
  }

  // What is on the screen where the window is.
  Pixels screen() {
    Pixels pixels;
    XImage* const image = XGetImage(display_, window_, 0, 0, static_cast<unsigned>(width_),
                                    static_cast<unsigned>(height_), AllPlanes, ZPixmap);
    if (image == nullptr) return pixels;
    pixels.width = width_;
    pixels.height = height_;
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const unsigned long value = XGetPixel(image, x, y);
        for (const int shift : {16, 8, 0}) {
          pixels.rgb.push_back(static_cast<std::uint8_t>(value >> shift));
        }
      }
    }
    XDestroyImage(image);
    return pixels;
  }

  // As when a person logs out.
  void end_server() {
    XCloseDisplay(std::exchange(display_, nullptr));  // it would end this process too
    server_.kill_now();
  }

 private:
  void send_button(int type) {
    XEvent event{};
    event.type = type;
    event.xbutton.window = window_;
    event.xbutton.root = DefaultRootWindow(display_);
    event.xbutton.same_screen = True;
    event.xbutton.button = Button1;
    event.xbutton.time = ++time_;
    XSendEvent(display_, window_, True, type == ButtonPress ? ButtonPressMask : ButtonReleaseMask,
               &event);
    XFlush(display_);
  }

  Child server_;
  std::string name_;
  bool missing_ = false;
  Display* display_ = nullptr;
  Window window_ = 0;
  int width_ = 0;
  int height_ = 0;
  Time time_ = 1000;  // the toolkit drops a key that is not later than the one before
};

}  // namespace maille::test
