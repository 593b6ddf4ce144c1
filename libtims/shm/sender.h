// The sending side of a mailbox: claim a slot, write the message into it, commit. Lock-free, any
// number of threads and processes; never waits. Waking a sleeping owner is the caller's business.
#pragma once

#include <atomic>
#include <cstdint>

#include "shm/checked_view.h"
#include "shm/slot.h"

namespace tims::shm {

enum class SendOutcome : std::uint8_t {
  kOk,
  kReplaced,   // claimed, and an older message had to go for it
  kFull,       // only more important messages, or slots that are being written or read
  kTooBig,     // larger than a slot
  kClosed,     // the mailbox is gone; look the address up again
  kReclaimed,  // the router had given this writer up and took the slot back
};
constexpr bool taken(SendOutcome o) { return o == SendOutcome::kOk || o == SendOutcome::kReplaced; }

// A slot that belongs to one sender until it commits or gives up.
struct Claim {
  std::uint32_t index = 0;
  SlotWord word;
  std::byte* message = nullptr;  // room for the header and the body
};

class Sender {
 public:
  // `writer`: the identity the router gave this process, 1 to 0xFFFFFF.
  Sender(const MailboxView& view, std::uint32_t writer) : view_(view), writer_(writer) {}

  // `length`: of the whole message. kOk or kReplaced: `claim` is set.
  SendOutcome claim(std::uint32_t length, std::uint8_t priority, Claim& claim);
  // Makes the message visible. kOk or kReclaimed.
  SendOutcome commit(const Claim& claim);
  void give_up(const Claim& claim);

  // After commit: the value of MailboxHeader::sleep when the owner must be woken, else 0.
  [[nodiscard]] std::uint32_t sleeper() const {
    const std::uint32_t sleep = view_.header().sleep.load(std::memory_order_seq_cst);
    return (sleep & 1) != 0 ? sleep : 0;
  }
  [[nodiscard]] bool closed() const {
    return view_.header().closed.load(std::memory_order_acquire) != 0;
  }
  [[nodiscard]] const MailboxView& view() const { return view_; }

 private:
  bool claim_free(std::uint8_t priority, Claim& claim);
  SendOutcome claim_by_scan(std::uint8_t priority, Claim& claim);
  bool claim_slot(std::uint32_t index, SlotWord from, std::uint8_t priority, Claim& claim);
  // What one look at every slot has found.
  struct Room {
    bool found = false;
    std::uint32_t index = 0;
    SlotWord word;
    std::uint64_t fingerprint = 0;  // of all words
  };
  [[nodiscard]] Room find_room(std::uint8_t priority) const;
  [[nodiscard]] Stamp now() const;
  void announce(const Claim& claim);
  bool ring_full(std::uint64_t position);

  MailboxView view_;
  std::uint32_t writer_;
  // The owner's head as last seen: spares the sender the owner's cache line.
  Word64 arrival_head_seen_{0};
};

}  // namespace tims::shm
