// Texts that repeat: a reason is written once and then counted, so that the operator's window keeps
// room for what is new. Pure.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "tims/message.h"
#include "tims/time.h"

namespace rack {

// The same for texts that differ only in their numbers, such as times.
std::uint64_t without_numbers(std::string_view text);

// --- Refused commands: a pilot that is not the active one may send ten MOVE per second.

class RefusalLog {
 public:
  static constexpr tims::Duration kReportEach = std::chrono::minutes(1);

  struct Verdict {
    bool write = false;
    std::uint32_t repeats = 0;  // not written since the last time
  };
  Verdict take(tims::Time now, const tims::Header& request, std::string_view why);

 private:
  struct Known {
    std::uint64_t key = 0;
    tims::Address from{};
    std::int8_t type = 0;
    std::uint32_t repeats = 0;
    tims::Time written{};
    tims::Time last{};
  };
  // The newest; more reasons at a time are written again.
  static constexpr std::size_t kKnown = 32;
  std::array<Known, kKnown> known_{};
};

// --- Failures of a component, which is turned on again after each of them. The same failure is
// written twice, since what has happened again may be of interest (a cable that was pulled twice),
// and then counted.

class FailureLog {
 public:
  // After this time a component that was turned on again is said to be on.
  static constexpr tims::Duration kSettled = std::chrono::seconds(10);

  // It could not be turned on, or has failed while on. Whether to write this.
  bool failed(std::string_view why);
  // It was turned on. Whether to write that now: not if it has failed for the same reason since it
  // was last turned on.
  bool turned_on(tims::Time now);
  // While it is on. When "on" is to be written after all: the number of failures that were not
  // written.
  std::optional<std::uint32_t> settled(tims::Time now);
  void turned_off() { *this = {}; }

 private:
  std::array<std::uint64_t, 4> reasons_{};  // the last ones
  std::size_t next_ = 0;
  bool any_ = false;
  bool on_ = false;
  bool says_on_later_ = false;
  bool returns_ = false;  // the same failure comes again after each ON
  std::uint32_t repeats_ = 0;
  tims::Time on_since_{};
};

}  // namespace rack
