#include "tools/evaluation/drives/drive.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "components/localisation/grid_map.h"
#include "components/localisation/likelihood_field.h"
#include "components/path/grid_search.h"
#include "components/path/vehicle.h"
#include "tools/evaluation/drives/robot.h"

namespace rack::drives {
namespace {

constexpr double kCell = 50;         // mm, of the maps
constexpr double kNear = 1000;       // mm, of people that a contact is noted with
constexpr double kAround = 2000;     // mm, of the plan's margin
constexpr double kRoomAtGoal = 550;  // mm, clearance of starts and goals
constexpr double kShortest = 2000;   // mm, from start to goal
constexpr double kCertain = 200;     // mm
constexpr double kWrong = 500;       // mm
constexpr double kTurned = radians(10.0);
constexpr double kArrivedWithin = 300;  // mm
constexpr auto kRecordEvery = std::chrono::milliseconds(100);
constexpr auto kStands = std::chrono::seconds(45);   // then the drive has failed
constexpr auto kUnknown = std::chrono::seconds(60);  // a robot that is not sure gets no goal
constexpr auto kSettles = std::chrono::seconds(3);   // before the goal is sent

// The chassis of deploy/robots/emulated.toml.
ChassisParamData chassis_of(const world::RobotDescription& robot) {
  ChassisParamData chassis;
  chassis.vxMax = 1000;
  chassis.vxMin = 10;
  chassis.accMax = chassis.decMax = 800;
  chassis.omegaMax = static_cast<f32>(radians(50.0));
  chassis.minTurningRadius = 10;
  chassis.breakConstant = 1;
  chassis.safetyMargin = 150;
  chassis.safetyMarginMove = 100;
  chassis.boundaryFront = whole_millimetres(robot.front);
  chassis.boundaryBack = whole_millimetres(robot.back);
  chassis.boundaryLeft = whole_millimetres(robot.left);
  chassis.boundaryRight = whole_millimetres(robot.right);
  chassis.wheelBase = 400;
  chassis.trackWidth = 400;
  chassis.pilotParameterA = 0.0008F;
  chassis.pilotParameterB = 1.5F;
  chassis.pilotVTransMax = 300;
  return chassis;
}

std::optional<world::SensorId> scanner_of(const world::RobotDescription& robot) {
  for (std::size_t i = 0; i < robot.sensors.size(); ++i)
    if (robot.sensors[i].kind == world::SensorKind::kScanner) return world::SensorId{0, i};
  return std::nullopt;
}

}  // namespace

bool DriveResult::was_certain_of_a_wrong_place() const {
  return wrong_while_certain > kWrong || turned_while_certain > kTurned;
}

bool DriveResult::holds() const {
  if (contacts > 0 || was_certain_of_a_wrong_place()) return false;
  return outcome != Outcome::kArrived || off_goal < kArrivedWithin;
}

struct Course::Parts {
  Parts(Scene of, localisation::LikelihoodField likelihood)
      : scene(std::move(of)), field(std::move(likelihood)) {}

