// ServoDrive: driver of one axis with a CiA 402 drive on a CAN bus.
#include <mutex>
#include <numbers>

#include "components/devices/chassis/servo_axis.h"
#include "rack/devices/driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 14>{{
    {"canDev", 0, "number N of the CAN interface canN", 0, 255},
    {"node", 1, "CANopen node id of the drive", 1, 126},
    one_of("0 rotary (data in rad; parameters in deg), 1 linear (mm)",
           {"sliding", 0, "kind of axis", 0, 1}),
    {"gearRatio", 1.0F, "motor turns per turn of the axis, or per mm; below 0: reversed", -10000,
     10000},
    {"increments", 4096, "encoder increments per turn of the motor", 1, 1e9},
    {"velocityUnits", 0, "velocity units of the drive per turn/s; 60: rpm; 0: increments/s", 0,
     1e9},
    {"posMin", -180.0F, "minimum position [deg or mm]", -1e6, 1e6},
    {"posMax", 180.0F, "maximum position [deg or mm]", -1e6, 1e6},
    {"velMax", 90.0F, "maximum velocity [deg/s or mm/s]", 0.001, 1e6},
    {"accMax", 180.0F, "maximum acceleration [deg/s2 or mm/s2]", 0.001, 1e6},
    {"homingMethod", 35, "homing method of CiA 402; 35, 37: current position becomes 0", -128, 127},
    {"homeAtOn", 0, "1: home the axis at ON", 0, 1},
    {"periodTime", 50, "period of the data [ms]", 20, 1000},
    {"moveDeadline", 0, "validity of a MOVE_VEL [ms]; 0: three periods of its sender", 0, 3600000},
}});

constexpr ModuleInfo kInfo{
    .program = "ServoDrive",
    .purpose =
        "One axis with a CANopen drive (CiA 402). Without the driver's heartbeat the drive stops "
        "after 0.2 s.",
    .class_id = tims::class_id::kServoDrive,
    .parameters = kParameters,
};

class ServoDrive : public Driver<ServoDriveData, ServoAxis> {
 public:
  ServoDrive() : Driver(kInfo, {.history = 100}) {}

 private:
  Result<DeviceOptions> device() const override { return device_by("canDev", can_device, 0); }

  // A parameter of the axis in rad or mm.
  [[nodiscard]] double axis(std::string_view name) const {
    const auto value = static_cast<double>(real(name));
    return integer("sliding") != 0 ? value : value * std::numbers::pi / 180;
  }

  Result<std::unique_ptr<ServoAxis>> make_dialogue() override {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    const double turns = static_cast<double>(real("gearRatio"));
    if (turns == 0) return refused("gearRatio must not be 0");
    if (axis("posMin") > axis("posMax")) return refused("posMin must not be larger than posMax");
    const double gear = integer("sliding") != 0 ? turns * 2 * std::numbers::pi : turns;
    const auto increments = static_cast<double>(integer("increments"));
    const auto units = static_cast<double>(integer("velocityUnits"));
    const double acceleration = axis("accMax") * std::abs(gear);
    auto dialogue = std::make_unique<ServoAxis>(ServoAxisSettings{
        .drive = {.node = static_cast<std::uint8_t>(integer("node")),
                  .increments_of_turn = increments,
                  .velocity_of_turn = units > 0 ? units : increments,
                  .acceleration = acceleration,
                  .deceleration = acceleration,
                  .quick_stop = 2 * acceleration,
                  .homing_method = static_cast<std::int8_t>(integer("homingMethod"))},
        .gear = gear,
        .min = axis("posMin"),
        .max = axis("posMax"),
        .velocity_max = axis("velMax"),
        .period = period(),
        .move_deadline = std::chrono::milliseconds(integer("moveDeadline")),
        .only_listen = is_recording()});
    const std::lock_guard lock(pending_mutex_);
    pending_ = {.home = integer("homeAtOn") != 0};
    waiting_.reset();
    return dialogue;
  }

  tims::Time prepare(tims::Time now) override {
    const std::lock_guard lock(pending_mutex_);
    if (!dialogue().is_ready()) return tims::kNever;
    if (dialogue().take_overdue()) log().warning("No MOVE_VEL in time, stopped");
    if (std::exchange(pending_.home, false)) dialogue().home();
    if (pending_.position)
      dialogue().move_to(static_cast<double>(pending_.position->position),
                         static_cast<double>(pending_.position->vel),
                         static_cast<double>(pending_.position->acc));
    if (pending_.velocity) dialogue().move(static_cast<double>(*pending_.velocity), now);
    pending_ = {};
    return tims::kNever;
  }

  Result<std::size_t> data_at(TimeStamp time, std::span<std::byte> to) const override {
    return data_between(time, to, interpolated);
  }

  // Answers requests that wait until the target is reached.
  Result<void> complete(ServoDriveData&) override {
    const std::lock_guard lock(pending_mutex_);
    if (!waiting_ || pending_.position || pending_.home || !dialogue().is_reached()) return {};
    (void)reply(*waiting_, ServoDriveType::kPositionReached);
    waiting_.reset();
    return {};
  }

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case ServoDriveType::kHome:
        return accept(message, {.home = true}, false);
      case ServoDriveType::kMovePos: {
        const auto motion = decode<ServoDriveMovePosData>(message);
        if (!motion) return motion.error();
        return accept(message, {.position = *motion}, motion->replyPositionReached != 0);
      }
      case ServoDriveType::kMoveVel: {
        const auto motion = decode<ServoDriveMoveVelData>(message);
        if (!motion) return motion.error();
        return accept(message, {.velocity = motion->vel}, false);
      }
      case ServoDriveType::kInformReached: {
        const std::lock_guard lock(pending_mutex_);
        waiting_ = message.header;
        break;
      }
      default:
        return Driver::module_command(message);
    }
    reply(message.header, tims::type::kOk);
    return {};
  }

  struct Motion {
    bool home = false;
    std::optional<ServoDriveMovePosData> position{};
    std::optional<f32> velocity{};
  };

  Result<void> accept(const tims::MessageView& message, const Motion& motion, bool inform) {
    if (!is_on()) return refused("the drive is off");
    {
      const std::lock_guard lock(pending_mutex_);
      pending_ = motion;
      waiting_.reset();
      if (inform) waiting_ = message.header;
    }
    wake();
    reply(message.header, tims::type::kOk);
    return {};
  }

  PriorityMutex pending_mutex_;
  Motion pending_;
  std::optional<tims::Header> waiting_;  // request to answer when the target is reached
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::ServoDrive drive;
  return drive.run(argc, argv);
}
