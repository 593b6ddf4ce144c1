// Many robots in one thread: routers with links and mailboxes, with the code of the real router
// (router/core, router/link), each with a real UDP socket.
#pragma once

#include "tests/bench/fleet_keys.h"
#include "tests/bench/plan.h"

namespace tims::bench {

inline constexpr std::uint32_t kMailboxesOfRobot = 100;

// Keys for so many robots.
Result<void> make_keys_of_fleet(const FleetKeys& keys, std::uint64_t robots);

// Runs `plan.count` robots below the router at `plan.endpoint` until it is killed. `plan.folder`:
// that of their keys; empty: their links are open.
bool play_fleet(const Plan& plan);

}  // namespace tims::bench
