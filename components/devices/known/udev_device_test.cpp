// With tables as udev has them for real devices: which devices are listed, and as what.
#include "components/devices/known/udev_device.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::device {
namespace udev_device_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr const char* kPlace = "/sys/devices/pci/usb1/1-2";
constexpr const char* kInterface = "/sys/devices/pci/usb1/1-2/1-2:1.0";

class UdevDeviceTest : public testing::Test {
 protected:
  // Devices without a file have an empty `file`.
  UdevDevice& add(const std::string& path, const std::string& subsystem,
                  const std::string& parent = {}, const std::string& file = {}) {
    UdevDevice& device = all_.emplace_back(UdevDevice{.path = path, .parent = parent});
    device.properties["SUBSYSTEM"] = subsystem;
    if (!file.empty()) device.properties["DEVNAME"] = file;
    device.has_file = !file.empty();
    return device;
  }
  UdevDevice& usb(const std::string& path, const std::string& vendor, const std::string& product) {
    UdevDevice& device = add(path, "usb", {}, "/dev/bus/usb/001/004");
    device.properties["DEVTYPE"] = "usb_device";
    device.properties["DRIVER"] = "usb";
    device.attributes = {{"idVendor", vendor},   {"idProduct", product},    {"serial", "H0512345"},
                         {"product", "URG"},     {"busnum", "1"},           {"devnum", "4"},
                         {"bDeviceClass", "02"}, {"manufacturer", "Hokuyo"}};
    return device;
  }
  UdevDevice& interface(const std::string& path, const std::string& of, const std::string& driver) {
    UdevDevice& device = add(path, "usb", of);
    device.usb = of;
    device.properties["DEVTYPE"] = "usb_interface";
    if (!driver.empty()) device.properties["DRIVER"] = driver;
    return device;
  }
  UdevDevice& acm() {
    usb(kPlace, "15d1", "0000");
    interface(kInterface, kPlace, "cdc_acm");
    UdevDevice& device =
        add(std::string(kInterface) + "/tty/ttyACM0", "tty", kInterface, "/dev/ttyACM0");
    device.usb = kPlace;
    return device;
  }
  std::vector<HostDevice> found() const { return listed_devices(all_); }

  std::vector<UdevDevice> all_;
};

TEST_F(UdevDeviceTest, NothingIsNothing) { EXPECT_THAT(found(), IsEmpty()); }

TEST_F(UdevDeviceTest, ASerialPortIsIdentified) {
  acm().links = {"/dev/serial/by-path/pci-usb-2", "/dev/serial/by-id/usb-Hokuyo-if00"};
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(1)) << "and the device of the bus is not shown again";
  const HostDevice& device = devices[0];
  EXPECT_EQ(device.node, "ttyACM0");
  EXPECT_EQ(device.driver, "cdc_acm");
  EXPECT_EQ(device_address(device), "serial:/dev/serial/by-id/usb-Hokuyo-if00");
  ASSERT_TRUE(device.usb);
  EXPECT_EQ(device.usb->vendor, 0x15D1);
  EXPECT_EQ(device.usb->serial_number, "H0512345");
  EXPECT_EQ(device.usb->text, "Hokuyo URG");
  EXPECT_EQ(device.usb->plugged_as, 1004U);
  EXPECT_EQ(programs_text(device), "LadarHokuyoUrgUsb");
  EXPECT_THAT(what_is_missing(device), IsEmpty());
}

TEST_F(UdevDeviceTest, OurOwnNameIsTheBest) {
  acm().links = {"/dev/serial/by-id/usb-Hokuyo-if00", "/dev/rack/hokuyo-H0512345",
                 "/dev/rack/hokuyo-H05123450"};
  EXPECT_EQ(device_address(found().at(0)), "serial:/dev/rack/hokuyo-H0512345");
}

TEST_F(UdevDeviceTest, TextOfADeviceCannotControlTheTerminal) {
  acm();
  all_[0].attributes["product"] = "\x1b[2J\nURG";
  all_[0].attributes["idVendor"] = "not hexadecimal";
  all_[0].attributes["devnum"] = "99999999999";
  const HostDevice device = found().at(0);
  EXPECT_TRUE(std::ranges::all_of(device.usb->text, [](char c) { return c >= ' ' && c < 0x7f; }))
      << device.usb->text;
  EXPECT_EQ(device.usb->vendor, 0);
  EXPECT_EQ(device.usb->plugged_as, 1000U);
}

