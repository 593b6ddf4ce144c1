// The limit of links over DDS: a reliable round trip with bare Fast DDS, each side answering in the
// library's callback thread.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

bool dds_ping(const Plan& plan);
bool dds_echo(const Plan& plan);

}  // namespace tims::bench
