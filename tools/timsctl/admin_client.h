// Asks a router by JSON (router/io/ADMIN.md).
#pragma once

#include <optional>
#include <string_view>

#include "tools/timsctl/connection.h"
#include "tools/timsctl/json.h"

namespace timsctl {

// The body as a JSON object, if it is one.
std::optional<json::object> json_of(const Message& message);

class AdminClient {
 public:
  // `router`: another one than that of the connection, reached through it.
  AdminClient(Connection& connection, const Signals& signals, tims::Duration timeout,
              std::optional<tims::Address> router = {})
      : connection_(connection), signals_(signals), timeout_(timeout), router_(router) {}

  // The same connection, another router; nothing: the connection's own.
  [[nodiscard]] AdminClient at(std::optional<tims::Address> router) const {
    return {connection_, signals_, timeout_, router};
  }

  [[nodiscard]] std::optional<tims::Address> router() const { return router_; }
  [[nodiscard]] tims::Address own_address() const { return connection_.address(); }

  [[nodiscard]] tims::AddressWidths widths() const { return connection_.widths(); }

  // The answer, all its pages in one, with "age_ms". `patience` is what the router was asked to
  // wait. Throws Failure: no answer, not understood, or what the router says is wrong.
  json::object ask(const json::object& question, tims::Duration patience = {});

 private:
  json::object ask_once(const json::object& question, tims::Duration patience);
  tims::Result<void> send(std::span<const std::byte> body, std::uint8_t seq_nr);
  [[nodiscard]] std::string where() const;

  Connection& connection_;
  const Signals& signals_;
  tims::Duration timeout_;
  std::optional<tims::Address> router_;
};

}  // namespace timsctl
