// The lanes of a link: each is a reliable stream of messages, in order, and the streams know
// nothing of each other, so that what is lost in one holds up none of the others.
//
// Out: a message first waits, in order of arrival, and may still be dropped there when more
// important ones need the room. Then it is committed: it gets its place in the stream and is kept
// until the other side has acknowledged it, or it has grown too old and the stream goes on behind
// it (SKIP, as the FORWARD-TSN of SCTP's partial reliability, RFC 3758). So what is urgent
// overtakes until the last moment, and only what is on its way takes memory for being repeated.
//
// In: the stream is put together again and cut into messages. What comes in order is handed on at
// once, from the datagram itself when the message is whole in it. What comes too early is kept;
// what cannot be kept is refused, and comes again.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "router/core/byte_chain.h"
#include "router/link/buffers.h"
#include "router/link/frame.h"

namespace tims::link {

// Some of a link's lanes, a bit each; read from the most urgent one down.
class LaneSet {
 public:
  // Goes through the lanes as they were when it began.
  class Iterator {
   public:
    explicit Iterator(std::uint32_t bits) : bits_(bits) {}
    std::size_t operator*() const { return static_cast<std::size_t>(std::bit_width(bits_)) - 1; }
    Iterator& operator++() {
      bits_ &= ~std::bit_floor(bits_);
      return *this;
    }
    bool operator==(const Iterator&) const = default;

   private:
    std::uint32_t bits_;
  };

  void add(std::size_t lane) { bits_ |= std::uint32_t{1} << lane; }
  void remove(std::size_t lane) { bits_ &= ~(std::uint32_t{1} << lane); }
  [[nodiscard]] bool empty() const { return bits_ == 0; }
  [[nodiscard]] Iterator begin() const { return Iterator(bits_); }
  [[nodiscard]] Iterator end() const { return Iterator(0); }

 private:
  std::uint32_t bits_ = 0;
};

// How far the stream may run ahead of what the other side is known to have.
inline constexpr std::uint64_t kLaneWindow = 8U << 20;
// In the routers' own lane it is short: what comes late comes all at once, and each mailbox told is
// work.
inline constexpr std::uint64_t kControlWindow = 256U << 10;

// One lane on its way out.
class LaneSender {
 public:
  LaneSender(core::BlockPool& pool, LossObserver& losses)
      : losses_(losses), waiting_(pool), stream_(pool) {}

  void set_window(std::uint64_t window) { window_ = window; }

  [[nodiscard]] bool has_room(std::size_t message) const {
    return waiting_.has_room(record_size(message) + 2 * core::BlockPool::kBlockSize);
  }
  // `message`: whole, its header in the machine's own order. There is room. While less than
  // `committed_max` bytes are committed and not sent, it need not wait.
  void push(Time now, const RecordPrefix& prefix, std::span<const std::byte> message,
            std::uint64_t committed_max);

  [[nodiscard]] std::uint64_t bytes() const { return waiting_.size() + stream_.size(); }
  // Nothing is to be sent, and nothing that was sent can come back as lost.
  [[nodiscard]] bool is_idle() const { return bytes() == 0 && skip_acked_ == skip_to_; }
  [[nodiscard]] bool has_waiting() const { return !waiting_.empty(); }
  [[nodiscard]] std::uint64_t waiting_bytes() const { return waiting_.size(); }
  // Drops the message that waits longest. Its header.
  Header drop_oldest();

  // What is to be sent next: something that was lost, or what has never been sent.
  [[nodiscard]] bool wants_to_send() const;
  [[nodiscard]] bool repeats() const { return sent_.repeats(); }
  // At most `size` bytes of it, which now count as sent.
  std::optional<Range> take(Time now, std::size_t size, std::uint64_t committed_max);
  void read(Range range, std::span<std::byte> to) const { stream_.read(range.begin, to); }

  void on_acked(Range range);
  void on_lost(Range range);
  // To be said until it is acknowledged: the stream goes on at this offset.
  [[nodiscard]] std::optional<std::uint64_t> skip() const {
    return skip_due_ ? std::optional(skip_to_) : std::nullopt;
  }
  void on_skip_sent() { skip_due_ = false; }
  void on_skip_lost() { skip_due_ = skip_to_ > skip_acked_; }
  void on_skip_acked(std::uint64_t to) { skip_acked_ = std::max(skip_acked_, to); }

  // Gives up what is older than `lifetime`.
  void expire(Time now, Duration lifetime);
  // Gives up everything; the lane begins anew.
  void clear(Time now, core::Outcome why);

