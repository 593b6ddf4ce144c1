// CompassCmps03: driver of a CMPS03 compass behind a board with a serial line.
#include "components/devices/positioning/cmps03.h"
#include "rack/devices/driver.h"

namespace rack::device {
namespace {

constexpr auto kParameters = driver_parameters(std::array<ParameterInfo, 6>{{
    {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
    {"baudrate", 57600, "baud rate of the line [bit/s]", 1200, 4000000},
    {"periodTime", 200, "period of the board [ms]", 10, 60000},
    at_once(
        {"calibration", 0, "1: calibrate the compass in four directions, guided by the log", 0, 1}),
    at_once({"compassAligned", 0, "1: the compass points in the direction the log asks for", 0, 1}),
    {"compassOffset", 0, "offset added to the heading [deg]", -360, 360},
}});

constexpr ModuleInfo kInfo{
    .program = "CompassCmps03",
    .purpose = "A CMPS03 compass behind a board with a serial line.",
    .class_id = tims::class_id::kCompass,
    .parameters = kParameters,
};

class CompassCmps03 : public Driver<CompassData, Cmps03> {
 public:
  CompassCmps03() : Driver(kInfo, {.history = 5}) {}

 private:
  Result<DeviceOptions> device() const override {
    return device_by("serialDev", serial_device, static_cast<std::uint32_t>(integer("baudrate")));
  }

  Result<std::unique_ptr<Cmps03>> make_dialogue() override {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    return std::make_unique<Cmps03>(
        Cmps03Settings{.offset = static_cast<double>(integer("compassOffset"))});
  }

  Result<void> module_loop() override {
    if (!is_recording())
      dialogue().request_calibration(integer("calibration") != 0, integer("compassAligned") != 0,
                                     now());
    auto done = Driver::module_loop();
    report_step();
    return done;
  }

  void report_step() {
    int direction = 0;
    switch (dialogue().take_step(direction)) {
      case Cmps03::Step::kNone:
        return;
      case Cmps03::Step::kAlign:
        log().print("calibration: turn the compass to direction 1 of 4, then set compassAligned=1");
        return;
      case Cmps03::Step::kConfirmed:
        log().print(
            "calibration: direction {} is known; turn the compass to the next one, then set "
            "compassAligned=1",
            direction);
        break;
      case Cmps03::Step::kSilent:
        log().warning(
            "calibration: the compass does not confirm direction {}; set compassAligned=1 "
            "again",
            direction);
        break;
      case Cmps03::Step::kDone:
        log().print("calibration: all four directions are known");
        set_parameter("calibration", 0);
        break;
      case Cmps03::Step::kEnded:
        log().print("calibration was ended by calibration=0, the compass may need a new one");
        break;
    }
    set_parameter("compassAligned", 0);
  }
};

}  // namespace
}  // namespace rack::device

int main(int argc, char** argv) {
  rack::device::CompassCmps03 compass;
  return compass.run(argc, argv);
}
