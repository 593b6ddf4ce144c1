// What the router is told, as plain values. Defaults, limits, units and help of every value stand
// in one table (options.cpp); a Config that came out of load() keeps them.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "tims/time.h"

namespace tims::config {

// Where a port listens. The host is always numeric ("127.0.0.1", "::1"): nothing is resolved.
struct Endpoint {
  std::string host;
  std::uint16_t port = 0;  // 0: the system chooses one

  [[nodiscard]] bool loopback() const;                          // 127.0.0.0/8, ::1
  [[nodiscard]] std::string to_string() const;                  // "127.0.0.1:2000", "[::1]:2000"
  static std::optional<Endpoint> parse(std::string_view text);  // also "localhost:2000"
  bool operator==(const Endpoint&) const = default;
};

enum class LogLevel : std::uint8_t { kError, kWarning, kInfo, kDebug };

struct Config {
  struct Router {
    std::string name;  // for people; default: the host's name
    std::uint8_t system = 0;
    std::uint8_t id = 1;
    bool operator==(const Router&) const = default;
  } router;

  struct Unix {
    std::string path;
    bool everybody = false;
    bool operator==(const Unix&) const = default;
  } unix;

  struct Tcp {
    std::optional<Endpoint> listen = Endpoint{"127.0.0.1", 2000};  // empty: off
    bool compat_delete = false;
    std::uint32_t queue_bytes = 4U << 20;  // waiting for one slow reader
    bool operator==(const Tcp&) const = default;
  } tcp;

  struct Http {
    std::optional<Endpoint> listen = Endpoint{"127.0.0.1", 8080};  // empty: off
    bool operator==(const Http&) const = default;
  } http;

  struct Message {
    std::uint32_t bytes_max = 16U << 20;  // header included
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

  struct Log {
    LogLevel level = LogLevel::kInfo;
    bool operator==(const Log&) const = default;
  } log;

  struct Security {
    bool insecure = false;  // listening beyond loopback without keys was asked for
    bool operator==(const Security&) const = default;
  } security;

  bool operator==(const Config&) const = default;
};

}  // namespace tims::config
