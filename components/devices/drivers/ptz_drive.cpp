// PtzDrive: driver of a pan-tilt-zoom camera mount with VISCA.
#include <mutex>
#include <variant>
#include <vector>

#include "components/devices/camera/visca.h"
#include "rack/devices/driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 9>{{
    {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
    one_of("9600, 38400", {"baudrate", 9600, "baud rate set in the camera [bit/s]", 1200, 115200}),
    {"periodTime", 100, "period of the data [ms]", 50, 5000},
    {"stepsPerDegree", 14.4F, "steps of pan and tilt per degree (EVI-D70: 13.33)", 1, 1000},
    {"zoomMax", 16384, "zoom value of the camera at maximum zoom", 1, 32767},
    {"panVelMax", 100, "maximum pan speed of the camera [deg/s]", 1, 1000},
    {"tiltVelMax", 100, "maximum tilt speed of the camera [deg/s]", 1, 1000},
    {"zoomVelMax", 50, "maximum zoom speed of the camera [%/s]", 1, 1000},
    {"moveDeadline", 0, "validity of a MOVE_VEL [ms]; 0: three periods of its sender", 0, 3600000},
}});

constexpr ModuleInfo kInfo{
    .program = "PtzDrive",
    .purpose = "A pan-tilt-zoom camera mount with VISCA (serial, or UDP port 52381).",
    .class_id = tims::class_id::kPtzDrive,
    .parameters = kParameters,
};

class PtzDrive : public Driver<PtzDriveData, Visca> {
 public:
  PtzDrive() : Driver(kInfo, {.history = 10}) {}

 private:
  struct Home {};
  using Command = std::variant<Home, PtzDriveMovePosData, PtzDriveMoveVelData>;

  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, static_cast<std::uint32_t>(integer("baudrate")));
  }

  Result<std::unique_ptr<Visca>> make_dialogue() override {
    const auto period = std::chrono::milliseconds(integer("periodTime"));
    set_period(period);
    const auto address = DeviceAddress::parse(text("device"));
    {
      const std::lock_guard lock(command_mutex_);
      commands_.clear();
      waiting_.clear();
    }
    return std::make_unique<Visca>(
        ViscaSettings{.is_datagrams = address && address->kind == TransportKind::kUdp,
                      .only_listen = is_recording(),
                      .period = period,
                      .move_deadline = std::chrono::milliseconds(integer("moveDeadline")),
                      .steps_of_degree = real("stepsPerDegree"),
                      .zoom_max = 1.0 * integer("zoomMax"),
                      .pan_speed_max = 1.0 * integer("panVelMax"),
                      .tilt_speed_max = 1.0 * integer("tiltVelMax"),
                      .zoom_speed_max = 1.0 * integer("zoomVelMax")});
  }

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case PtzDriveType::kHome:
        return accept(message.header, Home{}, false);
      case PtzDriveType::kMovePos: {
        const auto move = decode<PtzDriveMovePosData>(message);
        if (!move) return move.error();
        return accept(message.header, *move, move->replyPosReached != 0);
      }
      case PtzDriveType::kMoveVel: {
        const auto move = decode<PtzDriveMoveVelData>(message);
        if (!move) return move.error();
        return accept(message.header, *move, false);
      }
      case PtzDriveType::kInformReached: {
        const std::lock_guard lock(command_mutex_);
        waiting_.push_back(message.header);
        reply(message.header, tims::type::kOk);
        return {};
      }
      default:
        return Driver::module_command(message);
    }
  }

  Result<void> accept(const tims::Header& request, const Command& command, bool informs) {
    if (!is_on()) return refused("the drive is off");
    {
      const std::lock_guard lock(command_mutex_);
      constexpr std::size_t kMost = 16;  // when exceeded, the oldest commands are dropped
      if (commands_.size() == kMost) commands_.erase(commands_.begin());
      commands_.push_back(command);
      waiting_.clear();  // the target they wait for has been replaced
      if (informs) waiting_.push_back(request);
    }
    wake();
    reply(request, tims::type::kOk);
    return {};
  }

  tims::Time prepare(tims::Time now) override {
    const std::lock_guard lock(command_mutex_);
    if (dialogue().take_overdue()) log().warning("No MOVE_VEL in time, stopped");
    for (const Command& command : commands_) {
      if (const auto* to = std::get_if<PtzDriveMovePosData>(&command)) dialogue().move_to(*to);
      if (const auto* by = std::get_if<PtzDriveMoveVelData>(&command)) dialogue().move(*by, now);
      if (std::holds_alternative<Home>(command)) dialogue().home();
    }
    commands_.clear();
    return tims::kNever;
  }

  Result<void> complete(PtzDriveData&) override {
    if (!dialogue().take_reached()) return {};
    const std::lock_guard lock(command_mutex_);
    for (const tims::Header& request : waiting_) reply(request, PtzDriveType::kPositionReached);
    waiting_.clear();
    return {};
  }

  std::mutex command_mutex_;
  std::vector<Command> commands_;
  std::vector<tims::Header> waiting_;  // requests to answer when the target is reached
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::PtzDrive drive;
  return drive.run(argc, argv);
}
