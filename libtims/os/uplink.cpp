#include "os/uplink.h"

#include "os/wakeup.h"

namespace tims::os {

namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kKeepBytes = 2 << 20;  // of a place: stays in memory for the next message

}  // namespace

void wake_sleeper(const shm::Sender& sender, std::uint32_t sleep, Waker waker) {
  shm::Word32& word = sender.view().header().sleep;
  if (waker.fd < 0) return futex_clear_and_wake(*word.raw());
  waker.is_doorbell ? signal_event_fd(waker.fd) : wake(waker.fd);
  word.compare_exchange(sleep, sleep & ~1U, std::memory_order_acq_rel);
}

Result<std::unique_ptr<Uplink>> Uplink::make(const std::string& name, const Size& size) {
  auto memfd =
      make_memfd(name, shm::Geometry::of(size.slots, size.message_max, size.long_places).bytes);
  if (!memfd) return memfd.error();
  auto doorbell = make_event_fd();
  if (!doorbell) return doorbell.error();
  auto mapping = Mapping::of(*memfd);
  if (!mapping) return mapping.error();
  return std::unique_ptr<Uplink>(
      new Uplink(std::move(*memfd), std::move(*doorbell), std::move(*mapping), size));
}

Uplink::Uplink(File memfd, File doorbell, Mapping mapping, const Size& size)
    : memfd_(std::move(memfd)),
      doorbell_(std::move(doorbell)),
      mapping_(std::move(mapping)),
      receiver_(shm::MailboxView::create(mapping_.bytes(), 0,
                                         {.address = Address(),
                                          .slots = size.slots,
                                          .message_max = size.message_max,
                                          .long_places = size.long_places,
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

}  // namespace tims::os
