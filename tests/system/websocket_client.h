// A WebSocket client on which the test controls every frame (RFC 6455), and on top of it a TiMS
// client. Calls block until a deadline.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tests/support/message.h"
#include "tests/system/byte_socket.h"
#include "tims/result.h"

namespace tims::test {

class WebSocketClient {
 public:
  enum Opcode : std::uint8_t {
    kContinuation = 0,
    kText = 1,
    kBinary = 2,
    kClose = 8,
    kPing = 9,
    kPong = 10,
  };

  // Connects and sends the handshake. `fields`: additional header lines of the request.
  explicit WebSocketClient(const std::string& endpoint, std::string_view fields = {});
  static std::string request(std::string_view fields = {});

  // Whether the router accepted; otherwise answer() is its refusal.
  [[nodiscard]] bool is_open() const;
  [[nodiscard]] const std::string& answer() const { return answer_; }
  ByteSocket& socket() { return socket_; }

  // --- Frames
  struct Frame {
    std::uint8_t opcode = 0;
    bool fin = true;
    std::string payload{};
  };
  static std::string to_bytes(const Frame& frame, bool masked = true);
  bool send(const Frame& frame) { return socket_.send(to_bytes(frame)); }
  std::optional<Frame> take_frame();  // nothing: the other side has closed

  struct Closed {
    int code = 0;  // 0: without a close frame; 1005: without a code in it
    std::string reason{};
    bool operator==(const Closed&) const = default;
  };
  // Waits for the close and answers it. Frames before it are discarded.
  Closed wait_for_close();

  // --- Messages. Pings are answered during these calls.
  static std::string bytes_of_message(Header header, std::string_view body);
  bool send_message(const Header& header, std::string_view body = {});
  Result<OwnedMessage> receive();
  // The router's answer: kAddressInUse for ERROR.
  Result<void> register_mailbox(Address address);

  [[nodiscard]] int pings() const { return pings_; }
  [[nodiscard]] int frames_of_last_message() const { return frames_; }

 private:
  ByteSocket socket_;
  std::string answer_;
  int pings_ = 0;
  int frames_ = 0;
};

}  // namespace tims::test
