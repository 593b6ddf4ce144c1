#include "os/client_memory.h"

#include "os/wakeup.h"

namespace tims::os {

namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kKeepBytes = 2 << 20;  // of one place: stays in memory for the next message

}  // namespace

// --- The uplink

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

// --- Mailboxes of clients

ClientMemory::SegmentId ClientMemory::offer(File memfd) {
  segments_[++last_].memfd = std::move(memfd);
  return last_;
}

void ClientMemory::drop_if_empty(SegmentId id) {
  const auto found = segments_.find(id);
  if (found != segments_.end() && found->second.mailboxes.empty()) segments_.erase(found);
}

Result<ClientMemory::Handle> ClientMemory::add_mailbox(SegmentId id, std::uint64_t offset,
                                                       Address address, File waker) {
  const auto found = segments_.find(id);
  if (found == segments_.end()) return Error(Errc::kBadLayout, "no such segment");
  Segment& segment = found->second;
  if (segment.mapping.bytes().empty()) {
    auto mapping = Mapping::of(segment.memfd);
    if (!mapping) return mapping.error();
    segment.mapping = std::move(*mapping);
  }
  auto view = shm::MailboxView::open(segment.mapping.bytes(), offset);
  if (!view) return view.error();
  if (view->address() != address) return Error(Errc::kBadLayout, "the layout has another address");
  if ((view->wake() == shm::WakeKind::kSocket) != static_cast<bool>(waker) ||
      view->wake() == shm::WakeKind::kDoorbell)
    return Error(Errc::kBadLayout, "the kind of waker does not match the layout");
  // Every sender will receive this descriptor, so it must be safe to use.
  if (waker && !is_waker(waker.get()))
    return Error(Errc::kBadLayout, "the waker is not a Unix datagram socket");
  Handle handle = static_cast<Handle>(mailboxes_.size());
  if (free_.empty()) {
    mailboxes_.emplace_back();
  } else {
    handle = free_.back();
    free_.pop_back();
  }
  auto sender = std::make_unique<shm::Sender>(*view, writer_);
  mailboxes_[handle] = {id, offset, address, std::move(sender), std::move(waker)};
  segment.mailboxes.push_back(handle);
  return handle;
}

void ClientMemory::remove_mailbox(Handle handle) {
  const shm::MailboxView& view = mailboxes_[handle].sender->view();
  gone_ += shm::counters(view);
  shm::condemn(view);
  const SegmentId id = mailboxes_[handle].segment;
  withdraw_mailbox(handle);
  drop_if_empty(id);
}

void ClientMemory::open_mailbox(Handle handle) { shm::pardon(mailboxes_[handle].sender->view()); }

void ClientMemory::withdraw_mailbox(Handle handle) {
  Mailbox& mailbox = mailboxes_[handle];
  std::erase(segments_.at(mailbox.segment).mailboxes, handle);
  mailbox = {};
  free_.push_back(handle);
}

shm::Counters ClientMemory::counters() const {
  shm::Counters sum = gone_;
  for (const Mailbox& mailbox : mailboxes_)
    if (mailbox.sender) sum += shm::counters(mailbox.sender->view());
  return sum;
}

shm::SendOutcome ClientMemory::deliver(Handle handle,
                                       std::span<const std::byte, kHeaderSize> header,
                                       std::span<const std::byte> body, std::uint8_t priority) {
  const Mailbox& mailbox = mailboxes_[handle];
  if (!mailbox.sender) return shm::SendOutcome::kClosed;
  const auto outcome = mailbox.sender->put(header, body, priority);
  if (shm::taken(outcome)) wake(mailbox);
  return outcome;
}

}  // namespace tims::os
