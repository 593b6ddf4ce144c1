// Base of all drivers of satellite receivers. For each fix: takes the time of measurement from the
// pulse per second, requests robot coordinates from Position, and relays the time.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "components/clock/calendar.h"
#include "components/devices/drivers/driver.h"
#include "components/devices/drivers/host_clock.h"
#include "components/devices/drivers/relay.h"
#include "components/devices/io/pulse.h"
#include "components/devices/positioning/gps.h"
#include "rack/proxies/clock.h"
#include "rack/proxies/position.h"

namespace rack::device {

inline constexpr std::array<ParameterInfo, 7> kGpsParameters = {{
    or_none(partner("position", "the Position that converts to robot coordinates",
                    "that component; -1: none")),
    {"positionUpdate", 0, "1: update Position with fixes, weighted by both variances", 0, 1},
    optional_partner("clockRelay", "the clock relay that receives the time",
                     "that component; -1: none"),
    {"realtimeClockUpdate", 0, "1: set the clock of this host, which needs CAP_SYS_TIME", 0, 1},
    {"realtimeClockUpdateTime", 60000, "period of setting the clock [ms]", 0},
    {"enablePPSTiming", 1, "1: time-stamp fixes by the pulse per second, if the kernel provides it",
     0, 1},
    host_file({"pps", "", "PPS device, e.g. /dev/pps0; empty: that of the serial line"}),
}};

// `Dialog` must have the interface of NmeaReceiver.
template <class Dialog>
class GpsDriver : public Driver<GpsData, Dialog> {
 public:
  using Driver<GpsData, Dialog>::Driver;

 protected:
  Result<void> module_on() override {
    // A recording contains the time of another day.
    clock_.start(this->integer("realtimeClockUpdate") != 0 && !this->is_recording(),
                 std::chrono::milliseconds(this->integer("realtimeClockUpdateTime")));
    position_.connect();
    position_asked_.reset();
    relay_.connect();
    open_pulse();
    return Driver<GpsData, Dialog>::module_on();
  }

  void module_off() override {
    Driver<GpsData, Dialog>::module_off();
    pulse_.reset();
  }

  Result<void> complete(GpsData& data) override {
    const GpsMoment& moment = this->dialogue().moment();
    tims::Time measured = this->dialogue().recorded();
    const bool by_pulse = take_pulse(moment, measured);
    data.recordingTime = time_stamp_of(measured);
    if (data.mode != gps_mode::kInvalid) report_time(data, moment, measured, by_pulse);
    ask_position(data);
    return {};
  }

 private:
  // The kernel stamps pulses with the wall clock, which may be set at any time: use only their age.
  bool take_pulse(const GpsMoment& moment, tims::Time& measured) const {
    if (!pulse_ || !moment.utc) return false;
    const auto pulse = pulse_->last();
    if (!pulse) return false;
    timespec wall{};
    ::clock_gettime(CLOCK_REALTIME, &wall);
    const tims::Duration wall_now =
        std::chrono::seconds(wall.tv_sec) + tims::Duration(wall.tv_nsec);
    const tims::Duration arrived = wall_now - (now() - measured);
    const auto then = measured_by_pulse(*pulse, moment.fraction(), arrived);
    if (then) measured -= arrived - *then;
    return then.has_value();
  }

  void report_time(GpsData& data, const GpsMoment& moment, tims::Time measured, bool by_pulse) {
    if (!moment.utc || moment.is_leap_second) return;
    const auto updated = clock_.update(*moment.utc, measured, now());
    if (!updated) this->log().warning("{}", updated.error().detail());
    if (updated && *updated) data.recordingTime = time_stamp_of(measured);
    constexpr i32 kDeviation = 300;  // ms, standard deviation of the delay until a receiver sends
    ClockData clock = clock::clock_of(std::chrono::floor<std::chrono::seconds>(*moment.utc));
    clock.recordingTime = data.recordingTime;
    clock.syncMode = 1;
    clock.varT = by_pulse ? 1 : kDeviation;
    relay_.send(clock);
  }

  // While Position does not answer, requests are limited to one every few seconds.
  void ask_position(GpsData& data) {
    constexpr tims::Duration kPause = std::chrono::seconds(5);
    if (!position_ || data.mode == gps_mode::kInvalid) return;
    if (position_asked_ && now() - *position_asked_ < kPause) return;
    const auto position = position_->wgs84_to_pos({.latitude = data.latitude,
                                                   .longitude = data.longitude,
                                                   .altitude = data.altitude,
                                                   .heading = data.heading});
    if (position) {
      data.pos = position->pos;
      position_asked_.reset();
      if (this->integer("positionUpdate") != 0) report_position(data);
      return;
    }
    if (!position_asked_)
      this->log().warning(
          "{}; fixes have no robot coordinates until Position answers (positionInst=-1 turns "
          "them off)",
          position.error().message());
    position_asked_ = now();
  }

  // The course equals the heading only while the robot moves. Position may have no data for that
  // time.
  void report_position(const GpsData& data) {
    constexpr i32 kMoves = 1000;  // mm/s
    const auto known = position_->get_data(data.recordingTime);
    if (!known) return;
    const auto both = weighed(*known, data, data.speed >= kMoves);
    if (!both) return;
    if (const auto updated = position_->update(*both); !updated)
      this->log().warning("{}", updated.error().message());
  }

  void open_pulse() {
    pulse_.reset();
    if (this->integer("enablePPSTiming") == 0) return;
    std::string path = this->text("pps");
    if (path.empty()) {
      const auto options = this->device();
      if (options && options->address.kind == TransportKind::kSerial)
        path = Pulse::find(options->address.place);
    }
    if (path.empty()) return;
    auto opened = Pulse::open(path);
    if (opened)
      pulse_.emplace(std::move(*opened));
    else
      this->log().warning("{}; fixes are time-stamped at their arrival", opened.error().message());
  }

  OwnMailbox work_{*this, 2, 256};
  Partner<PositionProxy> position_{*this, "position", work_};
  std::optional<tims::Time> position_asked_;  // last request without an answer
  Relay<ClockProxy> relay_{*this, "clockRelay", work_};
  HostClock clock_;
  std::optional<Pulse> pulse_;
};

}  // namespace rack::device
