// Sends admin requests in JSON to a router (router/io/ADMIN.md).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "tools/cli/connection.h"
#include "tools/cli/output.h"

namespace timsctl {

// The body as a JSON object; empty if it is not one.
std::optional<json::object> json_of(const Message& message);

class AdminClient {
 public:
  // `router`: a router that is reached through that of the connection; empty: the latter itself.
  AdminClient(Connection& connection, const Signals& signals, tims::Duration timeout,
              std::optional<tims::Address> router = {})
      : connection_(connection), signals_(signals), timeout_(timeout), router_(router) {}

  // A client of another router over the same connection; empty: the router of the connection.
  [[nodiscard]] AdminClient at(std::optional<tims::Address> router) const {
    return {connection_, signals_, timeout_, router};
  }

  [[nodiscard]] std::optional<tims::Address> router() const { return router_; }
  [[nodiscard]] tims::Address own_address() const { return connection_.address(); }

  [[nodiscard]] tims::AddressWidths widths() const { return connection_.widths(); }

  // Returns the answer with all its pages and "age_ms". `patience`: additional time that the router
  // may wait before it answers. Throws Failure: no answer, an invalid answer, or an error reported
  // by the router.
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

// The routers of a fleet. The search starts at one router and continues at those that it names.

// Returns {"items": one per router, "partial": a router did not answer}, in breadth-first order
// from the first router. In addition to the members that routers report (router/io/ADMIN.md), an
// item has "state" (up; down: its link, or that of the router before it, is down; unreachable: it
// does not answer), "parent" (name of the router that leads to it), "depth", and "clock" (the sum
// of the offsets along the path; null: unknown).
json::object walk_fleet(const AdminClient& first);

// The items of all routers of the fleet, each with "at", the router that reported it; "partial" is
// also set if a router did not answer.
json::object ask_everywhere(AdminClient& admin, const json::object& question);

// Finds a router by name ("robot1") or address ("Tims(1/1)"). Throws Failure if there is none.
tims::Address find_router(const AdminClient& first, std::string_view name);

// The router address under "address" of an item.
std::optional<tims::Address> router_address(const json::object& item);

}  // namespace timsctl
