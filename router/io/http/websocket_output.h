// What waits to be written into one WebSocket: whole messages in order of importance, cut into
// frames just before they are written. Pure.
//
// Of the message whose frames are on their way nothing is replaced any more, and nothing overtakes
// it: the queue takes it for one that is half written (core::MessageQueue).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "router/core/message_queue.h"
#include "router/core/statistics.h"
#include "tims/message.h"

namespace tims::io {

// About a quarter of a megabyte a frame: between frames there is room for a ping.
inline constexpr std::size_t kFramePiecesMax = 64;

class WebSocketOutput {
 public:
  WebSocketOutput(core::BlockPool& pool, std::uint64_t queue_bytes_max,
                  const core::PriorityClasses& classes = core::kConventionalClasses)
      : queue_(pool, queue_bytes_max, core::MessageQueue::Share::kFair, classes) {}

  void set_queue_bytes_max(std::uint64_t bytes) { queue_.set_bytes_max(bytes); }

  // A whole message; it is copied.
  core::Outcome add(std::span<const std::byte> message, std::uint8_t priority);

  struct Frame {
    std::span<const std::span<const std::byte>> pieces;
    bool last;  // of its message
  };
  // What is to be written next; nothing when nothing waits. The bytes stay where they are until
  // end_frame(), which is called when they are written and before the next frame begins.
  std::optional<Frame> begin_frame();
  void end_frame();

  // Throws away what waits. No frame is being written.
  void clear(core::LossCounts& lost);
  // What had to go for newer messages since the last time; null when nothing had to.
  [[nodiscard]] const core::LossCounts* replaced() const {
    return has_replaced_ ? &replaced_ : nullptr;
  }
  void forget_replaced();

  [[nodiscard]] std::uint64_t queued_bytes() const { return queue_.bytes(); }
  [[nodiscard]] bool empty() const { return queue_.empty() && !in_frame_; }

 private:
  std::size_t begin_message();
  std::size_t add_rest(std::size_t count);

  core::MessageQueue queue_;
  core::LossCounts replaced_{};
  bool has_replaced_ = false;
  bool in_frame_ = false;
  std::array<std::byte, kHeaderSize> header_{};  // of the message being written
  std::uint64_t rest_ = 0;                       // bytes of it that are not in frames yet
  std::uint64_t frame_body_ = 0;                 // bytes of the frame that are still in the queue
  std::array<std::span<const std::byte>, kFramePiecesMax> pieces_{};
};

}  // namespace tims::io
