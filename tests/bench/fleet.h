// Many robots in one thread: routers with links and mailboxes, with the code of the real router
// (router/core, router/link), each with a real UDP socket.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

inline constexpr std::uint32_t kMailboxesOfRobot = 100;

// Runs `plan.count` robots below the router at `plan.endpoint` until it is killed.
bool play_fleet(const Plan& plan);

}  // namespace tims::bench
