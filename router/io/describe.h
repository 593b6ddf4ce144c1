// A client in words: "pid 4711 (laser)", "127.0.0.1:40312".
#pragma once

#include <string>

#include "router/core/event.h"

namespace tims::io {

inline std::string describe(const core::Party& party) {
  if (!party.id) return "the router itself";
  std::string text;
  if (party.pid != 0) text.append("pid ").append(std::to_string(party.pid));
  if (!party.peer.empty()) text.append(text.empty() ? "" : " ").append(party.peer.view());
  if (!party.name.empty()) text.append(" (").append(party.name.view()).append(")");
  return text;
}

}  // namespace tims::io
