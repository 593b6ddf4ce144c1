// The configuration of the router, as plain values. Defaults, limits, units and help of every
// value are in one table (options.cpp); a Config returned by load() satisfies them.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "router/core/types.h"
#include "router/policy/policy.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::config {

// A listening address. The host is always numeric ("127.0.0.1", "::1"): nothing is resolved.
struct Endpoint {
  std::string host;
  std::uint16_t port = 0;  // 0: the system chooses one

  [[nodiscard]] bool loopback() const;                          // 127.0.0.0/8, ::1
  [[nodiscard]] std::string to_string() const;                  // "127.0.0.1:2000", "[::1]:2000"
  static std::optional<Endpoint> parse(std::string_view text);  // also "localhost:2000"
  bool operator==(const Endpoint&) const = default;
};

using core::Compression;
using core::LinkKind;
using core::PathKind;
using core::PriorityClasses;
using core::Role;

// Whether this router was built with DDS.
inline constexpr bool kHasDds = TIMS_WITH_DDS != 0;

inline constexpr std::uint16_t kLinkPort = 2010;  // UDP, between routers

// The destination of a link. The host may be a name: the connecting side resolves it repeatedly.
struct Destination {
  std::string host;                // numeric, or a name in lower case; IPv6 without brackets
  std::uint16_t port = kLinkPort;  // 0: found in the fleet; then the host is "auto"

  [[nodiscard]] bool loopback() const;          // false for names: they are not resolved here
  [[nodiscard]] std::string to_string() const;  // "robot1:2010", "[::1]:2010"
  static std::optional<Destination> parse(std::string_view text);  // the port is optional
  bool operator==(const Destination&) const = default;
};

enum class LogLevel : std::uint8_t { kError, kWarning, kInfo, kDebug };

using LinkPaths = std::vector<PathKind>;  // in order of preference, without duplicates

// A relation to another router, or to a group of routers that may connect: [[link]].
struct Link {
  LinkKind kind = LinkKind::kSuper;
  std::string host;                                    // empty: this side accepts
  std::uint16_t port = 0;                              // 0: this side accepts
  std::optional<std::uint16_t> system;                 // the system this side accepts; empty: any
  LinkPaths paths{PathKind::kUdp};                     // at least one
  std::string name;                                    // for display; may be empty
  std::uint32_t mailboxes = 65536;                     // maximum the other side may announce
  Duration interval = std::chrono::milliseconds(300);  // keep-alive
  std::uint64_t rate = 0;                              // maximum bytes per second; 0: no limit
  std::uint8_t reserve = 10;                           // percentage of the rate, for upper classes
  // Maximum age of a reliable message that cannot be delivered.
  Duration lifetime = std::chrono::seconds(30);
  Compression compress = Compression::kAuto;  // of sensor data
  bool compress_own = false;                  // also of classes that RACK does not know
  bool secure = true;                         // of a router with keys: the link is sealed

  [[nodiscard]] bool accepts() const { return host.empty(); }
  [[nodiscard]] bool is_automatic() const { return !accepts() && port == 0; }  // to = "auto"
  [[nodiscard]] bool uses(PathKind path) const;
  [[nodiscard]] std::string to_string() const;  // "10.9.1.1:2010", "sub of system 1", "peer of *"
  bool operator==(const Link&) const = default;
};

// Of systems and routers; fewer with narrow fields (AddressBits).
inline constexpr std::int64_t kIdMax = 65535;

// An exception from routing along the tree: [[route]].
struct Route {
  std::string match;  // an AddressPattern: "Ladar(3/*)"
  std::string via;    // name of the router at the other end of a link

  [[nodiscard]] std::string to_string() const { return match; }
  bool operator==(const Route&) const = default;
};

// What somebody may send: [[rule]] (router/policy/policy.h).
struct Rule : policy::RuleText {
  [[nodiscard]] std::string to_string() const { return name; }
  bool operator==(const Rule&) const = default;
};

// A message that the rules must allow or deny: [[test]].
struct Test : policy::TestText {
  [[nodiscard]] std::string to_string() const { return name; }
  bool operator==(const Test&) const = default;
};

// Splits "10.9.1.1, 10.9.1.2:7410" into its elements.
std::vector<std::string> list_of(std::string_view text);

struct Config {
  struct Router {
    std::string name;  // for users; default: the host's name
    Role role = Role::kSystem;
    std::uint16_t system = 0;
    std::uint16_t id = 1;
    std::uint8_t priority = 0;  // SCHED_FIFO; 0: an ordinary process
    bool operator==(const Router&) const = default;
  } router;

  struct AddressBits {
    AddressWidths widths;
    bool operator==(const AddressBits&) const = default;
  } address;

