#include "router/io/local_segments.h"

#include <algorithm>

#include "os/uplink.h"
#include "os/wakeup.h"
#include "shm/mailbox_view.h"

namespace tims::io {

LocalSegments::SegmentId LocalSegments::offer(os::File memfd) {
  segments_[++last_].memfd = std::move(memfd);
  return last_;
}

void LocalSegments::drop_if_empty(SegmentId id) {
  const auto found = segments_.find(id);
  if (found != segments_.end() && found->second.mailboxes.empty()) segments_.erase(found);
}

Result<LocalSegments::Handle> LocalSegments::add_mailbox(SegmentId id, std::uint64_t offset,
                                                         Address address, os::File waker) {
  const auto found = segments_.find(id);
  if (found == segments_.end()) return Error(Errc::kBadLayout, "no such segment");
  Segment& segment = found->second;
  if (segment.mapping.bytes().empty()) {
    auto mapping = os::Mapping::of(segment.memfd);
    if (!mapping) return mapping.error();
    segment.mapping = std::move(*mapping);
  }
  auto view = shm::MailboxView::open(segment.mapping.bytes(), offset);
  if (!view) return view.error();
  if (view->address() != address) return Error(Errc::kBadLayout, "another address in the layout");
  if ((view->wake() == shm::WakeKind::kSocket) != static_cast<bool>(waker) ||
      view->wake() == shm::WakeKind::kDoorbell)
    return Error(Errc::kBadLayout, "the kind of waking does not fit");
  // For everybody who will send to it.
  if (waker && !os::is_waker(waker.get()))
    return Error(Errc::kBadLayout, "what wakes its owner is no Unix datagram socket");
  Handle handle = static_cast<Handle>(mailboxes_.size());
  if (free_.empty()) {
    mailboxes_.emplace_back();
  } else {
    handle = free_.back();
    free_.pop_back();
  }
  auto sender = std::make_unique<shm::Sender>(*view, kRouterWriter);
  mailboxes_[handle] = {id, offset, address, std::move(sender), std::move(waker)};
  segment.mailboxes.push_back(handle);
  return handle;
}

void LocalSegments::remove_mailbox(Handle handle) {
  gone_ += counts(mailboxes_[handle]);
  shm::condemn(mailboxes_[handle].sender->view());
  const SegmentId id = mailboxes_[handle].segment;
  withdraw_mailbox(handle);
  drop_if_empty(id);
}

void LocalSegments::open_mailbox(Handle handle) { shm::pardon(mailboxes_[handle].sender->view()); }

void LocalSegments::withdraw_mailbox(Handle handle) {
  Mailbox& mailbox = mailboxes_[handle];
  std::erase(segments_.at(mailbox.segment).mailboxes, handle);
  mailbox = {};
  free_.push_back(handle);
}

MailboxCounts LocalSegments::counts(const Mailbox& mailbox) {
  const shm::MailboxHeader& header = mailbox.sender->view().header();
  const auto read = [](const shm::Word64& word) { return word.load(std::memory_order_relaxed); };
  return {.received = read(header.received),
          .replaced = read(header.replaced),
          .refused = read(header.refused),
          .too_big = read(header.too_big),
          .reclaimed = read(header.reclaimed)};
}

MailboxCounts LocalSegments::counts() const {
  MailboxCounts sum = gone_;
  for (const Mailbox& mailbox : mailboxes_)
    if (mailbox.sender) sum += counts(mailbox);
  return sum;
}

void LocalSegments::wake(Mailbox& mailbox) {
  os::wake_owner(*mailbox.sender, {mailbox.waker.get()});
}

void LocalSegments::reclaim(SegmentId id,
                            const std::function<bool(std::uint32_t writer)>& is_dead) {
  const auto found = segments_.find(id);
  if (found == segments_.end()) return;
  for (const Handle handle : found->second.mailboxes) {
    Mailbox& mailbox = mailboxes_[handle];
    shm::reclaim(mailbox.sender->view(), is_dead);
    wake(mailbox);
  }
}

void LocalSegments::reclaim_everywhere(const std::function<bool(std::uint32_t writer)>& is_dead) {
  for (const auto& [id, segment] : segments_) reclaim(id, is_dead);
}

}  // namespace tims::io
