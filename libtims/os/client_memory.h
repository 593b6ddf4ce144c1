// Shared memory between clients and their router, or the thread that stands in for one that is
// reached over TCP (client/tcp_bridge.h): the uplink of each client, and the mailboxes that clients
// have laid out in memory of their own.
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

// The mailbox in which a router takes what a session cannot deliver itself. Its memory belongs to
// the one who takes, so that a session can spoil only its own.
class Uplink {
 public:
  struct Size {
    std::uint32_t slots = 0;        // messages
    std::uint32_t long_places = 0;  // for long ones among them
    std::uint32_t message_max = 0;  // bytes, header included
  };
  // Room for the largest message in each place, in sparse memory: only what is written to takes
  // pages, and a large message's pages go back after it. Armed: the first message rings.
  static Result<std::unique_ptr<Uplink>> make(const std::string& name, const Size& size);

  // For the senders. The doorbell, an eventfd: something has come.
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
  using SegmentId = std::uint64_t;       // never used again
  static constexpr SegmentId kLost = 0;  // of one whose descriptor did not arrive
  using Handle = std::uint32_t;          // of one mailbox; never 0

  // `writer`: who writes into the mailboxes from here.
  explicit ClientMemory(std::uint32_t writer) : writer_(writer) {}

  // The file is sealed and large enough for what is said to lie in it: checked when it is mapped.
  SegmentId offer(File memfd);
  // A segment without mailboxes goes when its client does, or with its last mailbox.
  void drop_if_empty(SegmentId id);
  [[nodiscard]] bool knows(SegmentId id) const { return segments_.contains(id); }

  // Maps the segment when that has not happened yet, and checks the mailbox's layout.
  Result<Handle> add_mailbox(SegmentId id, std::uint64_t offset, Address address, File waker);
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
    File waker;  // none: a futex
  };
  [[nodiscard]] const Mailbox& mailbox(Handle handle) const { return mailboxes_[handle]; }
  // Null when the handle is no mailbox's (any more).
  [[nodiscard]] const Mailbox* find(Handle handle) const {
    return handle < mailboxes_.size() && mailboxes_[handle].sender ? &mailboxes_[handle] : nullptr;
  }
  [[nodiscard]] const File& memfd(SegmentId id) const { return segments_.at(id).memfd; }

  // Of all mailboxes, those that are gone as well: counters of a process only grow.
  [[nodiscard]] shm::Counters counters() const;

  // Puts a whole message into the mailbox, and wakes its owner. kClosed: there is none.
  shm::SendOutcome deliver(Handle handle, std::span<const std::byte, kHeaderSize> header,
                           std::span<const std::byte> body, std::uint8_t priority);

  // Takes back the slots of one segment that writers for whom `is_dead(writer)` holds were writing,
  // and makes its owner look for messages they committed but did not announce.
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
  // The first is never used: 0 is no handle.
  std::vector<Mailbox> mailboxes_ = std::vector<Mailbox>(1);
  std::vector<Handle> free_;
  shm::Counters gone_;  // of mailboxes that were removed
  SegmentId last_ = 0;
};

}  // namespace tims::os
