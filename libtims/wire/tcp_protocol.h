// The original TCP protocol as bytes: a stream of messages; messages with dest = src = 0 are
// exchanged between a client and the router itself (specification, section 3.2). Pure: the caller
// reads and writes the socket.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "tims/address.h"
#include "tims/message.h"
#include "wire/header.h"

namespace tims::wire {

// Commands with dest = src = 0; the same numbers have other meanings between mailboxes.
namespace router_command {

// Ignored by the original router. If the body has kWidthsSize bytes and addresses are not divided
// into four fields of 8 bits, our router answers kAddressWidths before its other replies.
inline constexpr std::int8_t kLogin = 10;
inline constexpr std::int8_t kAddressWidths = -10;
inline constexpr std::int8_t kMailboxInit = 11;
inline constexpr std::int8_t kMailboxDelete = 12;
inline constexpr std::int8_t kMailboxInitWithReply = 13;
inline constexpr std::int8_t kMailboxDeleteWithReply = 14;
inline constexpr std::int8_t kMailboxPurge = 15;
inline constexpr std::int8_t kLifesign = 17;  // router to client; answered with type::kOk
inline constexpr std::int8_t kEnableWatchdog = 18;
inline constexpr std::int8_t kDisableWatchdog = 19;

// kMailboxInit and kMailboxInitWithReply with a body of this size have option bits after the
// address; the original router ignores them.
inline constexpr std::size_t kOptionsSize = 8;
// Of the samples of a stream (flag::kStream) that wait for this connection, only the newest.
// A client that asks for this knows the extension flags, so the router heeds those that it sets.
inline constexpr std::uint32_t kKeepNewest = 1;

// The body of kAddressWidths: system, class, instance, local.
inline constexpr std::size_t kWidthsSize = 4;

constexpr std::array<std::byte, kWidthsSize> encode_widths(const AddressWidths& widths) {
  return {std::byte{widths.system}, std::byte{widths.class_id}, std::byte{widths.instance},
          std::byte{widths.local}};
}

// Nothing when the bytes are not valid widths.
constexpr std::optional<AddressWidths> decode_widths(std::span<const std::byte> body) {
  if (body.size() != kWidthsSize) return std::nullopt;
  const auto bits = [&](std::size_t i) { return std::to_integer<std::uint8_t>(body[i]); };
  const AddressWidths widths{bits(0), bits(1), bits(2), bits(3)};
  if (!widths.valid()) return std::nullopt;
  return widths;
}

}  // namespace router_command

// Splits a stream, received in arbitrary chunks, into whole messages.
//
// A message that is complete within one received chunk is returned in place, without a copy. A
// message that spans chunks is assembled in a buffer, which never grows beyond `length_max`; a
// large buffer is freed after its message.
class StreamReader {
 public:
  explicit StreamReader(std::uint32_t length_max) : length_max_(length_max) {}

  enum class Status {
    kMessage,   // `message` is set; call again
    kNeedMore,  // chunk is used up
    kTooShort,  // the length is below 16 bytes: close the connection
    kTooLong,   // the length is above length_max: close the connection
  };
  struct Item {
    Status status;
    // The whole message, header included: in the chunk and valid as long as it, or in the reader's
    // own buffer and valid until the next call of next() or room(). Writable: the router changes
    // headers in place.
    std::span<std::byte> message;
    Header header;  // decoded; after kTooShort and kTooLong that of the refused message
  };

  // Takes the next message from `chunk` and removes its bytes from it. After kTooShort or kTooLong
  // the stream is lost; every later call returns the same result.
  Item next(std::span<std::byte>& chunk);

  // While a large message is incomplete: where the next bytes can be read directly, to save a copy;
  // empty when the next bytes should come in a chunk. After reading n bytes there, call advance(n),
  // then next() with an empty chunk.
  std::span<std::byte> room();
  void advance(std::size_t n);

  // Number of bytes held of an incomplete message.
  [[nodiscard]] std::size_t pending() const { return handed_out_ ? 0 : filled_; }

 private:
  Item gather(std::span<std::byte>& chunk);
  std::optional<Item> check(const Header& header);
  void take(std::span<std::byte>& chunk, std::size_t filled_end);
  void reserve(std::size_t bytes);
  void release();

  std::uint32_t length_max_;
  // The incomplete message: its first filled_ bytes; header_ is valid once 16 are there.
  std::unique_ptr<std::byte[]> buffer_;
  std::size_t capacity_ = 0;
  std::size_t filled_ = 0;
  Header header_;
  bool handed_out_ = false;     // the caller uses buffer_
  std::optional<Item> broken_;  // the stream is lost, with the reason
};

// The client's end of a connection, without its socket: collects output, and splits input into
// messages. It answers lifesigns and remembers the address widths that the router reports.
class TcpClientProtocol {
 public:
  // `received_max`: largest message accepted, header included; a longer one ends the stream.
  explicit TcpClientProtocol(std::uint32_t received_max) : reader_(received_max) {}

  // Byte order of headers, and of addresses in commands. Default: native.
  void set_byte_order(std::endian order) { order_ = order; }
  // For tests: the router's watchdog closes a client that does not answer lifesigns.
  void set_answers_lifesigns(bool answers) { answers_lifesigns_ = answers; }
  [[nodiscard]] std::uint64_t lifesigns() const { return lifesigns_; }
  // The flag for bodies in this byte order.
  [[nodiscard]] std::uint8_t body_order() const {
    return order_ == std::endian::little ? flag::kBodyLittleEndian : std::uint8_t{0};
  }
  [[nodiscard]] const AddressWidths& widths() const { return widths_; }

  // Appends a message to the output. The header's length is filled in.
  void put(Header header, std::span<const std::byte> body = {});
  void put_command(std::int8_t type);
  void put_command(std::int8_t type, Address mailbox);
  [[nodiscard]] std::span<const std::byte> unsent() const {
    return std::span(output_).subspan(sent_);
  }
  void sent(std::size_t bytes);
  // Encodes the header with its length, for a caller that sends the body without copying it.
  [[nodiscard]] std::array<std::byte, kHeaderSize> encode(Header header,
                                                          std::size_t body_size) const;

  // As StreamReader::next(), without the messages that are handled here.
  StreamReader::Item next(std::span<std::byte>& chunk);
  std::span<std::byte> room() { return reader_.room(); }
  void advance(std::size_t bytes) { reader_.advance(bytes); }

 private:
  void answer(const Header& lifesign);

  StreamReader reader_;
  std::endian order_ = std::endian::native;
  bool answers_lifesigns_ = true;
  std::uint64_t lifesigns_ = 0;
  AddressWidths widths_;
  std::vector<std::byte> output_;
  std::size_t sent_ = 0;  // of output_
};

// Whether the message is exchanged between a client and its router, not between mailboxes.
constexpr bool is_router_message(const Header& header) {
  return header.dest == Address() && header.src == Address();
}

}  // namespace tims::wire
