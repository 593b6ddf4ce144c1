// How good or bad a line between two hosts is, and the words that change it. Pure.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "tims/result.h"
#include "tims/time.h"

namespace timsctl::sim {

// Of one direction.
struct Quality {
  double loss = 0;  // share of the datagrams, 0 to 1
  double duplicate = 0;
  double reorder = 0;
  tims::Duration delay{};
  tims::Duration jitter{};      // up to so much more
  std::uint64_t rate_bits = 0;  // a second; 0: no limit
  bool blackout = false;        // nothing arrives, and nobody is told

  bool operator==(const Quality&) const = default;
};

struct LineState {
  bool cut = false;  // the cable is pulled: both ends see it
  Quality up;        // from the lower host to the upper one: towards the base
  Quality down;

  bool operator==(const LineState&) const = default;
};

using Profiles = std::map<std::string, Quality, std::less<>>;
Profiles built_in_profiles();  // cable, wifi, corridor, lte, blackout

// One key of a profile: "loss", "1%". The error's detail is half a sentence behind the key.
tims::Result<void> set_key(Quality& quality, std::string_view key, std::string_view value);
std::span<const std::string_view> quality_keys();

// What becomes of a line by words such as "cut", "heal", "wifi", "loss=10%", "direction=up".
// `own` is what the line is without any fault: heal goes back to it.
tims::Result<LineState> changed(const LineState& now, const LineState& own,
                                std::span<const std::string> words, const Profiles& profiles);

std::string to_string(const Quality& quality);  // "loss 1% delay 20ms", "perfect"
std::string to_string(const LineState& state);  // "cut", "up: perfect, down: loss 10%"
std::string rate_text(std::uint64_t bits);      // "50Mbit"

}  // namespace timsctl::sim
