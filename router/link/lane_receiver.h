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

#include "router/core/byte_chain.h"
#include "router/link/message_memory.h"
#include "router/link/range_set.h"
#include "router/link/record.h"

namespace tims::link {

// What the lanes of one link share, and their share of what all links have. While another link
// wants memory, one takes no more than it leaves to others (a dynamic threshold: Choudhury, Hahne
// 1998) or an equal share, but for the one message that has what is kept (message_memory.h). Places
// and blocks are always shared like that.
struct Assembly {
  core::BlockPool& pool;             // for what comes too early
  MessageMemory& memory;             // for messages that come in parts
  std::vector<MessageBuffer>& done;  // messages that were handed on and are still looked at
  std::uint32_t message_max = kMessageMaxDefault;
  std::size_t blocks = 0;  // of the pool, that this link has
  std::size_t bytes = 0;   // of the memory
  std::size_t places = 0;  // of the memory

  core::BlockPool::Index take_block();
  void give_block(core::BlockPool::Index& block);
  // Makes `buffer` as large, which is empty before its first bytes come. False: not now. Who
  // `insists` comes again, and may have what is kept.
  bool grow(Time now, MessageBuffer& buffer, std::size_t size, bool insists);
  void give(MessageBuffer& buffer);
  void hand_on(MessageBuffer& buffer);  // it is looked at until the turn ends
  void forget(const MessageBuffer& buffer);
  [[nodiscard]] bool is_used() const { return places > 0; }
  // Would so many bytes be more than it may have now?
  [[nodiscard]] bool is_over_share(Time now, std::size_t of_bytes) const {
    return memory.is_wanted(now, this) && of_bytes > memory.share();
  }
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

  // There was no memory for what has just come.
  [[nodiscard]] bool has_refused(Time now) const { return refused_ == now; }

  // What is here and in order could not be handed on for lack of memory: on_bytes and retry do.
  [[nodiscard]] bool is_stuck() const { return !early_.empty() && early_.front().begin <= next_; }
  Verdict retry(Time now, bool control, Arrivals& arrivals) {
    return is_stuck() ? drain_early(now, control, arrivals) : Verdict::kTaken;
  }

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
