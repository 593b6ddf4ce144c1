// Conversion between the localiser and the messages of RACK: scans in; estimates, samples and
// measurements out. Pure.
#pragma once

#include <vector>

#include "components/localisation/localiser.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/position.h"
#include "rack/proxies/scan2d.h"

namespace rack::localisation {

// Uses the points that are neither invalid nor dynamic nor at the maximum range of the scanner.
// `ends` has room for all points of a scan.
void beams_of(const Scan2dData& scan, i32 range_max, std::vector<BeamEnd>& ends);

// The estimate at `time`, some of the particles (samples), and the end points of the beams used
// (measurements). Allocates nothing when data.points has capacity.
void to_message(const Localiser& localiser, TimeStamp time, MclData& data);
// The estimate with its standard deviations, for the command UPDATE of Position.
PositionData to_update(const Localiser& localiser, TimeStamp time);

// Whether the estimate is reliable enough to publish: the cloud is in one place, and its standard
// deviation is at most `most` mm.
bool is_sure(const Estimate& estimate, double most);

}  // namespace rack::localisation
