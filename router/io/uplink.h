// The mailbox in which the router takes what a local client cannot deliver itself: one for each
// client that needs it, in memory of the router, so that a client can spoil only its own.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "os/file.h"
#include "os/mapping.h"
#include "shm/receiver.h"
#include "tims/result.h"

namespace tims::io {

class Uplink {
 public:
  static constexpr int kSlots = 1024;  // messages

  // Room for the largest message in each slot, in sparse memory: only what is written to takes
  // pages, and a large message's pages go back after it.
  static Result<std::unique_ptr<Uplink>> make(std::uint32_t message_max);

  [[nodiscard]] const os::File& memfd() const { return memfd_; }
  // An eventfd: the client says that something has come.
  [[nodiscard]] const os::File& doorbell() const { return doorbell_; }
  [[nodiscard]] shm::Receiver& receiver() { return receiver_; }
  void release(const shm::Taken& taken);

 private:
  Uplink(os::File memfd, os::File doorbell, os::Mapping mapping, std::uint32_t message_max);

  os::File memfd_;
  os::File doorbell_;
  os::Mapping mapping_;
  shm::Receiver receiver_;
};

}  // namespace tims::io
