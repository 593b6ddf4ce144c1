// How long commands are worth delivering, by their type: a speed that is older than a few periods
// of a pilot must not reach a chassis after a link was cut. Pure.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "router/policy/types.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::policy {

class Lifetimes {
 public:
  static constexpr std::size_t kMost = 64;
  static constexpr Duration kShortest = std::chrono::milliseconds(20);
  static constexpr Duration kLongest = std::chrono::minutes(10);

  Lifetimes() = default;
  explicit Lifetimes(const AddressWidths& widths) : widths_(widths) {}

  // "chassis.move 150ms": types as in rules, and a time. False: it is not, or there are too many.
  [[nodiscard]] bool add(std::string_view text);

  // kForever for what is no command, and for commands without a lifetime.
  static constexpr Duration kForever = Duration::max();
  [[nodiscard]] Duration of(const Header& header) const {
    return header.type > 0 && !items_.empty() ? find(header) : kForever;
  }

  bool operator==(const Lifetimes&) const = default;

 private:
  struct Item {
    TypePattern what{};
    Duration time{};
    bool operator==(const Item&) const = default;
  };
  [[nodiscard]] Duration find(const Header& header) const;

  AddressWidths widths_{};
  std::vector<Item> items_;
};

}  // namespace tims::policy
