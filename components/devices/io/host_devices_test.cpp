// With a directory tree like that of the kernel: which devices are listed.
#include "components/devices/io/host_devices.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <unistd.h>

#include "components/devices/io/can_link.h"
#include "tests/support/temporary_folder.h"

namespace rack::device {
namespace host_devices_test {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

class HostDevicesTest : public testing::Test {
 protected:
  void file(const std::string& path, const std::string& content = {}) {
    fs::create_directories((folder_.path() / path).parent_path());
    std::ofstream(folder_.path() / path) << content << '\n';
  }
  // `target`: from the root.
  void link(const std::string& path, const std::string& target) {
    const fs::path from = folder_.path() / path;
    fs::create_directories(from.parent_path());
    fs::create_directories(folder_.path() / target);
    fs::create_symlink(fs::relative(folder_.path() / target, from.parent_path()), from);
  }
  // Creates a USB device.
  void usb(const std::string& place, const std::string& vendor, const std::string& product) {
    const std::string folder = "sys/devices/pci/usb1/" + place + "/";
    file(folder + "idVendor", vendor);
    file(folder + "idProduct", product);
    file(folder + "serial", "H0512345");
    file(folder + "manufacturer", "Hokuyo");
    file(folder + "product", "URG");
    file(folder + "busnum", "1");
    file(folder + "devnum", "4");
    link("sys/bus/usb/devices/" + place, "sys/devices/pci/usb1/" + place);
  }
  void acm() {
    usb("1-2", "15d1", "0000");
    link("sys/devices/pci/usb1/1-2/1-2:1.0/driver", "sys/bus/usb/drivers/cdc_acm");
    link("sys/class/tty/ttyACM0/device", "sys/devices/pci/usb1/1-2/1-2:1.0");
    file("dev/ttyACM0");
  }
  std::vector<HostDevice> found() { return host_devices(folder_.path()); }

  tims::test::TemporaryFolder folder_;
};

TEST_F(HostDevicesTest, NothingIsNothing) { EXPECT_THAT(found(), IsEmpty()); }

TEST_F(HostDevicesTest, ASerialPortIsIdentified) {
  acm();
  fs::create_directories(folder_.path() / "dev/serial/by-id");
  fs::create_symlink("../../ttyACM0", folder_.path() / "dev/serial/by-id/usb-Hokuyo-if00");
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(1)) << "and the device of the bus is not shown again";
  const HostDevice& device = devices[0];
  EXPECT_EQ(device.node, "ttyACM0");
  EXPECT_EQ(device.driver, "cdc_acm");
  EXPECT_EQ(device_address(device), "serial:/dev/serial/by-id/usb-Hokuyo-if00");
  ASSERT_TRUE(device.usb);
  EXPECT_EQ(device.usb->vendor, 0x15D1);
  EXPECT_EQ(device.usb->serial_number, "H0512345");
  EXPECT_EQ(device.usb->plugged_as, 1004U);
  EXPECT_EQ(programs_text(device), "LadarHokuyoUrgUsb");
  EXPECT_THAT(what_is_missing(device), IsEmpty());
}

TEST_F(HostDevicesTest, OurOwnNameIsTheBest) {
  acm();
  for (const char* folder : {"dev/serial/by-id", "dev/rack"})
    fs::create_directories(folder_.path() / folder);
  fs::create_symlink("../../ttyACM0", folder_.path() / "dev/serial/by-id/usb-Hokuyo-if00");
  fs::create_symlink("../ttyACM0", folder_.path() / "dev/rack/hokuyo-H0512345");
  EXPECT_EQ(device_address(found().at(0)), "serial:/dev/rack/hokuyo-H0512345");
}

TEST_F(HostDevicesTest, PortsThatAreNoneAreLeftOut) {
  file("sys/class/tty/console/dev");  // without a device
  link("sys/class/tty/ttyS0/device", "sys/devices/serial8250:0");
  file("sys/class/tty/ttyS0/type", "0");
  file("dev/ttyS0");
  link("sys/class/tty/ttyS1/device", "sys/devices/serial8250:1");
  file("sys/class/tty/ttyS1/type", "4");  // there is one, but no file for it
  EXPECT_THAT(found(), IsEmpty());
  file("dev/ttyS1");
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_EQ(found()[0].path, "/dev/ttyS1");
}

TEST_F(HostDevicesTest, ProgramsThatUseItAreNamed) {
  acm();
  file("proc/4711/comm", "LadarHokuyoUrg");
  fs::create_directories(folder_.path() / "proc/4711/fd");
  for (const char* name : {"3", "4"})
    fs::create_symlink("/dev/ttyACM0", folder_.path() / "proc/4711/fd" / name);
  EXPECT_THAT(found().at(0).used_by, ElementsAre("LadarHokuyoUrg (pid 4711)"));
}

TEST_F(HostDevicesTest, CanInterfacesAndWhetherTheyAreUp) {
  file("sys/class/net/can0/type", "280");
  file("sys/class/net/can0/flags", "0x40080");
  file("sys/class/net/can1/type", "280");
  file("sys/class/net/can1/flags", "0x400c1");
  file("sys/class/net/eth0/type", "1");
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(2));
  EXPECT_FALSE(devices[0].is_up);
  EXPECT_TRUE(devices[1].is_up);
  EXPECT_EQ(device_address(devices[1]), "can:can1");
}

