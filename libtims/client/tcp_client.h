// A client of the original TCP protocol: one connection to a router, an original one or ours. Used
// by libtims for sessions over TCP, and by timsctl, tests and benchmarks.
//
// Not thread-safe. A call without a deadline never waits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "os/file.h"
#include "tims/address.h"
#include "tims/message.h"
#include "tims/result.h"
#include "tims/time.h"
#include "wire/endpoint.h"
#include "wire/tcp_protocol.h"

namespace tims::client {

// A message that owns its body.
struct Message {
  Header header;
  std::vector<std::byte> body;

  [[nodiscard]] MessageView view() const { return {header, body}; }
};

class TcpClient {
 public:
  static constexpr std::uint32_t kReceivedMax = 16U << 20;  // bytes, header included

  // `socket`: connected. If it is non-blocking, read() and flush() do not wait.
  explicit TcpClient(os::File socket, std::uint32_t received_max = kReceivedMax);
  // kTimeout or kSystem with the reason, without the host; `cancel` as in os::connect_tcp().
  static Result<TcpClient> connect(const wire::TcpEndpoint& router, Time deadline,
                                   std::uint32_t received_max = kReceivedMax, int cancel = -1);

  [[nodiscard]] const os::File& socket() const { return socket_; }
  [[nodiscard]] os::File& socket() { return socket_; }
  // Its pending output is sent by the next flush() or send().
  [[nodiscard]] wire::TcpClientProtocol& protocol() { return protocol_; }
  [[nodiscard]] const wire::TcpClientProtocol& protocol() const { return protocol_; }

  // Sends what the socket accepts. kEmpty: not all was sent; kClosed: the router is gone.
  Result<void> flush();
  // Sends everything, or kTimeout.
  Result<void> flush(Time deadline);

  // Reads once, and calls on_message(const Header&, std::span<std::byte> body) for every complete
  // message, including those of the router itself. kEmpty: nothing has arrived; kClosed. When the
  // beginning of the next message is unknown: kTooBig, kMalformed, or kVersion if the peer answers
  // in HTTP.
  template <typename OnMessage>
  Result<void> read(OnMessage on_message);

  // Sends one message. The header's length is filled in; a large body is not copied. kTimeout.
  Result<void> send(const Header& header, std::span<const std::byte> body, Time deadline);
  // The next message: kEmpty, or kTimeout at the deadline.
  Result<Message> take();
  Result<Message> receive(Time deadline);

  // Requests to the router: messages for mailboxes that arrive during the call are kept for take().
  // log_in() sends the login and receives the fleet's address widths.
  Result<void> log_in(Time deadline);
  Result<void> register_mailbox(Address address, Time deadline);  // kAddressInUse
  Result<void> delete_mailbox(Address address, Time deadline);    // kNoMailbox

 private:
  Result<std::span<std::byte>> read_chunk();
  Error broken(const Header& header);
  Result<bool> is_confirmed(std::int8_t command, Address mailbox, Time deadline);

  os::File socket_;
  wire::TcpClientProtocol protocol_;
  std::vector<std::byte> scratch_;
  std::deque<Message> received_;
  std::optional<Error> broken_;  // the stream is lost, with the reason
};

template <typename OnMessage>
Result<void> TcpClient::read(OnMessage on_message) {
  using Status = wire::StreamReader::Status;
  auto chunk = read_chunk();
  if (!chunk) return chunk.error();
  for (;;) {
    const wire::StreamReader::Item item = protocol_.next(*chunk);
    if (item.status == Status::kNeedMore) return {};
    if (item.status != Status::kMessage) return broken(item.header);
    on_message(item.header, item.message.subspan(kHeaderSize));
  }
}

}  // namespace tims::client
