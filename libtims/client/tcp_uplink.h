// The uplink of a session whose router is reached over TCP: the mailbox that takes what the
// session sends, and its bytes on their way into the socket. A sender finds no room in it only
// when the router has taken nothing for a while.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "os/file.h"
#include "os/mapping.h"
#include "shm/receiver.h"
#include "tims/result.h"

namespace tims::client {

class TcpUplink {
 public:
  static Result<std::unique_ptr<TcpUplink>> make(std::uint32_t message_max);

  // For the senders.
  [[nodiscard]] const os::File& memfd() const { return memfd_; }
  [[nodiscard]] const os::File& doorbell() const { return doorbell_; }

  // Appends what waits, the most important first, until `out` has as much as suits one write.
  // False: there was nothing; the doorbell rings for the next message.
  bool take(std::vector<std::byte>& out);
  // As much as it holds at most, also when senders go on meanwhile.
  void take_all(std::vector<std::byte>& out);

 private:
  TcpUplink(os::File memfd, os::File doorbell, os::Mapping mapping, std::uint32_t message_max);

  os::File memfd_;
  os::File doorbell_;
  os::Mapping mapping_;
  shm::Receiver receiver_;
};

}  // namespace tims::client
