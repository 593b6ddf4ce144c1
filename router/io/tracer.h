// Hop records (ADMIN.md): what the router reports about messages with flag TRACE.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "router/core/router.h"
#include "router/io/admin_source.h"

namespace tims::io {

class Tracer {
 public:
  // Maximum per turn; further records are dropped. Traces are a debugging aid, used for single
  // messages.
  static constexpr std::size_t kPerTurnMax = 64;

  using Send = std::function<void(core::Message& record)>;

  // Called from core::RouterHooks::traced.
  void on_traced(WallTime at, core::ClientId from, core::ClientId to, const core::Message& message);
  // Called from core::RouterHooks::trace_denied.
  void on_denied(WallTime at, core::ClientId from, const core::Message& message,
                 std::string_view rule);
  [[nodiscard]] bool has_records() const { return !hops_.empty(); }
  // Call at the end of a turn: `send` is Router::answer. The bytes stay valid until release().
  void send_records(const core::Router& router, std::string_view name, const Send& send);
  void release() { sent_.clear(); }

 private:
  struct Hop {
    // Before it is handed on: the time of the next router of this host is not earlier.
    WallTime at{};
    core::ClientId from{};
    core::ClientId to{};
    Header header{};
    std::uint8_t hops = 0;
    Duration waited{};
    std::string denied{};  // the rule of the policy that stopped it here; empty: none
  };
  std::vector<Hop> hops_;
  std::vector<std::vector<std::byte>> sent_;
};

}  // namespace tims::io
