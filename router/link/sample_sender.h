// Samples of streams (flag STREAM) of one class on their way out: each is sent once. While the link
// is short of bandwidth, a newer sample takes the place of a waiting older one of the same source,
// destination and type.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>

#include "router/link/frame.h"
#include "router/link/record.h"
#include "router/link/stream_buffer.h"

namespace tims::link {

class SampleSender {
 public:
  explicit SampleSender(core::BlockPool& pool) : bytes_(pool) {}

  [[nodiscard]] bool has_room(std::size_t message) const { return bytes_.has_room(message); }
  // `message`: whole, its header in the machine's own order. There is room.
  void push(Time now, std::uint8_t hops, const Header& header, std::span<const std::byte> message,
            Losses& losses);

  [[nodiscard]] std::uint64_t bytes() const { return bytes_.size(); }
  [[nodiscard]] bool empty() const { return samples_.empty(); }
  // Not while it is being sent.
  [[nodiscard]] bool can_drop_oldest() const { return !samples_.empty() && sent_ == 0; }
  [[nodiscard]] std::uint64_t droppable_bytes() const {
    return can_drop_oldest() ? bytes_.size() : 0;
  }
  Header drop_oldest();

  // The next piece of at most `size` bytes; its place in the frame. Never empty of bytes, while
  // there are samples. `number`: of the sample that begins now, if one does.
  struct Piece {
    SampleFrame frame{};
    std::size_t size = 0;
    std::uint64_t at = 0;  // for read()
  };
  Piece next(std::size_t size, std::uint32_t& last_number);
  void read(const Piece& piece, std::span<std::byte> to) const { bytes_.read(piece.at, to); }
  // After its bytes were read.
  void sent(const Piece& piece);

  // What waits now was not sent although it was tried: from now on newer samples replace it.
  void congested();
  void expire(Time now, Duration lifetime, Losses& losses);
  void clear(Time now, core::Outcome why, Losses& losses);

 private:
  struct Sample {
    Header header{};
    std::uint64_t at = 0;  // in bytes_
    Time since{};
    std::uint8_t hops = 0;
    bool replaceable = false;
    bool replaced = false;
  };
  void pop();
  void skip_replaced();

  StreamBuffer bytes_;
  std::deque<Sample> samples_;
  std::uint32_t number_ = 0;  // of the front, once its first piece was sent
  std::uint32_t sent_ = 0;    // bytes of the front
};

}  // namespace tims::link
