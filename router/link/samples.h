// Samples of continuous streams (flag STREAM), where only the newest matters. While the link is
// short of bandwidth, a newer sample takes the place of a waiting older one of the same source,
// destination and type. At the other end, what came whole is handed on; what is in part is kept for
// a while among few others, and a sample that comes after a newer one of its stream is thrown away.
//
// One that fits into a datagram is sent once and never again: the next is newer. Of a larger one,
// that would be the end as soon as one of its datagrams is lost. Therefore it is kept until it has
// come whole, as the acknowledgements of packets tell, and parts that were lost are sent again,
// with the same number, before anything newer of its class. It is forgotten when a newer one of its
// stream has come whole, after a while, and first of all when others need the memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "router/link/buffers.h"
#include "router/link/frame.h"
#include "router/link/lanes.h"
#include "router/link/packets.h"

namespace tims::link {

// For so long the rest of a sample is sent again after all of it was sent; and waited for, when no
// more of it comes.
inline constexpr Duration kSamplePatience = std::chrono::seconds(2);

// Of one class, on their way out.
class SampleSender {
 public:
  static constexpr std::size_t kKeptMax = 256;

  SampleSender(core::BlockPool& pool, LossObserver& losses) : losses_(losses), bytes_(pool) {}

  [[nodiscard]] bool has_room(std::size_t message) const { return bytes_.has_room(message); }
  // `message`: whole, its header in the machine's own order. There is room.
  void push(Time now, std::uint8_t hops, const Header& header, std::span<const std::byte> message);

  // Of those that wait, and of those that are kept.
  [[nodiscard]] std::uint64_t bytes() const { return held_; }
  // None waits, and none can come back as lost.
  [[nodiscard]] bool is_idle() const { return waiting_.empty() && kept_.empty(); }
  [[nodiscard]] bool wants_to_send() const { return ranges_.repeats() || !waiting_.empty(); }
  // All but the one that is being sent.
  [[nodiscard]] std::uint64_t droppable_bytes() const {
    return held_ - (sent_ > 0 ? waiting_.front().header.length : 0);
  }
  // What was sent goes first, then what waits longest. False: there is none.
  bool drop_one(Time now);

  // The next piece of at most `size` bytes: something that was lost, or what has never been sent.
  // `last_number`: of the sample that began last.
  struct Piece {
    SampleFrame frame{};  // its place in the sample
    std::size_t size = 0;
    std::uint64_t at = 0;  // for read(), on_acked(), on_lost()
    bool again = false;

    // What becomes of it is of no interest: it is never sent again.
    [[nodiscard]] bool is_sent_once() const { return !again && size == frame.total; }
    [[nodiscard]] Range range() const { return {at, at + size}; }
  };
  std::optional<Piece> next(std::size_t size, std::uint32_t& last_number);
  void read(const Piece& piece, std::span<std::byte> to) const { bytes_.read(piece.at, to); }
  // After its bytes were read.
  void sent(Time now, const Piece& piece);

  // What became of a piece.
  void on_acked(Range range);
  void on_lost(Range range);

  // What waits now was not sent although it was tried: from now on newer samples replace it.
  void congested();
  void expire(Time now, Duration lifetime);
  void clear(Time now, core::Outcome why);

 private:
  struct Sample {
    Header header{};
    std::uint64_t at = 0;      // in bytes_
    Time since{};              // it waits; once all of it was sent, since then
    std::uint32_t number = 0;  // once its first piece was sent
    std::uint8_t hops = 0;
    bool replaceable = false;

    [[nodiscard]] Range range() const { return {at, at + header.length}; }
  };
  [[nodiscard]] std::size_t first_droppable() const { return sent_ > 0 ? 1 : 0; }
  [[nodiscard]] static Piece piece_of(const Sample& sample, Range range);
  std::optional<Piece> next_lost(std::size_t size);
  [[nodiscard]] const Sample* sent_at(std::uint64_t offset) const;
  void free(const Sample& sample);
  void lose(Time now, const Sample& sample, core::Outcome why);

  LossObserver& losses_;
  StreamBuffer bytes_;  // in order of arrival
  std::deque<Sample> waiting_;
  std::uint32_t sent_ = 0;    // bytes of the first of them
  std::vector<Sample> kept_;  // that were sent, in their order
  SentRanges ranges_;         // of all that was sent of both
  std::uint64_t held_ = 0;    // bytes of both
};

// Of all classes, on their way in.
class SampleReceiver {
 public:
  SampleReceiver(Reassembly& reassembly, ArrivalObserver& arrivals)
      : reassembly_(reassembly), arrivals_(arrivals) {}

  // False: it is no sample.
  bool on_frame(Time now, const SampleFrame& frame);
  void expire(Time now);
  void clear();

  // Given up, and thrown away for a newer one.
  [[nodiscard]] std::uint64_t incomplete() const { return incomplete_; }
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
    Time progress{};  // a good part of it has come
    std::size_t progress_at = 0;
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
  bool finish(std::uint32_t number);
  void drop(Part& part);
  void drop_overtaken(const Header& header, std::uint32_t number);
  bool hand_on(Time now, std::uint8_t hops, std::uint32_t number, std::span<std::byte> message);

  Reassembly& reassembly_;
  ArrivalObserver& arrivals_;
  std::array<Part, kPartsMax> parts_;
  PacketWindow finished_;                 // numbers of which no more parts are wanted
  std::array<Stream, kStreams> streams_;  // by a hash of what makes a stream
  std::uint64_t incomplete_ = 0;
  std::uint64_t overtaken_ = 0;
};

}  // namespace tims::link
