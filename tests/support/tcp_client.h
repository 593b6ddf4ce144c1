// A client of the original protocol for tests: one TCP connection, every byte under the test's
// control. Calls wait with a deadline; lifesigns are answered while they wait.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string_view>
#include <vector>

#include "os/file.h"
#include "tests/support/message.h"
#include "tests/support/patience.h"
#include "tims/result.h"
#include "tims/time.h"
#include "wire/tcp_protocol.h"

namespace tims::test {

class TcpClient {
 public:
  // `endpoint` is "host:port".
  static Result<TcpClient> connect(std::string_view endpoint, Duration limit = kPatience);

  // Of headers, and of the bodies that are made here. Default: the machine's.
  void set_byte_order(std::endian order) { order_ = order; }
  // A client that no longer answers is closed by the router's watchdog.
  void set_answers_lifesigns(bool answers) { answers_lifesigns_ = answers; }
  [[nodiscard]] std::uint64_t lifesigns() const { return lifesigns_; }

  // Registers and waits for the answer: kAddressInUse when the router says ERROR.
  Result<void> register_mailbox(Address address, Duration limit = kPatience);
  Result<void> delete_mailbox(Address address, Duration limit = kPatience);

  // The header's length is set here.
  Result<void> send(Header header, std::span<const std::byte> body = {},
                    Duration limit = kPatience);
  // Any bytes, whether they are a message or not.
  Result<void> send_bytes(std::span<const std::byte> bytes, Duration limit = kPatience);

  // The next message that is not a lifesign. kTimeout, or kClosed once the router has closed.
  Result<OwnedMessage> receive(Duration limit = kPatience);
  // Waits until the router closes. What it sent before can still be received.
  Result<void> wait_for_close(Duration limit = kPatience);

  // Bytes nobody can be blocked by: how much the system buffers for this client (SO_RCVBUF).
  void set_receive_buffer(int bytes);
  void close() { socket_.reset(); }
  void reset();

 private:
  explicit TcpClient(os::File socket) : socket_(std::move(socket)) {}
  Result<void> command(std::int8_t type, Address mailbox, Duration limit);
  Result<void> read_some(Time deadline);
  Result<void> take_messages(std::span<std::byte> chunk);
  void answer_lifesign(const Header& lifesign);

  os::File socket_;
  wire::StreamReader reader_{std::uint32_t{64} << 20};
  std::deque<OwnedMessage> received_;
  std::endian order_ = std::endian::native;
  bool answers_lifesigns_ = true;
  std::uint64_t lifesigns_ = 0;
};

// Bytes of a text, for bodies in tests.
std::vector<std::byte> bytes_of(std::string_view text);

}  // namespace tims::test
