#include "components/devices/known/host_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rack/devices/device_address.h"

namespace rack::device {
namespace host_device_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

HostDevice hokuyo() {
  return {.kind = HostDeviceKind::kSerial,
          .node = "ttyACM0",
          .path = "/dev/ttyACM0",
          .stable = "/dev/serial/by-id/usb-Hokuyo-if00",
          .usb = UsbIdentity{.vendor = 0x15D1, .product = 0, .text = "URG", .plugged_as = 4},
          .driver = "cdc_acm"};
}

TEST(HostDeviceTest, AKnownOneIsCalledByItsNameAndItsProgram) {
  EXPECT_EQ(device_text(hokuyo()), "laser range finder Hokuyo");
  EXPECT_EQ(programs_text(hokuyo()), "LadarHokuyoUrgUsb");
  EXPECT_EQ(device_address(hokuyo()), "serial:/dev/serial/by-id/usb-Hokuyo-if00");
  EXPECT_THAT(what_is_missing(hokuyo()), IsEmpty());
}

TEST(HostDeviceTest, AnUnknownDeviceIsShownByItsOwnName) {
  HostDevice device = hokuyo();
  device.usb->vendor = 0xFFFE;
  EXPECT_EQ(device_text(device), "URG");
  EXPECT_EQ(programs_text(device), "any with a serial line");
  device.stable.clear();
  EXPECT_EQ(device_address(device), "serial:/dev/ttyACM0");
}

TEST(HostDeviceTest, AddressesAreThoseOfDrivers) {
  for (const HostDevice& device :
       {hokuyo(), HostDevice{.kind = HostDeviceKind::kCan, .node = "can0"},
        HostDevice{.kind = HostDeviceKind::kVideo, .node = "video0", .path = "/dev/video0"},
        HostDevice{.kind = HostDeviceKind::kUsb,
        .node = "1-2",
        .usb = UsbIdentity{.vendor = 0x19A2, .product = 0x5001, .serial_number = "7"}}})
    EXPECT_TRUE(DeviceAddress::parse(device_address(device))) << device_address(device);
  EXPECT_EQ(device_address({.kind = HostDeviceKind::kUsb, .usb = UsbIdentity{.vendor = 1}}), "");
}

TEST(HostDeviceTest, MissingPermissionIsReportedWithAHint) {
  HostDevice device = hokuyo();
  device.may_use = false;
  device.group = "dialout";
  EXPECT_THAT(what_is_missing(device), ElementsAre(HasSubstr("usermod -aG dialout")));
  device.group = "root";
  EXPECT_THAT(what_is_missing(device), ElementsAre(HasSubstr("60-rack.rules")));
}

TEST(HostDeviceTest, AMissingModuleIsNamed) {
  const HostDevice device{.kind = HostDeviceKind::kUsb,
                          .node = "1-2",
                          .usb = UsbIdentity{.vendor = 0x10C4, .product = 0xEA60}};
  EXPECT_THAT(what_is_missing(device), ElementsAre(HasSubstr("modprobe cp210x")));
}

TEST(HostDeviceTest, OtherObstaclesAreReported) {
  HostDevice device = hokuyo();
  device.latency_ms = 16;
  device.used_by = {"cat (pid 12)"};
  EXPECT_THAT(what_is_missing(device),
              ElementsAre(HasSubstr("latency timer is 16 ms"), "used by cat (pid 12)"));
  device.latency_ms = 1;
  device.used_by.clear();
  EXPECT_THAT(what_is_missing(device), IsEmpty());
  HostDevice can{.kind = HostDeviceKind::kCan, .node = "can1", .is_up = false};
  EXPECT_THAT(what_is_missing(can), ElementsAre(testing::EndsWith("ip link set can1 up")));
  can.driver = "gs_usb";
  EXPECT_THAT(what_is_missing(can), ElementsAre(HasSubstr("can1 up type can bitrate")));
}

TEST(HostDeviceTest, ChangesAreWhatCameAndWhatWent) {
  HostDevice hardware{.kind = HostDeviceKind::kCan, .node = "can0", .text = "CAN interface"};
  hardware.bit_rate = 0;
  EXPECT_THAT(what_is_missing(hardware),
              testing::ElementsAre(testing::HasSubstr(
                  "no bit rate set: ip link set can0 up type can bitrate 500000")));
  hardware.bit_rate = 250000;
  hardware.can_state = "bus-off";
  EXPECT_EQ(device_text(hardware), "CAN interface, 250000 bit/s, bus-off");
  EXPECT_THAT(what_is_missing(hardware),
              testing::ElementsAre(testing::HasSubstr("can0 type can restart")));
  const HostDevice can{.kind = HostDeviceKind::kCan, .node = "can0"};
  const std::vector before = {hokuyo(), can};
  EXPECT_THAT(changes(before, before), IsEmpty());
  std::vector after = before;
  after[0].used_by = {"somebody"};
  EXPECT_THAT(changes(before, after), IsEmpty()) << "it is the same device";
  after[0].usb->plugged_as = 5;
  const auto found = changes(before, after);
  ASSERT_EQ(found.size(), 2U) << "unplugged and plugged in between two lists";
  EXPECT_FALSE(found[0].is_there);
  EXPECT_TRUE(found[1].is_there);
  EXPECT_EQ(changes(before, {}).size(), 2U);
}

}  // namespace host_device_test
}  // namespace rack::device
