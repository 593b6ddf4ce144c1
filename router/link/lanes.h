// The lanes of a link: each is a reliable, ordered stream of messages. The streams are
// independent, so a loss in one does not delay the others.
//
// Sending: a message first waits, in order of arrival, and may still be dropped when more
// important messages need the room. Then it is committed: it gets its position in the stream and
// is kept until the other side has acknowledged it, or until it is too old and the stream skips
// it (SKIP, as the FORWARD-TSN of SCTP's partial reliability, RFC 3758). So urgent messages can
// overtake until the last moment, and only messages in flight need memory for retransmission.
//
// Receiving: the stream is reassembled and split into messages. In-order bytes are delivered
// immediately, directly from the datagram when it contains the whole message. Out-of-order bytes
// are stored; bytes that cannot be stored are refused and sent again.
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
#include "router/link/handover.h"

namespace tims::link {

// A set of lanes as a bit mask; iterated from the most urgent one down.
class LaneSet {
 public:
  // Iterates over the set as it was at the beginning.
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

// How far the stream may run ahead of what the other side has acknowledged.
inline constexpr std::uint64_t kLaneWindow = 8U << 20;
// The window of the routers' own lane is small: late data arrives all at once, and each announced
// mailbox must be processed.
inline constexpr std::uint64_t kControlWindow = 256U << 10;

// The sending end of one lane.
class LaneSender {
 public:
  LaneSender(core::BlockPool& pool, LossObserver& losses)
      : losses_(losses), waiting_(pool), stream_(pool) {}

  void set_window(std::uint64_t window) { window_ = window; }
  // Of messages that are committed from now on; null: none has one. They outlive the lane.
  void set_lifetimes(const policy::Lifetimes* lifetimes) { lifetimes_ = lifetimes; }

  [[nodiscard]] bool has_room(std::size_t message) const {
    return waiting_.has_room(record_size(message) + 2 * core::BlockPool::kBlockSize);
  }
  // `message`: a whole message, its header in host byte order. Precondition: there is room. It is
  // committed immediately while less than `committed_max` bytes are committed and not sent.
  void push(Time now, const RecordPrefix& prefix, std::span<const std::byte> message,
            std::uint64_t committed_max);

  [[nodiscard]] std::uint64_t bytes() const { return waiting_.size() + stream_.size(); }
  // True when there is nothing to send, and nothing sent can be reported as lost.
  [[nodiscard]] bool is_idle() const { return bytes() == 0 && skip_acked_ == skip_to_; }
  [[nodiscard]] bool has_waiting() const { return !waiting_.empty(); }
  [[nodiscard]] std::uint64_t waiting_bytes() const { return waiting_.size(); }
  // Drops the message that has waited longest and returns its header.
  Header drop_oldest();

  // True when there is something to send: lost bytes, or bytes not sent before.
  [[nodiscard]] bool wants_to_send() const;
  [[nodiscard]] bool repeats() const { return sent_.repeats(); }
  // At most `size` bytes of it, which count as sent afterwards.
  std::optional<Range> take(Time now, std::size_t size, std::uint64_t committed_max);
  void read(Range range, std::span<std::byte> to) const { stream_.read(range.begin, to); }

  void on_acked(Range range);
  void on_lost(Range range);
  // Sent until it is acknowledged: the stream continues at this offset.
  [[nodiscard]] std::optional<std::uint64_t> skip() const {
    return skip_due_ ? std::optional(skip_to_) : std::nullopt;
  }
  void on_skip_sent() { skip_due_ = false; }
  void on_skip_lost() { skip_due_ = skip_to_ > skip_acked_; }
  void on_skip_acked(std::uint64_t to) { skip_acked_ = std::max(skip_acked_, to); }

  // Drops everything older than `lifetime`, and marks what is older than its own.
  void expire(Time now, Duration lifetime);
  // Drops everything; the lane restarts.
  void clear(Time now, core::Outcome why);

  // For the next router (handover.h), which sends again all that has been sent and not released.
  void save(StateWriter& to) const;
  // Precondition: the lane is new. False: no such state, or no memory for it.
  [[nodiscard]] bool restore(StateReader& from);

