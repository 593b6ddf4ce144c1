// ChassisRoomba: driver of an iRobot Roomba or Create 2 on a serial line.
#include "components/devices/chassis/roomba.h"
#include "components/devices/drivers/chassis_driver.h"
#include "components/devices/drivers/relay.h"
#include "rack/proxies/io.h"

namespace rack::device {
namespace {

constexpr auto kParameters = chassis_parameters(
    std::array<ParameterInfo, 8>{{
        {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
        one_of("0 Roomba (400), 1 Create 2 and Roomba 600 or later",
               {"model", 0, "model of the robot", 0, 1}),
        optional_partner("scan2d", "the Scan2d that publishes bumpers and cliffs",
                         "that component; -1: none"),
        optional_partner("io", "the Io that publishes its sensors", "that component; -1: none"),
        {"motorMainBrush", 0, "1: turn the brush on", 0, 1},
        {"motorVacuum", 0, "1: turn the vacuum on", 0, 1},
        {"motorSideBrush", 0, "1: turn the brush on", 0, 1},
        {"startDocking", 0, "1: let the robot seek its dock", 0, 1},
    }},
    ChassisDefaults{.vxMax = 500,
                    .minTurningRadius = 100,
                    .safetyMarginMove = 0,
                    .front = 170,
                    .back = 170,
                    .left = 170,
                    .right = 170,
                    .wheelBase = 258,
                    .trackWidth = 258});

constexpr ModuleInfo kInfo{
    .program = "ChassisRoomba",
    .purpose =
        "An iRobot Roomba or Create 2 on a serial line. The robot has no watchdog: a guard "
        "process stops it when the driver crashes.",
    .class_id = tims::class_id::kChassis,
    .parameters = kParameters,
};

class ChassisRoomba : public ChassisDriver<Roomba> {
 public:
  ChassisRoomba() : ChassisDriver(kInfo) {}

 private:
  [[nodiscard]] RoombaModel model() const { return static_cast<RoombaModel>(integer("model")); }

  Result<DeviceOptions> device() const override {
    const bool is_new = model() == RoombaModel::kCreate2;
    return device_by("serialDev", serial_device, is_new ? 115200 : 57600);
  }

  Result<std::unique_ptr<Roomba>> make_dialogue() override {
    set_period(std::chrono::milliseconds(100));
    if (auto on = scan_.turn_on(); !on) return on.error();
    if (auto on = io_.turn_on(); !on) return on.error();
    return std::make_unique<Roomba>(
        RoombaSettings{.model = model(),
                       .track = static_cast<double>(integer("trackWidth")),
                       .main_brush = integer("motorMainBrush") != 0,
                       .vacuum = integer("motorVacuum") != 0,
                       .side_brush = integer("motorSideBrush") != 0,
                       .dock = integer("startDocking") != 0,
                       .only_listen = is_recording()});
  }

  Result<void> complete(ChassisData& data) override {
    if (scan_) {
      dialogue().look(points_);
      points_.recordingTime = data.recordingTime;
      points_.duration = static_cast<u32>(period().count());
      points_.sectorNum = 1;
      scan_.send(points_);
    }
    if (io_) {
      const RoombaSensors& sensors = dialogue().sensors();
      values_.recordingTime = data.recordingTime;
      values_.values.clear();
      for (const int value :
           {static_cast<int>(sensors.bumps), sensors.wall ? 1 : 0, sensors.cliffs[0] ? 1 : 0,
            sensors.cliffs[1] ? 1 : 0, sensors.cliffs[2] ? 1 : 0, sensors.cliffs[3] ? 1 : 0,
            static_cast<int>(sensors.overcurrents), static_cast<int>(sensors.charging)})
        values_.values.push_back(static_cast<u8>(value));
      io_.send(values_);
    }
    return ChassisDriver::complete(data);
  }

  OwnMailbox work_{*this, 1, 128};
  Relay<Scan2dProxy> scan_{*this, "scan2d", work_};
  Relay<IoProxy> io_{*this, "io", work_};
  Scan2dData points_;
  IoData values_;
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::ChassisRoomba chassis;
  return chassis.run(argc, argv);
}
