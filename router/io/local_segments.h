// The shared memory that local clients have offered, and the mailboxes in it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "os/file.h"
#include "os/shared_memory.h"
#include "router/io/reports.h"
#include "shm/sender.h"
#include "tims/address.h"
#include "tims/result.h"

namespace tims::io {

// The router's own identity as a writer: its slots are never reclaimed while it lives.
inline constexpr std::uint32_t kRouterWriter = 0xFFFFFF;

class LocalSegments {
 public:
  using SegmentId = std::uint64_t;       // unique on this host while the router runs
  static constexpr SegmentId kLost = 0;  // of one whose descriptor did not arrive
  using Handle = std::uint32_t;          // of one mailbox; never 0

  // The file is sealed and large enough for what is said to lie in it: checked when it is mapped.
  SegmentId offer(os::File memfd);
  // A segment without mailboxes goes when its client does, or with its last mailbox.
  void drop_if_empty(SegmentId id);
  [[nodiscard]] bool knows(SegmentId id) const { return segments_.contains(id); }

  // Maps the segment when that has not happened yet, and checks the mailbox's layout.
  Result<Handle> add_mailbox(SegmentId id, std::uint64_t offset, Address address, os::File waker);
  // Senders learn that it is gone; its segment goes with the last mailbox.
  void remove_mailbox(Handle handle);
  // Undoes add_mailbox() for one that was not registered; its memory stays as it is.
  void withdraw_mailbox(Handle handle);
  // It is registered: senders may use it, also when a former connection's end had closed it.
  void open_mailbox(Handle handle);

  struct Mailbox {
    SegmentId segment = 0;
    std::uint64_t offset = 0;
    Address address;
    std::unique_ptr<shm::Sender> sender;
    os::File waker;  // none: a futex
  };
  [[nodiscard]] Mailbox& mailbox(Handle handle) { return mailboxes_[handle]; }
  // Null when the handle is no mailbox's (any more).
  [[nodiscard]] const Mailbox* find(Handle handle) const {
    return handle < mailboxes_.size() && mailboxes_[handle].sender ? &mailboxes_[handle] : nullptr;
  }
  [[nodiscard]] const os::File& memfd(SegmentId id) const { return segments_.at(id).memfd; }

  [[nodiscard]] static MailboxCounts counts(const Mailbox& mailbox);
  // Of all mailboxes, those that are gone as well: counters of a process only grow.
  [[nodiscard]] MailboxCounts counts() const;

  // After a message was put into it.
  static void wake(Mailbox& mailbox);

  // Takes back the slots of one segment that writers for whom `is_dead` holds were writing, and
  // makes its owner look for messages they committed but did not announce.
  void reclaim(SegmentId id, const std::function<bool(std::uint32_t writer)>& is_dead);
  void reclaim_everywhere(const std::function<bool(std::uint32_t writer)>& is_dead);

 private:
  struct Segment {
    os::File memfd;
    os::Mapping mapping;
    std::vector<Handle> mailboxes;
  };

  std::unordered_map<SegmentId, Segment> segments_;
  std::vector<Mailbox> mailboxes_ =
      std::vector<Mailbox>(1);  // the first is never used: 0 is no handle
  std::vector<Handle> free_;
  MailboxCounts gone_;  // of mailboxes that were removed
  SegmentId last_ = 0;
};

}  // namespace tims::io
