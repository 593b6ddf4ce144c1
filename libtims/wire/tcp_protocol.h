// The original's TCP protocol as bytes: messages behind one another in a stream, and what clients
// and the router say to each other, messages with dest = src = 0 (specification, section 3.2).
// Pure: the caller reads and writes the socket.
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

// The numbers of these commands mean something else between mailboxes.
namespace router_command {

// Ignored by the original. With a body of kWidthsSize bytes, and where addresses are not divided
// into four times 8 bits, our router answers kAddressWidths, before it answers what comes later.
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

// The body of kAddressWidths: system, class, instance, local.
inline constexpr std::size_t kWidthsSize = 4;

constexpr std::array<std::byte, kWidthsSize> encode_widths(const AddressWidths& widths) {
  return {std::byte{widths.system}, std::byte{widths.class_id}, std::byte{widths.instance},
          std::byte{widths.local}};
}

// Nothing when they are no widths.
constexpr std::optional<AddressWidths> decode_widths(std::span<const std::byte> body) {
  if (body.size() != kWidthsSize) return std::nullopt;
  const auto bits = [&](std::size_t i) { return std::to_integer<std::uint8_t>(body[i]); };
  const AddressWidths widths{bits(0), bits(1), bits(2), bits(3)};
  if (!widths.valid()) return std::nullopt;
  return widths;
}

}  // namespace router_command

// Bytes of a stream, split anywhere, into whole messages.
//
// Whole messages that lie inside one received chunk are handed out in place, without a copy; only
// a message that spans chunks is gathered in a buffer of its own, which never grows beyond
// `length_max` and, when it is large, is given back when the message is done.
class StreamReader {
 public:
  explicit StreamReader(std::uint32_t length_max) : length_max_(length_max) {}

  enum class Status {
    kMessage,   // `message` is set; call again
    kNeedMore,  // chunk used up
    kTooShort,  // a header says less than 16 bytes: close the connection
    kTooLong,   // a header says more than length_max: close the connection
  };
  struct Item {
    Status status;
    // The whole message, header included. In place in the chunk, or in the reader's own buffer;
    // valid until the chunk is gone and the next call of next() or room() respectively. Writable:
    // the router rewrites headers in place.
    std::span<std::byte> message;
    Header header;  // decoded; of the refused message after kTooShort and kTooLong
  };

  // Takes the next message from `chunk` and shortens it. After kTooShort/kTooLong the stream is
  // lost; every later call says the same.
  Item next(std::span<std::byte>& chunk);

  // While a large message is being gathered: where the next bytes may be read directly, to save a
  // copy; empty when the reader would rather be given chunks. After reading n bytes there, call
  // advance(n), then next() with an empty chunk.
  std::span<std::byte> room();
  void advance(std::size_t n);

  // Bytes held of a message that is not complete.
  [[nodiscard]] std::size_t pending() const { return handed_out_ ? 0 : filled_; }

 private:
  Item gather(std::span<std::byte>& chunk);
  std::optional<Item> check(const Header& header);
  void take(std::span<std::byte>& chunk, std::size_t filled_end);
  void reserve(std::size_t bytes);
  void release();

  std::uint32_t length_max_;
  // The message being gathered: its first filled_ bytes; header_ is valid once 16 are there.
  std::unique_ptr<std::byte[]> buffer_;
  std::size_t capacity_ = 0;
  std::size_t filled_ = 0;
  Header header_;
  bool handed_out_ = false;     // the caller is looking at buffer_
  std::optional<Item> broken_;  // the stream is lost, and why
};

// The client's end of a connection, without its socket: what is to be sent piles up here, and what
// has come is cut into messages. It answers lifesigns, and remembers how the fleet divides
// addresses when the router says so.
class TcpClientProtocol {
 public:
  // `received_max`: of what may come, bytes with the header; what is longer ends the stream.
  explicit TcpClientProtocol(std::uint32_t received_max) : reader_(received_max) {}

  // Of headers, and of addresses in commands. Default: the machine's.
  void set_byte_order(std::endian order) { order_ = order; }
  // A client that does not is closed by the router's watchdog.
  void set_answers_lifesigns(bool answers) { answers_lifesigns_ = answers; }
  [[nodiscard]] std::uint64_t lifesigns() const { return lifesigns_; }
  // As a flag of what is made in that order.
  [[nodiscard]] std::uint8_t body_order() const {
    return order_ == std::endian::little ? flag::kBodyLittleEndian : std::uint8_t{0};
  }
  [[nodiscard]] const AddressWidths& widths() const { return widths_; }

  // To be sent. The header's length is filled in.
  void put(Header header, std::span<const std::byte> body = {});
  void put_command(std::int8_t type);
  void put_command(std::int8_t type, Address mailbox);
  [[nodiscard]] std::span<const std::byte> unsent() const {
    return std::span(output_).subspan(sent_);
  }
  void sent(std::size_t bytes);
  // The header's bytes, with the length filled in, for who sends a body without copying it.
  [[nodiscard]] std::array<std::byte, kHeaderSize> encode(Header header,
                                                          std::size_t body_size) const;

  // What has come: as StreamReader, without what is dealt with here.
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

// Between a client and its router, not between mailboxes.
constexpr bool is_router_message(const Header& header) {
  return header.dest == Address() && header.src == Address();
}

}  // namespace tims::wire
