// The command line of a component: long options with one or two dashes, as in the original
// (`--name value`, `--name=value`, `-name value`), or as much of a name as is unique.
//
// CLI11, which the other programs use, does not fit: its look-up would have to be replaced for
// abbreviated and single-dashed names, values are checked where those of SET_PARAM are
// (Parameters), and it refuses `--name=`, which a supervisor uses to pass an empty text.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "rack/parameters.h"
#include "tims/address.h"
#include "tims/result.h"

namespace rack {

struct Arguments {
  bool help = false;
  bool version = false;
  bool describe = false;
  std::string router{};  // --router; empty: from the environment
  // The operator's program that had turned it off before it crashed; set by the supervisor that
  // restarts it.
  std::optional<tims::Address> held_off_by{};
};

// The option for that. It is only used by supervisors, so it is not a parameter and cannot be
// abbreviated.
inline constexpr std::string_view kHeldOffBy = "heldOffBy";

// Sets the given parameters. kInvalidArgument: names the argument and the valid form.
tims::Result<Arguments> parse_arguments(std::span<const char* const> arguments,
                                        Parameters& parameters);

// For --help: every parameter with its default and allowed values.
std::string usage(const Parameters& parameters, std::string_view purpose);

}  // namespace rack
