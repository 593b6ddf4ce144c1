// The way of a message from router to router, as each of them says it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/cli/admin_client.h"

namespace timsctl {

struct Step {
  std::optional<tims::Address> router;  // nothing: that of the connection
  std::string name;
  json::object answer;  // to the question "route"
};

struct Path {
  std::vector<Step> steps;
  bool reached = false;                // the last one has the mailbox
  std::optional<std::string> failure;  // a router on the way did not answer, or they go in circles
};

// The router that has the mailbox itself: all routers of the fleet are asked. Nothing: none has it.
std::optional<Step> find_owner(const AdminClient& first, tims::Address mailbox);

// Begins at the router that `first` asks.
Path find_path(const AdminClient& first, std::optional<tims::Address> from, tims::Address to,
               std::int8_t type);

}  // namespace timsctl
