// A message on its way through the router, and the eight classes messages have by their priority.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "router/core/ids.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::core {

struct Message {
  Header header{};  // decoded
  // All of it, header included. The router writes the header here again when it forwards, so this
  // is memory that nobody else writes to: what lies in shared memory is copied out first.
  std::span<std::byte> bytes{};
  std::uint8_t hops = 0;  // links it has passed
  Duration waited{};      // in the queue of the last one, when it is traced

  [[nodiscard]] std::span<const std::byte> body() const { return bytes.subspan(kHeaderSize); }
};

// Messages are counted and, on links, sent in eight classes by their priority. The thresholds are
// one setting of a whole fleet.
struct PriorityClasses {
  // The lowest priority of each class above 0. As RACK is used: 0 are tools and the GUI, 1 is who
  // was given no priority, robots have steps of ten up to 50 (each data task one below its command
  // task, so 19 belongs to 20), nothing but stop commands 100 and more.
  std::array<std::uint8_t, kClasses - 1> from{0, 1, 15, 25, 35, 45, 100};

  // Texts for people are the least of all, though originals send them as urgently as their data.
  // By convention they are alone in class 0.
  [[nodiscard]] constexpr std::size_t of(const Header& header) const {
    return header.dest == kTextSink ? 0 : of(header.priority);
  }
  [[nodiscard]] constexpr std::size_t of(std::uint8_t priority) const {
    std::size_t message_class = 0;
    for (const std::uint8_t first : from) message_class += priority >= first ? 1 : 0;
    return message_class;
  }
  // With what a message waits for a slow client: texts give way to all others.
  [[nodiscard]] static constexpr std::uint8_t waits_with(const Header& header) {
    return header.dest == kTextSink ? 0 : header.priority;
  }
  [[nodiscard]] constexpr bool valid() const {
    return std::ranges::adjacent_find(from, std::ranges::greater_equal()) == from.end();
  }
  // "0/1/15/25/35/45/100"
  [[nodiscard]] std::string to_string() const {
    std::string text;
    for (const std::uint8_t first : from)
      text.append(text.empty() ? "" : "/").append(std::to_string(first));
    return text;
  }
  bool operator==(const PriorityClasses&) const = default;
};
inline constexpr PriorityClasses kConventionalClasses{};

}  // namespace tims::core
