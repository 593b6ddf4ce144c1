// Base of the drivers of DCF77 radio clocks.
#pragma once

#include "components/devices/drivers/host_clock.h"
#include "components/devices/positioning/dcf77.h"
#include "rack/devices/driver.h"

namespace rack::device {

class ClockDcf77 : public Driver<ClockData, Dcf77> {
 public:
  ClockDcf77(const ModuleInfo& info, Dcf77Kind kind) : Driver(info, {.history = 5}), kind_(kind) {}

 protected:
  Result<std::unique_ptr<Dcf77>> make_dialogue() override {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    // A recording contains the time of another day.
    clock_.start(integer("realtimeClockUpdate") != 0 && !is_recording(),
                 std::chrono::milliseconds(integer("realtimeClockUpdateTime")));
    return std::make_unique<Dcf77>(kind_);
  }

  Result<void> complete(ClockData& data) override {
    constexpr i32 kLeapSecond = 60;
    if (data.syncMode == 0 || data.second == kLeapSecond) return {};
    const tims::Time measured = dialogue().recorded();
    const auto updated = clock_.update(std::chrono::seconds(data.utcTime.raw()), measured, now());
    if (!updated) log().warning("{}", updated.error().detail());
    if (updated && *updated) data.recordingTime = time_stamp_of(measured);
    return {};
  }

 private:
  Dcf77Kind kind_;
  HostClock clock_;
};

inline constexpr std::array<ParameterInfo, 4> kClockParameters = {{
    {"serialDev", 0, "serial device: 0-99 ttyS, 100-199 ttyUSB, 200-299 ttyACM", 0, 299},
    {"periodTime", 1000, "period of the telegrams [ms]", 100, 60000},
    {"realtimeClockUpdate", 1, "1: set the clock of this host, which needs CAP_SYS_TIME", 0, 1},
    {"realtimeClockUpdateTime", 60000, "period of setting the clock [ms]", 0},
}};

}  // namespace rack::device
