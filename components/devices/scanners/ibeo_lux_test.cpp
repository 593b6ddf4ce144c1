#include "components/devices/scanners/ibeo_lux.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "base/text.h"
#include "components/devices/scanners/ego_motion.h"
#include "components/devices/scanners/ibeo_lux_emulator.h"
#include "rack/devices/virtual_line.h"

namespace rack::device {
namespace ibeo_lux_test {

using namespace std::chrono_literals;
using emulator::VirtualLine;

constexpr double kDegree = std::numbers::pi / 180;

struct Nobody : Output {
  void send(std::span<const std::byte>, std::uint32_t) override { FAIL(); }
};

// The bytes that the emulator sends within a time.
std::vector<std::byte> stream_of(Duration how_long,
                                 const emulator::IbeoLuxSettings& settings = {}) {
  std::vector<std::byte> received;
  emulator::IbeoLux scanner(settings);
  IbeoLux driver({});
  VirtualLine line(driver, scanner, {});
  line.set_lose([&](bool, std::span<const std::byte> sent) {
    received.insert(received.end(), sent.begin(), sent.end());
    return false;
  });
  line.start();
  line.run(how_long);
  return received;
}

int messages_in(std::initializer_list<std::span<const std::byte>> pieces) {
  LuxMessages messages;
  LuxMessage message;
  int found = 0;
  for (const auto piece : pieces) {
    messages.add({.bytes = piece});
    while (messages.next(message))
      found += message.kind == lux::kScan || message.kind == lux::kObjects ? 1 : 0;
  }
  return found;
}

TEST(IbeoLuxTest, TimesOfNtp) {
  EXPECT_EQ(lux_microseconds(0), 0);
  EXPECT_EQ(lux_microseconds(5ULL << 32 | 0x8000'0000), 5'500'000);
  EXPECT_EQ(lux_microseconds(0xFFFF'FFFF), 999'999);
}

TEST(IbeoLuxTest, SeesTheRoomInFourLayers) {
  const emulator::Room room;
  emulator::IbeoLux scanner({.sight = room});
  IbeoLux driver({});
  VirtualLine line(driver, scanner, {.piece = 1460, .delay = 3ms});
  line.start();
  LadarData scan;
  Time recorded;
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(line.run(1s, [&] { return driver.take(scan, recorded); }));
    ASSERT_EQ(scan.points.size(), 800U);
    EXPECT_EQ(scan.duration, 22U);
    EXPECT_NEAR(scan.startAngle, -50 * kDegree, 1e-6);
    EXPECT_NEAR(scan.endAngle, 50 * kDegree, 1e-6);
    for (const LadarPoint& point : scan.points) {
      ASSERT_NEAR(point.distance, room.distance(point.angle), 6);
      ASSERT_EQ(point.type, ladar_point::kUnknown);
    }
    EXPECT_EQ(scan.points[0].angle, scan.points[200].angle);
    // Time to build the message, and half a scan. A constant delay cannot be detected.
    EXPECT_NEAR(static_cast<double>((line.now() - recorded).count()) / 1e6, 5 + 11, 0.01);
  }
}

TEST(IbeoLuxTest, ObjectsAndTheirContours) {
  const auto body = stream_of(100ms);
  LuxMessages messages;
  messages.add({.bytes = body});
  LuxMessage message;
  ASSERT_TRUE(messages.next(message));
  ASSERT_TRUE(messages.next(message));
  ASSERT_EQ(message.kind, lux::kObjects);
  ObjRecogData boxes;
  ObjRecogData contours;
  std::int64_t began = 0;
  for (const bool absolute : {false, true}) {
    ASSERT_TRUE(decode_lux_objects(message.body, absolute, boxes, contours, began));
    ASSERT_EQ(boxes.objects.size(), 1U);
    const ObjRecogObject& box = boxes.objects[0];
    EXPECT_EQ(box.objectId, 17);
    EXPECT_EQ(box.type, object_type::kCar);
    EXPECT_EQ(box.pos.x, 10000);
    EXPECT_EQ(box.pos.y, -1500);  // to the left
    EXPECT_NEAR(box.pos.rho, 5 * kDegree, 1e-6);
    EXPECT_EQ(box.dim.x, 4500);
    EXPECT_EQ(box.dim.y, 1800);
    EXPECT_EQ(box.varPos.x, 80);
    EXPECT_EQ(box.varVel.y, 120);
    EXPECT_EQ(box.vel.x, absolute ? -3000 : -4000);
    EXPECT_EQ(box.vel.y, absolute ? -200 : -250);
    ASSERT_EQ(contours.objects.size(), 2U);
    EXPECT_EQ(contours.objects[0].pos.x, 9000);
    EXPECT_EQ(contours.objects[0].pos.y, -1500);
    EXPECT_EQ(contours.objects[0].dim.x, 1800);
    EXPECT_NEAR(contours.objects[0].pos.rho, -90 * kDegree, 1e-6);
    EXPECT_EQ(contours.objects[1].dim.x, 4000);
    EXPECT_EQ(contours.objects[1].pos.y, -2400);
  }
  for (std::size_t size = 0; size < message.body.size(); ++size)
    EXPECT_FALSE(decode_lux_objects(message.body.first(size), false, boxes, contours, began));
}

TEST(IbeoLuxTest, AContourOfFfffPointsIsAFaultOfTheScanner) {
  emulator::IbeoLux scanner({.has_contour_fault = true});
  IbeoLux driver({.absolute_speeds = true});
  VirtualLine line(driver, scanner, {});
  line.start();
  ObjRecogData boxes;
  ObjRecogData contours;
  Time recorded;
  ASSERT_TRUE(line.run(1s, [&] { return driver.take_objects(boxes, contours, recorded); }));
  EXPECT_EQ(boxes.objects.size(), 1U);
  EXPECT_TRUE(contours.objects.empty());
  EXPECT_EQ(line.now() - recorded, 27ms);
}

TEST(IbeoLuxTest, FlagsAndTheNearestOfSeveralEchoes) {
  std::string text(2 * lux::kScanHead, '0');
  text.replace(44, 4, "002d");  // 11520 ticks
  text.replace(56, 4, "0600");  // six points
  text +=
      "0000"
      "0000"
      "e803"
      "00000000";  // layer 0, ahead: 10 m
  text +=
      "1000"
      "0000"
      "f401"
      "00000000";  // second echo: 5 m
  text +=
      "2001"
      "0000"
      "6400"
      "00000000";  // third echo, transparent: 1 m
  text +=
      "0102"
      "4001"
      "c800"
      "00000000";  // layer 1, 10 degrees to the left: rain
  text +=
      "0104"
      "3001"
      "c800"
      "00000000";  // ground
  text +=
      "0108"
      "2001"
      "c800"
      "00000000";  // dirt
  const auto body = *tims::base::parse_hex(text);
  LadarData scan;
  LuxScan times;
  ASSERT_TRUE(decode_lux_scan(body, false, scan, times));
  ASSERT_EQ(scan.points.size(), 6U);
  EXPECT_EQ(scan.points[2].type, ladar_point::kTransparent);
  EXPECT_EQ(scan.points[3].type, ladar_point::kRain);
  EXPECT_NEAR(scan.points[3].angle, -10 * kDegree, 1e-6);
  EXPECT_EQ(scan.points[4].type, ladar_point::kInvalid);
  EXPECT_EQ(scan.points[5].type, ladar_point::kDirt);
  ASSERT_TRUE(decode_lux_scan(body, true, scan, times));
  ASSERT_EQ(scan.points.size(), 4U);
  EXPECT_EQ(scan.points[0].distance, 5000);
  for (std::size_t size = 0; size < body.size(); ++size)
    EXPECT_FALSE(decode_lux_scan(std::span(body).first(size), false, scan, times));
}

TEST(IbeoLuxTest, EverySplitAndJoiningInTheMiddle) {
  const auto stream = stream_of(180ms);
  ASSERT_EQ(messages_in({stream}), 4);
  for (std::size_t cut = 0; cut <= stream.size(); cut += cut < 100 || cut > 8000 ? 1 : 37)
    EXPECT_EQ(messages_in({std::span(stream).first(cut), std::span(stream).subspan(cut)}), 4)
        << cut;
  for (std::size_t from = 1; from < stream.size() / 2; from += 17)
    EXPECT_GE(messages_in({std::span(stream).subspan(from)}), 2) << from;
}

// Messages have no checksum: the test only requires that the following messages are found again.
TEST(IbeoLuxTest, AfterFlippedBitsAndNoiseItGoesOn) {
  const auto stream = stream_of(2s);
  const int all = messages_in({stream});
  for (std::size_t bit = 0; bit < 24 * 8; ++bit) {
    auto broken = stream;
    broken[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    EXPECT_GE(messages_in({broken}), all - 28) << bit;
  }
  std::mt19937 random(1);
  Nobody nobody;
  IbeoLux driver({});
  driver.start(Time(1s), nobody);
  LadarData scan;
  ObjRecogData boxes;
  ObjRecogData contours;
  Time recorded;
  for (int i = 0; i < 300; ++i) {
    auto broken = stream;
    for (int flips = 0; flips < 50; ++flips)
      broken[random() % broken.size()] ^= static_cast<std::byte>(1 << random() % 8);
    driver.on_arrival({.bytes = std::span(broken).first(20'000)}, nobody);
    driver.take(scan, recorded);
    driver.take_objects(boxes, contours, recorded);
  }
}

TEST(EgoMotionTest, FourFrames) {
  // 2 m/s, a turn to the right of 2 m radius; wheel base 1 m.
  const auto frames = ego_frames({.speed = 2000, .omega = 1}, 1000);
  EXPECT_EQ(tims::base::to_hex(frames[0]), "0200c8");
  EXPECT_EQ(tims::base::to_hex(frames[1]), "02f830");  // -2 m/s2
  EXPECT_EQ(tims::base::to_hex(frames[2]), "02fe30");  // -464 mrad
  EXPECT_EQ(tims::base::to_hex(frames[3]), "02d8f0");
  const auto still = ego_frames({.speed = 0, .omega = 10}, 1000);
  EXPECT_EQ(tims::base::to_hex(still[2]), "020000");
  EXPECT_EQ(tims::base::to_hex(still[3]), "028001");

  struct Bus : Output {
    void send(std::span<const std::byte>, std::uint32_t id) override { ids.push_back(id); }
    std::vector<std::uint32_t> ids;
  } bus;
  EgoMotion dialogue(1000);
  dialogue.start(Time(1s), bus);
  EXPECT_EQ(dialogue.next_timeout(), tims::kNever);
  dialogue.set_motion({.speed = 1, .omega = 0});
  ASSERT_LE(dialogue.next_timeout(), Time(1s));
  dialogue.on_timeout(Time(1s), bus);
  EXPECT_EQ(bus.ids, (std::vector<std::uint32_t>{0x303, 0x304, 0x305, 0x306}));
  EXPECT_EQ(dialogue.next_timeout(), tims::kNever);
}

}  // namespace ibeo_lux_test
}  // namespace rack::device
