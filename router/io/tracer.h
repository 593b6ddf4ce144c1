// Hop records: whoever sends a message with flag TRACE hears from every router on its way, where it
// came from, where it went and how long it had waited in the queue of the link before.
#pragma once

#include <functional>
#include <vector>

#include "router/core/router.h"
#include "router/io/reports.h"

namespace tims::io {

class Tracer {
 public:
  // Of one turn; more are not told. Traces are for people, one message in a thousand.
  static constexpr std::size_t kPerTurnMax = 64;

  using Send = std::function<void(core::Message& record)>;

  // From core::Surroundings::traced.
  void on_traced(core::ClientId from, core::ClientId to, const core::Message& message);
  [[nodiscard]] bool has_records() const { return !hops_.empty(); }
  // At the end of a turn: `send` is Router::answer. The bytes stay valid until release().
  void send_records(const core::Router& router, std::string_view name, const Clocks& clocks,
                    const Send& send);
  void release() { sent_.clear(); }

 private:
  struct Hop {
    core::ClientId from{};
    core::ClientId to{};
    Header header{};
    std::uint8_t hops = 0;
    Duration waited{};
  };
  std::vector<Hop> hops_;
  std::vector<std::vector<std::byte>> sent_;
};

}  // namespace tims::io
