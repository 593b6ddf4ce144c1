// timsctl doctor: what this host says about itself (files under /proc, limits, the clock), and what
// the doctor concludes from that and from the router's answers.
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
  std::optional<std::uint64_t> open;  // nothing when we may not look
};
std::optional<OpenFiles> open_files(std::uint32_t pid);

// Who listens at a TCP port; "another user's program" when it cannot be told.
std::optional<std::string> port_owner(std::uint16_t port);

struct SharedMemory {
  bool memfd = false;            // can be made
  std::uint64_t free_bytes = 0;  // of /dev/shm
};
SharedMemory shared_memory();

bool clock_is_synchronised();
bool is_running(std::uint32_t pid);
// A number under /proc or /sys.
std::optional<std::uint64_t> number_in(const std::string& path);

// What the doctor concludes from what it has seen. Pure.

struct Observations {
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

std::vector<Finding> judge(const Observations& observed);
// Of the clients (links, too) and mailboxes of a router: whom messages have not reached, those with
// most of them first: "12 to camera, 3 in the mailbox Ladar(3/0)". Empty: none were lost.
inline constexpr std::size_t kReceiversShown = 5;
std::string lost_to(std::span<const json::value> clients, std::span<const json::value> mailboxes);
// Those about links to other routers.
std::vector<Finding> judge_links(const Observations& observed);
std::string_view name(Level level);

}  // namespace timsctl
