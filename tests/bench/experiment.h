// One measurement: which processes run, with what between them, and what comes out.
#pragma once

#include <cstdint>
#include <string>

#include "tests/bench/metrics.h"
#include "tests/bench/two_hosts.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::bench {

enum class Shape {
  kRoundTrip,  // ping and echo
  kStream,     // a source and its sinks
  kPulse,      // a pulse and its gauge, perhaps beside a stream of large messages
  kScan,       // a scanner and its listeners
  kClock,      // one process that keeps time, and those that are in its way
  kAlone,      // one process with a role of its own
  kIdle,       // nothing but the router
  kIdleLink,   // nothing but two routers
  kLinkDeath,  // and the cable between them is cut
  kConvergence,
  kFleetJoin,   // one router finds another
  kFleetStart,  // so many at once, in one network
  kFailover,    // UDP between them is cut, and comes back
};
enum class Between {
  kNothing,
  kRouter,
  kRelay,
  // Two hosts, receivers at the base and senders at the robot:
  kCable,  // nothing but that
  kTwoRouters,
  kTwoRelays,
};
constexpr bool on_two_hosts(Between between) { return between >= Between::kCable; }

struct Experiment {
  Shape shape = Shape::kRoundTrip;
  std::string link{};  // what ping and echo, source and sinks use; or the role that works alone,
                       // perhaps as ROLE:LINK
  Between between = Between::kNothing;
  std::size_t payload = 64;
  std::uint32_t subscribers = 1;
  std::uint32_t pairs = 1;  // of source and sink, side by side
  std::uint64_t count = 0;
  Duration every = std::chrono::milliseconds(5);  // of what has a period
  std::size_t bulk = 0;             // bytes of the messages beside a pulse; 0: there are none
  std::uint32_t priority = 255;     // of a pulse
  std::uint32_t bulk_priority = 0;  // of what is beside it
  Cable cable{};                    // between two hosts
  std::string paths{};              // of routers that find each other by name; empty: by address
  bool rate_told = false;           // to the routers: what the cable carries
  bool one_cpu = false;             // all processes share the last CPU
  bool traced = false;              // under strace: how many system calls
};

// What every measurement of a run shares.
struct Setting {
  std::string program;  // this one
  std::string router;
  std::string folder;  // scratch, in memory
  Duration round_trip{};
  Duration stream{};
  Duration link{};  // a pulse over a link, or an idle one
};

Result<Metrics> measure(const Experiment& experiment, const Setting& setting);

}  // namespace tims::bench
