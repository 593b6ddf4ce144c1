// Many clients with many mailboxes each come at once, as after a restart of the router.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

inline constexpr std::uint32_t kComers = 1000;
inline constexpr std::uint32_t kMailboxesEach = 100;

// Seconds from the first connection until every mailbox is confirmed.
bool register_over_tcp(const Plan& plan);
bool register_over_unix(const Plan& plan);  // through libtims, one session a client

}  // namespace tims::bench
