// The verbs of timsctl that timsctl-sim does.
#pragma once

#include "tools/cli/options.h"

namespace timsctl::sim {

inline constexpr std::string_view kProgram = "timsctl-sim";

inline constexpr Verb kUp{
    "sim",
    "up",
    "FILE",
    1,
    1,
    "fleet for detach",
    true,
    "Makes a fleet on this machine: network namespaces, a router in each, components, bad lines. "
    "Runs until Ctrl-C and takes everything down then. Exit status 1: a program ended by itself. "
    "Needs root.",
    "timsctl sim up deploy/fleets/demo.toml",
    nullptr,
    kTexts,
    kProgram};

inline constexpr Verb kDown{
    "sim",
    "down",
    "[NAME]",
    0,
    1,
    "fleet",
    false,
    "Ends a fleet, or removes what a crash has left of it; without a name all of them.",
    "timsctl sim down demo",
    nullptr,
    kTexts,
    kProgram};

inline constexpr Verb kShow{
    "sim",
    "show",
    "[NAME]",
    0,
    1,
    "",
    false,
    "Fleets on this machine: hosts, addresses, routers' sockets, lines, programs.",
    "timsctl sim show",
    nullptr,
    kTexts,
    kProgram};

inline constexpr Verb kFault{
    "sim",
    "fault",
    "LINE PROFILE|KEY=VALUE|cut|heal...",
    1,
    20,
    "fleet link",
    false,
    "Changes a line between two hosts. Profiles: cable, wifi, corridor, lte, blackout and those "
    "of the fleet file. Keys: loss, duplicate, reorder, delay, jitter, rate, and direction (up: "
    "towards the base, down). cut pulls the cable, heal makes it as the fleet file says. With "
    "--link NAME in place of LINE: what the router of -H, of any fleet, does to its own datagrams "
    "to router NAME (all: to everybody), when its sim.faults is true. What is not said is "
    "perfect; no cut and no direction: ask the other router for the other one.",
    "timsctl sim fault robot1-base loss=10% delay=20ms direction=up",
    nullptr,
    kTexts,
    kProgram};

inline constexpr Verb kKill{
    "sim",
    "kill",
    "HOST [router|PROGRAM]",
    1,
    2,
    "fleet",
    false,
    "Ends everything on a host at once, as if it lost its power; or only its router, or the "
    "programs with PROGRAM in their command.",
    "timsctl sim kill robot1-main",
    nullptr,
    kTexts,
    kProgram};

inline constexpr Verb kStart{"sim",
                             "start",
                             "HOST",
                             1,
                             1,
                             "fleet",
                             false,
                             "Starts what does not run on a host.",
                             "timsctl sim start robot1-main",
                             nullptr,
                             kTexts,
                             kProgram};

inline constexpr Verb kExec{
    "sim",
    "exec",
    "HOST COMMAND...",
    2,
    1000,
    "fleet",
    false,
    "Runs a command on a host, with $TIMS_ROUTER set. Options behind COMMAND are its own.",
    "timsctl sim exec robot1-main timsctl route show -j",
    nullptr,
    kTexts,
    kProgram};

}  // namespace timsctl::sim
