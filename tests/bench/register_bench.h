// Many clients with many mailboxes each connect at once, as after a restart of the router.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

inline constexpr std::uint32_t kComers = 1000;
inline constexpr std::uint32_t kMailboxesEach = 100;

// Seconds from the first connection until every mailbox is confirmed.
bool register_over_tcp(const Plan& plan);
bool register_over_unix(const Plan& plan);  // with libtims, one session per client

}  // namespace tims::bench
