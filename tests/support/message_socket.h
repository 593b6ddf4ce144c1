// A non-blocking TCP connection that carries whole messages, for an event loop.
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

  // What has become of the other side.
  enum class Peer {
    kThere,
    kClosed,
    kReset,
    kNonsense,  // it sent something that is no header
  };
  [[nodiscard]] Peer peer() const { return peer_; }
  [[nodiscard]] bool is_there() const { return peer_ == Peer::kThere; }
  [[nodiscard]] int fd() const { return file_.get(); }

  // Writes what the system takes now and keeps the rest for on_writable(). What can no longer be
  // sent, because the other side is gone, is thrown away.
  void send(std::span<const std::byte> bytes);
  void on_writable();
  [[nodiscard]] bool has_unsent() const { return !unsent_.empty(); }

  // Reads what is there.
  void on_readable(std::vector<OwnedMessage>& messages);

  void shut_down_sending() const;  // the other side reads an end, and can still send
  void close_with_reset();

 private:
  void take(std::span<std::byte> chunk, std::vector<OwnedMessage>& messages);

  os::File file_;
  wire::StreamReader reader_;
  std::vector<std::byte> unsent_;
  Peer peer_ = Peer::kThere;
};

}  // namespace tims::test
