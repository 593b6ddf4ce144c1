// Asks a router by JSON (router/io/ADMIN.md).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "tools/cli/connection.h"
#include "tools/cli/output.h"

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

// The routers of a fleet, found by asking one and then those it names.

// {"items": one a router, "partial": somebody did not answer}, from the first on, neighbours after
// each other. What an item has beside what routers say of themselves (router/io/ADMIN.md):
// "state" (up; down: its link is, or that of the router it was behind; unreachable: it does not
// answer), "parent" (name of the router it was found at, or was behind), "depth", "clock" (added up
// along the way; null: not known).
json::object walk_fleet(const AdminClient& first);

// The items of every router that is there, each with "at": the router that knows it; "partial" also
// when one of them did not answer.
json::object ask_everywhere(AdminClient& admin, const json::object& question);

// By name ("robot1") or address ("Tims(1/1)"). Throws Failure when there is none.
tims::Address find_router(const AdminClient& first, std::string_view name);

// A router's address as an item has it under "address".
std::optional<tims::Address> router_address(const json::object& item);

}  // namespace timsctl
