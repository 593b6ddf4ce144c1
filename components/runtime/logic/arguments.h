// The command line of a component: long options with one or two dashes, as in the original
// (`--name value`, `--name=value`, `-name value`), or as much of a name as is unique.
//
// Not CLI11, which the other programs have: its lookup would have to be replaced for the short and
// single-dashed names, values are checked where those of SET_PARAM are (Parameters), and it refuses
// `--name=`, by which a supervisor hands on an empty text.
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
  std::string router{};  // --router; empty: as the environment says
  // Who has turned it off by hand before it crashed, from whoever starts it again.
  std::optional<tims::Address> held_off_by{};
};

// The option for that: nobody writes it by hand, so it is no parameter and has to be written out.
inline constexpr std::string_view kHeldOffBy = "heldOffBy";

// Sets what is given. kInvalidArgument names the argument and what it should have been.
tims::Result<Arguments> parse_arguments(std::span<const char* const> arguments,
                                        Parameters& parameters);

// For --help: every parameter with its default and what it may be.
std::string usage(const Parameters& parameters, std::string_view purpose);

}  // namespace rack
