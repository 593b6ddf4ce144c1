#include "components/pilot/pilot_replay.h"

#include <functional>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/path/polar_spline.h"
#include "components/pilot/car_fixture.h"

namespace rack::pilot {
namespace pilot_replay_test {

using device::CaptureRecord;
using Capture = std::vector<CaptureRecord>;

constexpr int kPeriod = 50;  // ms

// An indoor robot with a pilot that records, among posts that come and go.
class Drive {
 public:
  explicit Drive(int looks = 1)
      : settings_{.chassis = indoor_chassis(),
                  .maxSpeed = 700,
                  .looks = looks,
                  .scanPeriod = 75,
                  .positionPeriod = 50,
                  .chassisPeriod = 50} {
    EXPECT_TRUE(driver.begin(settings_));
    record(PilotRecord::kBegin, settings_);
    path_.recordingTime = 77;
    path_.splines.push_back(path::line({}, 4000));
    path_.splines.push_back(path::arc({.x = 4000}, 2000, 3142));
    for (PolarSpline& spline : path_.splines) {
      spline.vMax = spline.vStart = spline.vEnd = 700;
      spline.accMax = spline.decMax = 700;
      spline.lbo = 1000;
    }
  }

  void go(int looks) {
    for (int i = 0; i < looks; ++i) step();
  }
  void hold(bool on) {
    const PilotHoldData data{.holdState = on ? 1 : 0};
    record(PilotRecord::kHold, data);
    driver.hold(data);
  }
  void watch(Milliseconds<u32> timeout) {
    const PilotWatchdogData data{timeout};
    record(PilotRecord::kWatchdog, data);
    driver.watch(data);
  }

  PathDriver driver;
  Capture capture;
  std::vector<std::pair<int, int>> posts;  // in the world, mm
  bool is_blind = false;

 private:
  template <typename T>
  void record(PilotRecord kind, const T& message) {
    CaptureRecord& made = capture.emplace_back();
    made.time = std::chrono::milliseconds(time_);
    made.id = static_cast<std::uint32_t>(kind);
    made.bytes.resize(encoded_size(message));
    EXPECT_TRUE(encode(message, made.bytes, std::endian::little));
  }

  void step() {
    time_ += kPeriod;
    PathCycle look{.time = TimeStamp(static_cast<u32>(time_))};
    look_around(look);
    record(PilotRecord::kCycle, RecordedCycle{look, static_cast<u32>(capture.size())});
    const ChassisMoveData move = driver.step(look);
    record(PilotRecord::kMove, move);
    record(PilotRecord::kStatus, driver.status());
    (void)driver.take_request();
    for (int i = 0; i < kPeriod; i += 5)
      car_.step({static_cast<double>(move.vx), static_cast<double>(move.omega)});
  }

  void look_around(PathCycle& look) {
    PathDriver::Inputs& inputs = driver.inputs();
    const Pose at = car_.measured();
    look.came = PathCycle::kPosition | PathCycle::kChassis;
    inputs.position.recordingTime = look.time;
    inputs.position.pos = at.position();
    record(PilotRecord::kPosition, inputs.position);
    inputs.chassis.recordingTime = look.time;
    inputs.chassis.vx = static_cast<f32>(car_.speed());
    record(PilotRecord::kChassis, inputs.chassis);
    if (inputs.path.recordingTime != path_.recordingTime) {
      look.came |= PathCycle::kPath;
      inputs.path = path_;
      record(PilotRecord::kPath, inputs.path);
    }
    if (is_blind) {
      look.scanSilence = ++blind_for_;
      return;
    }
    blind_for_ = 0;
    look.came |= PathCycle::kScan;
    inputs.scan.recordingTime = look.time;
    inputs.scan.points.clear();
    for (const auto& [x, y] : posts) {
      const Pose seen = Pose{.x = 1.0 * x, .y = 1.0 * y} - at;
      inputs.scan.points.push_back(
          {.x = whole_millimetres(seen.x), .y = whole_millimetres(seen.y)});
    }
    record(PilotRecord::kScan, inputs.scan);
  }