  Scene scene;
  world::SensorId scanner{};
  ChassisParamData chassis{};
  localisation::GridMap map{};
  localisation::LikelihoodField field;
  localisation::WallLines walls{};
  path::FreeSpace space{};
  std::vector<path::Place> places{};  // for goals: with room, reachable
};

Course::Course(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Course::Course(Course&&) noexcept = default;
Course::~Course() = default;

tims::Result<Course> Course::make(Scene scene) {
  if (scene.world.robots.empty() || !scanner_of(scene.world.robots[0]))
    return tims::Error(tims::Errc::kInvalidArgument, scene.name + ": no robot with a scanner");
  auto map = localisation::cells_of(scene.plan, kCell);
  if (!map) return map.error();
  auto field = localisation::LikelihoodField::of(*map, {});
  if (!field) return field.error();
  auto space = path::FreeSpace::of(scene.plan, kCell, kAround);
  if (!space) return space.error();
  auto parts = std::make_unique<Parts>(std::move(scene), std::move(*field));
  const world::RobotDescription& robot = parts->scene.world.robots[0];
  parts->scanner = *scanner_of(robot);
  parts->chassis = chassis_of(robot);
  parts->walls = localisation::WallLines(*map);
  parts->map = std::move(*map);
  parts->space = std::move(*space);

  path::GridSearch reached;
  reached.run(parts->space, {.room = kRoomAtGoal}, {robot.start.x, robot.start.y}, nullptr);
  for (std::size_t row = 0; row < parts->space.rows(); ++row) {
    for (std::size_t column = 0; column < parts->space.columns(); ++column) {
      const path::Place place = parts->space.center_of(row, column);
      const bool has_obstacle = std::ranges::any_of(
          parts->scene.world.obstacles, [&](const world::ObstacleDescription& obstacle) {
            return std::hypot(place.x - obstacle.at.x, place.y - obstacle.at.y) < 1000;
          });
      if (parts->space.clearance(place) >= kRoomAtGoal && std::isfinite(reached.cost(place)) &&
          !has_obstacle &&
          std::hypot(place.x - robot.start.x, place.y - robot.start.y) >= kShortest)
        parts->places.push_back(place);
    }
  }
  if (parts->places.empty())
    return tims::Error(tims::Errc::kInvalidArgument, parts->scene.name + ": no room to drive");
  return Course(std::move(parts));
}

namespace {

// Looks at a robot from outside.
class Judge {
 public:
  Judge(const world::World& world, const Robot& robot, DriveResult& result, bool records)
      : world_(world),
        robot_(robot),
        result_(result),
        records_(records),
        truth_(world.make_truth()) {}

  void look() {
    world_.truth(truth_);
    const Pose is = truth_.robots[0].pose;
    note_contacts();
    moved_ = std::abs(truth_.robots[0].vx) > 1 || std::abs(truth_.robots[0].omega) > 0.01;
    const auto& position = robot_.position();
    if (!position) return;
    const Pose believed = Pose::of(position->pos);
    const tims::Time then = robot_.time_of(position->recordingTime);
    const bool is_known = robot_.now() - then < world::kRemembered;
    if (is_known && std::max(position->var.x.raw(), position->var.y.raw()) < kCertain) {
      const Pose was = world_.pose(0, then);
      const double wrong = std::hypot(was.x - believed.x, was.y - believed.y);
      const double turned = std::abs(signed_angle(was.rho - believed.rho));
      result_.wrong_while_certain = std::max(result_.wrong_while_certain, wrong);
      result_.turned_while_certain = std::max(result_.turned_while_certain, turned);
    }
    result_.off_goal = std::hypot(is.x - result_.goal.x, is.y - result_.goal.y);
    if (records_) record(is, believed, *position);
  }
  [[nodiscard]] bool moved() const { return moved_; }
  // Where they are now.
  void draw_people() {
    for (const world::PersonTruth& person : truth_.people)
      result_.picture.marks.push_back(
          {.name = "person",
           .at = {.x = person.at.x, .y = person.at.y, .rho = person.rho},
           .role = plot::Role::kOther});
  }

 private:
  void note_contacts() {
    const world::RobotTruth& robot = truth_.robots[0];
    const std::uint64_t before = std::exchange(result_.contacts, robot.contacts.own());
    const std::uint64_t bumped = std::exchange(bumped_, robot.contacts.bumped);
    if (result_.contacts == before && bumped_ == bumped) return;
    std::string text =
        fmt::format("{:7.2f} s  {} at {:.0f} mm/s, {:.0f} deg/s",
                    std::chrono::duration<double>(robot_.now().time_since_epoch()).count(),
                    result_.contacts == before ? "somebody walked into it" : "contact", robot.vx,
                    degrees(robot.omega));
    for (const world::PersonTruth& person : truth_.people) {
      const Pose there = Pose{.x = person.at.x, .y = person.at.y} - robot.pose;
      if (std::hypot(there.x, there.y) < kNear)
        text += fmt::format("; person {} {:.0f} mm ahead, {:.0f} to the right", person.id, there.x,
                            there.y);
    }
    result_.log.push_back(std::move(text));
  }

  void record(const Pose& is, const Pose& believed, const PositionData& position) {
    auto& lines = result_.picture.trajectories;
    if (lines.empty()) {
      lines.push_back({.name = "truth", .role = plot::Role::kTruth});
      lines.push_back({.name = "position", .role = plot::Role::kEstimate});
      result_.picture.series.push_back({.name = "deviation", .unit = "m"});
    }
    const double seconds = std::chrono::duration<double>(robot_.now().time_since_epoch()).count();
    lines[0].times.push_back(seconds);
    lines[0].points.push_back({is.x, is.y});
    lines[1].times.push_back(seconds);
    lines[1].points.push_back({believed.x, believed.y});
    result_.picture.series[0].times.push_back(seconds);
    result_.picture.series[0].values.push_back(
        std::max(position.var.x.raw(), position.var.y.raw()) / 1000.0);
  }

  const world::World& world_;
  const Robot& robot_;
  DriveResult& result_;
  bool records_;
  world::Truth truth_;
  bool moved_ = false;
  std::uint64_t bumped_ = 0;
};

}  // namespace

Pose Course::draw_goal(Random& random) const {
  const auto at = random.below(static_cast<std::uint32_t>(parts_->places.size()));
  const path::Place& place = parts_->places[at];
  return {.x = place.x, .y = place.y, .rho = 2 * kPi * static_cast<double>(random.uniform())};
}

DriveResult Course::drive(const DriveSettings& settings) const {
  Random random(settings.seed);
  DriveResult result;
  world::WorldDescription description = parts_->scene.world;
  description.seed = random.bits();
  if (settings.starts_anywhere) description.robots[0].start = draw_goal(random);
  result.start = description.robots[0].start;
  result.goal = draw_goal(random);

  auto world = world::World::make(std::move(description), tims::Time{});
  if (!world) {
    result.why = world.error().detail();
    return result;
  }
  Robot robot(*world,
              {.chassis = parts_->chassis,
               .scanner = parts_->scanner,
               .starts_anywhere = settings.starts_anywhere,
               .seed = random.bits()},
              parts_->field, parts_->walls, parts_->space, settings.load);
  Judge judge(*world, robot, result, settings.records);
  tims::Time next_look{};
  tims::Time moved{};
  bool is_sent = false;
  const auto has_ended = [&] {
    if (!is_sent) return false;
    const PilotStatusData pilot = robot.pilot();
    if (pilot.pilotState == pilot_state::kIdle && pilot.distanceToDest == 0) {
      result.outcome = Outcome::kArrived;
      return true;
    }
    return robot.now() - moved > kStands;
  };
  while (robot.now() - tims::Time{} < settings.longest && !has_ended()) {
    robot.step();
    if (!is_sent && robot.now() - tims::Time{} > kUnknown) {
      result.why = "the robot does not find where it is";
      break;
    }
    if (!is_sent && robot.now() - tims::Time{} > kSettles && robot.is_localised()) {
      const auto sent = robot.send(result.goal);
      if (!sent) {
        result.outcome = Outcome::kNoPath;
        result.why = sent.error().detail();
        break;
      }
      is_sent = true;
      moved = robot.now();
    }
    if (robot.now() < next_look) continue;
    next_look = robot.now() + kRecordEvery;
    judge.look();
    if (judge.moved()) moved = robot.now();
  }
  result.seconds = std::chrono::duration<double>(robot.now() - tims::Time{}).count();
  if (result.why.empty()) result.why = robot.why();
  result.log.insert(result.log.end(), robot.log().begin(), robot.log().end());
  std::ranges::stable_sort(result.log);  // each line begins with its time
  if (settings.records) {
    result.picture.map = parts_->map;
    result.picture.marks.push_back({.name = "goal", .at = result.goal, .role = plot::Role::kPath});
    judge.draw_people();
    result.picture.title = parts_->scene.name + ", seed " + std::to_string(settings.seed);
  }
  return result;
}

}  // namespace rack::drives
