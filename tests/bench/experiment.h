// One measurement: the processes, the routers or relays between them, and the result.
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
  kPulse,      // a pulse and its gauge, optionally with a stream of large messages
  kScan,       // a scanner and its listeners
  kClock,      // one process that measures its wake-ups, and processes that load the CPUs
  kAlone,      // one process with its own role
  kIdle,       // only the router
  kIdleLink,   // only two routers
  kLinkDeath,  // and the cable between them is cut
  kConvergence,
  kFleetJoin,   // one router discovers another
  kFleetStart,  // many routers at once, in one network
  kFailover,    // UDP between them is cut and restored
};
enum class Between {
  kNothing,
  kRouter,
  kRelay,
  // Two hosts, receivers at the base and senders at the robot:
  kCable,  // only the cable
  kTwoRouters,
  kTwoRelays,
};
constexpr bool on_two_hosts(Between between) { return between >= Between::kCable; }

struct Experiment {
  Shape shape = Shape::kRoundTrip;
  std::string link{};  // the link of ping and echo, source and sinks; or the role of a single
                       // process, optionally as ROLE:LINK
  Between between = Between::kNothing;
  std::size_t payload = 64;
  std::uint32_t subscribers = 1;
  std::uint32_t pairs = 1;  // of source and sink, in parallel
  std::uint64_t count = 0;
  Duration every = std::chrono::milliseconds(5);  // the period, if any
  std::size_t bulk = 0;             // size of the large messages during a pulse in bytes; 0: none
  std::uint32_t priority = 255;     // of a pulse
  std::uint64_t flood = 0;          // forged HELLOs a second at the base during a pulse
  std::uint32_t bulk_priority = 0;  // of the large messages
  Cable cable{};                    // between two hosts
  std::string paths{};              // between two routers; with dds: they connect by name
  bool rate_is_set = false;         // the capacity of the cable is configured in the routers
  bool sealed = false;              // the routers have keys
  bool one_cpu = false;             // all processes share the last CPU
  bool with_rules = false;          // the router has a policy of 100 rules
  bool traced = false;              // with strace, to count system calls
};

// Common settings of all measurements of a run.
struct Setting {
  std::string program;  // path of this program
  std::string router;
  std::string folder;  // temporary, in memory
  Duration round_trip{};
  Duration stream{};
  Duration link{};  // a pulse over a link, or an idle link
};

Result<Metrics> measure(const Experiment& experiment, const Setting& setting);

}  // namespace tims::bench
