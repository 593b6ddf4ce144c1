// Our pilots get the input of the original pilots (recording a-gui-drive); the outputs are
// compared.
#include <cmath>
#include <deque>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"
#include "components/pilot/drive.h"
#include "components/pilot/wall_follower.h"
#include "rack/proxies/position.h"
#include "tests/support/recording.h"

namespace rack::pilot {
namespace recorded_pilots_test {

using tims::Address;

constexpr Address kChassis(0x00110000);

// All messages that one pilot received and sent, in order.
class RecordedPilot {
 public:
  explicit RecordedPilot(Address component) : component_(component) {
    const auto recording =
        tims::test::read_recording(TIMS_TEST_DATA_DIR "/recordings/a-gui-drive.jsonl.gz");
    EXPECT_TRUE(recording) << recording.error().message();
    if (recording) lines_ = recording->lines;
  }

  template <typename Receive, typename Send>
  void replay(Receive receive, Send send) const {
    for (const auto& line : lines_) {
      const auto* message = std::get_if<tims::test::recorded::Message>(&line.event);
      if (message == nullptr) continue;
      const tims::MessageView view = message->view();
      const bool sent = message->to_router && is_its(view.header.src);
      if (sent && view.header.dest == kChassis && view.header.type == ChassisType::kMove)
        send(decode<ChassisMoveData>(view).value());
      if (!message->to_router && is_its(view.header.dest)) receive(view);
    }
  }

 private:
  [[nodiscard]] bool is_its(Address address) const {
    return (address.raw() & 0xFFFFFF00U) == component_.raw();
  }
  Address component_;
  std::vector<tims::test::recorded::Line> lines_;
};

// The original polled its input ten times per second, so it may have used either of the last two
// messages before its output.
template <typename Data>
class Newest {
 public:
  void put(const Data& data) {
    kept_.push_front(data);
    if (kept_.size() > 2) kept_.pop_back();
  }
  [[nodiscard]] const std::deque<Data>& candidates() const { return kept_; }

 private:
  std::deque<Data> kept_;
};

TEST(RecordedPilots, PilotJoystick) {
  Newest<JoystickData> sticks;
  Newest<Scan2dData> scans;
  ChassisParamData chassis;
  int moves = 0;
  int same = 0;
  RecordedPilot(Address(0x00180000))
      .replay(
          [&](const tims::MessageView& message) {
            const std::uint32_t class_id = message.header.src.fields().class_id;
            if (class_id == tims::class_id::kJoystick && message.body.size() == 32)
              sticks.put(decode<JoystickData>(message).value());
            if (class_id == tims::class_id::kScan2d && message.body.size() > 48)
              scans.put(decode<Scan2dData>(message).value());
            if (class_id == tims::class_id::kChassis && message.body.size() == 88)
              chassis = decode<ChassisParamData>(message).value();
          },
          [&](const ChassisMoveData& sent) {
            const JoystickDriveSettings settings{.speed_max = std::min(1000, chassis.vxMax.raw()),
                                                 .turns_at_rest = true};
            const auto as_sent = [&](const JoystickData& stick, const Scan2dData& scan) {
              const Drive ours = joystick_drive(stick, settings, chassis, &scan);
              // The original skips every second point, so it detects an obstacle later.
              return std::abs(ours.speed - sent.vx) <= 10 && ours.speed_safe <= sent.vy + 1 &&
                     ours.speed_safe >= sent.vy - 12 && std::abs(ours.omega - sent.omega) < 1e-3;
            };
            ++moves;
            bool any = false;
            for (const JoystickData& stick : sticks.candidates())
              for (const Scan2dData& scan : scans.candidates()) any = any || as_sent(stick, scan);
            same += any ? 1 : 0;
          });
  EXPECT_GT(moves, 200);
  EXPECT_GE(same, moves - 4) << "only the first, before a scan, and the last, a stop, may differ";
}

TEST(RecordedPilots, PilotWallFollowing) {
  constexpr int kTogether = 168;
  std::optional<WallFollower> follower;
  double heading = 0;
  Drive ours;
  int moves = 0;
  int same = 0;
  RecordedPilot(Address(0x00180100))
      .replay(
          [&](const tims::MessageView& message) {
            const std::uint32_t class_id = message.header.src.fields().class_id;
            if (class_id == tims::class_id::kPosition && message.body.size() == 52)
              heading = decode<PositionData>(message)->pos.rho;
            if (class_id == tims::class_id::kChassis && message.body.size() == 88)
              follower.emplace(WallFollowerSettings{.speed_max = 700, .omega_max = radians(20)},
                               decode<ChassisParamData>(message).value());
            if (class_id == tims::class_id::kScan2d && message.body.size() > 48 && follower) {
              ours = follower->follow(decode<Scan2dData>(message).value(),
                                      std::chrono::milliseconds(100), heading);
            }
          },
          [&](const ChassisMoveData& sent) {
            // At the end of its second turn the original misses a point that ours detects. From
            // then on the recorded input does not correspond to the movements of ours.
            if (++moves > kTogether) return;
            const bool is_same =
                std::abs(ours.speed - sent.vx) <= 25 && std::abs(ours.omega - sent.omega) <= 0.02;
            same += is_same ? 1 : 0;
          });
  EXPECT_GT(moves, kTogether);
  EXPECT_GE(same, kTogether - 5);
}

}  // namespace recorded_pilots_test
}  // namespace rack::pilot
