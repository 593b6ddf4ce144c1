// Shared memory between clients and their router, or the thread that replaces the router for a
// session over TCP (client/tcp_bridge.h): the uplink of each client, and the mailboxes that clients
// have laid out in their own memory.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "os/file.h"
#include "os/shared_memory.h"
#include "shm/receiver.h"
#include "shm/sender.h"
#include "tims/result.h"

namespace tims::os {

// The mailbox through which a session sends what it cannot deliver itself. The memory belongs to
// the receiving side and is used by one session only, so a session can corrupt only its own uplink.
class Uplink {
 public:
  struct Size {
    std::uint32_t slots = 0;        // messages
    std::uint32_t long_places = 0;  // for long messages among them
    std::uint32_t message_max = 0;  // bytes, header included
  };
  // Each place has room for the largest message, in sparse memory: pages are allocated when
  // written, and the pages of a large message are released after it. The uplink is armed: the first
  // message rings the doorbell.
  static Result<std::unique_ptr<Uplink>> make(const std::string& name, const Size& size);

  // For the senders. The doorbell is an eventfd that signals a new message.
  [[nodiscard]] const File& memfd() const { return memfd_; }
  [[nodiscard]] const File& doorbell() const { return doorbell_; }

  [[nodiscard]] std::size_t size() const { return mapping_.bytes().size(); }  // bytes, all of it
  [[nodiscard]] shm::Receiver& receiver() { return receiver_; }
  void release(const shm::Taken& taken);

 private:
  Uplink(File memfd, File doorbell, Mapping mapping, const Size& size);

  File memfd_;
  File doorbell_;
  Mapping mapping_;
  shm::Receiver receiver_;
};

// The memory that clients have offered, and the mailboxes in it.
class ClientMemory {
 public:
  using SegmentId = std::uint64_t;       // never reused
  static constexpr SegmentId kLost = 0;  // id of a segment whose descriptor did not arrive
  using Handle = std::uint32_t;          // of one mailbox; never 0

  // `writer`: identity under which this process writes into the mailboxes.
  explicit ClientMemory(std::uint32_t writer) : writer_(writer) {}

  // The file must be sealed and large enough for the mailboxes in it: both are checked when it is
  // mapped.
  SegmentId offer(File memfd);
  // A segment without mailboxes is removed when its client disconnects, or with its last mailbox.
  void drop_if_empty(SegmentId id);
  [[nodiscard]] bool knows(SegmentId id) const { return segments_.contains(id); }

  // Maps the segment if necessary, and checks the mailbox's layout.
  Result<Handle> add_mailbox(SegmentId id, std::uint64_t offset, Address address, File waker);
  // Marks the mailbox as closed for senders; the segment is removed with its last mailbox.
  void remove_mailbox(Handle handle);
  // Undoes add_mailbox() for a mailbox that was not registered; its memory is not changed.
  void withdraw_mailbox(Handle handle);
  // The mailbox is registered: senders may use it, also when it was marked closed at the end of an
  // earlier connection.
  void open_mailbox(Handle handle);

  struct Mailbox {
    SegmentId segment = 0;
    std::uint64_t offset = 0;
    Address address;
    std::unique_ptr<shm::Sender> sender;
    File waker;  // none: wake by futex
  };
  [[nodiscard]] const Mailbox& mailbox(Handle handle) const { return mailboxes_[handle]; }
  // Null when no mailbox has this handle (any more).
  [[nodiscard]] const Mailbox* find(Handle handle) const {
    return handle < mailboxes_.size() && mailboxes_[handle].sender ? &mailboxes_[handle] : nullptr;
  }
  [[nodiscard]] const File& memfd(SegmentId id) const { return segments_.at(id).memfd; }

  // Sums over all mailboxes, removed ones included: counters of a process only grow.
  [[nodiscard]] shm::Counters counters() const;

  // Puts a whole message into the mailbox and wakes its owner. kClosed: there is no such mailbox.
  shm::SendOutcome deliver(Handle handle, std::span<const std::byte, kHeaderSize> header,
                           std::span<const std::byte> body, std::uint8_t priority);

  // Reclaims the slots of one segment that were being written by writers for which
  // `is_dead(writer)` holds, and makes the owner look for messages that they committed but did not
  // announce.
  template <typename IsDead>
  void reclaim(SegmentId id, const IsDead& is_dead) {
    const auto found = segments_.find(id);
    if (found == segments_.end()) return;
    for (const Handle handle : found->second.mailboxes) {
      shm::reclaim(mailboxes_[handle].sender->view(), is_dead);
      wake(mailboxes_[handle]);
    }
  }
  template <typename IsDead>
  void reclaim_everywhere(const IsDead& is_dead) {
    for (const auto& [id, segment] : segments_) reclaim(id, is_dead);
  }

 private:
  struct Segment {
    File memfd;
    Mapping mapping;
    std::vector<Handle> mailboxes;
  };
  static void wake(const Mailbox& mailbox) { wake_owner(*mailbox.sender, {mailbox.waker.get()}); }

  const std::uint32_t writer_;
  std::unordered_map<SegmentId, Segment> segments_;
  // The first element is never used: 0 is not a valid handle.
  std::vector<Mailbox> mailboxes_ = std::vector<Mailbox>(1);
  std::vector<Handle> free_;
  shm::Counters gone_;  // counters of removed mailboxes
  SegmentId last_ = 0;
};

}  // namespace tims::os
