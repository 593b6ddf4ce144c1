// What PilotPath decides, period after period. Pure.
//
// A function of what it was told, in that order, and of nothing else: the newest messages of its
// inputs, what time it was, how often nothing had come, and commands. So a recording of these gives
// the same decisions again, bit for bit (pilot_replay.h), and why a robot stopped can be found out
// after the fact. The steps are those of a careful driver: a new path is taken where the vehicle
// is; as long as a message is missing, or nobody is sure of the position, it stands; else it goes
// as fast as the obstacles allow along the path.
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
  i32 periodTime = 50;   // ms; also those below
  i32 lag = 100;         // from a command to the wheels
  i32 steeringRate = 0;  // deg/s, of steered wheels; 0: they need no time
  i32 looks = 1;         // 0: without a scan, it stops before nothing
  i32 scanPeriod = 0;    // of its inputs
  i32 positionPeriod = 0;
  i32 chassisPeriod = 0;
  i32 pathPeriod = 50;
};

// What came since the look before, and when it looks.
struct PathLook {
  static constexpr u32 kPosition = 1;
  static constexpr u32 kChassis = 2;
  static constexpr u32 kPath = 4;
  static constexpr u32 kScan = 8;

  TimeStamp time = 0;
  u32 came = 0;             // which of those
  i32 positionSilence = 0;  // looks in a row at which nothing had come
  i32 chassisSilence = 0;
  i32 pathSilence = 0;
  i32 scanSilence = 0;
  i32 deviationMax = 0;   // mm; 0: any
  i32 replanTime = 3000;  // ms; 0: for ever
};

class PathDriver {
 public:
  // Why it goes no faster.
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
    kNoPath,
    kArrived,
    kAstray,
    kTurns,
  };
  struct Inputs {
    PositionData position{};
    ChassisData chassis{};
    PathData path{};
    Scan2dData scan{};
  };
  // For others to do.
  struct Errand {
    std::optional<DestinationPoint> next{};
    std::optional<PathReplanData> around{};
  };

  PathDriver();

  // Forgets all. An error: these brakes do not stop it in time, or the settings are nonsense.
  Result<void> begin(PathDriverSettings settings);

  // Where the messages of the next look() are put. After begin() only.
  Inputs& inputs() { return inputs_; }
  [[nodiscard]] const Inputs& inputs() const { return inputs_; }
  // Once a period. Allocates nothing.
  ChassisMoveData look(const PathLook& look);
  Errand take_errand();

  void describe(PilotData& data) const;
  // The same without splines.
  [[nodiscard]] PilotStatusData status() const;
  [[nodiscard]] Why why() const;
  [[nodiscard]] std::string why_text() const;
  [[nodiscard]] bool is_unsure() const { return is_unsure_; }

  // --- commands

  [[nodiscard]] bool has_begun() const { return follower_.has_value(); }
  void hold(const PilotHoldData& wish);
  void revert(const PilotRevertData& wish) {
    follower_->revert(std::chrono::milliseconds(wish.revertTime));
  }
  // The state becomes this one; returns the one before.
  u32 plan(u32 state);
  // Where it goes once it has arrived, one after the other. One that the path has no way to stays
  // the next: it is asked for again.
  void keep(std::span<const DestinationPoint> further);

 private:
  using milliseconds = std::chrono::milliseconds;

  [[nodiscard]] Pose pose_at(TimeStamp time) const;
  [[nodiscard]] milliseconds period() const { return milliseconds(settings_.periodTime); }
  void take_path();
  PathFollower::Command decide();
  [[nodiscard]] Why missing() const;
  void mind_the_deviation();
  void mind_the_time();
  void mind_the_refusal();
  [[nodiscard]] PathReplanData where_it_is() const;

  Inputs inputs_;
  PathDriverSettings settings_;
  PathLook look_;
  std::optional<PathFollower> follower_;
  std::optional<ObstacleStop> stop_;
  Pose at_;
  Pose seen_from_;
  PathFollower::Command command_;
  Why missing_ = Why::kDrives;
  double safe_ = 0;  // mm/s
  bool seen_ = false;
  bool located_ = false;
  bool is_unsure_ = false;  // of where it is
  u32 state_ = pilot_state::kIdle;
  bool reached_ = false;  // the end of its path
  TimeStamp taken_ = 0;   // of its path
  std::vector<DestinationPoint> destinations_;
  bool awaits_next_ = false;  // the way to the first of them
  milliseconds refused_{0};   // so long ago
  milliseconds hold_left_{0};
  milliseconds blocked_{0};
};

}  // namespace rack::pilot
