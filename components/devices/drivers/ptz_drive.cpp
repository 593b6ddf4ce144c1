// PtzDrive: a camera mount that speaks VISCA.
#include <mutex>
#include <variant>
#include <vector>

#include "components/devices/camera/visca.h"
#include "components/devices/drivers/driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 9>{{
    {"serialDev", 0, "0 to 99 ttyS, 100 to 199 ttyUSB, 200 to 299 ttyACM", 0, 299},
    {"baudrate", 9600, "9600 or 38400, as the camera is set", 1200, 115200},
    {"periodTime", 100, "ms", 50, 5000},
    {"stepsPerDegree", 14.4F, "of pan and tilt (EVI-D70: 13.33)", 1, 1000},
    {"zoomMax", 16384, "what the camera calls its farthest zoom", 1, 32767},
    {"panVelMax", 100, "at its highest speed, deg/s", 1, 1000},
    {"tiltVelMax", 100, "deg/s", 1, 1000},
    {"zoomVelMax", 50, "%/s", 1, 1000},
    {"moveDeadline", 0, "how long a MOVE_VEL holds, ms; 0: three periods of its sender", 0,
     3600000},
}});

constexpr ModuleInfo kInfo{
    .program = "PtzDrive",
    .purpose = "A camera mount that pans, tilts and zooms, by VISCA (serial, or UDP port 52381).",
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
      constexpr std::size_t kMost = 16;  // a drive that is told more often hears the newest
      if (commands_.size() == kMost) commands_.erase(commands_.begin());
      commands_.push_back(command);
      waiting_.clear();  // where they wait to arrive is no longer where it goes
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
  std::vector<tims::Header> waiting_;  // who is told that it is there
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::PtzDrive drive;
  return drive.run(argc, argv);
}
