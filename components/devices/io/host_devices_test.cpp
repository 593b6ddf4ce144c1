// The real machine, whatever is plugged in: most of the list is tested in
// known/udev_device_test.cpp with tables of devices that this machine does not have.
#include "components/devices/io/host_devices.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/io/device_monitor.h"
#include "components/devices/io/udev_library.h"

namespace rack::device {
namespace host_devices_test {

namespace fs = std::filesystem;

constexpr std::array<const char*, 1> kTerminals = {"tty"};

TEST(HostDevicesTest, EachIsADeviceOfTheKernelAndIsListedOnce) {
  std::set<std::pair<HostDeviceKind, std::string>> nodes;
  for (const HostDevice& device : host_devices()) {
    EXPECT_FALSE(device.node.empty());
    EXPECT_TRUE(nodes.emplace(device.kind, device.node).second) << device.node;
    EXPECT_TRUE(device.path.empty() || device.path.starts_with("/dev/")) << device.path;
    if (device.kind == HostDeviceKind::kSerial) {
      EXPECT_TRUE(fs::exists("/sys/class/tty/" + device.node + "/device")) << device.node;
    }
    if (!device.stable.empty()) {
      EXPECT_TRUE(fs::equivalent(device.stable, device.path)) << device.stable;
    }
  }
}

// Also in a container, where udev has no database.
TEST(HostDevicesTest, TheLibraryKnowsTheTerminalsOfThisKernel) {
  if (!fs::exists("/sys/class/tty/tty")) GTEST_SKIP() << "no /sys";
  const auto terminals = udev_devices(kTerminals);
  const auto found = std::ranges::find_if(terminals, [](const Udev<udev_device>& device) {
    return ::udev_device_get_sysname(device.get()) == std::string_view("tty");
  });
  ASSERT_NE(found, terminals.end());
  EXPECT_STREQ(::udev_device_get_devnode(found->get()), "/dev/tty");
  const auto devices = host_devices();
  EXPECT_EQ(std::ranges::count(devices, "tty", &HostDevice::node), 0) << "no serial port";
}

TEST(HostDevicesTest, ChangesCanBeWaitedFor) {
  auto monitor = DeviceMonitor::open();
  if (!monitor) GTEST_SKIP() << monitor.error().message();  // a sandbox without netlink
  EXPECT_GE(monitor->descriptor(), 0);
  monitor->take_events();
}

}  // namespace host_devices_test
}  // namespace rack::device
