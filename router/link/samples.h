// Samples of continuous streams (flag STREAM), where only the newest matters: each is sent once and
// never again. While the link is short of bandwidth, a newer sample takes the place of a waiting
// older one of the same source, destination and type. At the other end, what came whole is handed
// on; what is in part is kept for a while among few others, and a sample that comes after a newer
// one of its stream is thrown away.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>

#include "router/link/buffers.h"
#include "router/link/frame.h"
#include "router/link/lanes.h"

namespace tims::link {

// Of one class, on their way out.
class SampleSender {
 public:
  SampleSender(core::BlockPool& pool, LossObserver& losses) : losses_(losses), bytes_(pool) {}

  [[nodiscard]] bool has_room(std::size_t message) const { return bytes_.has_room(message); }
  // `message`: whole, its header in the machine's own order. There is room.
  void push(Time now, std::uint8_t hops, const Header& header, std::span<const std::byte> message);

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
  void expire(Time now, Duration lifetime);
  void clear(Time now, core::Outcome why);

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

  LossObserver& losses_;
  StreamBuffer bytes_;
  std::deque<Sample> samples_;
  std::uint32_t number_ = 0;  // of the front, once its first piece was sent
  std::uint32_t sent_ = 0;    // bytes of the front
};

// Of all classes, on their way in.
class SampleReceiver {
 public:
  SampleReceiver(Reassembly& reassembly, ArrivalObserver& arrivals)
      : reassembly_(reassembly), arrivals_(arrivals) {}

  // False: it is no sample.
  bool on_frame(Time now, const SampleFrame& frame);
  // Of what has come in part, the rest is not waited for longer than this.
  static constexpr Duration kPatience = std::chrono::seconds(2);
  void expire(Time now);
  void clear();

  [[nodiscard]] std::uint64_t incomplete() const { return incomplete_; }  // given up
  [[nodiscard]] std::uint64_t overtaken() const { return overtaken_; }

 private:
  static constexpr std::size_t kPartsMax = 8;   // samples in part
  static constexpr std::size_t kStreams = 128;  // whose newest number is remembered
  // Parts are taken so far ahead: this, and so many times what has come.
  static constexpr std::size_t kAheadMin = 64 << 10;
  static constexpr std::size_t kAheadTimes = 4;

  struct Part {
    std::uint32_t number = 0;
    std::uint32_t total = 0;
    Time since{};
    MessageBuffer bytes{};
    std::size_t received = 0;  // bytes
    RangeSet have{};
  };
  struct Stream {
    Address src{};
    Address dest{};
    std::int8_t type = 0;
    std::uint32_t newest = 0;  // 0: none yet
  };

  Part* part_for(Time now, const SampleFrame& frame);
  void give_up(Part& part);
  bool hand_on(Time now, std::uint8_t hops, std::uint32_t number, std::span<std::byte> message);

  Reassembly& reassembly_;
  ArrivalObserver& arrivals_;
  std::array<Part, kPartsMax> parts_;
  std::array<Stream, kStreams> streams_;  // by a hash of what makes a stream
  std::uint64_t incomplete_ = 0;
  std::uint64_t overtaken_ = 0;
};

}  // namespace tims::link
