// The router's table alone: the time of a look-up and the memory of a mailbox.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// ns per look-up among plan.count mailboxes, each dependent on the result of the one before.
bool measure_lookup(const Plan& plan);
// The same number of reads at random places in the same amount of memory.
bool measure_bare_reads(const Plan& plan);
// Peak bytes per mailbox while the table grows to plan.count of them.
bool measure_table_memory(const Plan& plan);

}  // namespace tims::bench
