#include "tests/bench/dds_engine_link.h"

#include <algorithm>

#include "router/link/datagram.h"

namespace tims::bench {
namespace {

constexpr const char* kFleet = "bench";
constexpr Duration kPatience = std::chrono::seconds(1);

}  // namespace

DdsEngineLink::Host::Host(const Plan&)
    : log(config::LogLevel::kWarning), engine(loop, log, {.fleet = kFleet}, *this) {}

Result<DdsEngineLink> DdsEngineLink::open(const Plan& plan) {
  DdsEngineLink link(plan);
  const link::Announcement self{.fleet = std::string_view(kFleet),
                                .who = {.epoch = 1, .name = std::string_view(plan.role)}};
  if (auto started = link.host_->engine.start(self); !started) return started.error();
  return link;
}

// Both wait for room, and the sender for whom it sends to.
bool DdsEngineLink::send(std::span<const std::byte> payload) {
  constexpr std::size_t kDatagram = link::kDatagramMax;
  constexpr std::size_t kTrain = link::kTrainBytesMax / kDatagram * kDatagram;
  Host& host = *host_;
  const Time limit = os::now() + kPatience;
  while (!payload.empty()) {
    const auto train = payload.first(std::min(payload.size(), kTrain));
    if (host.engine.send({.to = host.peer, .bytes = train, .datagram_size = kDatagram})) {
      payload = payload.subspan(train.size());
    } else {
      const Time now = os::now();
      if (now >= limit) return false;
      host.loop.run_once(now + std::chrono::microseconds(100));
    }
  }
  return true;
}

}  // namespace tims::bench
