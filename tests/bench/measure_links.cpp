#include "tests/bench/measure_links.h"

#include <csignal>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <unistd.h>

#include "libtims/os/clock.h"
#include "tests/bench/admin.h"
#include "tests/bench/fleet.h"
#include "tests/bench/launch.h"
#include "tests/bench/router_command.h"

namespace tims::bench {
namespace {

using Side = TwoHosts::Side;

double seconds_since(Time start) {
  return std::chrono::duration<double>(os::now() - start).count();
}

Result<std::array<double, 2>> received(const TwoHosts& hosts) {
  const auto base = hosts.received(Side::kBase);
  if (!base) return base.error();
  const auto robot = hosts.received(Side::kRobot);
  if (!robot) return robot.error();
  return std::array{*base, *robot};
}

// Polls until look() is true.
template <typename Look>
Result<void> wait_until(Look look, const char* what) {
  constexpr Duration kPatience = std::chrono::seconds(30);
  constexpr Duration kLookEvery = std::chrono::milliseconds(2);
  for (const Time give_up = os::now() + kPatience; os::now() < give_up;) {
    const Result<bool> there = look();
    if (!there) return there.error();
    if (*there) return {};
    std::this_thread::sleep_for(kLookEvery);
  }
  return Error(Errc::kTimeout, what);
}

// The router above a fleet. It uses the same address after a restart.
class Base {
 public:
  // `keys`: the folder of its keys; empty: none.
  Base(const Setting& setting, std::string keys)
      : router_(setting.router), socket_(setting.folder + "/base.sock"), keys_(std::move(keys)) {}

  Result<void> start() {
    auto process =
        launch(router_command(router_, socket_,
                              {"router.role=top", "link=kind=sub,system=*", "tcp.listen=off",
                               "udp.listen=" + udp_, "security.keys=" + keys_}),
               false);
    if (!process) return process.error();
    process_ = std::move(*process);
    const auto line = process_->wait_for_line("listening udp", kStartLimit);
    if (!line) return line.error();
    udp_ = line->substr(line->rfind(' ') + 1);
    return {};
  }
  void kill() { (void)process_->stop(SIGKILL); }

  [[nodiscard]] const std::string& udp() const { return udp_; }
  [[nodiscard]] const std::string& socket() const { return socket_; }

 private:
  std::string router_;
  std::string socket_;
  std::string keys_;
  std::string udp_ = "127.0.0.1:0";
  std::optional<test::ChildProcess> process_;
};

// Routers on this host that connect by name: a base and `robots` robots.
class NamedFleet {
 public:
  NamedFleet(const Setting& setting, std::uint64_t robots)
      : router_(setting.router), folder_(setting.folder), robots_(robots) {}

  // Starts all at once. Returns the seconds until the base knows all robots.
  Result<double> start() {
    const Time started = os::now();
    for (std::uint64_t system = 0; system <= robots_; ++system) {
      auto process = launch(command(system), false);
      if (!process) return process.error();
      processes_.push_back(std::move(*process));
    }
    if (const auto line = base().wait_for_line("listening unix", kStartLimit); !line)
      return line.error();
    auto admin = Admin::open(socket(0));
    if (!admin) return admin.error();
    for (std::uint64_t system = 1; system <= robots_; ++system) {
      const Address robot =
          Address::of({.system = static_cast<std::uint32_t>(system), .instance = 1});
      const auto known =
          wait_until([&] { return admin->knows(robot); }, "the base does not learn of all robots");
      if (!known) return known.error();
    }
    return seconds_since(started);
  }
  // As in a power cut.
  void kill() {
    for (auto& process : processes_) process.signal(SIGKILL);
    for (auto& process : processes_) (void)process.wait();
    processes_.clear();
  }

  [[nodiscard]] test::ChildProcess& base() { return processes_.front(); }
  [[nodiscard]] test::ChildProcess& robot() { return processes_.back(); }

 private:
  [[nodiscard]] std::string socket(std::uint64_t system) const {
    return folder_ + "/fleet" + std::to_string(system) + ".sock";
  }
  [[nodiscard]] std::vector<std::string> command(std::uint64_t system) const {
    const bool top = system == 0;
    return router_command(
        router_, socket(system),
        {top ? "router.role=top" : "router.role=system", "router.id=1",
         "router.system=" + std::to_string(system), "fleet.name=bench" + std::to_string(::getpid()),
         top ? "link=kind=sub,system=*" : "link=kind=super,to=auto", "tcp.listen=off",
         "udp.listen=127.0.0.1:0"});
  }

