// Measurements of links, not of messages.
#pragma once

#include "tests/bench/crew.h"

namespace tims::bench {

// Bytes a second that cross an idle link, headers included, each way.
Result<Metrics> measure_idle_link(const Crew& crew, const Setting& setting);
// Seconds from the cut of the cable until the base has withdrawn what is behind it.
Result<Metrics> measure_link_death(const Crew& crew);
// A thousand robots below one router, which is killed and started again: seconds from there until
// it knows all their mailboxes.
Result<Metrics> measure_convergence(const Experiment& experiment, const Setting& setting);

}  // namespace tims::bench
