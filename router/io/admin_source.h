// What the answers of the admin protocol (ADMIN.md) and the metrics are made from, besides the
// core's reports: values that only the process and its ports have.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/measure.h"
#include "router/config/config.h"
#include "router/config/load.h"
#include "router/core/router.h"
#include "router/io/rights.h"
#include "router/link/fault_injection.h"
#include "router/link/links.h"
#include "shm/receiver.h"
#include "tims/time.h"

namespace tims::io {

// The socket shared by all links.
struct UdpReport {
  std::uint32_t asked_buffer_bytes = 0;  // requested from the system, in each direction
  std::uint32_t receive_buffer_bytes = 0;
  std::uint32_t send_buffer_bytes = 0;
  std::uint64_t dropped_by_kernel = 0;  // datagrams dropped because the buffer was full
  // Datagrams over any path that this router has ignored or refused, of strangers or forged:
  std::uint64_t strange = 0;        // not of this protocol
  std::uint64_t unknown_token = 0;  // of a session that does not exist
  std::uint64_t refused = 0;        // who asked for a link
  link::Handshakes::Counters handshakes{};
};

// The engine that serves all DDS paths.
struct DdsReport {
  std::string state{};    // "up", "starting"
  std::string trouble{};  // the last error or warning it reported
  std::string address{};
  std::uint64_t samples_in = 0;
  std::uint64_t samples_out = 0;
  std::uint64_t datagrams_in = 0;
  std::uint64_t datagrams_out = 0;
  std::uint64_t strange = 0;    // samples not sent by a tims router
  std::uint64_t refused = 0;    // datagrams dropped: no room, or no receiver
  std::uint64_t unmatched = 0;  // datagrams whose receiver did not appear
  std::uint64_t waiting_bytes = 0;
};

// Requests from browsers that were refused, by the rule they violated (http/http_pages.h).
struct HttpRefusals {
  std::uint64_t host = 0;
  std::uint64_t origin = 0;
  std::uint64_t cross_site = 0;
};

// Of security.keys.
struct KeysReport {
  std::string fleet{};
  std::string identity{};  // "system 3, id 1 (robot3)"
  std::string state{};  // of the own certificate: "valid", "ends soon", "expired", "revoked", ...
  std::string ends{};   // RFC 3339
  std::uint64_t list = 0;  // number of the list of the fleet
  std::size_t revoked = 0;
  std::string problem{};  // why the present files cannot be used; the former keys are in force
};

struct ProcessReport {
  std::string name{};     // router.name
  std::string version{};  // of the program
  std::uint32_t pid = 0;
  std::uint32_t uid = 0;    // the user it runs as
  std::uint64_t epoch = 0;  // chosen at random at start
  Duration uptime{};
  std::uint64_t rss_bytes = 0;
  Duration longest_turn{};  // of the event loop
  // Listening addresses; empty when the port is not listening.
  std::string unix_path{};
  std::string tcp{};
  std::string http{};
  std::string udp{};
  std::optional<UdpReport> udp_socket{};
  std::string console{};  // folder; empty when there is none
  HttpRefusals http_refused{};
  bool insecure = false;                // security.insecure
  std::optional<KeysReport> keys{};     // empty: none
  std::vector<std::string> exposed{};   // ports that listen beyond loopback: "tcp", "http", "udp"
  std::vector<std::string> cautions{};  // config::cautions()
};

// State of a mailbox as visible in shared memory.
struct MailboxFill {
  std::uint32_t slots = 0;
  std::uint32_t message_max = 0;  // bytes, header included
  std::uint64_t waiting = 0;
  shm::Counters counts{};
  bool asleep = false;
};

class AdminSource : public core::Interface {
 public:
  [[nodiscard]] virtual const core::Router& router() const = 0;
  [[nodiscard]] virtual ProcessReport process(Time now) const = 0;
  [[nodiscard]] virtual const config::Config& config() const = 0;
  [[nodiscard]] virtual const config::Origins& origins() const = 0;
  // Null when the router has no links.
  [[nodiscard]] virtual const link::Links* links() const { return nullptr; }
  // Empty when this router is not in a fleet.
  [[nodiscard]] virtual std::optional<DdsReport> dds() const { return std::nullopt; }
  // Changes who drives a robot.
  virtual core::LeaseResult change_lease(Time, core::ClientId, core::LeaseVerb,
                                         const core::DrivingLease&) {
    return core::LeaseResult::kNotHeld;
  }
  // Who has proven to be at a TCP or WebSocket connection; null: it had not to.
  [[nodiscard]] virtual const Person* person(core::PortKind, std::uint32_t) const {
    return nullptr;
  }
  // A token for a browser, or the session itself (`bearer`). Empty: this router asks nobody to log
  // in.
  virtual std::optional<std::string> make_login(Time, const Person&, bool /*bearer*/) {
    return std::nullopt;
  }
  // Executes the request; returns false when the link does not exist.
  virtual bool act_on_link(std::string_view, link::Links::Action) { return false; }
  virtual bool inject_faults(std::string_view, const link::Faults&) { return false; }
  // Those in force; null: none.
  [[nodiscard]] virtual const link::Faults* faults_of(const link::Link&) const { return nullptr; }
  virtual void set_static_routes(const std::vector<core::StaticRoute>&) {}
  // The client has changed the router: for the log.
  virtual void changed(Time, core::ClientId, std::string_view /*what*/) {}
  // `handle` of a local mailbox (core::MailboxReport); empty when its fill level is unknown.
  [[nodiscard]] virtual std::optional<MailboxFill> fill(std::uint32_t handle) const = 0;
  // Sums over all mailboxes, including those that no longer exist.
  [[nodiscard]] virtual shm::Counters mailbox_counts() const = 0;
  [[nodiscard]] virtual std::uint64_t queued_bytes(core::PortKind port,
                                                   std::uint32_t token) const = 0;
};

using base::WallTime;

// Two clocks read at the same moment: events carry monotonic time, users expect wall-clock time.
struct Clocks {
  Time now{};
  WallTime wall{};

  [[nodiscard]] WallTime wall_time(Time at) const { return wall - (now - at); }
};

}  // namespace tims::io
