#include "rack/devices/device_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::device {
namespace device_address_test {

TEST(DeviceAddressTest, EveryKindIsReadAndWrittenAsItWas) {
  for (const char* text :
       {"serial:/dev/ttyUSB0?baud=500000&parity=even",
        "serial:/dev/serial/by-id/usb-x-if00",
        "tcp:192.168.0.1:2112",
        "tcp:[fe80::1%eth0]:2112",
        "udp::2368",
        "udp:192.168.0.201:2368",
        "can:can0",
        "usb:15d1:0000",
        "usb:15d1:0000/H0712345",
        "v4l:/dev/video0",
        "pty:/tmp/lms",
        "dcam:0",
        "dcam:99",
        "dcam:0100a1b2",
        "dcam:00b09d0100a1b2c3?format=UYVY&size=640x480",
        "play:/tmp/a.cap?port=2112&speed=max",
        "play:scans.cap?loop=1&speed=0.5",
        "rtsp://admin:pass@192.168.0.90:554/stream1?channel=1&subtype=0",
        "rtsps://cam/1",
        "http://[fe80::1]/video.cgi?resolution=640x480",
        "https://cam.example/mjpg",
        "file:/data/a.mp4?loop=1&rate=10&speed=max",
        "file:a.avi",
        "gstreamer:v4l2src device=/dev/video0 ! image/jpeg,width=640 ! appsink"}) {
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
  for (const char* rate : {"0", "-1", "1000.5", "nan", "fast", ""})
    EXPECT_THAT(why((std::string("file:x?rate=") + rate).c_str()),
                testing::HasSubstr("rate must be pictures per second"));
  EXPECT_EQ(why("file:x?rate=1000"), "good");
  EXPECT_THAT(why("file:x?baud=9600"), testing::HasSubstr("unknown option \"baud=9600\""));
  EXPECT_THAT(why("file:"), testing::HasSubstr("the path is missing"));
  EXPECT_THAT(why("http:cam"), testing::HasSubstr("// is missing"));
  for (const char* url : {"http://", "rtsp:///stream1", "rtsp://user:pass@/1", "http://:80/"})
    EXPECT_THAT(why(url), testing::HasSubstr("the host is missing")) << url;
  for (const char* url : {"http://cam/a b", "http://cam/\r\nHost: x", "http://cam/\x7F"})
    EXPECT_THAT(why(url), testing::HasSubstr("%20")) << url;
  EXPECT_THAT(why(("http://cam/" + std::string(8182, 'x')).c_str()),
              testing::HasSubstr("more than 8192 bytes"));
  EXPECT_EQ(why(("http://cam/" + std::string(8181, 'x')).c_str()), "good");
  EXPECT_THAT(why(("gstreamer:" + std::string(8193, 'x')).c_str()),
              testing::HasSubstr("more than 8192 bytes"));
  EXPECT_EQ(why(("gstreamer:" + std::string(8192, 'x')).c_str()), "good");
  EXPECT_THAT(why("gstreamer: "), testing::HasSubstr("the pipeline is missing"));
  EXPECT_THAT(why("play:x?loop=2"), testing::HasSubstr("loop must be 0 or 1"));
}

TEST(DeviceAddressTest, OptionsHaveDefaults) {
  EXPECT_EQ(DeviceAddress::parse("serial:/dev/x")->baud(9600), 9600U);
  EXPECT_EQ(DeviceAddress::parse("serial:/dev/x?baud=500000")->baud(9600), 500000U);
  EXPECT_EQ(DeviceAddress::parse("play:x")->speed(), 1);
  EXPECT_EQ(DeviceAddress::parse("play:x?speed=2.5")->speed(), 2.5);
  EXPECT_EQ(DeviceAddress::parse("play:x?speed=max")->speed(), 0);
}

TEST(DeviceAddressTest, PathsThatUsersPasteAreVideosOrCameras) {
  const auto read = [](const char* text) {
    const auto address = DeviceAddress::parse(text);
    return address ? address->to_string() : address.error().detail();
  };
  EXPECT_EQ(read("/data/a:b.mp4"), "file:/data/a:b.mp4");
  EXPECT_EQ(read("./a.avi?loop=1"), "file:./a.avi?loop=1");
  EXPECT_EQ(read("../pictures"), "file:../pictures");
  EXPECT_EQ(read("file:///data/a.mp4"), "file:/data/a.mp4");
  EXPECT_EQ(read("file://///data/a.mp4"), "file:/data/a.mp4");
  EXPECT_EQ(read("/dev/video2"), "v4l:/dev/video2");
  EXPECT_EQ(read("/dev/video2?size=640x480"), "v4l:/dev/video2?size=640x480");
  EXPECT_THAT(read("/dev/ttyACM0"), testing::HasSubstr("must begin with one of"));
  EXPECT_THAT(read("a.avi"), testing::HasSubstr("must begin with one of"));
}

TEST(DeviceAddressTest, PasswordsAreNotShown) {
  const auto shown = [](const char* text) { return DeviceAddress::parse(text)->shown(); };
  EXPECT_EQ(shown("rtsp://admin:secret@cam/1?a=b:c@d"), "rtsp://admin:***@cam/1?a=b:c@d");
  EXPECT_EQ(shown("rtsp://admin:se:c@ret@cam:554"), "rtsp://admin:***@cam:554");
  EXPECT_EQ(shown("rtsp://admin@cam:554/1"), "rtsp://admin@cam:554/1");
  EXPECT_EQ(shown("http://cam:80/@x:y@"), "http://cam:80/@x:y@");
  EXPECT_EQ(shown("gstreamer:rtspsrc location=rtsp://u:p@a/1 ! tee ! x uri=http://v:w@b"),
            "gstreamer:rtspsrc location=rtsp://u:***@a/1 ! tee ! x uri=http://v:***@b");
  EXPECT_EQ(shown("serial:/dev/x?baud=50"), "serial:/dev/x?baud=50");
  EXPECT_EQ(without_passwords("http://u:p@"), "http://u:***@");
  const auto address = DeviceAddress::parse("http://u:p@cam/a b");
  EXPECT_THAT(address.error().detail(), testing::HasSubstr("http://u:***@cam/a b"));
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
