// Conclusions of `timsctl nav` from the data of components. Pure.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "rack/proxies/chassis.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/scan2d.h"
#include "tims/time.h"

namespace timsctl {

// --- where: findings and remedies

struct Samples {
  std::size_t count = 0;
  double spread_m = 0;  // standard deviation, of x and y together
};
Samples samples_of(const rack::MclData& data);

struct WhereFacts {
  std::string position{};  // address in the form of timsctl: "Position/1/0"
  std::string position_state{};
  std::string mcl{};  // empty: there is no localisation
  std::string mcl_state{};
  bool mcl_has_map = false;
  bool mcl_sends_pose = false;  // it sends its pose to the position component
  bool has_gps = false;
  std::optional<Samples> samples{};
  std::optional<double> apart_m{};  // distance between both poses at the same time
  std::optional<double> age_s{};
};

struct MissingPart {
  std::string what;
  std::string next;  // what to do
};
std::vector<MissingPart> missing(const WhereFacts& facts);

// --- goto: the state of a drive

enum class DriveState : std::uint8_t {
  kPlanning,  // also before the first status
  kDriving,
  kTurning,     // at rest
  kStanding,    // an obstacle is ahead, or the pilot is stopped
  kMakesRoom,   // drives aside, since somebody blocks its path
  kWaitsAside,  // until its path is clear
  kSilent,      // its pilot sends no new status
  kArrived,
  kNoPath,   // there is no plan
  kAstray,   // the robot has left the corridor
  kDropped,  // the pilot no longer has a destination
  kBlocked,  // no progress for longer than `patience`
};
std::string_view name(DriveState state);
constexpr bool is_end(DriveState state) { return state >= DriveState::kArrived; }

class DriveWatch {
 public:
  // `before`: the time of the status after the pilot accepted the destination; older ones are
  // ignored.
  DriveWatch(rack::TimeStamp before, tims::Time now, tims::Duration patience)
      : newest_(before), changed_(now), moved_(now), patience_(patience) {}

  // `ahead`: the path of the pilot from where the robot is.
  DriveState take(const rack::PilotStatusData& status, tims::Time now,
                  std::span<const rack::PolarSpline> ahead = {});

 private:
  DriveState judge(const rack::PilotStatusData& status, tims::Time now,
                   std::span<const rack::PolarSpline> ahead);

  rack::TimeStamp newest_;
  tims::Time changed_;  // arrival of the newest status
  tims::Time moved_;    // when it last drove
  tims::Duration patience_;
  std::optional<tims::Time> idle_since_;
  double heading_ = 0;  // rad, in the newest status
  bool turned_ = false;
  bool fresh_ = false;
  bool drove_ = false;
};

// The obstacle that a standing robot most likely waits for: what is in the lane ahead, unless
// something else is much nearer to its hull. "an obstacle is 0.31 m ahead". Empty: nothing is
// within kNearby.
std::string obstacle_text(const rack::Scan2dData& scan, const rack::ChassisParamData& hull);
inline constexpr double kNearby = 1;  // m, from the hull

// --- path

struct PathSummary {
  double length_m = 0;
  double seconds = 0;  // at the planned speeds
};
PathSummary summary_of(std::span<const rack::PolarSpline> splines);

}  // namespace timsctl
