// A device to test on, and the promise that nobody complained about what was done with it.
#pragma once

#include <cstdlib>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "gpu/device.h"
#include "gpu/work_queue.h"

namespace maille::gpu {

class GpuTest : public ::testing::Test {
 protected:
  // False where the device lacks what the store needs; the test then skips itself.
  bool open(Store store, bool window = false) {
    auto made = Instance::create({.headless_surface = window, .log = log_});
    if (!made) {
      ADD_FAILURE() << made.error().message;
      return false;
    }
    instance_ = std::move(*made);
    const char* name = std::getenv("MAILLE_TEST_DEVICE");
    auto opened = Device::create(
        *instance_, {.name = name != nullptr ? name : "", .store = store, .window = window});
    if (!opened) {
      if (store != Store::sparse) ADD_FAILURE() << opened.error().message;
      return false;
    }
    device_ = std::move(*opened);
    auto queue = WorkQueue::create(*device_);
    if (!queue) {
      ADD_FAILURE() << queue.error().message;
      return false;
    }
    queue_ = std::move(*queue);
    return true;
  }

  void TearDown() override {
    queue_.reset();
    device_.reset();
#ifdef MAILLE_VALIDATION
    if (instance_) {
      EXPECT_TRUE(instance_->validating());
    }
#endif
    instance_.reset();
    for (const std::string& message : log_->take()) {
      ADD_FAILURE() << "validation layer: " << message;
    }
  }

  std::shared_ptr<ValidationLog> log_ = std::make_shared<ValidationLog>();
  std::unique_ptr<Instance> instance_;
  std::unique_ptr<Device> device_;
  std::unique_ptr<WorkQueue> queue_;
};

#define MAILLE_NEEDS(store)                                \
  if (!open(store)) {                                      \
    if (HasFailure()) return;                              \
    GTEST_SKIP() << "this device has no sparse 3D images"; \
  }                                                        \
  static_assert(true)

inline std::vector<std::byte> noise(std::size_t bytes, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> result(bytes);
  for (std::byte& b : result) b = static_cast<std::byte>(random() & 0xFF);
  return result;
}

}  // namespace maille::gpu
