// The mailboxes of a session whose router is reached over TCP: what comes from the router is
// delivered here, in this process.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "os/file.h"
#include "os/shared_memory.h"
#include "shm/sender.h"
#include "tims/address.h"
#include "tims/message.h"
#include "tims/result.h"
#include "wire/local_protocol.h"

namespace tims::client {

inline constexpr std::uint32_t kTcpWriter = 1;  // the only process that writes to them

class TcpMailboxes {
 public:
  Result<void> offer(std::uint64_t segment, const os::File& memfd);
  // `waker` may be none: a futex. kAddressInUse: another mailbox of this session has it.
  // `widths`: for its text.
  Result<void> add(const wire::OpenEntry& entry, os::File waker, const AddressWidths& widths);
  bool remove(Address address);  // false: unknown

  // To the mailbox of its receiver, if it has room; what it does not take, it counts.
  void deliver(const Header& header, std::span<const std::byte> body);

 private:
  struct Segment {
    os::Mapping mapping;
    std::size_t mailboxes = 0;
  };
  struct Mailbox {
    std::uint64_t segment = 0;
    std::unique_ptr<shm::Sender> sender;
    os::File waker;
  };

  std::map<std::uint64_t, Segment> segments_;
  std::map<Address, Mailbox> mailboxes_;
};

}  // namespace tims::client
