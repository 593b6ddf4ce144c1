#include "client/tcp_uplink.h"

#include "os/event_fd.h"
#include "wire/header.h"

namespace tims::client {

namespace {

constexpr std::uint32_t kSlots = 256;
constexpr std::uint32_t kLongPlaces = 16;
constexpr std::size_t kWriteBytes = 64 << 10;

void append(const shm::Taken& message, std::vector<std::byte>& out) {
  const std::size_t at = out.size();
  out.resize(at + kHeaderSize);
  wire::encode_header(message.header, wire::HeaderBytes(out.data() + at, kHeaderSize));
  out.insert(out.end(), message.body.begin(), message.body.end());
}

}  // namespace

Result<std::unique_ptr<TcpUplink>> TcpUplink::make(std::uint32_t message_max) {
  auto memfd =
      os::make_memfd("tims-tcp-uplink", shm::Geometry::of(kSlots, message_max, kLongPlaces).bytes);
  if (!memfd) return memfd.error();
  auto doorbell = os::make_event_fd();
  if (!doorbell) return doorbell.error();
  auto mapping = os::Mapping::of(*memfd);
  if (!mapping) return mapping.error();
  return std::unique_ptr<TcpUplink>(
      new TcpUplink(std::move(*memfd), std::move(*doorbell), std::move(*mapping), message_max));
}

TcpUplink::TcpUplink(os::File memfd, os::File doorbell, os::Mapping mapping,
                     std::uint32_t message_max)
    : memfd_(std::move(memfd)),
      doorbell_(std::move(doorbell)),
      mapping_(std::move(mapping)),
      receiver_(shm::MailboxView::create(mapping_.bytes(), 0,
                                         {.address = Address(),
                                          .slots = kSlots,
                                          .message_max = message_max,
                                          .long_places = kLongPlaces,
                                          .wake = shm::WakeKind::kDoorbell})) {}

bool TcpUplink::take(std::vector<std::byte>& out) {
  const std::size_t before = out.size();
  while (out.size() - before < kWriteBytes) {
    if (const auto taken = receiver_.take()) {
      append(*taken, out);
      receiver_.release(taken->hint);
      continue;
    }
    if (receiver_.rest()) break;
  }
  return out.size() > before;
}

void TcpUplink::take_all(std::vector<std::byte>& out) {
  const std::size_t limit = out.size() + mapping_.bytes().size();
  for (std::uint32_t n = 0; n < kSlots && out.size() < limit;) {
    if (const auto taken = receiver_.take()) {
      append(*taken, out);
      receiver_.release(taken->hint);
      ++n;
    } else if (receiver_.rest()) {
      return;
    }
  }
}

}  // namespace tims::client
