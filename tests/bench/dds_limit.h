// The limit of links by way of DDS: a reliable round trip with bare Fast DDS, each side answering
// from the library's own thread, as soon as it calls.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

bool dds_ping(const Plan& plan);
bool dds_echo(const Plan& plan);

}  // namespace tims::bench
