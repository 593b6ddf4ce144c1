// What must hold over all hosts of a change, and what the links between them have to carry. Pure.
//
// The tree of routers is found from their files: a router leads to the one whose udp.listen its
// super link names; a link to = "auto", or to a name that is in no file, to the router one role
// above it.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "router/config/config.h"
#include "tools/configuration/robot_check.h"

namespace timsctl::configuration {

struct FleetHost {
  std::string name{};
  std::optional<tims::config::Config> router{};  // empty: its file has errors
  std::vector<base::TextFile> robots{};
};

// Who uses whose data.
struct Edge {
  Instance from{};
  std::string to{};  // "Ladar(1/0)"
  std::string host{};
  std::string to_host{};      // empty: no host has it
  std::string parameter{};    // that names the instance
  double period_ms = 0;       // 0: unknown
  std::size_t bytes_max = 0;  // of one message, header included; 0: unknown
  std::size_t message_class = 0;
};

// One direction of a link, at the host that sends.
struct LinkBudget {
  std::string host{};
  std::string other{};     // the name of the router at the other end
  std::uint64_t rate = 0;  // bytes a second; 0: no limit
  int reserve_percent = 0;
  std::array<double, tims::core::kClasses> worst{};  // bytes a second by class
  std::optional<double> measured{};                  // all datagrams
  std::array<double, tims::core::kClasses>
      measured_by_class{};  // messages; without meaning unless measured

  [[nodiscard]] double worst_sum() const;
  // Of what may be used; classes below that of the reserve may use less. 0 without a limit.
  [[nodiscard]] double share(double lower, double all) const;
  [[nodiscard]] double worst_share() const;
  [[nodiscard]] double measured_share() const;
  [[nodiscard]] std::string_view level() const;  // "ok", "yellow", "red"
};

struct FleetReport {
  std::vector<Finding> findings;
  std::vector<std::string> order;  // in which hosts are changed: leaves first
  std::vector<Edge> edges;
  std::vector<LinkBudget> links;
};

FleetReport check_fleet(const std::vector<FleetHost>& hosts, const Describe& describe);

}  // namespace timsctl::configuration
