// A WebSocket client of which the test controls every frame (RFC 6455), and on top of it one that
// speaks TiMS. Calls wait, with a deadline.
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

  // Connects and begins. `fields`: lines that go into the request beside what must be there.
  explicit WebSocketClient(const std::string& endpoint, std::string_view fields = {});
  static std::string request(std::string_view fields = {});

  // Whether the router agreed; else what it said.
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
  // Waits for the end, and answers it. What comes before is thrown away.
  Closed wait_for_close();

  // --- Messages. Pings are answered meanwhile.
  static std::string bytes_of_message(Header header, std::string_view body);
  bool send_message(const Header& header, std::string_view body = {});
  Result<OwnedMessage> receive();
  // The router's answer: kAddressInUse when it says ERROR.
  Result<void> register_mailbox(Address address);

  [[nodiscard]] int pings() const { return pings_; }
  [[nodiscard]] int frames_of_last_message() const { return frames_; }

 private:
  ByteSocket socket_;
  std::string answer_;
  int pings_ = 0;
  int frames_ = 0;
};

std::string text_of(std::span<const std::byte> bytes);

}  // namespace tims::test
