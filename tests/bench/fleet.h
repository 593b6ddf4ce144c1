// Many robots at once: routers with links and mailboxes, as the real ones have them (router/core,
// router/link), over a real UDP socket each, all in one thread.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

inline constexpr std::uint32_t kMailboxesOfRobot = 100;

// `plan.count` robots below the router at `plan.endpoint`, until it is killed.
bool play_fleet(const Plan& plan);

}  // namespace tims::bench
