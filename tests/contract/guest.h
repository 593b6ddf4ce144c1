// A client of a router at any kind of port, for the contract tests of ports.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "tests/support/message.h"
#include "tests/support/patience.h"
#include "tims/result.h"

namespace tims::test {

// A client with one mailbox. Calls block until a deadline.
class Guest {
 public:
  Guest() = default;
  Guest(const Guest&) = delete;
  Guest& operator=(const Guest&) = delete;
  virtual ~Guest() = default;

  // kAddressInUse when the address has an owner.
  virtual Result<void> open(Address address) = 0;
  // The same, and of the samples of a stream that wait for it, the router keeps only the newest.
  // Only for guests at a socket of the router.
  virtual Result<void> open_keeping_newest(Address /*address*/) { return Errc::kInvalidArgument; }
  // From its mailbox. Of the flags only kStream is kept.
  virtual Result<void> send(const Header& header, std::span<const std::byte> body) = 0;
  // The next message to its mailbox.
  virtual Result<OwnedMessage> receive(Duration limit = kPatience) = 0;
  // An orderly close, after everything that was sent.
  virtual void close() = 0;
};

inline constexpr std::uint32_t kGuestBodyMax = 48 << 10;
inline constexpr std::uint32_t kGuestSlots = 1000;  // of a mailbox in shared memory

std::unique_ptr<Guest> local_guest(const std::string& router_socket);
std::unique_ptr<Guest> tcp_guest(const std::string& endpoint);
std::unique_ptr<Guest> websocket_guest(const std::string& endpoint);

}  // namespace tims::test
