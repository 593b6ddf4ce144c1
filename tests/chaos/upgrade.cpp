// fleet_upgrade: restarts the routers of a base and a robot in turn, under load, as systemd does
// for an upgrade, and counts what is lost and how long a link is silent.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <fmt/core.h>

#include "os/clock.h"
#include "os/shared_memory.h"
#include "router/link/handover.h"
#include "security/keys/authority.h"
#include "tests/support/descriptor_keeper.h"
#include "tests/support/numbered_traffic.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/two_networks.h"
#include "tools/cli/argument_parser.h"
#include "tools/cli/failure.h"

namespace tims::chaos {
namespace {

using namespace std::chrono_literals;
using test::KeptRouter;
using test::NumberedTraffic;
using test::TwoNetworks;

constexpr int kSkipped = 77;
// Messages that arrive between two restarts. A program whose router ends again within half a second
// waits longer each time before it connects again.
constexpr std::uint64_t kBetween = 400;
constexpr Duration kSilenceMax = 300ms;

struct Settings {
  std::uint32_t restarts = 1000;
  std::uint32_t other_layout = 0;  // every so many restarts, the layout is another one
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

// The keys of a fleet of two.
class Keys {
 public:
  Keys() {
    const security::Identity base{.fleet = "storm",
                                  .role = security::MemberRole::kTop,
                                  .system = 0,
                                  .id = 1,
                                  .name = "base",
                                  .rights = {}};
    auto authority = value_of(
        security::Authority::init(security::KeyFolder(folder("base")), "storm", seconds()), "keys");
    if (!authority.issue_own(base, {}, seconds())) throw std::runtime_error("keys of the base");
    const security::Identity robot{.fleet = "storm",
                                   .role = security::MemberRole::kSystem,
                                   .system = 1,
                                   .id = 1,
                                   .name = "robot",
                                   .rights = {}};
    if (!authority.issue_to(security::KeyFolder(folder("robot")), robot, {}, seconds()))
      throw std::runtime_error("keys of the robot");
  }
  [[nodiscard]] std::string folder(const std::string& name) const {
    return (folder_.path() / name).string();
  }

 private:
  static std::int64_t seconds() {
    return std::chrono::duration_cast<std::chrono::seconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
  }
  test::TemporaryFolder folder_;
};

class Storm {
  // In the network of this router.
  template <typename Act>
  auto on(KeptRouter& router, Act act) {
    return &router == &*robot_ ? networks_.on_the_right(act) : act();
  }

 public:
  explicit Storm(const Settings& settings) : settings_(settings) {
    if (settings.sealed) keys_.emplace();
    const std::string left = std::string(TwoNetworks::kLeft) + ":2010";
    base_.emplace(base_folder_.path(),
                  std::vector<std::string>{"router.name=base", "router.role=top", "router.system=0",
                                           "router.id=1", "udp.listen=" + left,
                                           "link=kind=sub,system=*", security_of("base")});
    robot_.emplace(robot_folder_.path(),
                   std::vector<std::string>{
                       "router.name=robot", "router.role=system", "router.system=1", "router.id=1",
                       std::string("udp.listen=") + TwoNetworks::kRight + ":2010",
                       "link=kind=super,to=" + left, security_of("robot")});
  }

  // Whether all of it was as promised.
  bool run() {
    check(base_->start(), "base");
    check(on(*robot_, [&] { return robot_->start(); }), "robot");
    begin_traffic();
    wait_for_more();
    for (auto& traffic : traffic_) (void)traffic->take_silence();
    for (std::uint32_t n = 1; n <= settings_.restarts; ++n) {
      const bool other = settings_.other_layout > 0 && n % settings_.other_layout == 0;
      restart(n % 2 == 0 ? *base_ : *robot_, other);
      wait_for_more();
      note_silence(other);
      if (n % 100 == 0) report(n);
    }
    for (auto& traffic : traffic_) traffic->end(10s);
    report(settings_.restarts);
    return is_good();
  }

 private:
  [[nodiscard]] std::string security_of(const std::string& name) const {
    return keys_ ? "security.keys=" + keys_->folder(name) : "security.insecure=true";
  }
  void begin_traffic() {
    const auto begin = [&](const NumberedTraffic::End& from, const NumberedTraffic::End& to) {
      traffic_.push_back(value_of(NumberedTraffic::begin(from, to, 1ms), "programs"));
    };
    begin({robot_->socket_path(), Address(0x01140000)},
          {base_->socket_path(), Address(0x00020000)});
    begin({base_->socket_path(), Address(0x00030000)},
          {robot_->socket_path(), Address(0x01150000)});
  }
  void restart(KeptRouter& router, bool other_layout) {
    if (!other_layout)
      return check(on(router, [&] { return router.restart(SIGUSR2); }), "a restart");
    (void)value_of(router.keeper().end(router.process(), SIGUSR2), "the end of a router");
    os::File& left = router.keeper().kept().at("links");
    auto bytes = value_of(os::read_memfd(left, link::Handover::kBytesMax), "the links");
    bytes.at(8) = static_cast<std::byte>(link::Handover::kVersion + 1);
    const auto newer = value_of(os::make_memfd("links", bytes), "the links");
    left = os::File(::fcntl(newer.get(), F_DUPFD, 200));
    check(on(router, [&] { return router.start(); }), "a plain restart");
  }
  void wait_for_more() {
    const Time deadline = os::deadline_after(10s);
    for (auto& traffic : traffic_) {
      const std::uint64_t before = traffic->arrived();
      while (traffic->arrived() < before + kBetween) {
        if (os::now() >= deadline)
          throw std::runtime_error("nothing arrives any more\n" + base_->process().output() +
                                   robot_->process().output());
        std::this_thread::sleep_for(1ms);
      }
    }
  }
  // One that begins anew is silent for longer, and may lose what is on its way.
  void note_silence(bool other_layout) {
    for (auto& traffic : traffic_) {
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
    fmt::print(
        "{} restarts: {} and {} messages, {} and {} arrived, {} wrong, {} refused without router; "
        "silence median {:.0f} ms, 99 % {:.0f} ms, longest {:.0f} ms\n",
        restarts, traffic_[0]->sent(), traffic_[1]->sent(), traffic_[0]->arrived(),
        traffic_[1]->arrived(), traffic_[0]->wrong() + traffic_[1]->wrong(),
        traffic_[0]->refused() + traffic_[1]->refused(), ms(0.5), ms(0.99), ms(1));
    std::fflush(stdout);
  }
  [[nodiscard]] bool is_good() const {
    const bool plain = settings_.other_layout > 0;
    return std::ranges::all_of(traffic_,
                               [&](const auto& traffic) {
                                 return traffic->arrived() == traffic->sent() &&
                                        (plain || traffic->wrong() == 0);
                               }) &&
           silences_.back() <= kSilenceMax;
  }

  Settings settings_;
  std::optional<Keys> keys_;
  test::TemporaryFolder base_folder_;
  test::TemporaryFolder robot_folder_;
  TwoNetworks networks_ = value_of(TwoNetworks::enter(), "two hosts");
  std::optional<KeptRouter> base_;
  std::optional<KeptRouter> robot_;
  std::vector<std::unique_ptr<NumberedTraffic>> traffic_;
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
  parser.flag("--sealed", settings.sealed, "with keys");
  return parser.run(argc, argv,
                    [&] { return static_cast<timsctl::Exit>(tims::chaos::run(settings)); });
}
