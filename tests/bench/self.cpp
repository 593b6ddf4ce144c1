#include "tests/bench/self.h"

#include <cstdio>

#include "tests/bench/limits.h"
#include "tests/bench/tims_link.h"

namespace tims::bench {
namespace {

// Two mailboxes of one process, with the options of a source and of a sink.
bool pass_messages(Plan plan, TimsLink::Method method) {
  plan.role = "sink";
  auto sink = TimsLink::open(plan, TimsLink::Method::kCopy);
  plan.role = "source";
  auto source = TimsLink::open(plan, method);
  if (!sink || !source) {
    const Error& error = sink ? source.error() : sink.error();
    std::fprintf(stderr, "self: %s\n", error.message().c_str());
    return false;
  }
  Payload payload(plan.payload);
  std::uint64_t seq = 0;
  measure_passes(plan, [&] {
    std::uint64_t received = 0;
    for (std::uint64_t i = 0; i < plan.window; ++i) {
      source->send(payload.with({.kind = Kind::kData, .seq = ++seq}));
      sink->receive(Duration::zero(), [&](std::span<const std::byte>) { ++received; });
    }
    return received;
  });
  return true;
}

}  // namespace

bool send_to_myself(const Plan& plan) { return pass_messages(plan, TimsLink::Method::kCopy); }
bool loan_to_myself(const Plan& plan) { return pass_messages(plan, TimsLink::Method::kLoan); }

}  // namespace tims::bench
