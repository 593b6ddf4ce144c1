// The part between the roles of a measurement: nothing, a router or a relay; with two hosts one on
// each, and the cable between them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/bench/experiment.h"
#include "tests/bench/fleet_keys.h"
#include "tests/bench/usage.h"
#include "tests/support/child_process.h"

namespace tims::bench {

// A host as seen by the roles.
struct Place {
  std::vector<std::string> enter{};  // prefix of commands that run there
  std::string address{};             // if there are two hosts
  std::string socket{};              // of its router
  std::string endpoint{};            // of its router or relay, or of the other end
};

class Middle {
 public:
  // `folder`: for sockets.
  Middle(const Setting& setting, const Experiment& experiment, std::string folder);
  Middle(const Middle&) = delete;
  Middle& operator=(const Middle&) = delete;

  // Returns when all are listening and the routers are connected.
  Result<void> start();

  [[nodiscard]] const Place& of_receivers() const { return places_.front(); }  // the base
  [[nodiscard]] const Place& of_senders() const { return places_.back(); }     // the robot
  [[nodiscard]] const TwoHosts& hosts() const { return *hosts_; }

  [[nodiscard]] bool empty() const { return processes_.empty(); }
  [[nodiscard]] Time second_started() const { return second_started_; }
  [[nodiscard]] pid_t first() const { return processes_.front().pid(); }
  [[nodiscard]] pid_t last() const { return processes_.back().pid(); }
  [[nodiscard]] Usage usage() const;  // of all processes
  [[nodiscard]] std::string output() const;

 private:
  using Side = TwoHosts::Side;

  Result<std::string> add(std::vector<std::string> command, const char* awaited);
  Result<void> start_here(std::vector<std::string> command);
  Result<void> start_on_two_hosts();
  Result<void> start_routers();
  // By the name of their fleet; else by address.
  [[nodiscard]] bool connects_by_name() const {
    return experiment_.paths.find("dds") != std::string::npos;
  }
  [[nodiscard]] std::string link(const char* kind, const std::string& to) const;
  Result<void> make_keys();
  [[nodiscard]] std::string trust(Side side) const;
  Result<void> add_router(Side side, const char* awaited, std::vector<std::string> settings);
  [[nodiscard]] Result<void> delay_datagrams() const;
  Result<void> start_relays();

  const Setting& setting_;
  const Experiment& experiment_;
  std::string folder_;
  std::unique_ptr<TwoHosts> hosts_;
  std::vector<Place> places_;  // one, or base and robot
  std::optional<FleetKeys> keys_;
  std::vector<test::ChildProcess> processes_;
  Time second_started_{};  // start of the second router, which connects
};

}  // namespace tims::bench
