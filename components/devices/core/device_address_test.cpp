#include "components/devices/core/device_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::device {
namespace device_address_test {

TEST(DeviceAddressTest, EveryKindIsReadAndWrittenAsItWas) {
  for (const char* text :
       {"serial:/dev/ttyUSB0?baud=500000&parity=even", "serial:/dev/serial/by-id/usb-x-if00",
        "tcp:192.168.0.1:2112", "tcp:[fe80::1%eth0]:2112", "udp::2368", "udp:192.168.0.201:2368",
        "can:can0", "usb:15d1:0000", "usb:15d1:0000/H0712345", "v4l:/dev/video0", "pty:/tmp/lms",
        "dcam:0", "dcam:99", "dcam:0100a1b2", "dcam:00b09d0100a1b2c3?format=UYVY&size=640x480",
        "play:/tmp/a.cap?port=2112&speed=max", "play:scans.cap?loop=1&speed=0.5"}) {
    const auto address = DeviceAddress::parse(text);
    ASSERT_TRUE(address) << text << ": " << address.error().message();
    EXPECT_EQ(address->to_string(), text);
  }
}

TEST(DeviceAddressTest, ErrorsAreReported) {
  const auto why = [](const char* text) {
    const auto address = DeviceAddress::parse(text);
    return address ? std::string("good") : address.error().detail();
  };
  EXPECT_THAT(why(""), testing::HasSubstr("must begin with one of serial:, tcp:"));
  EXPECT_THAT(why("/dev/ttyUSB0"), testing::HasSubstr("must begin with one of"));
  EXPECT_THAT(why("serial:"), testing::HasSubstr("the path is missing"));
  EXPECT_THAT(why("serial:/dev/x?baud=fast"), testing::HasSubstr("from 50 to 12000000"));
  EXPECT_THAT(why("serial:/dev/x?baud=49"), testing::HasSubstr("from 50 to 12000000"));
  EXPECT_EQ(why("serial:/dev/x?baud=50"), "good");
  EXPECT_EQ(why("serial:/dev/x?baud=12000000"), "good");
  EXPECT_THAT(why("serial:/dev/x?baud=12000001"), testing::HasSubstr("from 50 to 12000000"));
  EXPECT_THAT(why("serial:/dev/x?speed=1"), testing::HasSubstr("unknown option \"speed=1\""));
  EXPECT_THAT(why("serial:/dev/x?baud"), testing::HasSubstr("unknown option \"baud\""));
  for (const char* text : {"dcam:", "dcam:100", "dcam:-1", "dcam:00b09d0", "dcam:00b09d0100a1b2c",
                           "dcam:00b09d0100a1b2cg", "dcam:00b09d0100a1b2c34"})
    EXPECT_THAT(why(text), testing::HasSubstr("GUID of 16 hex digits")) << text;
  EXPECT_THAT(why("tcp:host"), testing::HasSubstr("the port is missing"));
  EXPECT_THAT(why("tcp:host:0"), testing::HasSubstr("from 1 to 65535"));
  EXPECT_THAT(why("tcp:host:65536"), testing::HasSubstr("from 1 to 65535"));
  EXPECT_THAT(why("tcp::2112"), testing::HasSubstr("the host is missing"));
  EXPECT_THAT(why("tcp:fe80::1:2112"), testing::HasSubstr("in brackets"));
  EXPECT_THAT(why("usb:15d1"), testing::HasSubstr("four hex digits each"));
  EXPECT_THAT(why("usb:15d1:00g0"), testing::HasSubstr("four hex digits each"));
  EXPECT_THAT(why("can:"), testing::HasSubstr("1 to 15 characters"));
  EXPECT_THAT(why("can:sixteen_letters_"), testing::HasSubstr("1 to 15 characters"));
  EXPECT_THAT(why("play:x?speed=0"), testing::HasSubstr("speed must be max"));
  EXPECT_THAT(why("play:x?speed=-1"), testing::HasSubstr("speed must be max"));
  EXPECT_THAT(why("play:x?speed=nan"), testing::HasSubstr("speed must be max"));
  EXPECT_THAT(why("play:x?loop=2"), testing::HasSubstr("loop must be 0 or 1"));
}

TEST(DeviceAddressTest, OptionsHaveDefaults) {
  EXPECT_EQ(DeviceAddress::parse("serial:/dev/x")->baud(9600), 9600U);
  EXPECT_EQ(DeviceAddress::parse("serial:/dev/x?baud=500000")->baud(9600), 500000U);
  EXPECT_EQ(DeviceAddress::parse("play:x")->speed(), 1);
  EXPECT_EQ(DeviceAddress::parse("play:x?speed=2.5")->speed(), 2.5);
  EXPECT_EQ(DeviceAddress::parse("play:x?speed=max")->speed(), 0);
}

TEST(DeviceAddressTest, NumbersOfTheOriginalAreAddresses) {
  EXPECT_EQ(serial_device(0)->to_string(), "serial:/dev/ttyS0");
  EXPECT_EQ(serial_device(99)->to_string(), "serial:/dev/ttyS99");
  EXPECT_EQ(serial_device(100)->to_string(), "serial:/dev/ttyUSB0");
  EXPECT_EQ(serial_device(299)->to_string(), "serial:/dev/ttyACM99");
  EXPECT_FALSE(serial_device(300));
  EXPECT_FALSE(serial_device(-1));
  EXPECT_EQ(can_device(3)->to_string(), "can:can3");
  EXPECT_FALSE(can_device(-1));
  EXPECT_FALSE(can_device(100));
}

TEST(DeviceAddressTest, TheNumberOfAnIidcCameraIsItsGuid) {
  const auto place = [](const char* text) {
    const auto address = dcam_device(text);
    return address ? address->to_string() : address.error().detail();
  };
  EXPECT_EQ(place("0"), "dcam:0");
  EXPECT_EQ(place("1"), "dcam:00000001");
  EXPECT_EQ(place("4294967295"), "dcam:ffffffff");
  EXPECT_EQ(place("-1"), "dcam:ffffffff");  // as the original stores it
  EXPECT_EQ(place("4294967296"), "dcam:0000000100000000");
  EXPECT_EQ(place("0x00b09d0100a1b2c3"), "dcam:00b09d0100a1b2c3");
  for (const char* text : {"", "0x", "first", "0x10b09d0100a1b2c34", "-4294967295"})
    EXPECT_THAT(place(text), testing::HasSubstr("cameraGuid must be")) << text;
}

}  // namespace device_address_test
}  // namespace rack::device
