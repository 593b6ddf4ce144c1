// Bytes of a TCP stream, split anywhere, into whole messages. Pure: the caller reads the socket.
//
// Whole messages that lie inside one received chunk are handed out in place, without a copy; only
// a message that spans chunks is gathered in a buffer of its own, which never grows beyond
// `length_max` and, when it is large, is given back when the message is done.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "tims/message.h"
#include "wire/header.h"

namespace tims::wire {

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
