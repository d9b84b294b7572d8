#include "gpu/device.h"

#include "tests/gpu/gpu_fixture.h"

namespace maille::gpu {
namespace {

DeviceInfo device(int index, std::string name, VkPhysicalDeviceType type) {
  DeviceInfo info;
  info.index = index;
  info.name = std::move(name);
  info.type = type;
  return info;
}

const std::vector<DeviceInfo> kMachine{
    device(0, "llvmpipe (LLVM 15)", VK_PHYSICAL_DEVICE_TYPE_CPU),
    device(1, "Intel Iris", VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU),
    device(2, "NVIDIA GeForce A", VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU),
    device(3, "NVIDIA GeForce B", VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU)};

TEST(ChooseDevice, PrefersDiscreteThenTheFirst) {
  const auto chosen = choose_device(kMachine, "");
  ASSERT_TRUE(chosen);
  EXPECT_EQ(*chosen, 2);
}

TEST(ChooseDevice, PrefersAnyGpuToACpu) {
  EXPECT_EQ(*choose_device(std::span(kMachine).first(2), ""), 1);
  EXPECT_EQ(*choose_device(std::span(kMachine).first(1), ""), 0);
}

TEST(ChooseDevice, TakesAnIndexOrAPartOfTheNameInAnyCase) {
  EXPECT_EQ(*choose_device(kMachine, "3"), 3);
  EXPECT_EQ(*choose_device(kMachine, "force b"), 3);
  EXPECT_EQ(*choose_device(kMachine, "LLVMPIPE"), 0);
}

TEST(ChooseDevice, ErrorListsWhatThereIs) {
  const auto chosen = choose_device(kMachine, "radeon");
  ASSERT_FALSE(chosen);
  EXPECT_EQ(chosen.error().kind, ErrorKind::device);
  EXPECT_NE(chosen.error().message.find("radeon"), std::string::npos);
  EXPECT_NE(chosen.error().message.find("1  Intel Iris (integrated)"), std::string::npos);
  EXPECT_FALSE(choose_device(kMachine, "4"));
  EXPECT_FALSE(choose_device({}, ""));
}

TEST(ChooseDevice, PassesOverWhatCannotBeUsedAndSaysWhy) {
  auto machine = kMachine;
  machine[2].unusable = "Vulkan 1.1, 1.2 is needed";
  EXPECT_EQ(*choose_device(machine, ""), 3);
  const auto chosen = choose_device(machine, "GeForce A");
  ASSERT_FALSE(chosen);
  EXPECT_NE(chosen.error().message.find("1.2 is needed"), std::string::npos);
}

using DeviceTest = GpuTest;

TEST_F(DeviceTest, OpensAndListsItself) {
  ASSERT_TRUE(open(Store::automatic));
  const auto devices = list_devices(*instance_);
  ASSERT_TRUE(devices);
  ASSERT_FALSE(devices->empty());
  EXPECT_EQ((*devices)[static_cast<std::size_t>(device_->info().index)].name, device_->info().name);
  EXPECT_FALSE(device_->info().driver.empty());
}

TEST_F(DeviceTest, ACpuGetsTheDenseStoreUnlessToldOtherwise) {
  ASSERT_TRUE(open(Store::automatic));
  if (device_->info().type != VK_PHYSICAL_DEVICE_TYPE_CPU) GTEST_SKIP() << "this device is no CPU";
  EXPECT_FALSE(device_->sparse_store());
}

TEST_F(DeviceTest, SparseWhereAskedFor) {
  MAILLE_NEEDS(Store::sparse);
  EXPECT_TRUE(device_->sparse_store());
}

TEST_F(DeviceTest, AWishThatNothingFitsIsAnError) {
  ASSERT_TRUE(open(Store::dense));
  const auto other = Device::create(*instance_, {.name = "no such device"});
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().kind, ErrorKind::device);
}

#ifdef MAILLE_VALIDATION
// The fixture's promise is worth nothing if the log does not hear.
TEST_F(DeviceTest, MisuseIsHeard) {
  ASSERT_TRUE(open(Store::dense));
  VkBufferCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = 0;  // must be greater
  info.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  VkBuffer buffer = VK_NULL_HANDLE;
  vkCreateBuffer(device_->get(), &info, nullptr, &buffer);
  if (buffer != VK_NULL_HANDLE) vkDestroyBuffer(device_->get(), buffer, nullptr);
  EXPECT_FALSE(instance_->validation_log().take().empty());
}
#endif

}  // namespace
}  // namespace maille::gpu
