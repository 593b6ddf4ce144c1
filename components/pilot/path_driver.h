// The decisions of PilotPath, one per period. Pure.
//
// The result is a function of the inputs in their order and of nothing else: the newest messages,
// the time, the number of periods without a message, and commands. So a recording of these inputs
// reproduces the same decisions bit for bit (pilot_replay.h), and the reason for a stop can be
// found later. A new path is joined at the position of the vehicle; while a message is missing or
// the position is uncertain, the vehicle stands; otherwise it follows the path as fast as the
// obstacles allow.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "components/pilot/obstacle_stop.h"
#include "components/pilot/path_follower.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/position.h"

namespace rack::pilot {

struct PathDriverSettings {
  ChassisParamData chassis{};
  i32 maxSpeed = 4000;   // mm/s
  i32 periodTime = 50;   // ms; all times below are in ms, too
  i32 lag = 100;         // from a command to the reaction of the wheels
  i32 steeringRate = 0;  // deg/s, of steered wheels; 0: no limit
  i32 looks = 1;         // 0: there is no scanner, and no stop at obstacles
  i32 scanPeriod = 0;    // of its inputs
  i32 positionPeriod = 0;
  i32 chassisPeriod = 0;
  i32 pathPeriod = 50;
};

// Inputs of one period: its time, and what was received since the period before.
struct PathCycle {
  static constexpr u32 kPosition = 1;
  static constexpr u32 kChassis = 2;
  static constexpr u32 kPath = 4;
  static constexpr u32 kScan = 8;

  TimeStamp time = 0;
  u32 came = 0;             // mask of the bits above
  i32 positionSilence = 0;  // number of periods in a row without a message
  i32 chassisSilence = 0;
  i32 pathSilence = 0;
  i32 scanSilence = 0;
  i32 deviationMax = 0;   // mm; 0: any
  i32 replanTime = 3000;  // ms; 0: never
};

class PathDriver {
 public:
  // The reason that limits the speed.
  enum class Why : std::uint8_t {
    kDrives,
    kNoPlace,
    kUnsure,
    kPositionMissing,
    kChassisMissing,
    kPathMissing,
    kScanMissing,
    kObstacle,
    kHeld,
    kUnwatched,
    kNoPath,
    kArrived,
    kAstray,
    kTurns,
    kMakesRoom,
    kWaitsAside,
  };
  struct Inputs {
    PositionData position{};
    ChassisData chassis{};
    PathData path{};
    Scan2dData scan{};
  };
  // Requests to other components.
  struct Request {
    std::optional<DestinationPoint> next{};
    std::optional<PathReplanData> around{};
  };

  PathDriver();

  // Resets the state. Error: the vehicle cannot stop in time with these brakes, or the settings are
  // invalid.
  Result<void> begin(PathDriverSettings settings);

  // The caller stores the messages for the next step() here, after begin().
  Inputs& inputs() { return inputs_; }
  [[nodiscard]] const Inputs& inputs() const { return inputs_; }
  // Called once per period. Allocates nothing.
  ChassisMoveData step(const PathCycle& cycle);
  Request take_request();

  void describe(PilotData& data) const;
  // The same without splines.
  [[nodiscard]] PilotStatusData status() const;
  [[nodiscard]] Why why() const;
  [[nodiscard]] std::string why_text() const;
  [[nodiscard]] bool is_unsure() const { return is_unsure_; }

  // --- commands

  [[nodiscard]] bool has_begun() const { return follower_.has_value(); }
  void hold(const PilotHoldData& command);
  void watch(const PilotWatchdogData& command);
  void revert(const PilotRevertData& command) {
    follower_->revert(std::chrono::milliseconds(command.revertTime));
  }
  // Sets the state; returns the previous one. A new plan ends the watch.
  u32 plan(u32 state);
  // Further destinations, used one after the other on arrival. When the path refuses one, it
  // remains the next and is requested again.
  void keep(std::span<const DestinationPoint> further);

 private:
  using milliseconds = std::chrono::milliseconds;

  [[nodiscard]] Pose pose_at(TimeStamp time) const;
  [[nodiscard]] milliseconds period() const { return milliseconds(settings_.periodTime); }
  void take_path();
  PathFollower::Command decide();
  [[nodiscard]] Why missing() const;
  void check_deviation();
  void check_hold_time();
  void check_watchdog();
  [[nodiscard]] bool is_unwatched() const {
    return watchdog_.count() > 0 && watchdog_left_.count() == 0;
  }
  void check_refusal();
  [[nodiscard]] PathReplanData replan_data() const;

  Inputs inputs_;
  PathDriverSettings settings_;
  PathCycle cycle_;
  std::optional<PathFollower> follower_;
  std::optional<ObstacleStop> stop_;
  Pose at_;
  Pose seen_from_;
  PathFollower::Command command_;
  Why missing_ = Why::kDrives;
  double safe_ = 0;  // mm/s
  bool seen_ = false;
  bool located_ = false;
  bool is_unsure_ = false;  // the position is uncertain
  u32 state_ = pilot_state::kIdle;
  bool reached_ = false;  // the end of its path
  TimeStamp taken_ = 0;   // of the current path
  std::vector<DestinationPoint> destinations_;
  bool awaits_next_ = false;  // a path to the first of them was requested
  milliseconds refused_{0};   // time since the refusal
  bool is_held_ = false;      // by HOLD
  milliseconds hold_left_{0};
  milliseconds watchdog_{0};       // 0: nobody monitors the drive
  milliseconds watchdog_left_{0};  // of it
  milliseconds blocked_{0};
};

}  // namespace rack::pilot