  std::string router_;
  std::string folder_;
  std::uint64_t robots_;
  std::vector<test::ChildProcess> processes_;  // the base is first
};

}  // namespace

Result<Metrics> measure_idle_link(const Crew& crew, const Setting& setting) {
  constexpr double kShown = 5;
  constexpr Duration kSettle = std::chrono::seconds(2);
  std::this_thread::sleep_for(kSettle);
  const pid_t router = crew.middle().last();
  const Usage usage = usage_of(router);
  const Time start = os::now();
  const auto before = received(crew.middle().hosts());
  if (!before) return before.error();
  std::this_thread::sleep_for(setting.link);
  const auto after = received(crew.middle().hosts());
  if (!after) return after.error();
  const double seconds = seconds_since(start);
  const Usage spent = usage_of(router) - usage;
  return Metrics{{"up_bytes_per_s", ((*after)[0] - (*before)[0]) / seconds},
                 {"down_bytes_per_s", ((*after)[1] - (*before)[1]) / seconds},
                 {"cpu_ms_in_5s", spent.cpu_s * 1e3 * kShown / seconds},
                 {"rss_mb", resident_mb(router)}};
}

Result<Metrics> measure_link_death(const Crew& crew) {
  auto admin = Admin::open(crew.middle().of_receivers().socket);
  if (!admin) return admin.error();
  const Address robot = Address::of({.system = 1, .instance = 1});
  const auto known = [&] { return admin->knows(robot); };
  const auto gone = [&]() -> Result<bool> {
    const auto still = known();
    return still ? Result<bool>(!*still) : still.error();
  };
  if (auto there = wait_until(known, "the base does not learn of the robot"); !there)
    return there.error();
  const Time start = os::now();
  if (auto cut = crew.middle().hosts().cut(); !cut) return cut.error();
  if (auto noticed = wait_until(gone, "the base does not detect the cut"); !noticed)
    return noticed.error();
  return Metrics{{"death_s", seconds_since(start)}};
}

Result<Metrics> measure_fleet_join(const Crew& crew, const Setting& setting) {
  auto admin = Admin::open(crew.middle().of_receivers().socket);
  if (!admin) return admin.error();
  const Address robot = Address::of({.system = 1, .instance = 1});
  if (auto there =
          wait_until([&] { return admin->knows(robot); }, "the base does not learn of the robot");
      !there)
    return there.error();
  const double joined = seconds_since(crew.middle().second_started());
  auto idle = measure_idle_link(crew, setting);
  if (idle) (*idle)["join_s"] = joined;
  return idle;
}

Result<Metrics> measure_fleet_start(const Experiment& experiment, const Setting& setting) {
  constexpr double kShown = 5;
  constexpr Duration kSettle = std::chrono::seconds(2);
  NamedFleet fleet(setting, experiment.count);
  const auto first = fleet.start();
  if (!first) return first.error();
  fleet.kill();
  const auto again = fleet.start();
  if (!again) return again.error();
  std::this_thread::sleep_for(kSettle);
  const Usage base = usage_of(fleet.base().pid());
  const Usage robot = usage_of(fleet.robot().pid());
  const Time start = os::now();
  std::this_thread::sleep_for(setting.link);
  const double share = kShown / seconds_since(start);
  return Metrics{{"join_s", *first},
                 {"join_again_s", *again},
                 {"cpu_ms_in_5s", (usage_of(fleet.robot().pid()) - robot).cpu_s * 1e3 * share},
                 {"base_cpu_ms_in_5s", (usage_of(fleet.base().pid()) - base).cpu_s * 1e3 * share},
                 {"rss_mb", resident_mb(fleet.robot().pid())},
                 {"base_rss_mb", resident_mb(fleet.base().pid())}};
}

namespace {

// Makes keys for a base and its robots; the folder of the base's. Without a folder there are none.
Result<std::string> keys_for(const std::string& folder, std::uint64_t robots) {
  if (folder.empty()) return std::string();
  const auto keys = FleetKeys::make(folder);
  if (!keys) return keys.error();
  if (auto made = keys->add(security::MemberRole::kTop, 0, 1); !made) return made.error();
  if (auto made = make_keys_of_fleet(*keys, robots); !made) return made.error();
  return keys->folder_of(security::MemberRole::kTop, 0, 1);
}

}  // namespace

Result<Metrics> measure_convergence(const Experiment& experiment, const Setting& setting) {
  const std::uint64_t all =
      experiment.count * (kMailboxesOfRobot + 1);  // including the robots' routers
  const auto wait_for_all = [all](const Base& base) -> Result<void> {
    auto admin = Admin::open(base.socket());
    if (!admin) return admin.error();
    return wait_until(
        [&]() -> Result<bool> {
          const auto known = admin->mailboxes();
          return known ? Result<bool>(*known >= all) : known.error();
        },
        "the base does not learn of all mailboxes");
  };
  const std::string folder = experiment.sealed ? setting.folder + "/keys" : std::string();
  auto keys = keys_for(folder, experiment.count);
  if (!keys) return keys.error();
  Base base(setting, *keys);
  if (auto started = base.start(); !started) return started.error();
  Plan plan;
  plan.folder = folder;
  plan.role = plan.link = "fleet";
  plan.endpoint = base.udp();
  plan.count = experiment.count;
  std::vector<std::string> command = to_arguments(plan);
  command.insert(command.begin(), setting.program);
  // Robots with keys have to compute as much as the base, and must not take its CPU.
  const auto fleet = launch(std::move(command), experiment.sealed);
  if (!fleet) return fleet.error();
  if (auto known = wait_for_all(base); !known) return known.error();
  base.kill();
  const Time start = os::now();
  if (auto started = base.start(); !started) return started.error();
  if (auto known = wait_for_all(base); !known) return known.error();
  return Metrics{{"known_again_s", seconds_since(start)}};
}

}  // namespace tims::bench
