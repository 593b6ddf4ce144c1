// One WebSocket, from the handshake to the end: whole binary messages in, frames out
// (WebSocketSession); and its output queue (WebSocketOutput, which is pure): whole messages by
// priority, split into frames just before they are written.
//
// The interface is plain because Boost.Beast's WebSocket costs a quarter of a minute of compile
// time and 600 MB of memory: websocket_session.cpp is the only file that includes it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "router/core/message_queue.h"
#include "router/core/queue_shares.h"
#include "router/core/statistics.h"
#include "router/core/stream_counters.h"
#include "router/io/http/http_message.h"
#include "router/io/http/stream_socket.h"
#include "router/io/loop.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::io {

// About a quarter of a megabyte per frame: pings can be sent between frames.
inline constexpr std::size_t kFramePiecesMax = 64;

class WebSocketOutput {
 public:
  // `owner` is asked to give memory to others.
  WebSocketOutput(core::QueueShares& shares, core::QueueOwner& owner, std::uint64_t queue_bytes_max,
                  const core::PriorityClasses& classes = core::kConventionalClasses)
      : queue_(shares, owner, queue_bytes_max, classes), queue_bytes_max_(queue_bytes_max) {}

  void set_queue_bytes_max(std::uint64_t bytes) { queue_bytes_max_ = bytes; }
  // From now on, only the newest sample of each stream waits.
  void keep_newest();
  // Null: keep_newest() was not called.
  [[nodiscard]] const core::StreamCounters* streams() const { return streams_.get(); }

  // Copies a whole message. One that is larger than the bound may exceed it by its size: a picture
  // would never arrive otherwise.
  core::Outcome add(std::span<const std::byte> message, std::uint8_t priority);

  struct Frame {
    std::span<const std::span<const std::byte>> pieces;
    bool last;  // last frame of its message
  };
  // The next frame; empty when the queue is empty. The bytes stay valid until end_frame(), which
  // must be called when they are written and before the next frame begins.
  std::optional<Frame> begin_frame();
  void end_frame();

  // Drops all waiting messages. Precondition: no frame is being written.
  void clear(core::LossCounts& lost);
  // Messages were dropped for others.
  void add_replaced(const core::LossCounts& lost);
  // Messages replaced by newer ones since the last call; null when there are none.
  [[nodiscard]] const core::LossCounts* replaced() const {
    return has_replaced_ ? &replaced_ : nullptr;
  }
  void forget_replaced();

  [[nodiscard]] std::uint64_t queued_bytes() const { return queue_.bytes(); }
  [[nodiscard]] bool empty() const { return queue_.empty() && !in_frame_; }

 private:
  std::size_t begin_message();
  std::size_t add_rest(std::size_t count);

  std::unique_ptr<core::StreamCounters> streams_;
  core::MessageQueue queue_;
  std::uint64_t queue_bytes_max_;
  core::LossCounts replaced_{};
  bool has_replaced_ = false;
  bool in_frame_ = false;
  std::array<std::byte, kHeaderSize> header_{};  // of the message being written
  std::size_t rest_ = 0;                         // bytes of it that are not in frames yet
  std::uint64_t frame_body_ = 0;                 // bytes of the frame that are still in the queue
  std::array<std::span<const std::byte>, kFramePiecesMax> pieces_{};
};

// Close codes of RFC 6455, section 7.4.1, and of its registry.
enum class WebSocketClose : std::uint16_t {
  kGoingAway = 1001,
  kUnsupportedData = 1003,
  kBadData = 1007,
  kPolicy = 1008,
  kTryAgainLater = 1013,
};

class WebSocketSession {
 public:
  // Receives the events of a session. Called from the event loop, never from within a call to the
  // session.
  class Listener {
   public:
    virtual void on_open() = 0;  // the handshake is done: always the first call
    // The bytes may be modified, and are valid until the call returns.
    virtual void on_message(std::span<std::byte> message) = 0;
    // A part of a message arrived; `bytes` of it have been received so far.
    virtual void on_part(std::size_t bytes) = 0;
    virtual void on_text() = 0;     // a text message arrived; its contents are not passed on
    virtual void on_written() = 0;  // the frame is in the socket
    // Always the last call. `unfinished`: bytes of an incomplete message.
    virtual void on_end(core::CloseReason reason, std::size_t unfinished) = 0;

   protected:
    ~Listener() = default;
  };

  struct Settings {
    std::uint32_t message_max = 0;
    // Interval of WebSocket pings. A client that has neither answered when the next one is due,
    // nor sent or read anything else, is disconnected.
    Duration ping_interval{};
    Duration handshake_timeout = std::chrono::seconds(10);
    Duration close_timeout = std::chrono::seconds(5);
  };

  // Answers `request`, the upgrade. The listener must exist until on_end() or drop().
  static std::shared_ptr<WebSocketSession> start(Loop& loop, StreamSocket socket,
                                                 const HttpRequest& request,
                                                 const Settings& settings, Listener& listener);
  virtual ~WebSocketSession() = default;

  virtual void set_ping_interval(Duration interval) = 0;

  // Writes one frame at a time: the next one after on_written(), until when the bytes must stay
  // valid. `pieces`: at most kFramePiecesMax.
  virtual void write(std::span<const std::span<const std::byte>> pieces, bool last) = 0;

  // Sends a close frame with the reason after the current frame; on_end() reports the end.
  // Further received data is discarded.
  virtual void close(WebSocketClose code, std::string reason) = 0;
  // Ends immediately without a close frame: no more calls to the listener or accesses to the
  // bytes.
  virtual void drop() = 0;
};

}  // namespace tims::io
