// A mailbox with all its users, and a record of the results they got. judge() checks the invariants
// against this record after every run of a schedule.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shm/receiver.h"
#include "shm/sender.h"
#include "tests/sched/scheduler.h"

namespace tims::sched {

// A message, from the call of claim() on. Times are ticks of the record; 0: has not happened.
struct Message {
  std::uint32_t number = 0;
  std::uint8_t priority = 0;
  std::uint32_t writer = 0;
  std::uint64_t begun = 0;
  std::uint64_t claimed = 0;
  std::uint64_t committed = 0;  // commit() has returned success
  std::uint64_t taken = 0;
  bool given_up = false;
  bool was_full = false;    // at some time during claim(): no slot for its priority
  bool had_closed = false;  // before claim() returned
  shm::SendOutcome claim_outcome = shm::SendOutcome::kFull;
  shm::SendOutcome outcome = shm::SendOutcome::kFull;
  shm::Claim claim;

  [[nodiscard]] bool has_slot() const { return claimed != 0 && shm::taken(claim_outcome); }
};

class MailboxFixture {
 public:
  static constexpr std::uint32_t kBodyBytes = 40;

  // On weak memory a thread may not have seen the latest values yet. Order is therefore checked
  // only between messages of one writer, and not whether the mailbox was full or a message was
  // waiting.
  explicit MailboxFixture(Scheduler& scheduler, const WeakMemory* weak = nullptr)
      : scheduler_(scheduler), weak_(weak) {}

  // Creates a new mailbox and clears the record.
  void reset(std::uint32_t slots);

  // Operations of the threads, as in the library's client.
  void send(std::uint32_t writer, std::uint8_t priority = 0);
  void loan_and_give_up(std::uint32_t writer);
  // Takes, reads and releases one message; false: none is available.
  bool receive();
  // The same, but sleeps until a message arrives if none is available.
  void receive_or_sleep();
  std::optional<shm::Taken> peek();
  void release(const shm::Taken& taken);
  void peek_and_put_back();
  void close();
  // What the router does for `writer` after a thread has crashed.
  void reclaim_after_death(std::uint32_t writer);
  void reclaim_slots_of(std::uint32_t writer);

  // Preparation, not recorded: advances every ring by so many places.
  void advance(std::uint32_t messages);
  // Sets the generation of every slot, as after so many claims.
  void age_slots(std::uint32_t generation);
  // Like advance(), for the arrival ring only: messages are sent and not taken.
  void overrun(std::uint32_t messages);

  // Called after every step; records whether the mailbox is full.
  void observe();
  // After the run: takes all messages and returns the first violated invariant, if any.
  std::optional<std::string> judge(const Outcome& outcome);

  [[nodiscard]] shm::Receiver& receiver() { return *receiver_; }
  [[nodiscard]] const shm::MailboxView& view() const { return view_; }
  [[nodiscard]] std::string name_of(Operation operation) const;

 private:
  struct Releaser {
    void operator()(std::byte* memory) const;
  };

  Message& begin(std::uint32_t writer, std::uint8_t priority);
  bool claim(shm::Sender& sender, Message& message);
  void wake(shm::Sender& sender);
  shm::Sender& sender_of(std::uint32_t writer);
  void send_unrecorded();
  void write(const Message& message);
  std::optional<std::uint32_t> read(const shm::Taken& taken);

  // judge.cpp
  [[nodiscard]] shm::SlotWord word_of(std::uint32_t index) const;
  [[nodiscard]] bool still_readable(const Message& message) const;
  void look_for_room(Message& message) const;
  [[nodiscard]] std::vector<const Message*> certainly_waiting() const;
  [[nodiscard]] const Message* replaced_by(const Message& message) const;
  void check_claim(const Message& message);
  void check_victim(const Message& message);
  void check_taken(const Message& message, std::uint64_t begun,
                   const std::vector<const Message*>& waiting);
  void check_nothing_taken(const std::vector<const Message*>& waiting);
  void check_order();
  void check_losses(bool died);
  void check_counters(bool died);
  void check_sleep(Threads stuck);
  void check_slots_come_back();
  void check_rings_are_well();
  void accuse(std::string what);

  Scheduler& scheduler_;
  const WeakMemory* weak_;
  std::unique_ptr<std::byte, Releaser> memory_;
  std::size_t bytes_ = 0;
  shm::MailboxView view_;
  std::optional<shm::Receiver> receiver_;
  std::deque<shm::Sender> senders_;  // by writer, from 1
  std::vector<Message> messages_;
  std::vector<Message*> claiming_;
  std::uint64_t ticks_ = 0;
  std::uint64_t takes_ = 0;
  std::uint64_t unrecorded_replacements_ = 0;
  bool closed_ = false;
  bool asleep_ = false;
  std::optional<std::string> accusation_;
};

}  // namespace tims::sched
