// The original's TCP protocol as bytes: messages behind one another in a stream, and what clients
// and the router say to each other, messages with dest = src = 0 (specification, section 3.2).
// Pure: the caller reads and writes the socket.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

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

}  // namespace tims::wire
