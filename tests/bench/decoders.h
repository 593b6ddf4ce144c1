// Roles that measure the speed of the device decoders on one core, compared with memcpy.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// `plan.link`: its name in decoder_streams.h. Measures MB per second from the device's bytes to the
// data that a driver publishes.
bool measure_decoder(const Plan& plan);
// The same for memcpy of the same bytes in the same pieces.
bool measure_copy_of_pieces(const Plan& plan);

}  // namespace tims::bench
