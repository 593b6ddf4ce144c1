// The transport at a stand-in behind the library's calls (tests/support/dc1394_stand_in.cpp).
#include <chrono>
#include <map>

#include <dc1394/dc1394.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include "components/devices/core/video_frame.h"
#include "components/devices/io/transports.h"
#include "os/clock.h"
#include "rack/devices/device.h"
#include "tests/support/dc1394_scene.h"
#include "tests/support/patience.h"

namespace rack::device {
namespace dcam_test {

using testing::HasSubstr;

struct Frame {
  std::vector<std::byte> bytes;
  Time time{};
  std::uint32_t id = 0;
};

class DcamTest : public testing::Test, protected tims::test::Dc1394Scene {
 protected:
  static tims::Result<std::unique_ptr<Transport>> open(const std::string& text) {
    const auto address = DeviceAddress::parse(text);
    EXPECT_TRUE(address) << address.error().message();
    return open_dcam(*address);
  }
  static std::string why(const std::string& text) {
    const auto opened = open(text);
    return opened ? "good" : opened.error().detail();
  }
  // Waits for frames, and keeps heads and controls.
  tims::Result<void> receive(Transport& transport, std::size_t count) {
    const Time end = tims::os::now() + tims::test::kPatience;
    while (frames_.size() < count && tims::os::now() < end) {
      pollfd wait{.fd = transport.descriptor(), .events = POLLIN, .revents = 0};
      ::poll(&wait, 1, 20);
      auto received = transport.receive(tims::os::now(), [&](const Arrival& arrival) {
        if (arrival.id == video::kHead)
          head_ = video_head(arrival.bytes);
        else if (arrival.id == video::kControl)
          controls_[video_control(arrival.bytes)->id] = *video_control(arrival.bytes);
        else
          frames_.push_back(
              {{arrival.bytes.begin(), arrival.bytes.end()}, arrival.last, arrival.id});
      });
      if (!received) return received;
    }
    EXPECT_GE(frames_.size(), count);
    return {};
  }

