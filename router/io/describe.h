// What several ports say in the same words.
#pragma once

#include <string>

#include "router/config/config.h"
#include "router/core/statistics.h"

namespace tims::io {

// A client: "pid 4711 (laser)", "127.0.0.1:40312".
inline std::string describe(const core::Peer& peer) {
  if (!peer.id) return "the router itself";
  std::string text;
  if (peer.pid != 0) text.append("pid ").append(std::to_string(peer.pid));
  if (!peer.endpoint.empty()) text.append(text.empty() ? "" : " ").append(peer.endpoint.view());
  if (!peer.name.empty()) text.append(" (").append(peer.name.view()).append(")");
  return text;
}

// Of a socket that was bound early (os/socket.h).
inline std::string waits_for_address(const char* protocol, const config::Endpoint& where) {
  return std::string(protocol) + " " + where.to_string() +
         ": this host has no such address yet; waiting for it";
}

}  // namespace tims::io
