// Between the localiser and the messages of RACK: scans in; estimates, samples and measurements
// out. Pure.
#pragma once

#include <vector>

#include "components/localisation/localiser.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/position.h"
#include "rack/proxies/scan2d.h"

namespace rack::localisation {

// A point counts if it is neither invalid nor dynamic nor at the end of what the scanner sees.
// `ends` has room for all points of a scan.
void beams_of(const Scan2dData& scan, i32 range_max, std::vector<BeamEnd>& ends);

// The estimate at `time`, some of the particles (samples), and where the beams end that were taken
// (measurements). Allocates nothing when data.points has its room.
void to_message(const Localiser& localiser, TimeStamp time, MclData& data);
// The estimate with its standard deviations, as Position takes it for UPDATE.
PositionData to_update(const Localiser& localiser, TimeStamp time);

// Whether the estimate is worth telling: the cloud is in one place, and `most` mm wide at most.
bool is_sure(const Estimate& estimate, double most);

}  // namespace rack::localisation
