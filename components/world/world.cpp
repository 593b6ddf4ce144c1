// World: the simulated world with the devices of its robots on their lines. Drivers communicate
// with the devices as with real ones; only the traffic on the lines moves the robots of this world.
// It publishes the truth and takes commands.
//
// One thread serves all lines and advances the world: at least once per step of the world, and
// whenever a device is due, so that a device measures the world of that moment. Commands take
// effect between two steps.
#include "rack/proxies/world.h"

#include <cmath>
#include <filesystem>
#include <mutex>
#include <optional>

#include <poll.h>

#include "base/text.h"
#include "components/position/map_picture.h"
#include "components/world/camera_library.h"
#include "components/world/core/world_file.h"
#include "components/world/plugged_device.h"
#include "components/world/senses.h"
#include "os/clock.h"
#include "os/file.h"
#include "rack/clock.h"
#include "rack/data_module.h"

namespace rack::device {
namespace {

using world::SensorId;
using world::Truth;

constexpr std::string_view kBase = "base";  // name of the robot's own line, next to its sensors

constexpr std::size_t kWorldBytesMax = 4 << 20;

constexpr std::array<ParameterInfo, 3> kParameters = {{
    host_file({"file", "", "file of the world (TOML)"}),
    {"period", 50, "period of the published truth [ms]", 5, 60000},
    {"seed", 0, "seed of noise, slip and people; 0: the seed in the file", 0, 2e9},
}};

constexpr ModuleInfo kInfo{
    .program = "World",
    .purpose = "A simulated world: the devices of its robots on their lines, and the truth.",
    .class_id = kWorld,
    .parameters = kParameters,
};

// --- the devices of a robot

struct SensorOfRobot {
  SensorId id;
  std::string name;  // "laser", and "laser-axis" for its axis
  bool is_axis = false;
  PluggedDevice device;
};

struct Robot {
  std::optional<PluggedDevice> base{};
  std::vector<SensorOfRobot> sensors{};
};

// --- the truth as a message

WorldThing thing_of(i32 kind, std::size_t id, const MapPoint& at, double rho) {
  WorldThing thing{.kind = kind, .id = static_cast<i32>(id)};
  thing.pos = {.x = whole_millimetres(at.x),
               .y = whole_millimetres(at.y),
               .rho = static_cast<float>(heading(rho))};
  return thing;
}

WorldThing thing_of(std::size_t id, const world::RobotTruth& robot, const std::string& name) {
  WorldThing thing =
      thing_of(world_thing::kRobot, id, {.x = robot.pose.x, .y = robot.pose.y}, robot.pose.rho);
  (void)thing.name.assign(name);
  thing.vx = whole_millimetres(robot.vx);
  thing.vy = whole_millimetres(robot.vy);
  thing.omega = static_cast<float>(robot.omega);
  thing.travelled = whole_millimetres(robot.travelled);
  thing.isBlocked = robot.is_blocked ? 1 : 0;
  thing.walls = static_cast<u32>(robot.contacts.walls);
  thing.obstacles = static_cast<u32>(robot.contacts.obstacles);
  thing.people = static_cast<u32>(robot.contacts.people);
  thing.robots = static_cast<u32>(robot.contacts.robots);
  thing.bumped = static_cast<u32>(robot.contacts.bumped);
  return thing;
}

void fill(WorldData& data, const Truth& truth, const world::WorldDescription& description) {
  data.peopleMove = truth.people_frozen ? 0 : 1;
  data.things.clear();
  constexpr std::size_t kMost = decltype(WorldData::things)::kMax;
  for (std::size_t i = 0; i < truth.robots.size() && data.things.size() < kMost; ++i)
    data.things.push_back(thing_of(i, truth.robots[i], description.robots[i].name));
  for (const world::PersonTruth& person : truth.people) {
    if (data.things.size() == kMost) return;
    data.things.push_back(thing_of(world_thing::kPerson, person.id, person.at, person.rho));
    data.things.back().vx = whole_millimetres(person.vx);
    data.things.back().vy = whole_millimetres(person.vy);
  }
  for (const world::PutObstacle& put : truth.obstacles) {
    if (data.things.size() == kMost) return;
    data.things.push_back(
        thing_of(world_thing::kObstacle, put.id, put.obstacle.at, put.obstacle.rho));
    data.things.back().radius = whole_millimetres(put.obstacle.radius);
  }
}

// ---

class World : public DataModule<WorldData> {
 public:
  World() : DataModule(kInfo, {.history = 100}) {}

 private:
  Result<void> module_on() override {
    auto description = read_description();
    if (!description) return description.error();
    if (auto made = make(std::move(*description)); !made) return made;
    set_period(std::chrono::milliseconds(integer("period")));
    return DataModule::module_on();
  }

