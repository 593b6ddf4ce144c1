// The frames of a DATA datagram, byte for byte (PROTOCOL.md draws them).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "router/core/ids.h"
#include "tims/time.h"

namespace tims::link {

// A link carries nine lanes: one for each class of messages, and one above them all for what the
// routers themselves have to say.
inline constexpr std::size_t kLanes = core::kClasses + 1;
inline constexpr std::size_t kControlLane = core::kClasses;

enum class FrameType : std::uint8_t {
  kKeepAlive = 1,
  kAck = 2,
  kStream = 3,
  kSkip = 4,
  kSample = 5,
  kProbe = 6,
  kChallenge = 7,
  kResponse = 8,
  kClose = 9,
  kNotReady = 10,
};

// Sent at a steady pace by both sides, each echoing the other's last one: round trip and clock
// offset come from the four times, as in NTP's symmetric mode (RFC 5905, section 8).
struct KeepAlive {
  bool deaf = false;                // its sender has not heard the receiver for long
  std::uint8_t questions = 0;       // CHALLENGE and RESPONSE so far: on a dead way they are no loss
  std::uint64_t sent_ns = 0;        // on the sender's monotonic clock
  std::uint64_t echo_ns = 0;        // sent_ns of the last one that came; 0: none yet
  std::uint32_t held_us = 0;        // how long ago that came
  std::uint16_t loss_permille = 0;  // of the datagrams that the sender of this should have received
  std::int64_t wall_ns = 0;         // the sender's real-time clock less its monotonic one
  std::uint32_t table_number = 0;   // how often the sender's exported table has changed
  std::uint32_t table_hash = 0;     // what it is now
};
inline constexpr std::uint8_t kQuestionsModulo = 128;
inline constexpr std::size_t kKeepAliveSize = 40;

struct PacketRange {  // both ends belong to it
  std::uint32_t first = 0;
  std::uint32_t last = 0;
};
struct Ack {
  static constexpr std::size_t kRangesMax = 32;
  std::uint16_t delay = 0;  // since the newest of them came, in units of kAckDelayUnit
  std::uint8_t count = 0;
  std::array<PacketRange, kRangesMax> ranges{};  // newest first
};
inline constexpr Duration kAckDelayUnit = std::chrono::microseconds(4);
constexpr std::size_t ack_size(std::size_t ranges) { return 4 + 8 * ranges; }

// Bytes of a lane: what is reliable and in order.
struct StreamFrame {
  std::uint8_t lane = 0;
  std::uint64_t offset = 0;
  std::span<std::byte> bytes{};
};
inline constexpr std::size_t kStreamHeaderSize = 12;

// What the lane has below `to` will not come any more; `to` begins a message.
struct SkipFrame {
  std::uint8_t lane = 0;
  std::uint64_t to = 0;
};
inline constexpr std::size_t kSkipSize = 12;

// A sample of a stream (flag STREAM), or a part of one: never sent twice.
struct SampleFrame {
  std::uint8_t hops = 0;
  std::uint32_t number = 0;  // of the sample, counted over the link
  std::uint32_t total = 0;   // bytes of the sample
  std::uint32_t offset = 0;
  std::span<std::byte> bytes{};
};
inline constexpr std::size_t kSampleHeaderSize = 16;

struct ProbeFrame {};  // the rest of the datagram is padding
struct ChallengeFrame {
  std::uint64_t nonce = 0;
};
struct ResponseFrame {
  std::uint64_t nonce = 0;
};
inline constexpr std::size_t kNonceFrameSize = 9;
struct CloseFrame {
  std::uint8_t reason = 0;
};
// There was no memory for what came in these lanes: try again in a while (the RNR NAK of
// InfiniBand). A hint, which may be lost: what was not kept is not acknowledged either.
struct NotReadyFrame {
  std::uint16_t lanes = 0;  // a bit for each
};
inline constexpr std::size_t kNotReadySize = 3;

using Frame = std::variant<KeepAlive, Ack, StreamFrame, SkipFrame, SampleFrame, ProbeFrame,
                           ChallengeFrame, ResponseFrame, CloseFrame, NotReadyFrame>;

// Walks the frames of a datagram. Once next() has said nothing, ok() tells whether that was the end
// or something that is no frame.
class FrameReader {
 public:
  explicit FrameReader(std::span<std::byte> frames) : rest_(frames) {}

  std::optional<Frame> next();
  [[nodiscard]] bool ok() const { return ok_; }

 private:
  std::optional<Frame> bad();

  std::span<std::byte> rest_;
  bool ok_ = true;
};

class ByteWriter;
void put(ByteWriter& out, const KeepAlive& frame);
void put(ByteWriter& out, const Ack& frame);
void put(ByteWriter& out, const SkipFrame& frame);
void put(ByteWriter& out, const NotReadyFrame& frame);
void put_challenge(ByteWriter& out, FrameType type, std::uint64_t nonce);
void put_close(ByteWriter& out, std::uint8_t reason);
// The headers only: the bytes follow.
void put_header(ByteWriter& out, std::uint8_t lane, std::uint64_t offset, std::size_t size);
void put_header(ByteWriter& out, const SampleFrame& frame, std::size_t size);

}  // namespace tims::link
