// Routers that are restarted for an upgrade, again and again at moments that a seed determines:
// also before their programs are back, before a sealed link has its new keys, and both ends at
// once.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/sim/findings.h"
#include "tests/sim/simulated_network.h"

namespace tims::sim {

class RestartStorm {
 public:
  RestartStorm(std::uint64_t seed, bool verbose);

  // Runs the simulation and returns the failures, one text each; empty: success.
  std::vector<std::string> run();
  [[nodiscard]] std::size_t restarts() const { return restarts_; }
  [[nodiscard]] std::uint64_t messages() const { return sent_; }

 private:
  struct Host {
    Node* node = nullptr;
    std::vector<Address> mailboxes{};        // one program each
    std::vector<core::ClientId> programs{};  // kNoClient: not connected
    std::vector<std::byte> left{};
    std::uint64_t run = 0;
  };
  // What a program sends to another one.
  struct Flow {
    std::size_t from = 0;  // host
    std::size_t to = 0;    // host
    std::size_t program = 0;
    std::uint8_t priority = 0;
    std::uint32_t sent = 0;
    std::uint32_t newest = 0;  // number of the newest one that has arrived
    std::uint32_t arrived = 0;
  };

  void build();
  void begin_flows();
  void plan_storm();
  void plan_restart(std::size_t host, Time when);
  void restart(std::size_t host);
  void start(std::size_t host);
  void attach(std::size_t host, std::size_t program);
  void tick();
  void send(Flow& flow);
  void take(std::size_t host, const Arrival& arrival);
  void check_links();
  void check_messages();

  void fail(const std::string& what) { findings_.fail(what); }
  void print(const std::string& what) const { findings_.print(what); }
  [[nodiscard]] Time now() const { return network_.now(); }
  Duration between(Duration least, Duration most) { return least + network_.random(most - least); }

  const std::uint64_t seed_;
  SimulatedNetwork network_;
  Findings findings_;
  bool loses_ = false;  // datagrams
  Duration pause_{};    // between two restarts of a router, about
  std::vector<Host> hosts_;
  std::vector<Flow> flows_;
  Time storm_until_{};
  std::size_t restarts_ = 0;
  std::uint64_t ticks_ = 0;
  std::uint64_t sent_ = 0;
  std::uint64_t told_ = 0;  // answered with NOT_AVAILABLE
  bool stopped_ = false;
};

}  // namespace tims::sim
