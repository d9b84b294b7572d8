// The window from end to end: the built program on a display of the test's own, a head in it, and a
// pointer that pulls its nose.
//
// Nothing is timed: what should come is asked for until it is there. Pictures of one state of one
// machine are equal to the byte, so "the same" allows for next to nothing: kSame of the pixels.
#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/app/picture.h"
#include "tests/app/program.h"
#include "volume/phantom.h"
#include "volume/volume_file.h"

#include "tests/app/x_display.h"

namespace maille::test {
namespace {

constexpr int kDifference = 8;  // of 255, in one channel: a pixel has changed
constexpr double kSame = 1e-4;
constexpr int kWidth = 1024;
constexpr int kHeight = 768;
// Of the head of write_head() in the first camera.
constexpr int kNose[2] = {512, 440};
constexpr int kPull = 20;  // pixels, to the right: as far as the bone lets the skin go

void write_head(const std::filesystem::path& path) {
  const auto head = make_phantom("head", {112, 128, 128}, 1);
  ASSERT_TRUE(head.ok());
  ASSERT_TRUE(write_volume(path, *head).ok());
}

struct Change {
  double near_nose = 0.0;  // share of the pixels there
  double elsewhere = 0.0;
};

// Near: within 128 pixels of the nose, across and down.
Change change_between(const Pixels& a, const Pixels& b) {
  Pixels inside[2];
  Pixels outside[2];
  for (int which = 0; which < 2; ++which) {
    const Pixels& all = which == 0 ? a : b;
    for (int y = 0; y < all.height; ++y) {
      for (int x = 0; x < all.width; ++x) {
        const bool near = std::max(std::abs(x - kNose[0]), std::abs(y - kNose[1])) < 128;
        Pixels& part = (near ? inside : outside)[which];
        const auto first = all.rgb.begin() + std::ptrdiff_t{3} * (y * all.width + x);
        part.rgb.insert(part.rgb.end(), first, first + 3);
      }
    }
  }
  return {share_that_differs(inside[0], inside[1], kDifference),
          share_that_differs(outside[0], outside[1], kDifference)};
}

bool same(const Pixels& a, const Pixels& b) {
  return share_that_differs(a, b, kDifference) <= kSame;
}

class WindowTest : public testing::Test {
 protected:
  void SetUp() override {
    if (display_.missing()) GTEST_SKIP() << "Xvfb is not installed (tools/setup installs it)";
    ASSERT_NE(display_.name(), "") << "Xvfb does not start";
    write_head(folder_ / "head.nrrd");
    program_ = Child({MAILLE_PROGRAM, "head.nrrd"}, [&] {
      setenv("DISPLAY", display_.name().c_str(), 1);
      unsetenv("WAYLAND_DISPLAY");
      dup2(open(folder_("err").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDERR_FILENO);
      if (chdir(folder_.path().c_str()) != 0) _exit(126);
    });
    ASSERT_TRUE(comes_true([&] { return display_.find_window("Maille") || !program_.runs(); }));
    ASSERT_TRUE(program_.runs()) << said();
    display_.move_to(kWidth / 2, kHeight - 10);
    ASSERT_EQ(picture().width, kWidth) << said();
  }

  // By F12. Empty: none came.
  Pixels picture() {
    const auto path = folder_ / ("maille-" + std::to_string(++pictures_) + ".png");
    display_.key(XK_F12);
    comes_true([&] { return std::filesystem::exists(path) || !program_.runs(); });
    return std::filesystem::exists(path) ? read_png(path) : Pixels{};
  }

  // The first picture that is as wanted; what is asked of the window takes a moment.
  bool shows(const std::function<bool(const Pixels&)>& wanted) {
    return comes_true([&] { return !program_.runs() || wanted(last_ = picture()); }) &&
           program_.runs();
  }
  bool shows(const Pixels& wanted) {
    return shows([&](const Pixels& p) { return same(p, wanted); });
  }

  // Each step is one wish and one new picture, as relaxation stands still from before the grab: the
  // last one is the end.
  Pixels pull_the_nose() {
    display_.key(XK_space);
    display_.move_to(kNose[0], kNose[1]);
    display_.press();
    Pixels before = first_;
    for (int step = 1; step <= 2; ++step) {
      display_.move_to(kNose[0] + kPull * step / 2, kNose[1]);
      EXPECT_TRUE(shows([&](const Pixels& now) { return !same(now, before); })) << said();
      before = last_;
    }
    return last_;
  }

  void quit() {
    display_.key(XK_q);
    EXPECT_EQ(program_.wait(), 0) << said();
    // What is said while everything is taken down does not reach the exit code.
    EXPECT_EQ(said().find("vulkan "), std::string::npos) << said();
  }

  std::string said() const { return read_file(folder_ / "err"); }

  const Folder folder_;
  XDisplay display_;
  Child program_;
  int pictures_ = 0;
  Pixels first_;
  Pixels last_;
};

TEST_F(WindowTest, ADragPullsTheNoseAndEscapeBringsItBack) {
  first_ = picture();
  const auto pulled = pull_the_nose();
  const auto change = change_between(first_, pulled);
  EXPECT_GT(change.near_nose, 0.01);
  EXPECT_LT(change.elsewhere, kSame);
  display_.key(XK_Escape);
  EXPECT_TRUE(shows(first_));
  // The button is still down, and what it does now is nothing.
  display_.move_to(kNose[0] + 2 * kPull, kNose[1]);
  display_.release();
  EXPECT_TRUE(same(picture(), first_));
  quit();
}

TEST_F(WindowTest, WhatWasPulledStaysUntilItIsUndone) {
  first_ = picture();
  const auto pulled = pull_the_nose();
  display_.release();
  EXPECT_TRUE(same(picture(), pulled));
  display_.key(XK_z, ControlMask);
  EXPECT_TRUE(shows(first_));
  display_.key(XK_z, ControlMask | ShiftMask);
  EXPECT_TRUE(shows(pulled));
  quit();
}

TEST_F(WindowTest, RelaxationGoesOnWhileNothingIsAsked) {
  first_ = picture();
  const auto pulled = pull_the_nose();
  display_.release();
  display_.key(XK_space);
  EXPECT_TRUE(shows([&](const Pixels& now) { return !same(now, pulled); }));
  EXPECT_LT(change_between(first_, last_).elsewhere, 0.01);
  quit();
}

TEST_F(WindowTest, ADragOnTheBackgroundTurnsTheView) {
  first_ = picture();
  display_.move_to(60, 60);
  display_.press();
  display_.move_to(160, 60);
  display_.release();
  EXPECT_TRUE(shows([&](const Pixels& now) {
    const auto change = change_between(first_, now);
    return change.near_nose > 0.2 && change.elsewhere > 0.05;
  }));
  display_.key(XK_Return);  // the whole volume, from the front
  EXPECT_TRUE(shows(first_));
  quit();
}

TEST_F(WindowTest, TheFirstSurfaceIsShownAndTheTransferFunctionAgain) {
  first_ = picture();
  display_.key(XK_i);
  EXPECT_TRUE(
      shows([&](const Pixels& now) { return change_between(first_, now).near_nose > 0.2; }));
  display_.key(XK_i);
  EXPECT_TRUE(shows(first_));
  quit();
}

TEST_F(WindowTest, HelpIsOnTheScreenOnly) {
  first_ = picture();
  // In the middle, so that the panel in the corner may say what it likes.
  const auto change_on_screen = [&](const Pixels& before) {
    return change_between(before, display_.screen()).near_nose;
  };
  ASSERT_TRUE(comes_true([&] { return change_on_screen(first_) < kSame; }));
  display_.key(XK_h);
  EXPECT_TRUE(comes_true([&] { return change_on_screen(first_) > 0.2; }));
  EXPECT_TRUE(same(picture(), first_));
  display_.key(XK_h);
  EXPECT_TRUE(comes_true([&] { return change_on_screen(first_) < kSame; }));
  quit();
}

TEST_F(WindowTest, EndsWithItsDisplay) {
  display_.end_server();
  EXPECT_EQ(program_.wait(), 1) << said();
  EXPECT_NE(said(), "");
}

TEST(WithoutADisplay, ThereIsNoWindowAndASentenceSaysSo) {
  const Folder folder;
  Child program({MAILLE_PROGRAM}, [&] {
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    dup2(open(folder("err").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDERR_FILENO);
  });
  EXPECT_EQ(program.wait(), 4);
  const auto said = read_file(folder / "err");
  EXPECT_EQ(said.rfind("maille: error: no window can be opened: ", 0), 0u) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
}

}  // namespace
}  // namespace maille::test
