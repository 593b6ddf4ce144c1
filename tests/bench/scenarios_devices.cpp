#include "tests/bench/cases.h"
#include "tests/bench/decoder_streams.h"

namespace tims::bench {
namespace {

constexpr double kScenariosDevicesLatestUs = 1000;  // after the line time
constexpr double kDriverPercent = 2;

Case decoding(const DecoderCase& one) {
  const std::string name(one.name);
  return {.scenario = "devices@" + name,
          .payload = 0,
          .contenders = {{"tims", {.shape = Shape::kAlone, .link = "decode:" + name}},
                         {"limit-memcpy", {.shape = Shape::kAlone, .link = "copy:" + name}}},
          .rows = {{"tims", "mb_per_s", "limit-memcpy", {.at_least = one.target}}}};
}

Case scanning(const std::string& scanner, std::uint64_t scans, Target cpu) {
  const auto reading = [&](const std::string& role, Between between) {
    return Experiment{
        .shape = Shape::kAlone, .link = role + ":" + scanner, .between = between, .count = scans};
  };
  return {.scenario = "devices@" + scanner + "-scans",
          .payload = 0,
          .contenders = {{"tims", reading("driver", Between::kRouter)},
                         {"limit-read", reading("bare-reader", Between::kNothing)}},
          .rows = {{"tims", "p50_us", "limit-read", {}},
                   {"tims", "p99_us", "limit-read", {.at_most = kScenariosDevicesLatestUs}},
                   {"tims", "max_us", "limit-read", {}},
                   {"tims", "cpu_percent", "limit-read", cpu}}};
}

}  // namespace

std::vector<Case> devices_cases(bool quick) {
  const std::uint64_t scans = quick ? 300 : 1000;
  std::vector<Case> cases = {scanning("lms200", scans, {.at_most = kDriverPercent}),
                             scanning("cola", scans, {})};
  for (const DecoderCase& one : decoder_cases()) cases.push_back(decoding(one));
  return cases;
}

}  // namespace tims::bench
