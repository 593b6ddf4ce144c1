// Messages are counted and, on links, sent in eight classes by their priority. The thresholds are
// one setting of a whole fleet.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "router/core/ids.h"
#include "tims/message.h"

namespace tims::core {

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
  [[nodiscard]] std::string to_string() const;  // "0/1/15/25/35/45/100"
  bool operator==(const PriorityClasses&) const = default;
};
inline constexpr PriorityClasses kConventionalClasses{};

}  // namespace tims::core
