// Common setup of most scenarios: a base above two robots, the first of which has a second host.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/sim/simulated_network.h"

namespace tims::sim {

using namespace std::chrono_literals;

inline constexpr Address kGui{0x00020000};      // at the base
inline constexpr Address kLadar{0x01140000};    // at the robot
inline constexpr Address kCamera{0x01150000};   // at the robot's second host
inline constexpr Address kChassis{0x02110000};  // at the other robot
inline constexpr Duration kKeepAlive = 300ms;

struct Story : SimulatedNetwork {
  // `base_setup`: limits of the base, if it is to have any. `compress`: on all links.
  explicit Story(std::uint64_t seed = 1, NodeSetup base_setup = {},
                 core::Compression compress = core::Compression::kOff, bool sealed = false)
      : SimulatedNetwork(seed) {
    if (sealed) seal_all();
    if (sealed) judge_all();
    const auto links = [compress](std::vector<link::LinkSettings> all) {
      for (link::LinkSettings& one : all) one.packing.compress = compress;
      return all;
    };
    base_setup.name = "base";
    base_setup.role = core::Role::kTop;
    base_setup.links = links({sub_link()});
    base = &add(base_setup);
    robot = &add({.name = "robot",
                  .role = core::Role::kSystem,
                  .system = 1,
                  .links = links({super_link(address_of(0)), sub_link()})});
    host = &add({.name = "host",
                 .role = core::Role::kSubsystem,
                 .system = 1,
                 .id = 2,
                 .links = links({super_link(address_of(1))})});
    other = &add({.name = "other",
                  .role = core::Role::kSystem,
                  .system = 2,
                  .links = links({super_link(address_of(0)), sub_link()})});
    set_faults({.delay = 1ms});
  }
  // Starts all nodes and their clients, and waits until their mailboxes are known.
  void begin() {
    for (const auto& node : nodes()) node->start(now());
    gui = client(*base, kGui);
    ladar = client(*robot, kLadar);
    camera = client(*host, kCamera);
    chassis = client(*other, kChassis);
    EXPECT_TRUE(run_until([&] { return converged(); }, 2s));
  }
  core::ClientId client(Node& node, Address address) {
    const auto id = node.add_client(now(), address.to_string());
    EXPECT_TRUE(node.add_mailbox(now(), id, address));
    return id;
  }
  [[nodiscard]] static bool knows(Node& node, Address address) {
    return node.router().find(address) != nullptr;
  }
  [[nodiscard]] bool converged() const {
    return knows(*base, kLadar) && knows(*base, kCamera) && knows(*base, kChassis) &&
           knows(*robot, kCamera);
  }
  // Sends a command from `from` to `to`; returns whether it arrives.
  bool reaches(Node& from, core::ClientId sender, Address src, Node& to, core::ClientId receiver,
               Address dest, Duration within = 1s) {
    const std::size_t before = to.arrivals(receiver).size();
    from.send(now(), sender, {.type = 3, .priority = 100, .dest = dest, .src = src});
    return run_until([&] { return to.arrivals(receiver).size() > before; }, within);
  }
  bool gui_reaches_camera() { return reaches(*base, gui, kGui, *host, camera, kCamera); }
  [[nodiscard]] static std::size_t not_available(Node& node, core::ClientId client) {
    const auto& all = node.arrivals(client);
    return static_cast<std::size_t>(std::count_if(all.begin(), all.end(), [](const Arrival& a) {
      return a.header.type == type::kNotAvailable;
    }));
  }
  [[nodiscard]] static const core::Event* find_event(const Node& node, core::EventKind kind) {
    for (const core::Event& event : node.events)
      if (event.kind == kind) return &event;
    return nullptr;
  }
  [[nodiscard]] static std::size_t links_up(Node& node) {
    std::size_t up = 0;
    node.links().for_each([&](const link::Link& link) { up += link.is_up() ? 1 : 0; });
    return up;
  }

  Node* base;
  Node* robot;
  Node* host;
  Node* other;
  core::ClientId gui{};
  core::ClientId ladar{};
  core::ClientId camera{};
  core::ClientId chassis{};
};

}  // namespace tims::sim
