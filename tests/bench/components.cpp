#include "tests/bench/components.h"

#include <array>
#include <cstdio>
#include <vector>

#include "libtims/os/clock.h"
#include "rack/data_module.h"
#include "rack/proxies/ladar.h"
#include "tests/bench/metrics.h"
#include "tests/bench/usage.h"
#include "tims/session.h"

namespace tims::bench {
namespace {

constexpr std::uint32_t kPoints = 361;

constexpr rack::ModuleInfo kInfo{
    .program = "Scanner", .purpose = "A component of tims-bench.", .class_id = class_id::kLadar};

Address scanner_address() { return Address::of({.class_id = class_id::kLadar}); }

int run(rack::Module& module, const Plan& plan, const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"--router=" + plan.socket};
  arguments.insert(arguments.end(), more.begin(), more.end());
  std::vector<const char*> argv;
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  return module.run(argv);
}

// The time of put, stored in the first point.
void stamp(rack::LadarData& scan, Time now) {
  const auto ns = static_cast<std::uint64_t>(now.time_since_epoch().count());
  scan.points[0].distance = static_cast<std::int32_t>(static_cast<std::uint32_t>(ns >> 32U));
  scan.points[0].intensity = static_cast<std::int32_t>(static_cast<std::uint32_t>(ns));
}
Time stamped(const rack::LadarData& scan) {
  const auto high = static_cast<std::uint32_t>(std::int32_t{scan.points[0].distance});
  const auto low = static_cast<std::uint32_t>(std::int32_t{scan.points[0].intensity});
  return Time(Duration((std::uint64_t{high} << 32U) | low));
}

class Scanner : public rack::DataModule<rack::LadarData> {
 public:
  explicit Scanner(const Plan& plan) : DataModule(kInfo, {}), plan_(plan) {}

 private:
  rack::Result<void> module_on() override {
    rack::LadarData& scan = get_local_buffer();
    scan.points.clear();
    for (std::uint32_t i = 0; i < kPoints; ++i) scan.points.push_back({});
    set_period(std::chrono::duration_cast<std::chrono::milliseconds>(plan_.every));
    before_ = own_usage();
    began_ = os::now();
    return DataModule::module_on();
  }
  rack::Result<void> module_loop() override {
    sleep_until_next(plan_.every);
    rack::LadarData& scan = get_local_buffer();
    scan.recordingTime = rack::TimeStamp(++count_);
    stamp(scan, os::now());
    auto put = put_local_buffer();
    const Duration passed = os::now() - began_;
    if (passed >= plan_.seconds) {
      const Usage spent = own_usage() - before_;
      constexpr double kPercent = 100;
      print_metric("cpu_percent",
                   kPercent * spent.cpu_s * 1e9 / static_cast<double>(passed.count()));
      stop();
    }
    return put;
  }

  const Plan& plan_;
  Usage before_;
  Time began_{};
  std::uint32_t count_ = 0;
};

class Clockwork : public rack::DataModule<rack::LadarData> {
 public:
  explicit Clockwork(const Plan& plan) : DataModule(kInfo, {}), plan_(plan) {
    late_.reserve(static_cast<std::size_t>(plan.seconds / plan.every) + 1);
  }
  std::vector<Duration>& late() { return late_; }

 private:
  rack::Result<void> module_loop() override {
    if (began_ == Time{}) began_ = os::now();
    const Time wanted = sleep_until_next(plan_.every);
    const Time now = os::now();
    late_.push_back(now - wanted);
    get_local_buffer().recordingTime = rack::TimeStamp(++beats_);
    if (now - began_ >= plan_.seconds) stop();
    return put_local_buffer();
  }

  const Plan& plan_;
  Time began_{};
  std::uint32_t beats_ = 0;
  std::vector<Duration> late_;
};

}  // namespace

bool play_scanner(const Plan& plan) {
  Scanner scanner(plan);
  return run(scanner, plan) == 0;
}

bool play_clockwork(const Plan& plan) {
  Clockwork clockwork(plan);
  const std::string priority = std::to_string(kRealTimePriority);
  if (run(clockwork, plan, {"--targetStatus=1", "--dataTaskPrio=" + priority}) != 0) return false;
  print_latencies(clockwork.late());
  return true;
}

bool play_listener(const Plan& plan) {
  auto session = Session::connect({.name = "listener", .router = plan.socket});
  if (!session) return false;
  const auto address = [&](std::uint32_t local) {
    return Address::of({.class_id = class_id::kTest, .instance = plan.index, .local = local});
  };
  auto work = session->open({.address = address(0), .slots = 4, .body_max = 128});
  auto data = session->open(
      {.address = address(1), .slots = 4, .body_max = rack::body_max<rack::LadarData>()});
  if (!work || !data) return false;
  rack::LadarProxy scanner(*work, scanner_address());
  const Time give_up = os::now() + std::chrono::seconds(10);  // its program may still be starting
  while (!scanner.on() && os::now() < give_up) {
  }
  if (!scanner.get_cont_data(0, data->address())) return false;
  std::vector<Duration> samples;
  rack::LadarData scan;
  for (;;) {
    const auto message = data->peek_for(std::chrono::seconds(2));
    const Time now = os::now();
    if (!message || !scanner.decode_stream(*message, scan)) break;  // the scanner has exited
    samples.push_back(now - stamped(scan));
  }
  print_latencies(samples);
  return !samples.empty();
}

bool burn(const Plan& plan) {
  std::uint64_t work = 0;
  for (const Time end = os::now() + plan.seconds; os::now() < end;)
    for (int i = 0; i < 1000; ++i) work = work * 31 + 7;
  return work != 0;
}

}  // namespace tims::bench