void put(std::vector<std::byte>& to, const auto& value) {
  const auto bytes = std::as_bytes(std::span(&value, 1));
  to.insert(to.end(), bytes.begin(), bytes.end());
}
std::vector<std::byte> attribute_of(unsigned short type, std::span<const std::byte> value) {
  std::vector<std::byte> all;
  put(all,
      rtattr{.rta_len = static_cast<unsigned short>(RTA_LENGTH(value.size())), .rta_type = type});
  all.insert(all.end(), value.begin(), value.end());
  all.resize(RTA_ALIGN(all.size()));
  return all;
}
std::vector<std::byte> joined(std::vector<std::byte> one, const std::vector<std::byte>& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}

// Answer of kernel 6.1 for a controller; truncated attributes are ignored.
TEST(CanLinkTest, ItsBitRateAndStateAreRead) {
  std::vector<std::byte> timing;
  can_bittiming rate{};
  rate.bitrate = 500000;
  put(timing, rate);
  std::vector<std::byte> state;
  put(state, std::uint32_t{3});
  const auto data =
      joined(attribute_of(IFLA_CAN_CTRLMODE, std::array<std::byte, 8>{}),
             joined(attribute_of(IFLA_CAN_BITTIMING, timing), attribute_of(IFLA_CAN_STATE, state)));
  const auto info = joined(attribute_of(IFLA_INFO_KIND, std::as_bytes(std::span("can"))),
                           attribute_of(IFLA_INFO_DATA | NLA_F_NESTED, data));
  std::vector<std::byte> message;
  nlmsghdr head{};
  head.nlmsg_type = RTM_NEWLINK;
  put(message, head);
  put(message, ifinfomsg{});
  message = joined(message, joined(attribute_of(IFLA_IFNAME, std::as_bytes(std::span("can0"))),
                                   attribute_of(IFLA_LINKINFO, info)));
  const CanLink link = parse_can_link(message);
  EXPECT_TRUE(link.is_hardware);
  EXPECT_EQ(link.bit_rate, 500000U);
  EXPECT_EQ(link.state, "bus-off");
  for (std::size_t size = 0; size < message.size(); ++size) {
    const std::vector<std::byte> cut(message.begin(),
                                     message.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(parse_can_link(cut).state, "") << size;
  }
}

TEST_F(HostDevicesTest, AStickIsShownOnce) {
  for (const char* name : {"js0", "event3"}) {
    link("sys/class/input/" + std::string(name) + "/device", "sys/devices/virtual/input/input7");
    file("dev/input/" + std::string(name));
  }
  file("sys/devices/virtual/input/input7/name", "Gamepad");
  file("sys/devices/virtual/input/input7/js0/dev");
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(1));
  EXPECT_EQ(programs_text(devices[0]), "Joystick");
  EXPECT_EQ(device_address(devices[0]), "/dev/input/js0");
  EXPECT_EQ(device_text(devices[0]), "Gamepad");
}

TEST_F(HostDevicesTest, ACameraIsShownOnce) {
  for (const char* index : {"0", "1"}) {
    const std::string node = "video" + std::string(index);
    file("sys/class/video4linux/" + node + "/index", index);
    file("sys/class/video4linux/" + node + "/name", "Webcam");
    file("dev/" + node);
  }
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(1));
  EXPECT_EQ(device_address(devices[0]), "v4l:/dev/video0");
  EXPECT_EQ(device_text(devices[0]), "Webcam");
  EXPECT_EQ(programs_text(devices[0]), "CameraV4l");
}

TEST_F(HostDevicesTest, ADeviceWithoutADriverIsShownAndWhatItNeeds) {
  usb("1-3", "10c4", "ea60");
  file("dev/bus/usb/001/004");
  usb("usb1", "1d6b", "0002");
  file("sys/devices/pci/usb1/usb1/bDeviceClass", "09");
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(1)) << "hubs are left out";
  EXPECT_EQ(devices[0].node, "1-3");
  EXPECT_EQ(devices[0].path, "/dev/bus/usb/001/004");
  EXPECT_THAT(what_is_missing(devices[0]), ElementsAre(testing::HasSubstr("modprobe cp210x")));
}

TEST_F(HostDevicesTest, AnFtdiConverterReportsItsLatency) {
  usb("1-2", "0403", "6001");
  link("sys/class/tty/ttyUSB0/device", "sys/devices/pci/usb1/1-2/1-2:1.0/ttyUSB0");
  file("sys/devices/pci/usb1/1-2/1-2:1.0/ttyUSB0/latency_timer", "16");
  file("dev/ttyUSB0");
  EXPECT_EQ(found().at(0).latency_ms, 16);
}

TEST(HostDevicesHereTest, CanBeListed) {
  for (const HostDevice& device : host_devices()) EXPECT_FALSE(device.node.empty());
  const auto events = listen_for_devices();
  if (events) take_device_events(*events);
}

}  // namespace host_devices_test
}  // namespace rack::device
