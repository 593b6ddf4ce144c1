// The cost of sealing, in one thread: messages of 1 MiB in datagrams as between two hosts.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// As a link does it, with the keys of a session.
bool seal_datagrams(const Plan& plan);
// AES-128-GCM alone, for the same bytes.
bool encrypt_alone(const Plan& plan);

}  // namespace tims::bench