  void module_off() override {
    {
      const std::lock_guard lock(world_mutex_);
      is_made_ = false;
    }
    trains_.clear();
    robots_.clear();
    world_.reset();
  }

  Result<void> module_loop() override {
    const tims::Time due = next_truth();
    while (tims::os::now() < due) {
      wait(due);
      const std::lock_guard lock(world_mutex_);
      serve();
    }
    WorldData& data = get_local_buffer();
    {
      const std::lock_guard lock(world_mutex_);
      go_on(*world_, trains_, tims::os::now(), truth_);
      data.recordingTime = time_stamp();
      fill(data, truth_, world_->description());
    }
    return put_local_buffer();
  }

  // --- construction

  // Drawings without a path are in the folder of the world's file.
  Result<world::WorldDescription> read_description() {
    const std::filesystem::path path = text("file");
    if (path.empty()) return refused("no world: give its file with --file");
    auto content = tims::os::read_file(path, kWorldBytesMax);
    if (!content) return content.error();
    auto file = world::read_world(
        {path.string(), std::move(*content)},
        [&](const std::string& name) {
          return tims::os::read_file(path.parent_path() / name, localisation::kMapBytesMax);
        },
        navigation::read_map_picture);
    for (std::size_t i = 0; i + 1 < file.problems.size(); ++i)
      log().error("{}", file.problems[i].to_string());
    if (!file.problems.empty()) return refused(file.problems.back().to_string());
    for (const std::string& remark : file.remarks) log().warning("plan {}", remark);
    for (const auto& hint : file.hints) log().warning("{}", hint.to_string());
    if (integer("seed") != 0) file.description.seed = static_cast<std::uint64_t>(integer("seed"));
    return std::move(file.description);
  }

  // Commands do not wait for the world: they find none until it is complete.
  Result<void> make(world::WorldDescription description) {
    auto made = world::World::make(std::move(description), tims::os::now());
    if (!made) return made.error();
    world_.emplace(std::move(*made));
    truth_ = world_->make_truth();
    if (auto robots = make_robots(); !robots) return robots;
    const std::lock_guard lock(world_mutex_);
    is_made_ = true;
    return {};
  }

  Result<void> make_robots() {
    const Duration utc_of_zero =
        tims::os::wall_now().time_since_epoch() - tims::os::now().time_since_epoch();
    const auto& robots = world_->description().robots;
    robots_.clear();
    trains_.clear();
    robots_.resize(robots.size());
    std::size_t lines = 0;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      if (auto made = make_base(i); !made) return made;
      const auto& sensors = robots[i].sensors;
      for (std::size_t k = 0; k < sensors.size(); ++k)
        if (auto made = make_sensor({i, k}, utc_of_zero); !made) return made;
      for (std::size_t k = 0; k < sensors.size(); ++k)
        if (auto made = make_axis({i, k}); !made) return made;
      lines += robots_[i].sensors.size() + 1;
    }
    polled_.reserve(lines);
    return {};
  }

  Result<void> make_base(std::size_t number) {
    const world::RobotDescription& robot = world_->description().robots[number];
    if (robot.device.empty()) return {};
    const EmulatorInfo* const info = find_emulator(robot.device);
    if (info == nullptr || info->senses != Senses::kWheels)
      return refused(robot.name + ": \"" + robot.device +
                     "\" is not a base; rack-emulate --list shows all devices");
    auto emulator = info->make({});
    auto& wheelwork = dynamic_cast<emulator::Wheelwork&>(*emulator);
    auto drivetrain = Drivetrain::make(*world_, number, wheelwork);
    if (!drivetrain)
      return tims::Error(drivetrain.error().code(),
                         robot.name + ": " + drivetrain.error().detail());
    trains_.push_back(*drivetrain);
    auto device =
        plugged(robot.name + "/" + std::string(kBase), *info, robot.line, std::move(emulator));
    if (!device) return device.error();
    robots_[number].base.emplace(std::move(*device));
    return {};
  }

  Result<void> make_sensor(const SensorId& id, Duration utc_of_zero) {
    const world::RobotDescription& robot = world_->description().robots[id.robot];
    const world::SensorDescription& sensor = robot.sensors[id.sensor];
    if (sensor.device.empty()) return {};
    const std::string name = robot.name + "/" + sensor.name;
    const EmulatorInfo* const info = find_emulator(sensor.device);
    if (info == nullptr || info->senses != senses_of(sensor.kind))
      return refused(
          name + ": \"" + sensor.device +
          "\" is not a device for this kind of sensor; rack-emulate --list shows all devices");
    Scene scene = scene_of(*world_, id, utc_of_zero);
    if (sensor.kind == world::SensorKind::kCamera) {
      auto pictures = pictures_of(*world_, id);
      // The world is complete without it, as in a build without OpenCV.
      if (!pictures) {
        log().warning("{} is left out: {}", name, pictures.error().detail());
        return {};
      }
      scene.pictures = std::move(*pictures);
    }
    auto device = plugged(name, *info, sensor.line, info->make(scene));
    if (!device) return device.error();
    robots_[id.robot].sensors.push_back({id, sensor.name, false, std::move(*device)});
    return {};
  }