  std::optional<VideoHead> head_;
  std::map<std::uint32_t, VideoControl> controls_;
  std::vector<Frame> frames_;
};

TEST_F(DcamTest, FramesComeWithTheirHeadTheirTimesAndTheControls) {
  const Time begin = tims::os::now();
  const auto camera = open("dcam:0?size=640x480&format=UYVY&rate=20");
  ASSERT_TRUE(camera) << camera.error().message();
  EXPECT_EQ((*camera)->description(), "IIDC camera 00b09d0100a1b2c3 (Nobody Stand-in?) 640x480");
  EXPECT_EQ(state("sending"), 1);
  EXPECT_EQ(state("rate"), DC1394_FRAMERATE_30);
  ASSERT_TRUE(receive(**camera, 3));
  EXPECT_EQ(head_, (VideoHead{video::kUyvy, 640, 480, 1280}));
  for (const Frame& frame : frames_) {
    EXPECT_EQ(frame.id, video::kUyvy);
    EXPECT_EQ(frame.bytes.size(), 640U * 480 * 2);
    EXPECT_LE(frame.time, tims::os::now() - std::chrono::milliseconds(2));
    EXPECT_GE(frame.time, begin - std::chrono::milliseconds(2));
  }
  EXPECT_LT(frames_[0].time, frames_[1].time);
  EXPECT_EQ(controls_[video::kShutter], (VideoControl{video::kShutter, 1, 4095, 1000}));
  EXPECT_EQ(controls_[video::kGain], (VideoControl{video::kGain, 192, 1023, 192}));
  EXPECT_EQ(controls_[video::kBlueBalance].max, 255);
  EXPECT_EQ(controls_[video::kAutoGain].value, 1);
  EXPECT_EQ(controls_[video::kAutoWhiteBalance].value, 1);
  EXPECT_EQ((*camera)->statistics(), "");
}

TEST_F(DcamTest, AFrameWithoutATimeHasThatOfItsArrival) {
  scene("old", 1);
  const auto camera = open("dcam:0?size=320x240");
  ASSERT_TRUE(camera);
  const Time begin = tims::os::now();
  ASSERT_TRUE(receive(**camera, 1));
  EXPECT_GE(frames_[0].time, begin);
  EXPECT_LE(frames_[0].time, tims::os::now());
}

TEST_F(DcamTest, AWindowOfTheSensorIsInItsMiddle) {
  const auto camera = open("dcam:0?size=1280x960&format=RGGB,GBRG,GRBG,BA81&rate=10");
  ASSERT_TRUE(camera) << camera.error().message();
  EXPECT_EQ(state("left"), 54);
  EXPECT_EQ(state("top"), 39);
  EXPECT_EQ(state("packet"), 1536);  // 1228800 bytes in 800 packets
  ASSERT_TRUE(receive(**camera, 1));
  EXPECT_EQ(head_, (VideoHead{video::kRggb, 1280, 960, 1280}));
}

TEST_F(DcamTest, NumbersOf16BitsAreBigEndian) {
  const auto camera = open("dcam:0?size=640x480&format=Y16");
  ASSERT_TRUE(camera);
  ASSERT_TRUE(receive(**camera, 1));
  EXPECT_EQ(frames_[0].id, video::kGrey16 | video::kBigEndian);
}

TEST_F(DcamTest, ControlsAreSet) {
  auto camera = open("dcam:0?size=320x240");
  ASSERT_TRUE(camera);
  ASSERT_TRUE(receive(**camera, 1));
  const auto set = [&](std::uint32_t id, int value) {
    const auto sent = (*camera)->send(tims::os::now(), control_bytes(value), id);
    return sent && *sent;
  };
  EXPECT_TRUE(set(video::kShutter, 4095));
  EXPECT_EQ(state("shutter"), 4095);
  EXPECT_EQ(state("autoshutter"), 0);
  EXPECT_EQ(state("autogain"), 1) << "another control";
  EXPECT_TRUE(set(video::kAutoGain, 0));
  EXPECT_EQ(state("autogain"), 0);
  EXPECT_TRUE(set(video::kBlueBalance, 140));
  EXPECT_TRUE(set(video::kRedBalance, 130));
  EXPECT_EQ(state("blue"), 140);
  EXPECT_EQ(state("red"), 130);
  EXPECT_EQ(state("autowhite"), 0);
  EXPECT_TRUE(set(video::kAutoWhiteBalance, 1));
  EXPECT_EQ(state("autowhite"), 1);
  EXPECT_FALSE(set(video::kShutter, 4096)) << "outside of its range";
  EXPECT_FALSE(set(video::kShutter, -1));
  EXPECT_FALSE(set(video::kBrightness, 1)) << "not one of its controls";
  EXPECT_FALSE(set(0, 1));
  EXPECT_FALSE(*(*camera)->send(tims::os::now(), std::vector<std::byte>(3), video::kGain));
  camera->reset();
  EXPECT_EQ(state("sending"), 0);
}

// As CameraDcam does: it sets blue when that is reported, and red after that.
TEST_F(DcamTest, AControlMayBeSetAsSoonAsItIsReported) {
  const auto camera = open("dcam:0?size=320x240");
  ASSERT_TRUE(camera);
  ASSERT_TRUE((*camera)->receive(tims::os::now(), [&](const Arrival& arrival) {
    const auto control = video_control(arrival.bytes);
    if (!control) return;
    controls_[control->id] = *control;
    if (control->id == video::kBlueBalance) {
      EXPECT_TRUE((*camera)->send(tims::os::now(), control_bytes(140), control->id));
    }
  }));
  EXPECT_EQ(state("blue"), 140);
  EXPECT_EQ(state("red"), 90);
  EXPECT_EQ(controls_[video::kRedBalance].value, 90);
}

TEST_F(DcamTest, ACameraIsFoundByItsNumberOrItsGuid) {
  scene("cameras", 3);
  const auto name = [](const std::string& place) {
    const auto camera = open("dcam:" + place + "?size=320x240");
    return camera ? (*camera)->description().substr(0, 28) : camera.error().detail();
  };
  EXPECT_EQ(name("0"), "IIDC camera 00b09d0100a1b2c1");
  EXPECT_EQ(name("2"), "IIDC camera 00b09d0100a1b2c3");
  EXPECT_EQ(name("00a1b2c2"), "IIDC camera 00b09d0100a1b2c2");
  EXPECT_EQ(name("00B09D0100A1B2C2"), "IIDC camera 00b09d0100a1b2c2");
  EXPECT_THAT(name("3"), HasSubstr("IIDC camera 3 is not there; there are: 00b09d0100a1b2c1 "));
  EXPECT_THAT(name("00b09d0200a1b2c2"), HasSubstr("is not there"));
}

TEST_F(DcamTest, WhatIsMissingIsReported) {
  scene("small", 1);
  EXPECT_THAT(why("dcam:0?size=800x600"), HasSubstr("does not send 800x600 as UYVY, RGB3, GREY"));
  EXPECT_THAT(why("dcam:0?size=800"), HasSubstr("size must be"));
  EXPECT_THAT(why("dcam:0?speed=300"), HasSubstr("speed must be 100"));
  EXPECT_THAT(why("dcam:0?speed=800"),
              HasSubstr("no speeds above 400 Mbit/s: Generic failure (camera is not capable"));
  EXPECT_FALSE(check_dcam(*DeviceAddress::parse("dcam:0?size=800x600")));
  EXPECT_TRUE(check_dcam(*DeviceAddress::parse("dcam:0?size=640x480")));
  scene("full", 1);
  EXPECT_THAT(why("dcam:0?size=640x480"),
              HasSubstr("No bandwidth (Error: could not allocate bandwidth); the bus is full"));
  EXPECT_TRUE(check_dcam(*DeviceAddress::parse("dcam:0?size=640x480")));
  scene("plugged", 0);
  EXPECT_THAT(why("dcam:0"), HasSubstr("IIDC camera 0 is not there, nor is any other; check that"));
  scene("bus", 0);
  EXPECT_THAT(why("dcam:0"), HasSubstr("no FireWire or USB bus; check that it is plugged in"));
  const auto other = open_transport(*DeviceAddress::parse("dcam:0"), 0);
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().detail(), HasSubstr("by CameraDcam"));
}

TEST_F(DcamTest, AnUnpluggedCameraIsGoneAndComesBack) {
  auto camera = open("dcam:0?size=320x240");
  ASSERT_TRUE(camera);
  ASSERT_TRUE(receive(**camera, 1));
  scene("plugged", 0);
  const auto gone = receive(**camera, 1000);
  ASSERT_FALSE(gone);
  EXPECT_THAT(gone.error().detail(), HasSubstr("00b09d0100a1b2c3 is gone"));
  camera->reset();
  EXPECT_FALSE(open("dcam:0?size=320x240"));
  scene("plugged", 1);
  camera = open("dcam:0?size=320x240");
  ASSERT_TRUE(camera);
  scene("broken", 1);
  const auto broken = receive(**camera, 1000);
  ASSERT_FALSE(broken);
  EXPECT_THAT(broken.error().detail(), HasSubstr("is gone: Generic failure (dequeue: no device)"));
}

TEST_F(DcamTest, CorruptFramesAreDropped) {
  scene("corrupt", 2);
  const auto camera = open("dcam:0?size=320x240&rate=30");
  ASSERT_TRUE(camera);
  ASSERT_TRUE(receive(**camera, 3));
  EXPECT_THAT((*camera)->statistics(), HasSubstr("corrupt frames"));
  scene("corrupt", 1);
  const std::size_t before = frames_.size();
  const auto received = receive(**camera, 1000);
  ASSERT_FALSE(received);
  EXPECT_THAT(received.error().detail(), HasSubstr("sends only corrupt frames"));
  EXPECT_LE(frames_.size(), before + 1);
}

TEST_F(DcamTest, ACameraThatWasSendingIsStoppedAndReported) {
  scene("sending", 1);
  const auto camera = open("dcam:0?size=320x240");
  ASSERT_TRUE(camera);
  EXPECT_THAT((*camera)->take_event().value_or(""), HasSubstr("another program has crashed"));
  EXPECT_FALSE((*camera)->take_event());
  ASSERT_TRUE(receive(**camera, 1));
}

}  // namespace dcam_test
}  // namespace rack::device
