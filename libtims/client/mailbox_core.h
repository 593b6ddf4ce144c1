// What a mailbox is behind its handle.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>

#include "client/session_core.h"
#include "shm/receiver.h"
#include "tims/mailbox.h"

namespace tims {

class MailboxCore {
 public:
  MailboxCore(std::shared_ptr<SessionCore> session, std::shared_ptr<OwnSegment> segment,
              std::size_t index, std::uint8_t priority);

  void close();
  Result<shm::Taken> take_before(Time deadline);
  Result<shm::Taken> try_take();
  void put_back(const shm::Taken& taken);
  void release(shm::Hint hint) { receiver_.release(hint); }
  std::size_t clean();

  // A slot of the receiver. `header` is completed by the caller.
  struct Draft {
    client::Target* target = nullptr;
    shm::Claim claim;
    Header header;
  };
  Result<Draft> claim(const Envelope& envelope, std::size_t body_size);
  Result<void> commit(const Draft& draft);

  [[nodiscard]] Address address() const { return address_; }
  [[nodiscard]] int event_fd() const { return event_fd_; }
  [[nodiscard]] MailboxCounters counters() const;

 private:
  shm::SendOutcome claim_slot(Draft& draft, std::uint32_t length);
  void sleep(Time deadline);
  void wake_own_readers();

  std::shared_ptr<SessionCore> session_;
  std::shared_ptr<OwnSegment> segment_;
  const Address address_;
  const std::uint8_t priority_;
  const int event_fd_;
  std::atomic<bool> closed_ = false;

  std::timed_mutex seat_;  // held by the one thread that takes or sleeps
  shm::Receiver receiver_;
};

}  // namespace tims
