// A client of the original's TCP protocol: one connection to a router, an original one or ours.
// libtims uses it for sessions over TCP, timsctl, tests and benchmarks use it where they are such a
// client.
//
// One thread at a time. Without a deadline a call never waits.
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
  static constexpr std::uint32_t kReceivedMax = 16U << 20;  // bytes, with the header

  // `socket`: connected. Whether read() and flush() wait is up to it: non-blocking, they do not.
  explicit TcpClient(os::File socket, std::uint32_t received_max = kReceivedMax);
  // kTimeout or kSystem, and why not, without the host; `cancel` as in os::connect_tcp().
  static Result<TcpClient> connect(const wire::TcpEndpoint& router, Time deadline,
                                   std::uint32_t received_max = kReceivedMax, int cancel = -1);

  [[nodiscard]] const os::File& socket() const { return socket_; }
  [[nodiscard]] os::File& socket() { return socket_; }
  // What has been put into it goes out with the next flush() or send().
  [[nodiscard]] wire::TcpClientProtocol& protocol() { return protocol_; }
  [[nodiscard]] const wire::TcpClientProtocol& protocol() const { return protocol_; }

  // As much as the socket takes. kEmpty: not all; kClosed: the router has gone.
  Result<void> flush();
  // All, or kTimeout.
  Result<void> flush(Time deadline);

  // Reads once, and calls on_message(const Header&, std::span<std::byte> body) for every message
  // that is complete, also for those of the router itself. kEmpty: nothing has come; kClosed; and
  // where nobody knows where the next message begins kTooBig, kMalformed, or kVersion: it answers
  // in HTTP.
  template <typename OnMessage>
  Result<void> read(OnMessage on_message);

  // Messages one by one. The header's length is filled in; a large body is not copied. kTimeout.
  Result<void> send(const Header& header, std::span<const std::byte> body, Time deadline);
  // The next one: kEmpty, or kTimeout at the deadline.
  Result<Message> take();
  Result<Message> receive(Time deadline);

  // What the router answers: messages for mailboxes that come meanwhile wait for take(). Says who
  // is there, and learns how the fleet divides its addresses.
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
  std::optional<Error> broken_;  // the stream is lost, and why
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
