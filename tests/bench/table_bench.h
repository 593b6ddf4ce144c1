// The router's table alone: what a look-up costs, and what a mailbox occupies.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// ns a look-up among plan.count mailboxes, each asked for after the answer to the one before.
bool measure_lookup(const Plan& plan);
// The same number of reads at random places of as much memory, and nothing else.
bool measure_bare_reads(const Plan& plan);
// Bytes a mailbox, at the worst moment on the way to plan.count of them.
bool measure_table_memory(const Plan& plan);

}  // namespace tims::bench
