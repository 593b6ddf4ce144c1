// One lane on its way in: puts the stream together again and cuts it into messages.
//
// What comes in order is handed on at once, from the datagram itself when the message is whole in
// it. What comes too early is kept; what cannot be kept is refused, and comes again.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "router/core/block_pool.h"
#include "router/link/message_memory.h"
#include "router/link/range_set.h"
#include "router/link/record.h"

namespace tims::link {

// What the lanes of one link share, and their share of what all links have: while another link
// wants memory, one takes no more than it leaves to others (a dynamic threshold: Choudhury, Hahne
// 1998).
struct Assembly {
  core::BlockPool& pool;             // for what comes too early
  MessageMemory& memory;             // for messages that come in parts
  std::vector<MessageBuffer>& done;  // messages that were handed on and are still looked at
  std::uint32_t message_max = kMessageMaxDefault;
  std::size_t blocks = 0;  // of the pool, that this link has
  std::size_t bytes = 0;   // of the memory

  core::BlockPool::Index take_block();
  void give_block(core::BlockPool::Index& block);
  // Empty when there is none now.
  MessageBuffer take(Time now, std::size_t size);
  void give(MessageBuffer& buffer);
  void hand_on(MessageBuffer& buffer);  // it is looked at until the turn ends
  [[nodiscard]] bool is_used() const { return bytes > 0; }
};

class LaneReceiver {
 public:
  explicit LaneReceiver(Assembly& assembly) : assembly_(assembly) {}
  LaneReceiver(const LaneReceiver&) = delete;
  LaneReceiver& operator=(const LaneReceiver&) = delete;
  ~LaneReceiver() { drop_early(); }

  enum class Verdict : std::uint8_t {
    kTaken,    // or known already
    kRefused,  // no memory, or too far ahead: must not be acknowledged
    kBroken,   // no stream of messages: the other side is no router of ours
  };
  Verdict on_bytes(Time now, std::uint64_t offset, std::span<std::byte> bytes, bool control,
                   Arrivals& arrivals);
  Verdict on_skip(Time now, std::uint64_t to, bool control, Arrivals& arrivals);

  // What is here and in order could not be handed on for lack of memory: on_bytes and retry do.
  [[nodiscard]] bool is_stuck() const { return !early_.empty() && early_.front().begin <= next_; }
  Verdict retry(Time now, bool control, Arrivals& arrivals) {
    return is_stuck() ? drain_early(now, control, arrivals) : Verdict::kTaken;
  }

  // A message that makes no progress is given up after a while, sooner when others want its memory;
  // what still comes of it is thrown away. Its header.
  static constexpr Duration kPatience = std::chrono::seconds(30);
  static constexpr Duration kPatienceIfWanted = std::chrono::seconds(2);
  static constexpr std::size_t kProgress = 16 << 10;  // so much more, or all of it
  std::optional<Header> give_up_stalled(Time now);

  void clear();  // the lane begins anew
  [[nodiscard]] std::uint64_t next() const { return next_; }

 private:
  bool keep_early(std::uint64_t offset, std::span<const std::byte> bytes);
  Verdict drain_early(Time now, bool control, Arrivals& arrivals);
  void drop_early();
  [[nodiscard]] core::BlockPool::Index& block_of(std::uint64_t offset);

  // Returns how many bytes it took; sets broken_. `stable`: the bytes stay until the flush.
  std::size_t consume(Time now, std::span<std::byte> bytes, bool stable, bool control,
                      Arrivals& arrivals);
  std::size_t consume_head(Time now, std::span<const std::byte> bytes);
  std::size_t consume_body(Time now, std::span<const std::byte> bytes, bool control,
                           Arrivals& arrivals);
  bool begin_message(Time now, const Header& header);
  [[nodiscard]] bool is_bad(const Header& header) const;
  static void hand_on(Time now, std::span<const std::byte> prefix, core::Message message,
                      bool control, Arrivals& arrivals);

  Assembly& assembly_;
  std::uint64_t next_ = 0;  // first byte that has not come
  bool broken_ = false;

  // The message in the making.
  std::array<std::byte, kRecordHead> head_{};
  std::size_t head_size_ = 0;
  MessageBuffer body_;           // the message, header included
  std::size_t body_size_ = 0;    // so much of it is there
  std::size_t thrown_away_ = 0;  // of a message that was given up: so much is still to come
  Time progress_{};              // a good part of it has come
  std::size_t progress_at_ = 0;
  Header header_{};

  RangeSet early_;
  std::vector<core::BlockPool::Index> early_blocks_;  // a ring, by block number; empty until used
};

}  // namespace tims::link
