// A random network determined by a seed: a tree of routers with traffic and faults; then the faults
// end, and the invariants are checked.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/sim/findings.h"
#include "tests/sim/ledger.h"
#include "tests/sim/simulated_network.h"
#include "tests/sim/swarm_plan.h"

namespace tims::sim {

struct SwarmTotals {
  std::uint64_t messages = 0;
  std::uint64_t arrived = 0;
  std::uint64_t lost = 0;  // and counted as lost by a router
  std::uint64_t datagrams = 0;
};

class Swarm {
 public:
  Swarm(std::uint64_t seed, bool verbose);

  // Runs the simulation and returns the failures, one text each; empty: success.
  std::vector<std::string> run();
  [[nodiscard]] const SwarmTotals& totals() const { return totals_; }

 private:
  struct Client {
    std::size_t node = 0;
    std::string name{};
    std::vector<Address> mailboxes{};
    core::ClientId id{};  // kNoClient: not connected
  };

  // swarm.cpp: the events of the run
  void build();
  void start(std::size_t i);
  void attach(Client& client);
  void plan_trouble(Duration span);
  void plan_crash(Time when);
  void plan_partition(Time when, Duration span);
  void plan_half_cuts(Duration span);
  void cut(std::size_t a, std::size_t b, link::PathKind kind, bool one_way, Duration length);
  void set_faults(const std::string& from, const std::string& to);
  void plan_move(Time when);
  void plan_churn(Time when);
  void plan_faults(Time when);
  void plan_traffic(Duration span, std::uint64_t messages);
  void send_something();
  void send(Client& from, Address src, Client& to, Address dest, Header header, std::size_t size);
  void heal();

  // swarm_checks.cpp: the invariants
  void check_tables();
  void check_table(std::size_t i);
  void check_routes();
  [[nodiscard]] std::size_t waiting_from(std::size_t first) const;
  void check_losses();
  void check_answers();
  void check_idle();
  [[nodiscard]] std::string idle_problem();
  void check_memory();
  void check_events();

  void fail(const std::string& what) { findings_.fail(what); }
  void print(const std::string& what) const { findings_.print(what); }
  [[nodiscard]] Time now() const { return network_.now(); }
  [[nodiscard]] Node& node(std::size_t i) { return *network_.nodes()[i]; }
  Duration within(Duration span) { return network_.random(span); }

  const std::uint64_t seed_;
  SimulatedNetwork network_;
  Findings findings_;
  Plan plan_;
  std::vector<Client> clients_;
  Ledger ledger_;
  std::vector<bool> crashed_;
  SwarmTotals totals_;
  std::size_t moves_ = 0;
  bool healed_ = false;
};

}  // namespace tims::sim
