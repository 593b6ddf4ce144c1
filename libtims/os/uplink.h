// The system's side of mailboxes in shared memory: waking an owner who sleeps, and the uplink, in
// which a session puts what it cannot deliver itself.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "os/file.h"
#include "os/shared_memory.h"
#include "shm/receiver.h"
#include "shm/sender.h"
#include "tims/result.h"

namespace tims::os {

// How the owner of a mailbox is woken: -1, by its futex.
struct Waker {
  int fd = -1;
  bool is_doorbell = false;  // an eventfd of the router's, else a socket (os/wakeup.h)
};

// Wakes the owner of a mailbox if it sleeps; after each message that was put into it.
//
// Every kind wakes first and clears the sign after it, or both at once: a sender that dies in
// between leaves the owner woken, or the sign standing for the next sender. Which kind it is says
// the router, not the memory, which the owner can change: a waker is checked, a doorbell is the
// router's own.
void wake_sleeper(const shm::Sender& sender, std::uint32_t sleep, Waker waker);
inline void wake_owner(const shm::Sender& sender, Waker waker) {
  if (const std::uint32_t sleep = sender.sleeper()) wake_sleeper(sender, sleep, waker);
}

// The mailbox in which a router, or the thread that stands in for one that is reached over TCP,
// takes what a session cannot deliver itself. Its memory belongs to the one who takes, so that a
// session can spoil only its own.
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

}  // namespace tims::os