  struct Unix {
    std::string path;
    bool everybody = false;
    bool operator==(const Unix&) const = default;
  } unix;

  struct Tcp {
    std::optional<Endpoint> listen = Endpoint{"127.0.0.1", 2000};  // empty: off
    std::string plain = "loopback";  // networks (networks.h) from which TLS is not demanded
    bool compat_delete = false;
    bool admin = false;  // clients may change the router itself; applies to http as well
    std::uint32_t queue_bytes = 4U << 20;  // queued for one slow reader
    bool operator==(const Tcp&) const = default;
  } tcp;

  struct Http {
    std::optional<Endpoint> listen = Endpoint{"127.0.0.1", 8080};  // empty: off
    std::string names;                                             // "robot7.local, robot7"
    std::string origins;      // "http://robot7:3000, http://localhost:5173"
    std::string certificate;  // PEM files for browsers, of a public authority; empty: the fleet's
    std::string key;
    std::string console;  // a folder, or "off"; empty: that of the installation or build
    std::uint32_t queue_bytes = 1U << 20;  // queued for one slow WebSocket client
    bool operator==(const Http&) const = default;
  } http;

  struct Udp {
    std::optional<Endpoint> listen = Endpoint{"127.0.0.1", kLinkPort};  // empty: off
    bool operator==(const Udp&) const = default;
  } udp;

  struct Fleet {
    std::string name;  // empty: this router is in no fleet
    bool operator==(const Fleet&) const = default;
  } fleet;

  struct Dds {
    std::uint8_t domain = 0;
    bool multicast = true;
    std::string peers;   // "10.9.1.1, 10.9.1.2:7410"
    std::string server;  // "10.9.1.1:11811"; empty: none
    Duration lease = std::chrono::seconds(10);
    // Bytes; fits into a tunnel too (WireGuard takes 1420 with IP).
    std::uint32_t message_max = 1392;
    std::uint32_t history = 32;  // samples
    Duration heartbeat = std::chrono::milliseconds(2);
    std::string profiles;      // a file; empty: none
    bool beyond_host = false;  // of a router with keys; one without: security.insecure
    bool operator==(const Dds&) const = default;
  } dds;

  struct Message {
    std::uint32_t bytes_max = 16U << 20;  // header included
    PriorityClasses classes;
    std::string lifetimes = "chassis.move 150ms";  // of commands (router/policy/lifetimes.h)
    bool operator==(const Message&) const = default;
  } message;

  struct Lifesign {
    Duration interval = std::chrono::seconds(5);
    bool operator==(const Lifesign&) const = default;
  } lifesign;

  struct Limits {
    std::uint32_t clients = 1024;
    std::uint32_t mailboxes_per_client = 4096;
    bool operator==(const Limits&) const = default;
  } limits;

  // Newest values (router/core/newest_values.h).
  struct Newest {
    std::uint32_t bytes = 16U << 20;       // 0: none are kept
    std::uint32_t length_max = 64U << 10;  // of one message, header included
    std::string streams = "status, parameters, state";
    bool operator==(const Newest&) const = default;
  } newest;

  struct Log {
    LogLevel level = LogLevel::kInfo;
    bool operator==(const Log&) const = default;
  } log;

  struct Security {
    bool insecure = false;  // listening beyond loopback without authentication was allowed
    std::string keys;       // a folder (security/keys/key_folder.h); empty: this router has no keys
    bool refuse_expired = false;  // certificates, if the clock can be trusted
    // After which the list of revoked certificates is old, if the clock can be trusted; 0: never.
    Duration list_age_max{};
    bool refuse_old_list = false;  // with an old list: users, and routers of other robots
    Duration renew_within = std::chrono::minutes(10);  // a certificate that is due
    bool operator==(const Security&) const = default;
  } security;

  struct Sim {
    bool faults = false;
    bool operator==(const Sim&) const = default;
  } sim;

  std::vector<Link> links;    // in configuration order: the first super link is preferred
  std::vector<Route> routes;  // in configuration order
  std::vector<Rule> rules;    // in configuration order: the first that matches decides
  std::vector<Test> tests;

  [[nodiscard]] bool has_keys() const { return !security.keys.empty(); }
  // Whether DDS speaks with other hosts, or on this one only.
  [[nodiscard]] bool dds_leaves_host() const {
    return has_keys() ? dds.beyond_host : security.insecure;
  }

  bool operator==(const Config&) const = default;
};

// The rules and tests of a configuration. `origins`: where each rule is written ("router.toml:12").
policy::PolicyText policy_text(const Config& config,
                               const std::vector<std::string>& rule_places = {});

}  // namespace tims::config
