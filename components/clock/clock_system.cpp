// ClockSystem: the clock of this host.
#include <ctime>

#include "components/clock/calendar.h"
#include "components/runtime/clock.h"
#include "components/runtime/data_module.h"

namespace rack::clock {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(5000);
constexpr auto kStep = std::chrono::milliseconds(100);  // OFF does not wait for a whole period

constexpr ModuleInfo kInfo{
    .program = "ClockSystem",
    .purpose = "The clock of this host, UTC.",
    .class_id = tims::class_id::kClock,
};

class ClockSystem : public DataModule<ClockData> {
 public:
  ClockSystem() : DataModule(kInfo, {.history = 5}) {}

 private:
  // Not used by it, but others count on its place.
  Result<void> module_init() override {
    const auto work = create_mailbox(10, wire_size<ClockData>());
    return work ? Result<void>() : work.error();
  }

  Result<void> module_on() override {
    set_period(kPeriod);
    steps_ = 0;
    return DataModule::module_on();
  }

  Result<void> module_loop() override {
    sleep_until_next(kStep);
    if (steps_++ % (kPeriod / kStep) != 0) return {};
    get_local_buffer() = clock_of(std::chrono::seconds(::time(nullptr)));
    get_local_buffer().recordingTime = time_stamp();
    return put_local_buffer();
  }

  int steps_ = 0;
};

}  // namespace
}  // namespace rack::clock

int main(int argc, char** argv) {
  rack::clock::ClockSystem clock;
  return clock.run(argc, argv);
}
