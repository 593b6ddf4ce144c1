// ClockSystem: the clock of this host, which another clock may set.
#include <array>
#include <cerrno>
#include <ctime>
#include <optional>
#include <system_error>

#include "components/clock/calendar.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/partner.h"

namespace rack::clock {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(5000);
constexpr auto kStep =
    std::chrono::milliseconds(100);  // so that OFF need not wait for a whole period

constexpr std::array<ParameterInfo, 3> kParameters = {
    optional_partner("clock", "the clock that sets this one",
                     "the clock that sets this one; -1: none"),
    at_once({"systemClockUpdate", 1,
             "1: set the time of this host by that clock; needs CAP_SYS_TIME", 0, 1}),
    at_once({"systemClockUpdateTime", 60000, "interval between updates [ms]", 0}),
};

constexpr ModuleInfo kInfo{
    .program = "ClockSystem",
    .purpose = "The clock of this host, UTC; another clock may set it.",
    .class_id = tims::class_id::kClock,
    .parameters = kParameters,
};

class ClockSystem : public DataModule<ClockData> {
 public:
  ClockSystem() : DataModule(kInfo, {.history = 5}) {}

 private:
  Result<void> module_on() override {
    set_period(kPeriod);
    steps_ = 0;
    sync_mode_ = 0;
    updated_.reset();
    if (auto on = other_.turn_on(); !on) return on;
    return DataModule::module_on();
  }

  Result<void> module_loop() override {
    sleep_until_next(kStep);
    if (steps_++ % (kPeriod / kStep) != 0) return {};
    if (auto updated = update(); !updated) return updated;
    ClockData& data = get_local_buffer();
    data = clock_of(std::chrono::seconds(::time(nullptr)));
    data.recordingTime = time_stamp();
    data.syncMode = sync_mode_;
    return put_local_buffer();
  }

  // Sets the time of this host by the other clock when it is due; while that clock is not
  // synchronised, retries every period.
  Result<void> update() {
    if (!other_ || integer("systemClockUpdate") == 0) return {};
    const std::chrono::milliseconds interval(integer("systemClockUpdateTime"));
    if (updated_ && time_stamp() - *updated_ <= interval) return {};
    const auto data = other_->get_data();
    if (!data) return data.error();
    sync_mode_ = 0;
    const auto time = time_by(*data, time_stamp());
    if (!time) return {};
    const auto seconds = std::chrono::floor<std::chrono::seconds>(*time);
    const timespec now{.tv_sec = seconds.count(),
                       .tv_nsec = std::chrono::nanoseconds(*time - seconds).count()};
    if (::clock_settime(CLOCK_REALTIME, &now) != 0)
      return refused(std::string("cannot set the time of this host: ") +
                     std::generic_category().message(errno) +
                     "; it needs CAP_SYS_TIME, or systemClockUpdate=0");
    sync_mode_ = data->syncMode;
    updated_ = time_stamp();
    return {};
  }

  OwnMailbox work_{*this, 10, wire_size<ClockData>()};
  Partner<ClockProxy> other_{*this, "clock", work_};
  std::optional<TimeStamp> updated_;
  i32 sync_mode_ = 0;
  int steps_ = 0;
};

}  // namespace
}  // namespace rack::clock

int main(int argc, char** argv) {
  rack::clock::ClockSystem clock;
  return clock.run(argc, argv);
}
