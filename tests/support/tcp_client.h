// A client of the original protocol for tests: libtims' client, which can also violate the
// protocol. Calls block until a deadline; lifesigns are answered while they wait.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string_view>
#include <vector>

#include "client/tcp_client.h"
#include "tests/support/message.h"
#include "tests/support/patience.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::test {

class TcpClient {
 public:
  // `endpoint` is "host:port".
  static Result<TcpClient> connect(std::string_view endpoint, Duration limit = kPatience);

  // Byte order of headers and of the bodies encoded here. Default: the machine's.
  void set_byte_order(std::endian order) { client_.protocol().set_byte_order(order); }
  // A client that no longer answers is closed by the router's watchdog.
  void set_answers_lifesigns(bool answers) { client_.protocol().set_answers_lifesigns(answers); }
  [[nodiscard]] std::uint64_t lifesigns() const { return client_.protocol().lifesigns(); }

  // Registers and waits for the answer: kAddressInUse if it is ERROR.
  Result<void> register_mailbox(Address address, Duration limit = kPatience);
  Result<void> delete_mailbox(Address address, Duration limit = kPatience);

  // Sets the length in the header.
  Result<void> send(Header header, std::span<const std::byte> body = {},
                    Duration limit = kPatience);
  // Sends arbitrary bytes.
  Result<void> send_bytes(std::span<const std::byte> bytes, Duration limit = kPatience);

  // The next message that is not a lifesign. kTimeout, or kClosed once the router has closed.
  Result<OwnedMessage> receive(Duration limit = kPatience);
  // Waits until the router closes the connection. Earlier messages can still be received.
  Result<void> wait_for_close(Duration limit = kPatience);

  // Sets the size of the system's receive buffer for this client (SO_RCVBUF).
  void set_receive_buffer(int bytes);
  void close() { client_.socket().reset(); }
  void reset();

 private:
  static constexpr std::uint32_t kReceivedMax = 64U << 20;

  explicit TcpClient(os::File socket) : client_(std::move(socket), kReceivedMax) {}

  client::TcpClient client_;
  std::deque<OwnedMessage> before_close_;
};

// The bytes of a text, for bodies in tests.
std::vector<std::byte> bytes_of(std::string_view text);

}  // namespace tims::test