TEST_F(UdevDeviceTest, PortsThatAreNoneAreLeftOut) {
  add("/sys/devices/virtual/tty/console", "tty", {}, "/dev/console");
  add("/sys/devices/serial8250", "platform");
  add("/sys/devices/serial8250/tty/ttyS0", "tty", "/sys/devices/serial8250", "/dev/ttyS0")
      .attributes["type"] = "0";
  UdevDevice& second =
      add("/sys/devices/serial8250/tty/ttyS1", "tty", "/sys/devices/serial8250", "/dev/ttyS1");
  second.attributes["type"] = "4";
  second.has_file = false;  // there is one, but no file for it
  EXPECT_THAT(found(), IsEmpty());
  all_.back().has_file = true;
  ASSERT_THAT(found(), SizeIs(1));
  EXPECT_EQ(found()[0].path, "/dev/ttyS1");
  EXPECT_EQ(device_text(found()[0]), "serial port");
}

TEST_F(UdevDeviceTest, AConverterThatAContainerHasNoFileForIsListedWithAHint) {
  acm().has_file = false;
  HostDevice device = found().at(0);
  EXPECT_FALSE(device.is_there);
  device.may_use = false;
  EXPECT_THAT(what_is_missing(device), ElementsAre(HasSubstr("docker run --device")));
}

TEST_F(UdevDeviceTest, PortsAreInTheOrderOfTheirNumbers) {
  add("/sys/devices/hub", "platform");
  for (const char* name : {"ttyUSB10", "ttyUSB2", "ttyACM7"})
    add(std::string("/sys/devices/hub/") + name, "tty", "/sys/devices/hub",
        std::string("/dev/") + name);
  std::vector<std::string> nodes;
  for (const HostDevice& device : found()) nodes.push_back(device.node);
  EXPECT_THAT(nodes, ElementsAre("ttyACM7", "ttyUSB2", "ttyUSB10"));
}

TEST_F(UdevDeviceTest, CanInterfacesAndWhetherTheyAreUp) {
  const auto interface_is = [&](const std::string& name, const char* type, const char* flags) {
    UdevDevice& device = add("/sys/devices/virtual/net/" + name, "net");
    device.attributes = {{"type", type}, {"flags", flags}};
  };
  interface_is("can0", "280", "0x40080");
  interface_is("can1", "280", "0x400c1");
  interface_is("can2", "280", "");
  interface_is("eth0", "1", "0x1003");
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(3));
  EXPECT_FALSE(devices[0].is_up);
  EXPECT_TRUE(devices[1].is_up);
  EXPECT_FALSE(devices[2].is_up);
  EXPECT_EQ(device_address(devices[1]), "can:can1");
  EXPECT_EQ(device_text(devices[1]), "virtual CAN interface");
}

TEST_F(UdevDeviceTest, AStickIsShownOnce) {
  const std::string input = "/sys/devices/virtual/input/input7";
  add(input, "input").attributes["name"] = "Gamepad";
  for (const char* name : {"/js0", "/event3", "/mouse0"})
    add(std::string(input).append(name), "input", input, std::string("/dev/input").append(name));
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(1));
  EXPECT_EQ(programs_text(devices[0]), "Joystick");
  EXPECT_EQ(device_address(devices[0]), "/dev/input/js0");
  EXPECT_EQ(device_text(devices[0]), "Gamepad");
}

TEST_F(UdevDeviceTest, AKeyboardIsNoStick) {
  const std::string input = "/sys/devices/virtual/input/input8";
  add(input, "input").attributes["name"] = "Keyboard";
  add(input + "/event4", "input", input, "/dev/input/event4");
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(1));
  EXPECT_FALSE(devices[0].is_stick);
  EXPECT_EQ(programs_text(devices[0]), "");
}

TEST_F(UdevDeviceTest, ACameraIsShownOnce) {
  for (const std::string index : {"0", "1"})
    add("/sys/devices/virtual/video4linux/video" + index, "video4linux", {}, "/dev/video" + index)
        .attributes = {{"index", index}, {"name", "Webcam"}};
  add("/sys/devices/virtual/video4linux/v4l-subdev0", "video4linux", {}, "/dev/v4l-subdev0");
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(1));
  EXPECT_EQ(device_address(devices[0]), "v4l:/dev/video0");
  EXPECT_EQ(device_text(devices[0]), "Webcam");
  EXPECT_EQ(programs_text(devices[0]), "CameraV4l");
}