  PathDriverSettings settings_;
  PathData path_;
  Car car_{{.chassis = indoor_chassis(), .turns_at_rest = true}, {}, 5};
  int time_ = 1000;
  int blind_for_ = 0;
};

Capture drive_with_a_stop() {
  Drive drive;
  drive.go(60);
  drive.posts = {{2800, 0}};
  drive.go(160);
  drive.posts.clear();
  drive.go(20);
  drive.is_blind = true;
  drive.go(20);
  drive.is_blind = false;
  drive.go(10);
  drive.hold(true);
  drive.go(30);
  return std::move(drive.capture);
}

void play(PilotReplay& replay, const Capture& capture) {
  for (const CaptureRecord& record : capture) {
    const auto taken = replay.take(record);
    ASSERT_TRUE(taken) << taken.error().detail();
  }
}

TEST(PilotReplay, DecidesTheSameBitForBit) {
  PilotReplay replay;
  play(replay, drive_with_a_stop());
  EXPECT_EQ(replay.begins(), 1U);
  EXPECT_EQ(replay.decisions(), 300U);
  EXPECT_EQ(replay.different(), 0U) << replay.first_difference()->text;
  EXPECT_EQ(replay.undecided(), 0U);
}

// `timsctl nav goto` watches each drive: without a further WATCHDOG the pilot holds.
TEST(PilotReplay, RepeatsDrivesThatAProgramWatches) {
  Drive drive;
  drive.watch(1000);
  drive.go(60);
  PilotReplay replay;
  play(replay, drive.capture);
  EXPECT_EQ(replay.decisions(), 60U);
  EXPECT_EQ(replay.different(), 0U) << replay.first_difference()->text;
}

TEST(PilotReplay, ReportsWhyItStopped) {
  PilotReplay replay;
  play(replay, drive_with_a_stop());
  std::vector<std::string> stops;
  for (const PilotReplay::Event& event : replay.events())
    if (event.stops) stops.push_back(event.why);
  ASSERT_GE(stops.size(), 2U);
  EXPECT_THAT(stops, testing::Contains(testing::StartsWith("an obstacle, free distance ")));
  EXPECT_THAT(stops, testing::Not(testing::Contains(testing::HasSubstr("corridor"))));
  const auto& events = replay.events();
  const auto has = [&](const char* why) {
    return std::ranges::any_of(events, [&](const auto& e) { return e.why == why; });
  };
  EXPECT_TRUE(has("no scans, or outdated ones"));
  EXPECT_TRUE(has("held by HOLD"));
  EXPECT_TRUE(has("follows the path"));
}

TEST(PilotReplay, TheFirstDifferenceIsReported) {
  Capture capture = drive_with_a_stop();
  int moves = 0;
  for (CaptureRecord& record : capture) {
    if (record.id != static_cast<std::uint32_t>(PilotRecord::kMove) || ++moves != 100) continue;
    record.bytes.at(8) ^= std::byte{1};  // the last bit of its turn
  }
  PilotReplay replay;
  play(replay, capture);
  EXPECT_EQ(replay.different(), 1U);
  ASSERT_TRUE(replay.first_difference());
  EXPECT_EQ(replay.first_difference()->at, std::chrono::milliseconds(1000 + 100 * kPeriod));
  EXPECT_THAT(replay.first_difference()->text, testing::HasSubstr("MOVE"));
  EXPECT_THAT(replay.first_difference()->text, testing::HasSubstr("points of a scan"));
}

TEST(PilotReplay, AChangedParameterIsADifference) {
  for (const auto& [name, value] : {std::pair("maxSpeed", 500), {"lag", 300}}) {
    PilotReplay replay;
    ASSERT_TRUE(replay.change(name, value));
    play(replay, drive_with_a_stop());
    EXPECT_GT(replay.different(), 0U) << name;
  }
  PilotReplay replay;
  const auto refused = replay.change("maxSpede", 1);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().detail(), testing::HasSubstr("maxSpeed, lag"));
}

TEST(PilotReplay, WhatAFullDiskLeftOutIsNotDecided) {
  Capture capture = drive_with_a_stop();
  capture.erase(capture.begin() + 300);
  const Capture again = drive_with_a_stop();
  capture.insert(capture.end(), again.begin(), again.end());  // it was turned off and on
  PilotReplay replay;
  play(replay, capture);
  EXPECT_EQ(replay.begins(), 2U);
  EXPECT_EQ(replay.different(), 0U);
  EXPECT_GT(replay.undecided(), 50U);
  EXPECT_EQ(replay.decisions() + replay.undecided(), 600U);
}

TEST(PilotReplay, SurvivesAnyBytes) {
  const Capture capture = drive_with_a_stop();
  std::mt19937 random(3);
  const auto below = [&](std::size_t end) { return random() % end; };
  for (int round = 0; round < 300; ++round) {
    PilotReplay replay;
    for (CaptureRecord record : capture) {
      if (below(20) == 0 && !record.bytes.empty())
        record.bytes.at(below(record.bytes.size())) = static_cast<std::byte>(below(256));
      if (below(200) == 0) record.bytes.resize(below(2 * record.bytes.size() + 1));
      if (below(200) == 0) record.id = static_cast<std::uint32_t>(below(14));
      if (!replay.take(record)) break;
    }
  }
}

}  // namespace pilot_replay_test
}  // namespace rack::pilot
