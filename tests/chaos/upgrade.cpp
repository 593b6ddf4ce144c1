// fleet_upgrade: restarts the routers of a base and a robot in turn, under load, as systemd does
// for an upgrade, and counts what is lost and how long a link is silent.
#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "tests/support/fleet_keys.h"
#include "tests/support/kept_pair.h"
#include "tools/cli/argument_parser.h"
#include "tools/cli/failure.h"

namespace tims::chaos {
namespace {

using namespace std::chrono_literals;
using test::KeptPair;
using test::KeptRouter;
using test::TwoNetworks;

constexpr int kSkipped = 77;
constexpr Duration kSilenceMax = 300ms;

struct Settings {
  std::uint32_t restarts = 1000;
  std::uint32_t other_layout = 0;  // every so many restarts, the layout is another one
  std::uint64_t between = 400;     // messages that arrive, in each direction
  bool sealed = false;
};

template <typename T>
T value_of(Result<T> result, const std::string& what) {
  if (!result) throw std::runtime_error(what + ": " + result.error().message());
  return std::move(*result);
}
void check(const Result<void>& result, const std::string& what) {
  if (!result) throw std::runtime_error(what + ": " + result.error().message());
}

class Storm {
 public:
  explicit Storm(const Settings& settings)
      : settings_(settings), pair_(networks_, pair_of(settings, keys_)) {}

  // Whether all of it was as promised.
  bool run() {
    check(pair_.start(), "two hosts");
    for (const auto& traffic : pair_.traffic()) (void)traffic->take_silence();
    for (std::uint32_t n = 1; n <= settings_.restarts; ++n) {
      const bool other = settings_.other_layout > 0 && n % settings_.other_layout == 0;
      KeptRouter& router = n % 2 == 0 ? pair_.base() : pair_.robot();
      check(other ? pair_.restart_with_other_layout(router) : pair_.restart(router), "a restart");
      if (settings_.between > 0) check(pair_.wait_for_more(settings_.between), "after a restart");
      note_silence(other);
      if (n % 100 == 0) report(n);
    }
    pair_.end(10s);
    report(settings_.restarts);
    return is_good();
  }

 private:
  static KeptPair::Settings pair_of(const Settings& settings,
                                    std::optional<test::FleetKeys>& keys) {
    if (!settings.sealed) return {};
    keys.emplace();
    return {.keys_base = keys->base(),
            .keys_robot = keys->join("robot", security::MemberRole::kSystem, 1, 1)};
  }
  // One that begins anew is silent for longer, and may lose what is on its way.
  void note_silence(bool other_layout) {
    for (const auto& traffic : pair_.traffic()) {
      const Duration silence = traffic->take_silence();
      if (!other_layout) silences_.push_back(silence);
    }
  }
  void report(std::uint32_t restarts) {
    std::ranges::sort(silences_);
    const auto ms = [&](double part) {
      const auto at = static_cast<std::size_t>(part * static_cast<double>(silences_.size() - 1));
      return std::chrono::duration<double, std::milli>(silences_.at(at)).count();
    };
    const auto& [up, down] = pair_.traffic();
    fmt::print(
        "{} restarts: {} and {} messages, {} and {} arrived, {} wrong, {} refused without router; "
        "silence median {:.0f} ms, 99 % {:.0f} ms, longest {:.0f} ms\n",
        restarts, up->sent(), down->sent(), up->arrived(), down->arrived(),
        up->wrong() + down->wrong(), up->refused() + down->refused(), ms(0.5), ms(0.99), ms(1));
    std::fflush(stdout);
  }
  // Restarts that follow each other at once make one silence.
  [[nodiscard]] bool is_good() {
    const bool plain = settings_.other_layout > 0;
    return std::ranges::all_of(pair_.traffic(),
                               [&](const auto& traffic) {
                                 return traffic->arrived() == traffic->sent() &&
                                        (plain || traffic->wrong() == 0);
                               }) &&
           (settings_.between == 0 || silences_.back() <= kSilenceMax);
  }

  Settings settings_;
  std::optional<test::FleetKeys> keys_;
  TwoNetworks networks_ = value_of(TwoNetworks::enter(), "two hosts");
  KeptPair pair_;
  std::vector<Duration> silences_;
};

int run(const Settings& settings) {
  if (const auto possible = TwoNetworks::enter(); !possible) {
    fmt::print("skipped: {}\n", possible.error().message());
    return kSkipped;
  }
  try {
    const bool good = Storm(settings).run();
    std::puts(good ? "as promised" : "WRONG");
    return good ? 0 : 1;
  } catch (const std::exception& failure) {
    fmt::print("WRONG: {}\n", failure.what());
    return 1;
  }
}

}  // namespace
}  // namespace tims::chaos

int main(int argc, char** argv) {
  tims::chaos::Settings settings;
  timsctl::ArgumentParser parser(
      "fleet_upgrade",
      "Restarts the routers of two hosts in turn, under load, as systemctl restart does (needs "
      "root).\nExit status 1: a message was lost, doubled or out of order, or a link was silent "
      "for more\nthan 300 ms; 77: no two hosts can be made here.");
  parser.option("--restarts", settings.restarts, "number of restarts", {1, 1'000'000});
  parser.option("--other-layout", settings.other_layout,
                "every so many restarts, the state is of another version: a plain restart",
                {0, 1'000'000});
  parser.option("--between", settings.between,
                "messages that arrive in each direction between two restarts; 0: the next restart "
                "follows at once, whatever the last one has come to",
                {0, 1'000'000});
  parser.flag("--sealed", settings.sealed, "with keys");
  return parser.run(argc, argv,
                    [&] { return static_cast<timsctl::Exit>(tims::chaos::run(settings)); });
}
