// The routers of a fleet, found by asking one and then those it names.
#pragma once

#include <string>
#include <string_view>

#include "tools/timsctl/admin_client.h"
#include "tools/timsctl/json.h"

namespace timsctl {

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
