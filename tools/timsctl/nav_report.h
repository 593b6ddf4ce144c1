// What `timsctl nav` concludes from what components say. Pure.
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

// --- where: what is missing, and what to do about it

struct Samples {
  std::size_t count = 0;
  double spread_m = 0;  // standard deviation, of x and y together
};
Samples samples_of(const rack::MclData& data);

struct WhereFacts {
  std::string position{};  // as timsctl takes it: "Position/1/0"
  std::string position_state{};
  std::string mcl{};  // empty: there is none
  std::string mcl_state{};
  bool mcl_has_map = false;
  bool mcl_tells = false;  // the position where it is
  bool has_gps = false;
  std::optional<Samples> samples{};
  std::optional<double> apart_m{};  // what the two say at the same time
  std::optional<double> age_s{};
};

struct MissingPart {
  std::string what;
  std::string next;  // what to do
};
std::vector<MissingPart> missing(const WhereFacts& facts);

// --- goto: what has become of a drive

enum class DriveState : std::uint8_t {
  kPlanning,  // also: nothing is known yet
  kDriving,
  kTurning,   // at rest
  kStanding,  // something is in its way, or it holds
  kSilent,    // its pilot says nothing new
  kArrived,
  kNoWay,    // there is no plan
  kAstray,   // it has left the corridor
  kDropped,  // the pilot has no destination any more
  kBlocked,  // it got no further for longer than one has patience
};
std::string_view name(DriveState state);
constexpr bool is_end(DriveState state) { return state >= DriveState::kArrived; }

class DriveWatch {
 public:
  // `before`: of the pilot's status after it had taken the destination; older ones say nothing.
  DriveWatch(rack::TimeStamp before, tims::Time now, tims::Duration patience)
      : newest_(before), changed_(now), moved_(now), patience_(patience) {}

  DriveState take(const rack::PilotStatusData& status, tims::Time now);

 private:
  DriveState judge(const rack::PilotStatusData& status, tims::Time now);

  rack::TimeStamp newest_;
  tims::Time changed_;  // when the newest came
  tims::Time moved_;    // when it last drove
  tims::Duration patience_;
  std::optional<tims::Time> idle_since_;
  double heading_ = 0;  // rad, of the newest
  bool turned_ = false;
  bool fresh_ = false;
  bool drove_ = false;
};

// m from the front of the hull to the nearest point in the lane ahead; nothing: it is free.
std::optional<double> free_ahead(const rack::Scan2dData& scan, const rack::ChassisParamData& hull);

// --- path

struct PathSummary {
  double length_m = 0;
  double seconds = 0;  // at the planned speeds
};
PathSummary summary_of(std::span<const rack::PolarSpline> splines);

}  // namespace timsctl
