// Roles that decode: how fast the decoders of devices are on one core, beside memcpy.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// `plan.link`: its name in decoder_streams.h. MB a second of what its device sends, until it is
// data that a driver publishes.
bool measure_decoder(const Plan& plan);
// Of memcpy, of the same bytes in the same pieces.
bool measure_copy_of_pieces(const Plan& plan);

}  // namespace tims::bench
