// What a former router is said to have left: any bytes, or any links in a state that is right
// otherwise. Properties: the router starts, stays within its memory, and its turns end.
#include <vector>

#include "router/link/handover.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/small_node.h"
#include "tests/sim/simulated_network.h"

namespace {

using namespace tims;
using namespace std::chrono_literals;

struct Restarted : sim::SimulatedNetwork {
  Restarted() : SimulatedNetwork(1) {
    base = &add(fuzz::small_node("base", core::Role::kTop, 0, {sim::sub_link()}));
    robot = &add(fuzz::small_node("robot", core::Role::kSystem, 1,
                                  {sim::super_link(sim::address_of(0)), sim::sub_link()}));
    base->start(now());
  }
  void restart_with(std::span<const std::byte> links) {
    robot->start(now());
    link::Handover former{.at = now(), .self = robot->links().self()};
    former.links.assign(links.begin(), links.end());
    robot->kill();
    fuzz::require(robot->start(now(), former.encode()).has_value());
    run_for(300ms);
    // It can also be left to the next one.
    const auto again = robot->hand_over(now());
    fuzz::require(robot->start(now(), again).has_value());
    run_for(100ms);
  }

  sim::Node* base;
  sim::Node* robot;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(1);
  if (data[0] == 0) {
    const auto former = link::Handover::decode(Time(100s), bytes);
    if (former) fuzz::require(former->encode().size() == bytes.size());
    return 0;
  }
  Restarted().restart_with(bytes);
  return 0;
}
