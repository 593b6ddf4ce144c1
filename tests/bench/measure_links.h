// Measurements of links instead of messages.
#pragma once

#include "tests/bench/crew.h"

namespace tims::bench {

// Bytes per second over an idle link, headers included, in each direction, and the cost of the
// robot's router.
Result<Metrics> measure_idle_link(const Crew& crew, const Setting& setting);
// Seconds from the cut of the cable until the base has withdrawn the robot's mailboxes.
Result<Metrics> measure_link_death(const Crew& crew);
// Seconds from the start of the robot's router until the base knows it; then its CPU time and
// memory, and the bytes on the cable during that time.
Result<Metrics> measure_fleet_join(const Crew& crew, const Setting& setting);
// A base and `count` robots that connect by name start at once: seconds until all are known; the
// same after all were killed; then the cost of a robot and of the base.
Result<Metrics> measure_fleet_start(const Experiment& experiment, const Setting& setting);
// A thousand robots below one router, which is killed and restarted: seconds from the restart until
// it knows all their mailboxes.
Result<Metrics> measure_convergence(const Experiment& experiment, const Setting& setting);

}  // namespace tims::bench
