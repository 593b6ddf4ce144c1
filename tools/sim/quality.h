// The quality of a line between two hosts, and the commands that change it. Pure.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "tims/result.h"
#include "tims/time.h"

namespace timsctl::sim {

// The quality of one direction.
struct Quality {
  double loss = 0;  // fraction of the datagrams, 0 to 1
  double duplicate = 0;
  double reorder = 0;
  tims::Duration delay{};
  tims::Duration jitter{};      // maximum additional delay
  std::uint64_t rate_bits = 0;  // per second; 0: no limit
  bool blackout = false;        // all datagrams are lost silently

  bool operator==(const Quality&) const = default;
};

struct LineState {
  bool cut = false;  // the cable is unplugged: both ends lose the carrier
  Quality up;        // from the lower host to the upper one: towards the base
  Quality down;

  bool operator==(const LineState&) const = default;
};

using Profiles = std::map<std::string, Quality, std::less<>>;
Profiles built_in_profiles();  // cable, wifi, corridor, lte, blackout

// Sets one key of a profile: "loss", "1%". The error text continues a sentence that starts with the
// key.
tims::Result<void> set_key(Quality& quality, std::string_view key, std::string_view value);
std::span<const std::string_view> quality_keys();

// The state of a line after commands such as "cut", "heal", "wifi", "loss=10%", "direction=up".
// `own`: the state without faults, restored by heal.
tims::Result<LineState> changed(const LineState& now, const LineState& own,
                                std::span<const std::string> arguments, const Profiles& profiles);

std::string to_string(const Quality& quality);  // "loss 1% delay 20ms", "perfect"
std::string to_string(const LineState& state);  // "cut", "up: perfect, down: loss 10%"
std::string rate_text(std::uint64_t bits);      // "50Mbit"

}  // namespace timsctl::sim
