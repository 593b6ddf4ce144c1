// Measurements of links, not of messages.
#pragma once

#include "tests/bench/crew.h"

namespace tims::bench {

// Bytes a second that cross an idle link, headers included, each way, and what the robot's router
// costs.
Result<Metrics> measure_idle_link(const Crew& crew, const Setting& setting);
// Seconds from the cut of the cable until the base has withdrawn what is behind it.
Result<Metrics> measure_link_death(const Crew& crew);
// Seconds from the start of the router at the robot until the base knows it; then what it costs to
// run it, and what crosses the cable meanwhile.
Result<Metrics> measure_fleet_join(const Crew& crew, const Setting& setting);
// A base and `count` robots that find each other by name start at once: seconds until all are
// known; the same after all were killed; then what a robot and the base cost.
Result<Metrics> measure_fleet_start(const Experiment& experiment, const Setting& setting);
// A thousand robots below one router, which is killed and started again: seconds from there until
// it knows all their mailboxes.
Result<Metrics> measure_convergence(const Experiment& experiment, const Setting& setting);

}  // namespace tims::bench
