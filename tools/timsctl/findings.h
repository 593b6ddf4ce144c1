// What the doctor concludes from what it has seen. Pure.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/host_facts.h"
#include "tools/timsctl/json.h"

namespace timsctl {

struct Facts {
  std::string where;    // the router that was asked
  bool local = true;    // it is on this host
  std::string version;  // of timsctl
  std::optional<Failure> unreachable{};
  json::object status{};
  json::array mailboxes{};
  json::array clients{};
  json::object stats{};
  json::array links{};
  std::vector<std::string> dead_owners{};  // "Ladar(3/0) of laser (pid 811)"
  std::optional<double> clock_difference_s{};

  // Of this host; with a local router only.
  std::optional<SocketFile> socket{};
  std::optional<OpenFiles> files{};
  std::optional<std::string> tcp_port_owner{};  // of port 2000, when no router answers
  std::optional<SharedMemory> memory{};
  bool clock_synchronised = true;
  std::optional<std::uint64_t> receive_buffer_max{};  // net.core.rmem_max
};

enum class Level { kOk, kInfo, kWarning, kFailure };

struct Finding {
  std::string id;
  Level level = Level::kOk;
  std::string text;
  std::string hint;
};

// With the hint of the catalogue when it is bad and has none of its own.
Finding make_finding(std::string id, Level level, std::string text, std::string hint = {});

std::vector<Finding> judge(const Facts& facts);
// Of the clients (links, too) and mailboxes of a router: whom messages have not reached, those with
// most of them first: "12 to camera, 3 in the mailbox Ladar(3/0)". Empty: none were lost.
inline constexpr std::size_t kReceiversShown = 5;
std::string lost_to(std::span<const json::value> clients, std::span<const json::value> mailboxes);
// Those about links to other routers.
std::vector<Finding> judge_links(const Facts& facts);
std::string_view name(Level level);

}  // namespace timsctl