TEST_F(UdevDeviceTest, ACameraOnFireWireIsShownWithItsGuid) {
  const std::string bus = "/sys/devices/pci/0000:05:00.0/";
  add(bus + "fw0", "firewire", {}, "/dev/fw0").attributes = {{"guid", "0x0011060000004a5b"},
                                                             {"vendor_name", "Linux Firewire"}};
  UdevDevice& camera = add(bus + "fw1", "firewire", {}, "/dev/fw1");
  camera.attributes = {{"guid", "0x00b09d0100a1b2c3"},
                       {"units", "0x00a02d:0x000102"},
                       {"vendor_name", "Point Grey Research"},
                       {"model_name", "Flea2"}};
  add(bus + "fw1/fw1.0", "firewire", bus + "fw1").attributes["guid"] = "0x00b09d0100a1b2c3";
  add(bus + "fw2", "firewire", {}, "/dev/fw2").attributes = {{"guid", "0x0800460102ab34cd"},
                                                             {"units", "0x00a02d:0x000100"}};
  add(bus + "fw3", "firewire", {}, "/dev/fw3").attributes["units"] = "0x00a02d:0x000100";
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(2))
      << "neither the host, nor the camera's unit, nor one without GUID";
  EXPECT_EQ(name(devices[0].kind), "firewire");
  EXPECT_EQ(device_address(devices[0]), "dcam:00b09d0100a1b2c3");
  EXPECT_EQ(device_text(devices[0]), "Point Grey Research Flea2");
  EXPECT_EQ(programs_text(devices[0]), "CameraDcam");
  EXPECT_THAT(what_is_missing(devices[0]), IsEmpty());
  EXPECT_EQ(device_text(devices[1]), "IIDC camera");
  // Another camera at the same number is another device.
  auto later = devices;
  later[0].guid = "00b09d0100a1b2c4";
  EXPECT_THAT(changes(devices, later), SizeIs(2));
}

TEST_F(UdevDeviceTest, LinesAndPulsesAreListedWithTheirFiles) {
  add("/sys/devices/platform/gpio/gpiochip0", "gpio", {}, "/dev/gpiochip0");
  add("/sys/devices/platform/gpio/gpio/gpiochip512", "gpio");  // of the old interface
  add("/sys/devices/virtual/pps/pps0", "pps", {}, "/dev/pps0").attributes["name"] = "ktimer";
  const auto devices = found();
  ASSERT_THAT(devices, SizeIs(2));
  EXPECT_EQ(device_address(devices[0]), "gpio:/dev/gpiochip0");
  EXPECT_EQ(device_text(devices[0]), "input and output lines");
  EXPECT_EQ(device_address(devices[1]), "/dev/pps0");
  EXPECT_EQ(device_text(devices[1]), "pulse: ktimer");
}

TEST_F(UdevDeviceTest, ADeviceWithoutADriverIsShownAndWhatItNeeds) {
  const std::string place = "/sys/devices/pci/usb1/1-3";
  usb(place, "10c4", "ea60");
  interface(place + "/1-3:1.0", place, "");
  usb("/sys/devices/pci/usb1", "1d6b", "0002").attributes["bDeviceClass"] = "09";
  auto devices = found();
  ASSERT_THAT(devices, SizeIs(1)) << "hubs are left out";
  EXPECT_EQ(devices[0].node, "1-3");
  EXPECT_EQ(devices[0].path, "/dev/bus/usb/001/004");
  EXPECT_THAT(what_is_missing(devices[0]), ElementsAre(HasSubstr("modprobe cp210x")));
  interface(place + "/1-3:1.1", place, "usbfs");
  devices = found();
  EXPECT_EQ(devices.at(0).driver, "usbfs") << "of the first interface that has one";
}

TEST_F(UdevDeviceTest, AnFtdiConverterReportsItsLatency) {
  usb(kPlace, "0403", "6001");
  interface(kInterface, kPlace, "ftdi_sio");
  const std::string port = std::string(kInterface) + "/ttyUSB0";
  UdevDevice& serial = add(port, "usb-serial", kInterface);
  serial.properties["DRIVER"] = "ftdi_sio";
  serial.attributes["latency_timer"] = "16";
  add(port + "/tty/ttyUSB0", "tty", port, "/dev/ttyUSB0").usb = kPlace;
  const HostDevice device = found().at(0);
  EXPECT_EQ(device.latency_ms, 16);
  EXPECT_EQ(device.driver, "ftdi_sio");
  EXPECT_EQ(found().size(), 1U);
}

TEST_F(UdevDeviceTest, EachAttributeThatTheListUsesIsAskedFor) {
  EXPECT_THAT(udev_attributes("usb-serial"), ElementsAre(testing::StrEq("latency_timer")));
  EXPECT_THAT(udev_attributes("usb"), SizeIs(8));
  EXPECT_THAT(udev_attributes("block"), IsEmpty());
  for (const char* subsystem : {"tty", "net", "video4linux", "input", "pps", "usb", "firewire"})
    EXPECT_FALSE(udev_attributes(subsystem).empty()) << subsystem;
  EXPECT_THAT(udev_subsystems(), SizeIs(8));
}

}  // namespace udev_device_test
}  // namespace rack::device