  // The drive of a sensor's axis.
  Result<void> make_axis(const SensorId& id) {
    const world::RobotDescription& robot = world_->description().robots[id.robot];
    const world::SensorDescription& sensor = robot.sensors[id.sensor];
    if (sensor.axis.device.empty()) return {};
    const std::string own = sensor.name + "-axis";
    const std::string name = robot.name + "/" + own;
    const EmulatorInfo* const info = find_emulator(sensor.axis.device);
    if (info == nullptr || info->senses != Senses::kWheels)
      return refused(name + ": \"" + sensor.axis.device +
                     "\" is not a drive; rack-emulate --list shows all devices");
    auto emulator = info->make({});
    auto train = Drivetrain::make(*world_, id, dynamic_cast<emulator::Wheelwork&>(*emulator));
    if (!train) return tims::Error(train.error().code(), name + ": " + train.error().detail());
    auto device = plugged(name, *info, sensor.axis.line, std::move(emulator));
    if (!device) return device.error();
    trains_.push_back(*train);
    robots_[id.robot].sensors.push_back({id, own, true, std::move(*device)});
    return {};
  }

  // Connects an emulator to its line. "{system}" in the line is the system of this component, so
  // that several worlds can run in parallel.
  Result<PluggedDevice> plugged(const std::string& name, const EmulatorInfo& info,
                                const std::string& line, std::unique_ptr<Dialogue> emulator) const {
    const auto system = address().fields(address_widths()).system;
    const std::string place = tims::base::filled_in(line.empty() ? info.address : line,
                                                    {{"system", std::to_string(system)}});
    auto parsed = DeviceAddress::parse(place);
    if (!parsed) return tims::Error(parsed.error().code(), name + ": " + parsed.error().detail());
    PluggedDevice device(name, std::move(*parsed), info.baud, std::move(emulator));
    if (auto opened = device.plug(); !opened)
      return tims::Error(opened.error().code(), name + ": " + opened.error().detail());
    return device;
  }

  // --- advancing

  template <typename Each>
  void for_each_device(const Each& each) {
    for (Robot& robot : robots_) {
      if (robot.base) each(*robot.base);
      for (SensorOfRobot& sensor : robot.sensors) each(sensor.device);
    }
  }

  tims::Time next_truth() {
    const tims::Time now = tims::os::now();
    if (next_truth_ + period() <= now) next_truth_ = now;
    return next_truth_ += period();
  }

  // Waits until a device is due or has received bytes, or the world must advance.
  void wait(tims::Time until) {
    {
      const std::lock_guard lock(world_mutex_);
      polled_.clear();
      until = std::min(until, world_->now() + world::kStep);
      for_each_device([&](const PluggedDevice& device) {
        until = std::min(until, device.next_timeout());
        if (device.descriptor() >= 0)
          polled_.push_back({.fd = device.descriptor(), .events = POLLIN, .revents = 0});
      });
    }
    const auto rest = std::max(Duration(0), until - tims::os::now());
    const auto patience = tims::os::to_timespec(tims::Time(rest));
    ::ppoll(polled_.data(), polled_.size(), &patience, nullptr);
  }

  void serve() {
    const tims::Time now = tims::os::now();
    go_on(*world_, trains_, now, truth_);
    for_each_device([&](PluggedDevice& device) {
      if (const auto problem = device.serve(now)) log().warning("{}; opening it again", *problem);
    });
  }

