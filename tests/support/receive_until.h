// Receives from a transport as a driver does, until a condition is met, it fails, or the patience
// of a test is over.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <poll.h>

#include "os/clock.h"
#include "rack/devices/transport.h"
#include "tests/support/patience.h"

namespace rack::device {

// `take`: called with each Arrival.
template <typename Condition, typename Take>
tims::Result<void> receive_until(Transport& transport, Condition condition, Take take) {
  const tims::Time end = tims::os::now() + tims::test::kPatience;
  while (!condition() && tims::os::now() < end) {
    pollfd wait{.fd = transport.descriptor(), .events = POLLIN, .revents = 0};
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(transport.next_timeout() - tims::os::now());
    ::poll(&wait, 1, static_cast<int>(std::clamp<std::int64_t>(left.count(), 0, 20)));
    if (auto received = transport.receive(tims::os::now(), take); !received) return received;
  }
  return {};
}

// The same for a line: the arrivals, and their bytes as a text.
template <typename Condition>
tims::Result<void> receive_until(Transport& transport, std::vector<Arrival>& arrivals,
                                 std::string& text, Condition condition) {
  return receive_until(transport, condition, [&](const Arrival& arrival) {
    arrivals.push_back(arrival);
    for (const std::byte byte : arrival.bytes) text += static_cast<char>(byte);
  });
}

}  // namespace rack::device
