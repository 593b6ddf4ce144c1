// The recording of a pilot (PilotPath --record=FILE), decided again. Pure.
//
// It is a capture as those of devices are (components/recordings/capture.h): what the pilot
// received and what it commanded, each as a message of its kind in the order in which it was taken
// into account. Time is what the recorded looks say it was, so that the same decisions come out
// again, bit for bit, at once and on any day; the first that does not is kept, with what it was
// decided by. A parameter can be changed: then the first difference is where it would have
// mattered.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "components/pilot/path_driver.h"
#include "components/recordings/capture.h"

namespace rack::pilot {

// The id of a record; its bytes are the message named behind it, of this machine's byte order.
enum class PilotRecord : std::uint32_t {
  kBegin = 1,  // PathDriverSettings: it was turned on
  kPosition,   // PositionData
  kChassis,    // ChassisData
  kPath,       // PathData, where it is another one
  kScan,       // Scan2dData
  kLook,       // RecordedLook: it decides
  kHold,       // PilotHoldData
  kRevert,     // PilotRevertData
  kPlan,       // PilotPlan
  kKeep,       // PilotMultiDestData: further destinations
  kMove,       // ChassisMoveData: the decision
  kStatus,     // PilotStatusData
};

struct RecordedLook {
  PathLook look{};
  u32 records = 0;  // before it, since it was turned on: a full disk leaves some out
};

struct PilotPlan {
  u32 state = 0;
};

class PilotReplay {
 public:
  struct Difference {
    tims::Duration at{};  // in the recording
    std::string text;     // what was decided then, what now, and by what
  };
  struct Event {
    tims::Duration at{};
    Pose pose;
    bool stops = false;  // it was told to stand
    std::string why;
  };

  // NAME of a parameter of PilotPath. kInvalidArgument: it cannot be changed here.
  Result<void> change(std::string_view name, i32 value);
  static std::string changeable();

  // Record by record. kMalformed: it is none of a pilot's.
  Result<void> take(const device::CaptureRecord& record);

  [[nodiscard]] std::uint64_t begins() const { return begins_; }
  [[nodiscard]] std::uint64_t decisions() const { return decisions_; }
  [[nodiscard]] std::uint64_t different() const { return different_; }
  // Decisions that cannot be made again: records before them are missing.
  [[nodiscard]] std::uint64_t undecided() const { return undecided_; }
  [[nodiscard]] const std::optional<Difference>& first_difference() const { return first_; }
  // Each time the reason for which it drives or stands became another one.
  [[nodiscard]] const std::vector<Event>& events() const { return events_; }

 private:
  Result<void> begin(const device::CaptureRecord& record);
  Result<void> take_input(const device::CaptureRecord& record);
  Result<void> take_command(const device::CaptureRecord& record);
  Result<void> look(const device::CaptureRecord& record);
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
  PathLook looked_;
  std::optional<PathDriver::Why> why_;
  bool is_lost_ = true;        // until it begins
  bool has_differed_ = false;  // at this look
  std::uint32_t records_ = 0;  // since it began
  std::uint64_t begins_ = 0;
  std::uint64_t decisions_ = 0;
  std::uint64_t different_ = 0;
  std::uint64_t undecided_ = 0;
  std::optional<Difference> first_;
  std::vector<Event> events_;
};

}  // namespace rack::pilot
