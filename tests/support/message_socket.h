// A non-blocking TCP connection that transfers complete messages, for an event loop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "os/file.h"
#include "tests/support/message.h"
#include "wire/tcp_protocol.h"

namespace tims::test {

class MessageSocket {
 public:
  explicit MessageSocket(os::File file, std::uint32_t length_max = std::uint32_t{64} << 20)
      : file_(std::move(file)), reader_(length_max) {}

  // State of the other side.
  enum class Peer {
    kThere,
    kClosed,
    kReset,
    kNonsense,  // it sent an invalid header
  };
  [[nodiscard]] Peer peer() const { return peer_; }
  [[nodiscard]] bool is_there() const { return peer_ == Peer::kThere; }
  [[nodiscard]] int fd() const { return file_.get(); }

  // Writes what the system accepts now and keeps the rest for on_writable(). After the other side
  // has closed, the bytes are discarded.
  void send(std::span<const std::byte> bytes);
  void on_writable();
  [[nodiscard]] bool has_unsent() const { return !unsent_.empty(); }

  // Reads the available bytes.
  void on_readable(std::vector<OwnedMessage>& messages);

  void shut_down_sending() const;  // the other side reads the end of the stream, and can still send
  void close_with_reset();

 private:
  void take(std::span<std::byte> chunk, std::vector<OwnedMessage>& messages);

  os::File file_;
  wire::StreamReader reader_;
  std::vector<std::byte> unsent_;
  Peer peer_ = Peer::kThere;
};

}  // namespace tims::test
