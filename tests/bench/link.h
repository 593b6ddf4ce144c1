// A way between one sender (ping, source) and its receivers (echo, sink). Roles are written once
// against this; what is measured is one class each. A template, so that nothing stands between a
// role and a link: at 100 ns a message a virtual call would be seen.
#pragma once

#include <concepts>
#include <cstddef>
#include <span>

#include "os/clock.h"
#include "tims/time.h"

namespace tims::bench {

template <typename L>
concept Link = requires(L& link, std::span<const std::byte> payload, Duration timeout) {
  // To every receiver, or back to the sender. False: nothing taken for a while.
  { link.send(payload) } -> std::same_as<bool>;
  // What send() has gathered goes out now.
  link.flush();
  // Waits up to the timeout (kForever: sets up no timer), then hands over all that is there.
  link.receive(timeout, [](std::span<const std::byte>) {});
  // Without back-pressure of its own: the source may only send what the sinks have asked for.
  { link.needs_credit() } -> std::same_as<bool>;
};

// How long a stream looks for the next message before it sleeps (waking a process costs more), and
// how long it leaves the sender in peace between two looks: a receiver that looks all the time
// takes away the cache line in which the sender is writing.
inline constexpr Duration kStreamSpin = std::chrono::microseconds(10);
inline constexpr Duration kLookEvery = std::chrono::microseconds(1);

// Until look() is true or the time is over.
template <typename Look>
bool look_for(Duration patience, Look look) {
  if (patience == Duration::zero()) return false;
  const Time give_up = os::now() + patience;
  for (Time now{}; now < give_up;) {
    if (look()) return true;
    now = os::now();
    for (const Time again = now + kLookEvery; now < again;) now = os::now();
  }
  return false;
}

}  // namespace tims::bench
