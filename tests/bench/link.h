// A link from one sender (ping, source) to its receivers (echo, sink). Roles use this interface;
// each measured system is one class. It is a concept for templates, because at 100 ns per message a
// virtual call would be significant.
#pragma once

#include <concepts>
#include <cstddef>
#include <span>

#include "os/clock.h"
#include "tims/time.h"

namespace tims::bench {

template <typename L>
concept Link = requires(L& link, std::span<const std::byte> payload, Duration timeout) {
  // Sends to every receiver, or back to the sender. False: timeout without progress.
  { link.send(payload) } -> std::same_as<bool>;
  // Sends everything that send() has collected.
  link.flush();
  // Waits up to the timeout (kForever: without a timer), then delivers all available messages.
  link.receive(timeout, [](std::span<const std::byte>) {});
  // True for links without back-pressure: the source may send only what the sinks have granted.
  { link.needs_credit() } -> std::same_as<bool>;
};

// How long a stream polls for the next message before it sleeps (waking a process costs more), and
// the pause between two polls: continuous polling would take the cache line from the writing
// sender.
inline constexpr Duration kStreamSpin = std::chrono::microseconds(10);
inline constexpr Duration kLookEvery = std::chrono::microseconds(1);

// Polls until look() is true or the time is over.
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
