// Splits a long arrival into pieces, so that a decoder with a small buffer loses no bytes.
#pragma once

#include <algorithm>

#include "rack/devices/dialogue.h"

namespace rack::device {

// Calls `take` with arrivals of at most `most` bytes, each with its share of the time interval.
template <typename Take>
void in_pieces(const Arrival& arrival, std::size_t most, Take take) {
  if (arrival.bytes.size() <= most) return take(arrival);
  const auto size = static_cast<std::int64_t>(arrival.bytes.size());
  const Duration took = arrival.last - arrival.first;
  for (std::size_t at = 0; at < arrival.bytes.size(); at += most) {
    const std::size_t count = std::min(most, arrival.bytes.size() - at);
    const auto share = [&](std::size_t bytes) {
      return arrival.first + took * static_cast<std::int64_t>(bytes) / size;
    };
    take(Arrival{.bytes = arrival.bytes.subspan(at, count),
                 .first = share(at),
                 .last = share(at + count),
                 .id = arrival.id});
  }
}

}  // namespace rack::device
