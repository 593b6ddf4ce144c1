// Which client a message is handed to: the owner of its destination in the table, the link of a
// static route, the link to the destination's robot, or the link up the tree.
#pragma once

#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "router/core/registrations.h"
#include "router/core/types.h"
#include "tims/address.h"

namespace tims::core {

// The route for messages to unregistered destinations.
struct StaticRoute {
  AddressPattern match{};
  Text<64> text{};  // the pattern as configured
  Text<64> via{};   // name of a router at the other end of a link (ClientInfo::Link)
};

struct NextHop {
  Client* to = nullptr;
  std::uint32_t handle = 0;
  enum class By : std::uint8_t { kTable, kStatic, kSystem, kUp, kNone } by = By::kNone;
  Outcome why_not = Outcome::kNoRoute;  // set when `to` is null
};

bool is_link(const Client* client, LinkKind kind);

// Messages from routers above or beside are forwarded only downwards, which rules out loops.
bool only_down(const Client* from);

class Routes {
 public:
  Routes(Clients& clients, const Registrations& registrations, AddressWidths widths)
      : clients_(clients), registrations_(registrations), widths_(widths) {}

  void add_link(ClientId link) { links_.push_back(link); }
  void remove_link(ClientId link);
  // The link for messages to unknown destinations; kNoClient: none.
  void set_uplink(ClientId link) { uplink_ = link; }
  [[nodiscard]] ClientId uplink() const { return uplink_; }
  void set_static(std::vector<StaticRoute> routes) { static_ = std::move(routes); }
  [[nodiscard]] const std::vector<StaticRoute>& all_static() const { return static_; }

  // The client that a message to this address is handed to; `from` is null for the router itself.
  [[nodiscard]] NextHop next_hop(const Client* from, Address dest) const;
  [[nodiscard]] bool leads_over_link(const Client& from, Address dest) const;
  // True when the address is in the system the link is configured for, or when a static route
  // leads to it over the link. Checked for mailboxes that the link announces and for sources of
  // messages it brings.
  [[nodiscard]] bool may_come_from(const Client& link, Address address) const;

 private:
  [[nodiscard]] ClientId link_named(std::string_view name) const;
  [[nodiscard]] ClientId peer_router(std::uint32_t system) const;

  Clients& clients_;
  const Registrations& registrations_;
  AddressWidths widths_;
  ClientId uplink_{};
  std::vector<ClientId> links_;
  std::vector<StaticRoute> static_;
};

}  // namespace tims::core
