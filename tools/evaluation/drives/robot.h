// The programs of an indoor robot on a virtual clock: the pure cores of the components, with the
// mailboxes, periods, timeouts and restarts of the programs around them. Pure.
//
// The robot is that of deploy/robots/emulated.toml: a differential drive with encoders, a laser
// scanner, OdometryChassis, Position, MonteCarloLocalisation, PathRDDF and PilotPath. Each program
// runs when the machine lets it; a request to one that does not run fails, as after its timeout.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "components/localisation/localiser.h"
#include "components/localisation/position_updates.h"
#include "components/localisation/wall_lines.h"
#include "components/path/route_planner.h"
#include "components/pilot/path_driver.h"
#include "components/position/reckoning.h"
#include "components/world/core/world.h"
#include "tools/evaluation/drives/machine.h"
#include "tools/evaluation/drives/mailbox.h"

namespace rack::drives {

struct RobotSettings {
  ChassisParamData chassis{};
  std::size_t robot = 0;  // in the world
  world::SensorId scanner{};
  i32 speed_max = 500;      // mm/s, of the pilot
  i32 replan_time = 8000;   // ms
  i32 deviation_max = 500;  // mm, of the pilot; 0: any
  i32 range_max = 8000;     // mm
  localisation::FilterSettings filter{};
  bool starts_anywhere = false;  // the localiser knows nothing about the start
  std::uint64_t seed = 1;
};

class Robot {
 public:
  // `field`, `walls`, `space`: the map; they must outlive the robot.
  Robot(world::World& world, const RobotSettings& settings,
        const localisation::LikelihoodField& field, const localisation::WallLines& walls,
        const path::FreeSpace& space, const Load& load);

  static constexpr tims::Duration kStep = world::kStep;

  // Runs everything for a step. The world is advanced with it.
  void step();
  [[nodiscard]] tims::Time now() const { return now_; }
  // The time that a time stamp of the robot's data stands for.
  [[nodiscard]] tims::Time time_of(TimeStamp stamp) const;

  // As by SET_DESTINATION of the pilot. The reason of a refusal.
  tims::Result<void> send(const Pose& goal);
  [[nodiscard]] PilotStatusData pilot() const { return driver_.status(); }
  [[nodiscard]] std::string why() const { return driver_.why_text(); }
  [[nodiscard]] const std::optional<PositionData>& position() const { return newest_position_; }
  // As `timsctl nav goto` requires of a robot.
  [[nodiscard]] bool is_localised() const;
  [[nodiscard]] std::span<const std::string> log() const { return log_; }

 private:
  template <typename Data>
  class History;

  [[nodiscard]] TimeStamp stamp() const;
  void note(std::string_view text);
  void begin_mcl(const Pose& at, double deviation);
  bool restart_mcl(TimeStamp time, const Pose& odometry);
  void begin_path();
  void begin_pilot();
  void restart_crashed();

  void measure_movement();
  void measure_scan();
  void run_chassis();
  void run_scan2d();
  void run_odometry();
  void run_position();
  void run_mcl();
  void run_path();
  void run_pilot();
  void command(const ChassisMoveData& move);
  [[nodiscard]] std::optional<OdometryData> odometry_at(TimeStamp time) const;
  [[nodiscard]] std::optional<PositionData> position_at(TimeStamp time) const;

  world::World& world_;
  RobotSettings settings_;
  const localisation::LikelihoodField& field_;
  const localisation::WallLines& walls_;
  const path::FreeSpace& space_;
  Machine machine_;
  tims::Time now_;
  tims::Time begin_;
  std::vector<std::string> log_;

  // The devices.
  tims::Time next_movement_;
  tims::Time next_scan_;
  std::vector<double> rims_;
  tims::Time commanded_{};  // the last MOVE
  Mailbox<ChassisData> encoders_{1000};
  Mailbox<std::pair<tims::Time, Scan2dData>> turns_{1000};

  // Messages.
  Mailbox<ChassisData> odometry_in_;
  Mailbox<OdometryData> position_in_;
  Mailbox<Scan2dData> mcl_in_;
  bool mcl_starts_ = false;  // with the next scan
  Mailbox<PositionData> path_position_in_{10};
  Mailbox<Scan2dData> path_scan_in_{2};
  Mailbox<ChassisData> pilot_chassis_in_{10};
  Mailbox<PositionData> pilot_position_in_{10};
  Mailbox<PathData> pilot_path_in_{2};
  Mailbox<Scan2dData> pilot_scan_in_{2};
  Mailbox<PathReplanData> replans_{2};

  // The programs.
  std::optional<navigation::DeadReckoning> reckoning_;
  tims::Time last_movement_{};  // when OdometryChassis got one
  std::map<u32, OdometryData> odometry_;
  navigation::PositionTracker tracker_{{}, {}};
  bool tracks_ = false;
  std::map<u32, PositionData> positions_;
  std::optional<PositionData> newest_position_;
  std::optional<localisation::Localiser> localiser_;
  localisation::PositionUpdates updates_;
  std::vector<localisation::BeamEnd> beams_;
  Pose mcl_odometry_;
  tims::Time published_{};
  path::RoutePlanner planner_;
  bool makes_room_ = false;
  PathData path_;
  tims::Time next_path_{};
  pilot::PathDriver driver_;
  pilot::PathCycle cycle_;
  tims::Time next_pilot_{};
  bool has_goal_ = false;
};

}  // namespace rack::drives
