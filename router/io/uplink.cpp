#include "router/io/uplink.h"

#include "os/event_fd.h"

namespace tims::io {

namespace {

constexpr std::uint32_t kLongPlaces = 64;
constexpr std::size_t kPage = 4096;
constexpr std::size_t kKeepBytes = 2 << 20;  // of a place: stays in memory for the next message

}  // namespace

Result<std::unique_ptr<Uplink>> Uplink::make(std::uint32_t message_max) {
  auto memfd =
      os::make_memfd("tims-uplink", shm::Geometry::of(kSlots, message_max, kLongPlaces).bytes);
  if (!memfd) return memfd.error();
  auto doorbell = os::make_event_fd();
  if (!doorbell) return doorbell.error();
  auto mapping = os::Mapping::of(*memfd);
  if (!mapping) return mapping.error();
  return std::unique_ptr<Uplink>(
      new Uplink(std::move(*memfd), std::move(*doorbell), std::move(*mapping), message_max));
}

Uplink::Uplink(os::File memfd, os::File doorbell, os::Mapping mapping, std::uint32_t message_max)
    : memfd_(std::move(memfd)),
      doorbell_(std::move(doorbell)),
      mapping_(std::move(mapping)),
      receiver_(shm::MailboxView::create(mapping_.bytes(), 0,
                                         {.address = Address(),
                                          .slots = kSlots,
                                          .message_max = message_max,
                                          .long_places = kLongPlaces,
                                          .wake = shm::WakeKind::kDoorbell})) {
  receiver_.arm();
}

void Uplink::release(const shm::Taken& taken) {
  if (taken.body.size() > kKeepBytes) {
    const std::size_t begin = static_cast<std::size_t>(taken.body.data() - mapping_.bytes().data());
    const std::size_t first = (begin + kPage - 1) / kPage * kPage;
    const std::size_t last = (begin + taken.body.size()) / kPage * kPage;
    mapping_.discard(first, last - first);
  }
  receiver_.release(taken.hint);
}

}  // namespace tims::io
