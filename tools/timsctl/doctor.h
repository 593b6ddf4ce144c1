// timsctl doctor: observations of this host (files in /proc, limits, the clock), and findings from
// them and from the answers of the router.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/cli/failure.h"
#include "tools/cli/output.h"

namespace timsctl {

struct SocketFile {
  std::uint32_t mode = 0;  // permission bits
  std::string owner;
  std::string group;
};
std::optional<SocketFile> socket_file(const std::string& path);

struct OpenFiles {
  std::uint64_t limit = 0;
  std::optional<std::uint64_t> open;  // empty without permission
};
std::optional<OpenFiles> open_files(std::uint32_t pid);

// The program that listens at a TCP port; "another user's program" if it cannot be determined.
std::optional<std::string> port_owner(std::uint16_t port);

struct SharedMemory {
  bool memfd = false;            // memfd_create works
  std::uint64_t free_bytes = 0;  // of /dev/shm
};
SharedMemory shared_memory();

bool clock_is_synchronised();
bool is_running(std::uint32_t pid);
// The number in a file in /proc or /sys.
std::optional<std::uint64_t> number_in(const std::string& path);

// Findings from the observations. Pure.

struct Observations {
  std::string where;    // the router that was asked
  bool local = true;    // the router is on this host
  std::string version;  // of timsctl
  std::optional<Failure> unreachable{};
  json::object status{};
  json::array mailboxes{};
  json::array clients{};
  json::object stats{};
  json::array links{};
  std::vector<std::string> dead_owners{};  // "Ladar(3/0) of laser (pid 811)"
  std::vector<std::string> in_error{};     // components: "Ladar(3/0)"
  std::size_t components = 0;              // number of components that were asked
  std::optional<double> clock_difference_s{};

  // Observations of this host; only for a local router.
  std::optional<SocketFile> socket{};
  std::optional<OpenFiles> files{};
  std::optional<std::string> tcp_port_owner{};  // owner of port 2000 if no router answers
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

// Adds the hint of the catalogue to a warning or failure without a hint.
Finding make_finding(std::string id, Level level, std::string text, std::string hint = {});

std::vector<Finding> judge(const Observations& observed);
// The receivers (clients, links, mailboxes) with undelivered messages, in descending order: "12 to
// camera, 3 in the mailbox Ladar(3/0)". Empty: no messages were lost.
inline constexpr std::size_t kReceiversShown = 5;
std::string lost_to(std::span<const json::value> clients, std::span<const json::value> mailboxes);
// Findings about links to other routers.
std::vector<Finding> judge_links(const Observations& observed);
// What somebody has injected into the link of this item of tims/link/1 (`timsctl sim fault
// --link`): "10% lost, 20.00ms late"; empty: nothing.
std::string injected_faults(const json::object& link);
std::string_view name(Level level);

}  // namespace timsctl