 private:
  [[nodiscard]] bool restore_message(StreamBuffer& to, AgeMarks& ages, Time since,
                                     std::span<const std::byte> record);
  void commit(Time now, std::uint64_t committed_max);
  void add_deadline(const Header& header, Time since);
  [[nodiscard]] bool is_late(Time now, const Header& header, Time since) const {
    return lifetimes_ != nullptr && now - since > lifetimes_->of(header);
  }
  void mark_late(Time now, Range range);
  // Moving a message frees blocks in waiting_.
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
  StreamBuffer stream_;  // from the first message that is not fully acknowledged
  AgeMarks stream_since_;
  const policy::Lifetimes* lifetimes_ = nullptr;
  Deadlines deadlines_;
  std::uint64_t next_ = 0;  // first byte never sent
  SentRanges sent_;         // parts above stream_.begin()
  std::uint64_t skip_to_ = 0;
  std::uint64_t skip_acked_ = 0;
  bool skip_due_ = false;
};

// The receiving end of one lane.
class LaneReceiver {
 public:
  // `control`: the routers' own lane.
  LaneReceiver(Reassembly& reassembly, ArrivalObserver& arrivals, bool control)
      : reassembly_(reassembly), arrivals_(arrivals), control_(control) {}
  LaneReceiver(const LaneReceiver&) = delete;
  LaneReceiver& operator=(const LaneReceiver&) = delete;
  ~LaneReceiver() { drop_early(); }

  enum class Verdict : std::uint8_t {
    kTaken,    // or a duplicate
    kRefused,  // no memory, or too far ahead: must not be acknowledged
    kBroken,   // not a stream of messages: protocol violation
  };
  Verdict on_bytes(Time now, std::uint64_t offset, std::span<std::byte> bytes);
  Verdict on_skip(Time now, std::uint64_t to);

  // True when there was no memory for the bytes that just arrived.
  [[nodiscard]] bool has_refused(Time now) const { return refused_ == now; }

  // True when bytes that are in order could not be delivered for lack of memory; on_bytes and
  // retry try again.
  [[nodiscard]] bool is_stuck() const { return !early_.empty() && early_.front().begin <= next_; }
  Verdict retry(Time now) { return is_stuck() ? drain_early(now) : Verdict::kTaken; }

  // A message without progress is given up after a while, sooner when other links need its
  // memory; its remaining bytes are discarded. A message that waits for memory is exempt, unless
  // its link has more than its share. Returns its header.
  static constexpr Duration kPatience = std::chrono::seconds(30);
  static constexpr Duration kPatienceIfWanted = std::chrono::seconds(2);
  // Significant progress: this much more, or all of it.
  static constexpr std::size_t kProgress = 16 << 10;
  std::optional<Header> give_up_stalled(Time now);

  void clear();  // the lane restarts
  [[nodiscard]] std::uint64_t next() const { return next_; }

  // For the next router (handover.h): what was acknowledged and has not been handed on.
  void save(StateWriter& to) const;
  // Precondition: the lane is new. False: no such state, or no memory for it.
  [[nodiscard]] bool restore(Time now, StateReader& from);

 private:
  bool keep_early(Time now, std::uint64_t offset, std::span<const std::byte> bytes);
  Verdict drain_early(Time now);
  void drop_early();
  [[nodiscard]] core::BlockPool::Index& block_of(std::uint64_t offset);

  // Returns the number of bytes taken; sets broken_. `stable`: the bytes stay valid until the
  // flush.
  std::size_t consume(Time now, std::span<std::byte> bytes, bool stable);
  std::size_t consume_head(Time now, std::span<const std::byte> bytes);
  std::size_t consume_body(Time now, std::span<const std::byte> bytes);
  // `prefix`: of a record that is complete otherwise.
  [[nodiscard]] bool can_hand_on(Time now, std::span<const std::byte> prefix);
  bool begin_message(Time now, const Header& header);
  [[nodiscard]] bool is_bad(const Header& header) const;
  void hand_on(Time now, std::span<const std::byte> prefix, core::Message message);

  Reassembly& reassembly_;
  ArrivalObserver& arrivals_;
  const bool control_;
  std::uint64_t next_ = 0;  // first byte not received
  bool broken_ = false;

  // When the bytes that are consumed now arrived, at the earliest.
  Time arrived_{};
  AgeMarks early_since_;

  // The message being received.
  std::array<std::byte, kRecordHead> head_{};
  std::size_t head_size_ = 0;
  Time begun_{};               // when its first byte arrived, at the earliest
  MessageBuffer body_;         // the received part of the message, header included
  std::size_t body_size_ = 0;  // number of bytes received
  std::size_t discarded_ = 0;  // remaining bytes of a message that was given up
  Time progress_{};            // time of the last significant progress
  std::size_t progress_at_ = 0;
  Time refused_{};  // last time there was no memory
  Header header_{};

  RangeSet early_;
  // A ring, indexed by block number; empty until used.
  std::vector<core::BlockPool::Index> early_blocks_;
};

}  // namespace tims::link
