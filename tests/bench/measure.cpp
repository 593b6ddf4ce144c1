#include <thread>

#include "libtims/os/clock.h"
#include "tests/bench/crew.h"
#include "tests/bench/experiment.h"
#include "tests/bench/failover.h"
#include "tests/bench/measure_links.h"

namespace tims::bench {
namespace {

// In addition to the measured time: for start, connecting and exit.
constexpr Duration kMeasurePatience = std::chrono::seconds(30);

Duration length_of(const Experiment& experiment, const Setting& setting) {
  const bool single = experiment.shape == Shape::kPulse || experiment.shape == Shape::kScan ||
                      experiment.shape == Shape::kClock;
  if (single) return setting.link;
  return experiment.shape == Shape::kRoundTrip ? setting.round_trip : setting.stream;
}

Plan plan_of(const Experiment& experiment, const Setting& setting) {
  Plan plan;
  plan.link = experiment.link;
  plan.payload = experiment.payload;
  plan.window = window_of(experiment.payload);
  plan.subscribers = experiment.subscribers;
  plan.count = experiment.count;
  plan.every = experiment.every;
  plan.seconds = length_of(experiment, setting);
  return plan;
}

Plan with_role(Plan plan, const char* role) {
  plan.role = role;
  return plan;
}

// The bulk stream runs before the first pulse.
std::vector<Plan> pulse_roles(Plan plan, const Experiment& experiment) {
  Plan bulk = plan;
  plan.priority = experiment.priority;
  if (experiment.flood > 0) {
    Plan flood = with_role(plan, "flood");
    flood.count = experiment.flood;
    return {with_role(plan, "gauge"), flood, with_role(plan, "pulse")};
  }
  if (experiment.bulk == 0) return {with_role(plan, "gauge"), with_role(plan, "pulse")};
  bulk.pair = 1;
  bulk.priority = experiment.bulk_priority;
  bulk.payload = experiment.bulk;
  bulk.window = window_of(experiment.bulk);
  return {with_role(plan, "gauge"), with_role(bulk, "sink"), with_role(bulk, "source"),
          with_role(plan, "pulse")};
}

// The scanner exits after enough scans, and then its listeners do.
std::vector<Plan> scan_roles(Plan plan, std::uint32_t listeners) {
  std::vector<Plan> roles{with_role(plan, "scanner")};
  for (plan.index = 0; plan.index < listeners; ++plan.index)
    roles.push_back(with_role(plan, "listener"));
  return roles;
}

std::vector<Plan> clock_roles(const Plan& plan) {
  Plan busy = with_role(plan, "burn");
  busy.link = busy.role;
  std::vector<Plan> roles(std::thread::hardware_concurrency(), busy);
  roles.push_back(with_role(plan, plan.link.c_str()));
  return roles;
}

// Receivers start first, so that senders find them.
std::vector<Plan> roles_of(const Experiment& experiment, const Setting& setting) {
  Plan plan = plan_of(experiment, setting);
  if (experiment.shape == Shape::kAlone) {
    // "ROLE:LINK", or one name for both.
    const std::size_t colon = experiment.link.find(':');
    plan.role = experiment.link.substr(0, colon);
    if (colon != std::string::npos) plan.link = experiment.link.substr(colon + 1);
    return {plan};
  }
  if (experiment.shape == Shape::kPulse) return pulse_roles(plan, experiment);
  if (experiment.shape == Shape::kScan) return scan_roles(plan, experiment.subscribers);
  if (experiment.shape == Shape::kClock) return clock_roles(plan);
  const bool stream = experiment.shape == Shape::kStream;
  std::vector<Plan> receivers;
  std::vector<Plan> senders;
  for (plan.pair = 0; plan.pair < experiment.pairs; ++plan.pair) {
    plan.role = stream ? "sink" : "echo";
    for (plan.index = 0; plan.index < experiment.subscribers; ++plan.index)
      receivers.push_back(plan);
    plan.index = 0;
    plan.role = stream ? "source" : "ping";
    senders.push_back(plan);
  }
  receivers.insert(receivers.end(), senders.begin(), senders.end());
  return receivers;
}

// Five seconds without requests to the router.
Result<Metrics> measure_idle(const Crew& crew) {
  constexpr Duration kSettle = std::chrono::milliseconds(300);
  constexpr Duration kIdle = std::chrono::seconds(5);
  std::this_thread::sleep_for(kSettle);
  const Usage before = usage_of(crew.middle().first());
  std::this_thread::sleep_for(kIdle);
  const Usage spent = usage_of(crew.middle().first()) - before;
  return Metrics{{"cpu_ms_in_5s", spent.cpu_s * 1e3},
                 {"wakeups_in_5s", spent.sleeps},
                 {"rss_mb", resident_mb(crew.middle().first())}};
}

}  // namespace

Result<Metrics> measure(const Experiment& experiment, const Setting& setting) {
  if (experiment.shape == Shape::kConvergence) return measure_convergence(experiment, setting);
  if (experiment.shape == Shape::kFleetStart) return measure_fleet_start(experiment, setting);
  Crew crew(setting, experiment);
  if (auto started = crew.start_middle(); !started) return started.error();
  if (experiment.shape == Shape::kIdle) return measure_idle(crew);
  if (experiment.shape == Shape::kIdleLink) return measure_idle_link(crew, setting);
  if (experiment.shape == Shape::kFleetJoin) return measure_fleet_join(crew, setting);
  if (experiment.shape == Shape::kFailover) return measure_failover(crew);
  if (experiment.shape == Shape::kLinkDeath) return measure_link_death(crew);
  for (const Plan& plan : roles_of(experiment, setting)) {
    if (auto started = crew.start(plan); !started) return started.error();
  }
  auto results = crew.wait(length_of(experiment, setting) + kMeasurePatience);
  if (!results) return results.error();
  Metrics joined = join(*results, experiment.subscribers, experiment.pairs);
  if (experiment.shape == Shape::kPulse && experiment.between == Between::kTwoRouters)
    joined["base_rss_mb"] = resident_mb(crew.middle().first());
  // Costs per million of the few large messages during a pulse are not meaningful.
  if (experiment.shape == Shape::kPulse)
    for (const char* cost : {"cpu_s", "sleeps_per_million"}) joined.erase(cost);
  return joined;
}

}  // namespace tims::bench
