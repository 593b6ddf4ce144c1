// Replays the recording of a pilot (PilotPath --record=FILE) and repeats its decisions. Pure.
//
// The recording is a capture like those of devices (rack/devices/capture.h): the messages
// that the pilot received and the commands that it sent, in the order of processing. Time comes
// from the recorded cycles, so that the decisions are reproduced bit for bit, as fast as possible
// and on any day. The first difference is kept, together with the inputs of that decision. A
// parameter can be changed: then the first difference shows where it would have mattered.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "components/pilot/path_driver.h"
#include "rack/devices/capture.h"

namespace rack::pilot {

// The id of a record; its payload is the message named behind it, little-endian: a recording is
// replayed on any machine.
enum class PilotRecord : std::uint32_t {
  kBegin = 1,  // PathDriverSettings: the pilot was turned on
  kPosition,   // PositionData
  kChassis,    // ChassisData
  kPath,       // PathData, when it has changed
  kScan,       // Scan2dData
  kCycle,      // RecordedCycle: one decision
  kHold,       // PilotHoldData
  kRevert,     // PilotRevertData
  kPlan,       // PilotPlan
  kKeep,       // PilotMultiDestData: further destinations
  kMove,       // ChassisMoveData: the decision
  kStatus,     // PilotStatusData
  kWatchdog,   // PilotWatchdogData
  kLast = kWatchdog,
};

struct RecordedCycle {
  PathCycle cycle{};
  u32 records = 0;  // number of records since kBegin; with a full disk some are missing
};

struct PilotPlan {
  u32 state = 0;
};

class PilotReplay {
 public:
  struct Difference {
    tims::Duration at{};  // in the recording
    std::string text;     // recorded decision, new decision, and its inputs
  };
  struct Event {
    tims::Duration at{};
    Pose pose;
    bool stops = false;  // the pilot commanded a stop
    std::string why;
  };

  // NAME of a parameter of PilotPath. kInvalidArgument: it cannot be changed in a replay.
  Result<void> change(std::string_view name, i32 value);
  static std::string changeable();

  // Processes one record. kMalformed: it is not a record of a pilot.
  Result<void> take(const device::CaptureRecord& record);

  [[nodiscard]] std::uint64_t begins() const { return begins_; }
  [[nodiscard]] std::uint64_t decisions() const { return decisions_; }
  [[nodiscard]] std::uint64_t different() const { return different_; }
  // Decisions that cannot be repeated: records before them are missing.
  [[nodiscard]] std::uint64_t undecided() const { return undecided_; }
  [[nodiscard]] const std::optional<Difference>& first_difference() const { return first_; }
  // One event for each change of the reason to drive or stand.
  [[nodiscard]] const std::vector<Event>& events() const { return events_; }

 private:
  Result<void> begin(const device::CaptureRecord& record);
  Result<void> take_input(const device::CaptureRecord& record);
  Result<void> take_command(const device::CaptureRecord& record);
  Result<void> cycle(const device::CaptureRecord& record);
  Result<void> compare_move(const device::CaptureRecord& record);
  Result<void> compare_status(const device::CaptureRecord& record);
  void differs(const device::CaptureRecord& record, const std::string& what);
  void note_why(tims::Duration at);
  [[nodiscard]] std::string inputs() const;

  struct Changes {
    std::optional<i32> max_speed, lag, steering_rate, deviation_max, replan_time;
  };
  struct Changeable {
    std::string_view name;
    std::optional<i32> Changes::*value;
  };
  static std::span<const Changeable> all_changeable();

  PathDriver driver_;
  Changes changes_;
  ChassisMoveData move_;
  PilotStatusData status_;
  PathCycle cycle_;
  std::optional<PathDriver::Why> why_;
  bool is_lost_ = true;        // until kBegin
  bool has_differed_ = false;  // in this cycle
  std::uint32_t records_ = 0;  // since kBegin
  std::uint64_t begins_ = 0;
  std::uint64_t decisions_ = 0;
  std::uint64_t different_ = 0;
  std::uint64_t undecided_ = 0;
  std::optional<Difference> first_;
  std::vector<Event> events_;
};

}  // namespace rack::pilot
