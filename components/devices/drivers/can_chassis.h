// Base of the drivers of vehicles with motors on a CAN bus: the bus and the assignment of motors to
// wheels.
#pragma once

#include <charconv>

#include "components/devices/chassis/motor_chassis.h"
#include "components/devices/drivers/chassis_driver.h"

namespace rack::device {

// steering: 0 differential, 1 front axle steered, 2 both axles steered.
constexpr std::array<ParameterInfo, 9> can_chassis_parameters(i32 steering) {
  return {{
      {"canDev", 0, "number N of the CAN interface canN", 0, 255},
      one_of("0 differential, 1 front axle steered, 2 both axles steered",
             {"steering", steering, "kind of steering", 0, 2}),
      {"nodes", "1,2,3,4,5,6",
       "nodes of the motors: left, right; or front left, front right, rear left, rear right; then "
       "front steering, rear steering; -3: node 3 is reversed"},
      {"gearRatio", 1.0F, "motor turns per turn of the wheel", 0.001, 10000},
      {"steerRatio", 1.0F, "motor turns per turn of the steering", 0.001, 10000},
      {"steerZero", 0.0F, "angle of the steering motor for straight ahead [deg]", -360000, 360000},
      {"steerMax", 30, "maximum steering angle to each side [deg]", 0, 90},
      {"vyMax", 0, "maximum sideways speed [mm/s], only with steering=2", 0, 1e6},
      {"periodTime", 50, "period of the data [ms]", 20, 1000},
  }};
}

class CanChassis : public ChassisDriver<MotorChassis> {
 public:
  using ChassisDriver::ChassisDriver;

 protected:
  // Creates the motor of a node.
  virtual Result<std::unique_ptr<Motor>> make_motor(std::uint8_t node, MotorTask task) const = 0;
  [[nodiscard]] virtual bool is_canopen() const = 0;
  [[nodiscard]] virtual std::uint8_t last_node() const = 0;

  Result<DeviceOptions> device() const override { return device_by("canDev", can_device, 0); }

  [[nodiscard]] ChassisParamData limits() const override {
    ChassisParamData limits = ChassisDriver::limits();
    limits.vyMax = integer("steering") == kBothAxles ? integer("vyMax") : 0;
    return limits;
  }

  Result<std::unique_ptr<MotorChassis>> make_dialogue() override {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    const auto nodes = read_nodes();
    if (!nodes) return nodes.error();
    const auto wheels = make_wheels(nodes->size());
    if (!wheels) return wheels.error();
    std::vector<MotorLink> links;
    for (std::size_t i = 0; i < nodes->size(); ++i) {
      auto link = make_link((*nodes)[i], wheels->is_steering(i));
      if (!link) return link.error();
      links.push_back(std::move(*link));
    }
    return std::make_unique<MotorChassis>(
        MotorChassisSettings{
            .period = period(), .is_canopen = is_canopen(), .only_listen = is_recording()},
        *wheels, std::move(links));
  }

 private:
  static constexpr i32 kDifferential = 0;
  static constexpr i32 kBothAxles = 2;

  // Reads a list such as "3,-4": node 4 turns in the opposite direction.
  Result<std::vector<int>> read_nodes() const {
    std::vector<int> nodes;
    const std::string list = text("nodes");
    for (std::size_t begin = 0; begin <= list.size();) {
      const std::size_t end = std::min(list.find(',', begin), list.size());
      int node = 0;
      const auto [last, error] = std::from_chars(list.data() + begin, list.data() + end, node);
      if (error != std::errc() || last != list.data() + end || std::abs(node) > last_node())
        return refused("nodes=" + list + ": \"" + list.substr(begin, end - begin) +
                       "\" is not a node; valid are 0 to " + std::to_string(last_node()));
      nodes.push_back(node);
      begin = end + 1;
    }
    // Drops the surplus: the default lists more nodes than most vehicles have motors.
    const std::size_t needed = integer("steering") == kDifferential ? 2
                               : integer("steering") == kBothAxles  ? 6
                                                                    : 3;
    if (nodes.size() > needed) nodes.resize(needed);
    return nodes;
  }

  Result<Wheels> make_wheels(std::size_t nodes) const {
    const auto track = static_cast<double>(integer("trackWidth"));
    const auto base = static_cast<double>(integer("wheelBase"));
    const double most = integer("steerMax") * std::numbers::pi / 180;
    const i32 steering = integer("steering");
    if (steering == kDifferential && nodes == 2) return Wheels::differential(track);
    if (steering == kBothAxles && nodes == 6) return Wheels::double_ackermann(base, track, most);
    if (steering == 1 && (nodes == 2 || nodes == 3))
      return Wheels::ackermann(base, track, nodes == 2, most);
    return refused("nodes=" + text("nodes") + " has " + std::to_string(nodes) +
                   " motors, but steering=" + std::to_string(steering) +
                   (steering == kDifferential ? " needs 2"
                    : steering == kBothAxles  ? " needs 6"
                                              : " needs 3, or 2 with one rear motor"));
  }

  Result<MotorLink> make_link(int signed_node, bool steers) const {
    const auto node = static_cast<std::uint8_t>(std::abs(signed_node));
    auto motor = make_motor(node, steers ? MotorTask::kPositions : MotorTask::kTurns);
    if (!motor) return motor.error();
    const double sign = signed_node < 0 ? -1 : 1;
    const double of_wheel = static_cast<double>(real("gearRatio")) /
                            static_cast<double>(std::max(integer("wheelRadius"), i32{1}));
    const auto of_steering = static_cast<double>(real("steerRatio"));
    const double zero = static_cast<double>(real("steerZero")) * std::numbers::pi / 180;
    return MotorLink{.motor = std::move(*motor),
                     .name = "motor of node " + std::to_string(node),
                     .gear = sign * (steers ? of_steering : of_wheel),
                     .zero = steers ? zero : 0};
  }
};

}  // namespace rack::device