 private:
  void commit(Time now, std::uint64_t committed_max);
  // Blocks come free in waiting_ as a message moves.
  [[nodiscard]] bool can_commit() const {
    return stream_.has_room(2 * core::BlockPool::kBlockSize);
  }
  [[nodiscard]] std::uint64_t window_end() const;
  static Header header_at(const StreamBuffer& buffer, std::uint64_t offset);
  std::uint64_t lose(Time now, StreamBuffer& buffer, std::uint64_t to, core::Outcome why);

  LossObserver& losses_;
  std::uint64_t window_ = kLaneWindow;
  StreamBuffer waiting_;
  AgeMarks waiting_since_;
  StreamBuffer stream_;  // from the first message that is not acknowledged whole
  AgeMarks stream_since_;
  std::uint64_t next_ = 0;  // first byte that was never sent
  SentRanges sent_;         // parts above stream_.begin()
  std::uint64_t skip_to_ = 0;
  std::uint64_t skip_acked_ = 0;
  bool skip_due_ = false;
};

// One lane on its way in.
class LaneReceiver {
 public:
  // `control`: the routers' own lane.
  LaneReceiver(Reassembly& reassembly, ArrivalObserver& arrivals, bool control)
      : reassembly_(reassembly), arrivals_(arrivals), control_(control) {}
  LaneReceiver(const LaneReceiver&) = delete;
  LaneReceiver& operator=(const LaneReceiver&) = delete;
  ~LaneReceiver() { drop_early(); }

  enum class Verdict : std::uint8_t {
    kTaken,    // or known already
    kRefused,  // no memory, or too far ahead: must not be acknowledged
    kBroken,   // no stream of messages: the other side is no router of ours
  };
  Verdict on_bytes(Time now, std::uint64_t offset, std::span<std::byte> bytes);
  Verdict on_skip(Time now, std::uint64_t to);

  // There was no memory for what has just come.
  [[nodiscard]] bool has_refused(Time now) const { return refused_ == now; }

  // What is here and in order could not be handed on for lack of memory: on_bytes and retry do.
  [[nodiscard]] bool is_stuck() const { return !early_.empty() && early_.front().begin <= next_; }
  Verdict retry(Time now) { return is_stuck() ? drain_early(now) : Verdict::kTaken; }

  // A message that makes no progress is given up after a while, sooner when other links want its
  // memory; what still comes of it is thrown away. Not one that waits for memory, unless its link
  // has more than its share. Its header.
  static constexpr Duration kPatience = std::chrono::seconds(30);
  static constexpr Duration kPatienceIfWanted = std::chrono::seconds(2);
  static constexpr std::size_t kProgress = 16 << 10;  // so much more, or all of it
  std::optional<Header> give_up_stalled(Time now);

  void clear();  // the lane begins anew
  [[nodiscard]] std::uint64_t next() const { return next_; }

 private:
  bool keep_early(std::uint64_t offset, std::span<const std::byte> bytes);
  Verdict drain_early(Time now);
  void drop_early();
  [[nodiscard]] core::BlockPool::Index& block_of(std::uint64_t offset);

  // Returns how many bytes it took; sets broken_. `stable`: the bytes stay until the flush.
  std::size_t consume(Time now, std::span<std::byte> bytes, bool stable);
  std::size_t consume_head(Time now, std::span<const std::byte> bytes);
  std::size_t consume_body(Time now, std::span<const std::byte> bytes);
  bool begin_message(Time now, const Header& header);
  [[nodiscard]] bool is_bad(const Header& header) const;
  void hand_on(Time now, std::span<const std::byte> prefix, core::Message message);

  Reassembly& reassembly_;
  ArrivalObserver& arrivals_;
  const bool control_;
  std::uint64_t next_ = 0;  // first byte that has not come
  bool broken_ = false;

  // The message in the making.
  std::array<std::byte, kRecordHead> head_{};
  std::size_t head_size_ = 0;
  MessageBuffer body_;           // the message, header included, as far as it came
  std::size_t body_size_ = 0;    // so much of it is there
  std::size_t thrown_away_ = 0;  // of a message that was given up: so much is still to come
  Time progress_{};              // a good part of it has come
  std::size_t progress_at_ = 0;
  Time refused_{};  // when there was no memory for what came, the last time
  Header header_{};

  RangeSet early_;
  std::vector<core::BlockPool::Index> early_blocks_;  // a ring, by block number; empty until used
};

}  // namespace tims::link
