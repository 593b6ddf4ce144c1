// What happened to messages, by port, class and outcome; and how often each kind of event was.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "router/core/event.h"
#include "router/core/ids.h"
#include "router/core/outcome.h"
#include "tims/time.h"

namespace tims::core {

struct Count {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;

  void add(std::uint64_t size) {
    ++messages;
    bytes += size;
  }
  bool operator==(const Count&) const = default;
};

// Messages that were taken and lost, by class.
using Losses = std::array<Count, kClasses>;

// The port is the one a message entered through; for a message that was lost in a queue, the
// queue's.
class MessageCounters {
 public:
  void add(PortKind port, std::size_t message_class, Outcome outcome, std::uint64_t size) {
    cell(port, message_class, outcome).add(size);
  }
  void add(PortKind port, std::size_t message_class, Outcome outcome, const Count& count) {
    Count& to = cell(port, message_class, outcome);
    to.messages += count.messages;
    to.bytes += count.bytes;
  }
  [[nodiscard]] const Count& of(PortKind port, std::size_t message_class, Outcome outcome) const {
    return counts_[static_cast<std::size_t>(port)][message_class]
                  [static_cast<std::size_t>(outcome)];
  }
  // Over all ports and classes.
  [[nodiscard]] Count total(Outcome outcome) const;

 private:
  Count& cell(PortKind port, std::size_t message_class, Outcome outcome) {
    return counts_[static_cast<std::size_t>(port)][message_class]
                  [static_cast<std::size_t>(outcome)];
  }
  std::array<std::array<std::array<Count, kOutcomeCount>, kClasses>, kPortKindCount> counts_;
};

class EventCounters {
 public:
  void add(EventKind kind) { ++counts_[static_cast<std::size_t>(kind)]; }
  [[nodiscard]] std::uint64_t of(EventKind kind) const {
    return counts_[static_cast<std::size_t>(kind)];
  }

 private:
  std::array<std::uint64_t, kEventKindCount> counts_{};
};

// How many messages were dropped within the last minute, to the second.
class DropHistory {
 public:
  void add(Time now, std::uint64_t messages = 1);
  [[nodiscard]] std::uint64_t last_minute(Time now) const;

 private:
  struct Second {
    std::int64_t number = -1;  // of this second since the clock began
    std::uint64_t drops = 0;
  };
  std::array<Second, 60> seconds_;
};

}  // namespace tims::core
