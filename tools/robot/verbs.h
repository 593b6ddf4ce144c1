// The verbs of timsctl that timsctl-robot does.
#pragma once

#include "tools/cli/options.h"

namespace timsctl::robot {

inline constexpr std::string_view kProgram = "timsctl-robot";

inline constexpr Verb kUp{
    "up",
    "",
    "FILE",
    1,
    1,
    "system on for detach",
    true,
    "Starts the components of a robot at the router of -H, passes on what they say, and starts "
    "again what crashes. Runs until Ctrl-C and ends them then. FILE - is stdin. Exit status 1: a "
    "component ended and stayed down.",
    "timsctl up deploy/robots/sim.toml --system 1",
    nullptr,
    kTexts,
    kProgram};

inline constexpr Verb kDown{"down",
                            "",
                            "[NAME]",
                            0,
                            1,
                            "",
                            false,
                            "Ends a robot that `up` has started, on this host.",
                            "timsctl down sim-1",
                            nullptr,
                            kTexts,
                            kProgram};

inline constexpr Verb kShow{
    "robot",
    "show",
    "",
    0,
    0,
    "",
    false,
    "Robots that `up` has started on this host: their programs, and how they are.",
    "timsctl robot",
    nullptr,
    kRows,
    kProgram};

// What `timsctl component param save` becomes.
inline constexpr Verb kSave{"component",
                            "save",
                            "ADDR [NAME]",
                            1,
                            2,
                            "wait dry-run",
                            false,
                            "Writes the parameters of a component that were set since `up` started "
                            "it into the robot's file.",
                            "timsctl component param save Chassis/1/0",
                            nullptr,
                            kRows,
                            kProgram};

}  // namespace timsctl::robot
