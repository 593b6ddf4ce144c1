// One lane on its way out: a reliable stream of messages.
//
// A message first waits, in order of arrival, and may still be dropped there when more important
// ones need the room. Then it is committed: it gets its place in the stream and is kept until the
// other side has acknowledged it, or it has grown too old and the stream goes on behind it (SKIP,
// as the FORWARD-TSN of SCTP's partial reliability, RFC 3758).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "router/link/age_marks.h"
#include "router/link/range_set.h"
#include "router/link/record.h"
#include "router/link/stream_buffer.h"

namespace tims::link {

// How far the stream may run ahead of what the other side is known to have.
inline constexpr std::uint64_t kLaneWindow = 8U << 20;
// In the routers' own lane it is short: what comes late comes all at once, and each mailbox told is
// work.
inline constexpr std::uint64_t kControlWindow = 256U << 10;

class LaneSender {
 public:
  explicit LaneSender(core::BlockPool& pool) : waiting_(pool), stream_(pool) {}

  void set_window(std::uint64_t window) { window_ = window; }

  [[nodiscard]] bool has_room(std::size_t message) const {
    return waiting_.has_room(record_size(message) + 2 * core::BlockPool::kBlockSize);
  }
  // `message`: whole, its header in the machine's own order. There is room. While less than
  // `committed_max` bytes are committed and not sent, it need not wait.
  void push(Time now, const RecordPrefix& prefix, std::span<const std::byte> message,
            std::uint64_t committed_max);

  [[nodiscard]] std::uint64_t bytes() const { return waiting_.size() + stream_.size(); }
  [[nodiscard]] std::uint64_t unsent_bytes() const {
    return waiting_.size() + (stream_.end() - next_);
  }
  // Nothing is to be sent, and nothing that was sent can come back as lost.
  [[nodiscard]] bool is_idle() const { return bytes() == 0 && skip_acked_ == skip_to_; }
  [[nodiscard]] bool has_waiting() const { return !waiting_.empty(); }
  [[nodiscard]] std::uint64_t waiting_bytes() const { return waiting_.size(); }
  // Drops the message that waits longest. Its header.
  Header drop_oldest();

  // What is to be sent next: something that was lost, or what has never been sent.
  [[nodiscard]] bool wants_to_send() const;
  [[nodiscard]] bool repeats() const { return !lost_.empty(); }
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
  void expire(Time now, Duration lifetime, Losses& losses);
  // Gives up everything; the lane begins anew.
  void clear(Time now, core::Outcome why, Losses& losses);

 private:
  void commit(Time now, std::uint64_t committed_max);
  // Blocks come free in waiting_ as a message moves.
  [[nodiscard]] bool can_commit() const {
    return stream_.has_room(2 * core::BlockPool::kBlockSize);
  }
  [[nodiscard]] std::uint64_t window_end() const;
  static Header header_at(const StreamBuffer& buffer, std::uint64_t offset);
  static std::uint64_t lose(Time now, StreamBuffer& buffer, std::uint64_t to, core::Outcome why,
                            Losses& losses);

  std::uint64_t window_ = kLaneWindow;
  StreamBuffer waiting_;
  AgeMarks waiting_since_;
  StreamBuffer stream_;  // from the first message that is not acknowledged whole
  AgeMarks stream_since_;
  std::uint64_t next_ = 0;  // first byte that was never sent
  RangeSet acked_;          // parts above stream_.begin()
  RangeSet lost_;           // to be sent again
  std::uint64_t skip_to_ = 0;
  std::uint64_t skip_acked_ = 0;
  bool skip_due_ = false;
};

}  // namespace tims::link
