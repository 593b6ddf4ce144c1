#include "tests/system/websocket_client.h"

#include <algorithm>
#include <array>
#include <bit>

#include "os/clock.h"
#include "tests/support/patience.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace {

// The example of RFC 6455, section 1.3.
constexpr std::string_view kKey = "dGhlIHNhbXBsZSBub25jZQ==";
constexpr std::string_view kAccept = "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=";

std::string big_endian(std::uint64_t number, std::size_t size) {
  std::string bytes;
  for (std::size_t i = size; i-- > 0;) bytes += static_cast<char>(number >> (8 * i));
  return bytes;
}

std::uint64_t from_big_endian(std::string_view bytes) {
  std::uint64_t number = 0;
  for (const char c : bytes) number = number << 8 | static_cast<unsigned char>(c);
  return number;
}

}  // namespace

// --- Handshake

std::string WebSocketClient::request(std::string_view fields) {
  return "GET /tims HTTP/1.1\r\nHost: 127.0.0.1:8080\r\nConnection: keep-alive, Upgrade\r\n"
         "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: " +
         std::string(kKey) + "\r\n" + std::string(fields) + "\r\n";
}

WebSocketClient::WebSocketClient(const std::string& endpoint, std::string_view fields)
    : socket_(endpoint) {
  socket_.send(request(fields));
  answer_ = socket_.take_until("\r\n\r\n");
}

bool WebSocketClient::is_open() const {
  return answer_.starts_with("HTTP/1.1 101 ") && answer_.find(kAccept) != std::string::npos;
}

// --- Frames

std::string WebSocketClient::to_bytes(const Frame& frame, bool masked) {
  const std::size_t size = frame.payload.size();
  const char mask_bit = static_cast<char>(masked ? 0x80 : 0);
  std::string bytes(1, static_cast<char>((frame.fin ? 0x80 : 0) | frame.opcode));
  if (size < 126) {
    bytes += static_cast<char>(mask_bit | static_cast<char>(size));
  } else if (size < 65536) {
    bytes += static_cast<char>(mask_bit | 126);
    bytes += big_endian(size, 2);
  } else {
    bytes += static_cast<char>(mask_bit | 127);
    bytes += big_endian(size, 8);
  }
  if (!masked) return bytes + frame.payload;
  constexpr std::array<char, 4> kMask{0x12, 0x34, 0x56, 0x78};
  bytes.append(kMask.begin(), kMask.end());
  for (std::size_t i = 0; i < size; ++i)
    bytes += static_cast<char>(frame.payload[i] ^ kMask[i % kMask.size()]);
  return bytes;
}

std::optional<WebSocketClient::Frame> WebSocketClient::take_frame() {
  const std::string head = socket_.take(2);
  if (head.size() < 2) return std::nullopt;
  const auto first = static_cast<std::uint8_t>(head[0]);
  std::uint64_t size = static_cast<std::uint8_t>(head[1]) & 0x7FU;
  if (size == 126) size = from_big_endian(socket_.take(2));
  if (size == 127) size = from_big_endian(socket_.take(8));
  Frame frame{.opcode = static_cast<std::uint8_t>(first & 0x0FU), .fin = (first & 0x80U) != 0};
  frame.payload = socket_.take(size);
  if (frame.payload.size() < size) return std::nullopt;
  return frame;
}

WebSocketClient::Closed WebSocketClient::wait_for_close() {
  while (const auto frame = take_frame()) {
    if (frame->opcode != kClose) continue;
    send(*frame);
    socket_.take_rest();
    socket_.close();
    if (frame->payload.size() < 2) return {1005, ""};
    const auto code = from_big_endian(std::string_view(frame->payload).substr(0, 2));
    return {static_cast<int>(code), frame->payload.substr(2)};
  }
  return {};
}

// --- Messages

std::string WebSocketClient::bytes_of_message(Header header, std::string_view body) {
  header.length = static_cast<std::uint32_t>(kHeaderSize + body.size());
  std::array<std::byte, kHeaderSize> bytes;
  wire::encode_header(header, bytes);
  return text_of(bytes) + std::string(body);
}

bool WebSocketClient::send_message(const Header& header, std::string_view body) {
  return send({.opcode = kBinary, .payload = bytes_of_message(header, body)});
}

Result<OwnedMessage> WebSocketClient::receive() {
  std::string bytes;
  frames_ = 0;
  const Time deadline = os::deadline_after(kPatience);
  while (const auto frame = take_frame()) {
    if (os::now() > deadline) return Error(Errc::kTimeout, "no message came");
    if (frame->opcode == kPing) {
      ++pings_;
      send({.opcode = kPong, .payload = frame->payload});
      continue;
    }
    const bool expected = frame->opcode == (frames_ == 0 ? kBinary : kContinuation);
    if (!expected) return Error(Errc::kBadLayout, "opcode " + std::to_string(frame->opcode));
    ++frames_;
    bytes += frame->payload;
    if (!frame->fin) continue;
    const auto all = std::as_bytes(std::span(bytes));
    if (all.size() < kHeaderSize) return Error(Errc::kBadLayout, "shorter than a header");
    const Header header = wire::decode_header(all.first<kHeaderSize>());
    if (header.length != all.size()) return Error(Errc::kBadLayout, "length");
    return copy_of({header, all.subspan(kHeaderSize)});
  }
  return Error(Errc::kClosed, "by the router");
}

Result<void> WebSocketClient::register_mailbox(Address address) {
  std::array<char, 4> body = std::bit_cast<std::array<char, 4>>(address.raw());
  send_message({.type = wire::router_command::kMailboxInitWithReply},
               std::string_view(body.data(), body.size()));
  const auto answer = receive();
  if (!answer) return answer.error();
  if (answer->header.type == type::kOk && is_router_message(answer->header)) return {};
  return Error(Errc::kAddressInUse, describe(answer->view()));
}

}  // namespace tims::test
