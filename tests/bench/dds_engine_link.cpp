#include "tests/bench/dds_engine_link.h"

#include <algorithm>
#include <cstring>

#include <unistd.h>

#include "router/link/datagram.h"
#include "tests/bench/dds_host.h"

namespace tims::bench {
namespace {

constexpr const char* kFleet = "bench";
constexpr Duration kDdsEngineLinkPatience = std::chrono::seconds(1);

}  // namespace

DdsEngineLink::Host::Host()
    : log(config::LogLevel::kWarning), engine(loop, log, {.fleet = kFleet}, *this) {}

Result<DdsEngineLink> DdsEngineLink::open(const Plan& plan) {
  wait_for_interface(plan.host);
  DdsEngineLink link;
  const link::Announcement self{.fleet = std::string_view(kFleet),
                                .identity = {.epoch = static_cast<std::uint64_t>(::getpid()),
                                             .name = std::string_view(plan.role)}};
  if (auto started = link.host_->engine.start(self); !started) return started.error();
  return link;
}

std::span<const std::byte> DdsEngineLink::message_at(std::span<const std::byte> bytes,
                                                     std::size_t at) {
  std::uint32_t size = 0;
  if (bytes.size() - at < kSize) return {};
  std::memcpy(&size, &bytes[at], kSize);
  return bytes.size() - at - kSize < size ? std::span<const std::byte>()
                                          : bytes.subspan(at + kSize, size);
}

// Waits for room, and at first for the discovery of the receiver.
bool DdsEngineLink::send(std::span<const std::byte> payload) {
  constexpr std::size_t kDatagram = link::kDatagramMax;
  constexpr std::size_t kBurst = link::kBurstBytesMax / kDatagram * kDatagram;
  const auto size = static_cast<std::uint32_t>(payload.size());
  out_.resize(kSize + size);
  std::memcpy(out_.data(), &size, kSize);
  std::memcpy(out_.data() + kSize, payload.data(), size);
  Host& host = *host_;
  const Time limit = os::now() + kDdsEngineLinkPatience;
  for (std::span<const std::byte> rest = out_; !rest.empty();) {
    const auto burst = rest.first(std::min(rest.size(), kBurst));
    if (host.engine.send({.to = host.peer, .bytes = burst, .datagram_size = kDatagram})) {
      rest = rest.subspan(burst.size());
    } else {
      const Time now = os::now();
      if (now >= limit) return false;
      host.loop.run_once(now + std::chrono::microseconds(100));
    }
  }
  return true;
}

}  // namespace tims::bench
