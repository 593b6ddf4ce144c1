// Samples of continuous streams (flag STREAM), of which only the newest matters. While the link
// is short of bandwidth, a newer sample replaces a waiting older one of the same source,
// destination and type. At the receiver, complete samples are delivered; a few incomplete ones
// are kept for a while, and a sample that arrives after a newer one of its stream is discarded.
//
// A sample that fits into one datagram is sent once and never repeated: the next one is newer. A
// larger sample would be lost with any one of its datagrams. Therefore it is kept until all its
// packets are acknowledged, and lost parts are sent again, with the same number, before anything
// newer of its class. It is discarded when a newer one of its stream has arrived completely,
// after a timeout, and first when memory is needed.
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

// How long a sender repeats lost parts after the whole sample was sent, and how long a receiver
// waits for more parts.
inline constexpr Duration kSamplePatience = std::chrono::seconds(2);

// Outgoing samples of one class.
class SampleSender {
 public:
  static constexpr std::size_t kKeptMax = 256;

  SampleSender(core::BlockPool& pool, LossObserver& losses) : losses_(losses), bytes_(pool) {}

  [[nodiscard]] bool has_room(std::size_t message) const { return bytes_.has_room(message); }
  // `message`: a whole message, its header in host byte order. Precondition: there is room.
  void push(Time now, std::uint8_t hops, const Header& header, std::span<const std::byte> message);

  // Bytes waiting and bytes kept for repetition.
  [[nodiscard]] std::uint64_t bytes() const { return held_; }
  // True when no sample waits and none can be reported as lost.
  [[nodiscard]] bool is_idle() const { return waiting_.empty() && kept_.empty(); }
  [[nodiscard]] bool wants_to_send() const { return ranges_.repeats() || !waiting_.empty(); }
  // All bytes except those of the sample being sent.
  [[nodiscard]] std::uint64_t droppable_bytes() const {
    return held_ - (sent_ > 0 ? waiting_.front().header.length : 0);
  }
  // Drops sent samples first, then the one that has waited longest. Returns false when there is
  // none.
  bool drop_one(Time now);

  // The next piece of at most `size` bytes: a lost part, or bytes not sent before. `last_number`:
  // number of the most recently started sample.
  struct Piece {
    SampleFrame frame{};  // its position in the sample
    std::size_t size = 0;
    std::uint64_t at = 0;  // for read(), on_acked(), on_lost()
    bool again = false;

    // True when its fate need not be tracked: it is never sent again.
    [[nodiscard]] bool is_sent_once() const { return !again && size == frame.total; }
    [[nodiscard]] Range range() const { return {at, at + size}; }
  };
  std::optional<Piece> next(std::size_t size, std::uint32_t& last_number);
  void read(const Piece& piece, std::span<std::byte> to) const { bytes_.read(piece.at, to); }
  // Called after its bytes were read.
  void sent(Time now, const Piece& piece);

  // The fate of a piece.
  void on_acked(Range range);
  void on_lost(Range range);

  // The waiting samples could not be sent: from now on newer samples replace them.
  void congested();
  void expire(Time now, Duration lifetime);
  void clear(Time now, core::Outcome why);

 private:
  struct Sample {
    Header header{};
    std::uint64_t at = 0;      // position in bytes_
    Time since{};              // start of waiting; once completely sent, the time of that
    std::uint32_t number = 0;  // assigned when its first piece is sent
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
  std::uint32_t sent_ = 0;    // bytes of the first waiting sample already sent
  std::vector<Sample> kept_;  // completely sent, in order of sending
  SentRanges ranges_;         // for the bytes sent of both
  std::uint64_t held_ = 0;    // bytes of both
};

// Incoming samples of all classes.
class SampleReceiver {
 public:
  SampleReceiver(Reassembly& reassembly, ArrivalObserver& arrivals)
      : reassembly_(reassembly), arrivals_(arrivals) {}

  // Returns false when it is not a valid sample.
  bool on_frame(Time now, const SampleFrame& frame);
  void expire(Time now);
  void clear();

  // For the next router (handover.h): samples with numbers below are not wanted any more.
  [[nodiscard]] std::uint64_t next() const { return finished_.next(); }
  void continue_at(std::uint64_t next) { finished_.continue_at(next); }

  // Number of samples given up, and number discarded because a newer one had arrived.
  [[nodiscard]] std::uint64_t incomplete() const { return incomplete_; }
  [[nodiscard]] std::uint64_t overtaken() const { return overtaken_; }

 private:
  static constexpr std::size_t kPartsMax = 8;  // maximum number of incomplete samples
  // number of streams whose newest number is remembered
  static constexpr std::size_t kStreams = 128;
  // Parts are accepted this far ahead, plus a multiple of what has arrived.
  static constexpr std::size_t kAheadMin = 64 << 10;
  static constexpr std::size_t kAheadTimes = 4;

  struct Part {
    std::uint32_t number = 0;
    std::uint32_t total = 0;
    Time progress{};  // time of the last significant progress
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
  std::array<Stream, kStreams> streams_;  // indexed by a hash of the stream's key
  std::uint64_t incomplete_ = 0;
  std::uint64_t overtaken_ = 0;
};

}  // namespace tims::link