  // --- commands

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case WorldType::kPlace:
        return answered(message, with<WorldPlace>(message, [&](const WorldPlace& command) {
                          return place(command);
                        }));
      case WorldType::kPut:
        return with<WorldObstacle>(
            message, [&](const WorldObstacle& command) { return put(message, command); });
      case WorldType::kRemove:
        return answered(message, with<WorldRemove>(message, [&](const WorldRemove& command) {
                          return remove(command);
                        }));
      case WorldType::kPeople:
        return answered(message,
                        with<WorldPeople>(message, [&](const WorldPeople& command) -> Result<void> {
                          world_->freeze_people(command.move == 0);
                          return {};
                        }));
      case WorldType::kPlug:
        return answered(message, with<WorldPlug>(message, [&](const WorldPlug& command) {
                          return plug(command);
                        }));
      case WorldType::kGetLines:
        return report_lines(message);
      default:
        return DataModule::module_command(message);
    }
  }

  // Decodes a command and executes it while there is a world.
  template <Struct Command, typename Do>
  Result<void> with(const tims::MessageView& message, const Do& act) {
    const auto command = decode<Command>(message);
    if (!command) return command.error();
    const std::lock_guard lock(world_mutex_);
    if (!is_made_) return refused("the world is off; turn it on first");
    return act(*command);
  }

  Result<std::size_t> robot_called(std::string_view name) const {
    if (const auto found = world_->find_robot(name)) return *found;
    std::string names;
    for (const auto& robot : world_->description().robots) names += " " + robot.name;
    return refused("no robot \"" + std::string(name) + "\"; there are:" + names);
  }

  Result<void> place(const WorldPlace& command) {
    const auto robot = robot_called(command.robot.view());
    if (!robot) return robot.error();
    const auto rho = static_cast<double>(command.pos.rho.raw());
    if (!std::isfinite(rho)) return refused("rho is not a number");
    return world_->place(*robot, {.x = static_cast<double>(command.pos.x.raw()),
                                  .y = static_cast<double>(command.pos.y.raw()),
                                  .rho = rho});
  }

  Result<void> put(const tims::MessageView& message, const WorldObstacle& command) {
    if (command.radius.raw() <= 0 || command.height.raw() <= 0)
      return refused("the radius and the height of an obstacle must be at least 1 mm");
    const auto id = world_->put({.shape = world::Shape::kCircle,
                                 .at = {.x = static_cast<double>(command.pos.x.raw()),
                                        .y = static_cast<double>(command.pos.y.raw())},
                                 .radius = static_cast<double>(command.radius.raw()),
                                 .height = static_cast<double>(command.height.raw())});
    if (!id) return id.error();
    WorldObstacle there = command;
    there.id = static_cast<i32>(*id);
    reply(message.header, WorldType::kObstacle, there);
    return {};
  }

  Result<void> remove(const WorldRemove& command) {
    if (command.id < 0 || !world_->remove(static_cast<std::size_t>(command.id)))
      return refused("no obstacle " + std::to_string(command.id) + " was placed in this world");
    return {};
  }

  Result<void> plug(const WorldPlug& command) {
    const auto robot = robot_called(command.robot.view());
    if (!robot) return robot.error();
    if (command.sensor.view() == kBase && robots_[*robot].base)
      return plug(*robots_[*robot].base, command.isPlugged != 0);
    std::string names = robots_[*robot].base ? " base" : "";
    for (SensorOfRobot& sensor : robots_[*robot].sensors) {
      names += " " + sensor.name;
      if (sensor.name != command.sensor.view()) continue;
      if (!sensor.is_axis) world_->plug(sensor.id, command.isPlugged != 0);
      return plug(sensor.device, command.isPlugged != 0);
    }
    return refused("no device \"" + std::string(command.sensor.view()) + "\"; there are:" + names);
  }
  static Result<void> plug(PluggedDevice& device, bool is_plugged) {
    if (is_plugged) return device.plug();
    device.pull();
    return {};
  }

  Result<void> report_lines(const tims::MessageView& message) {
    const std::lock_guard lock(world_mutex_);
    if (!is_made_) return refused("the world is off; turn it on first");
    WorldLines all;
    for (std::size_t i = 0; i < robots_.size(); ++i) {
      const world::RobotDescription& robot = world_->description().robots[i];
      const auto add = [&](std::string_view sensor, const std::string& device,
                           const PluggedDevice& plugged) {
        if (all.lines.size() == decltype(WorldLines::lines)::kMax) return;
        WorldLine line{.isPlugged = plugged.is_plugged() ? 1 : 0};
        (void)line.robot.assign(robot.name);
        (void)line.sensor.assign(sensor);
        (void)line.device.assign(device);
        (void)line.line.assign(plugged.address().to_string());
        all.lines.push_back(line);
      };
      if (robots_[i].base) add(kBase, robot.device, *robots_[i].base);
      for (const SensorOfRobot& sensor : robots_[i].sensors) {
        const world::SensorDescription& its = robot.sensors[sensor.id.sensor];
        add(sensor.name, sensor.is_axis ? its.axis.device : its.device, sensor.device);
      }
    }
    reply(message.header, WorldType::kLines, all);
    return {};
  }

  PriorityMutex world_mutex_;  // protects the members below while is_made_, else the data task's
  bool is_made_ = false;       // protected always
  std::optional<world::World> world_;
  std::vector<Robot> robots_;
  std::vector<Drivetrain> trains_;
  Truth truth_;
  std::vector<pollfd> polled_;  // used by the data task
  tims::Time next_truth_{};
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::World component;
  return component.run(argc, argv);
}
