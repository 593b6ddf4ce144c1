// The DATA datagram, byte for byte (drawn in PROTOCOL.md): its frames, the messages as stored in
// the lanes, and the routers' own messages in the control lane.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "router/core/statistics.h"
#include "router/core/types.h"
#include "router/link/datagram.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::link {

struct DataHeader {
  std::uint64_t token = 0;
  std::uint32_t packet = 0;  // the lower 32 bits of the packet's number
  // Of the keys it is sealed with (session_keys.h); 0 when it is not.
  std::uint8_t phase = 0;
  std::uint8_t generation = 0;
};
inline constexpr std::size_t kDataHeaderSize = 16;
struct Data {
  DataHeader header{};
  std::span<const std::byte> head{};  // its bytes
  std::span<std::byte> frames{};      // sealed, with the tag, until they are opened
};
// Empty for any other datagram.
std::optional<Data> decode_data(std::span<std::byte> datagram);
void encode(const DataHeader& header, std::span<std::byte, kDataHeaderSize> to);

// --- frames

// A link carries nine lanes: one for each class of messages, and the most urgent one for the
// routers' own messages.
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
  kPause = 11,
};

// Sent at a steady pace by both sides, each echoing the other's last one: round trip and clock
// offset follow from the four timestamps, as in NTP's symmetric mode (RFC 5905, section 8).
struct KeepAlive {
  bool nothing_received =
      false;  // its sender has received nothing from the receiver for a long time
  // number of CHALLENGE and RESPONSE sent: lost on a dead path, they do not count as loss
  std::uint8_t questions = 0;
  std::uint64_t sent_ns = 0;        // on the sender's monotonic clock
  std::uint64_t echo_ns = 0;        // sent_ns of the last keep-alive received; 0: none yet
  std::uint32_t held_us = 0;        // time since that was received
  std::uint16_t loss_permille = 0;  // of the datagrams that its sender should have received
  std::int64_t wall_ns = 0;         // the sender's real-time clock minus its monotonic clock
  std::uint32_t table_number = 0;   // number of changes of the sender's exported table
  std::uint32_t table_hash = 0;     // hash of its current state
};
inline constexpr std::uint8_t kQuestionsModulo = 128;
inline constexpr std::size_t kKeepAliveSize = 40;

struct PacketRange {  // both ends inclusive
  std::uint32_t first = 0;
  std::uint32_t last = 0;
};
struct Ack {
  static constexpr std::size_t kRangesMax = 32;
  std::uint16_t delay = 0;  // since the newest of them arrived, in units of kAckDelayUnit
  std::uint8_t count = 0;
  std::array<PacketRange, kRangesMax> ranges{};  // newest first
};
inline constexpr Duration kAckDelayUnit = std::chrono::microseconds(4);
constexpr std::size_t ack_size(std::size_t ranges) { return 4 + 8 * ranges; }

// Bytes of a lane, reliable and in order.
struct StreamFrame {
  std::uint8_t lane = 0;
  std::uint64_t offset = 0;
  std::span<std::byte> bytes{};
};
inline constexpr std::size_t kStreamHeaderSize = 12;

// The lane's bytes below `to` will not be sent any more; a message begins at `to`.
struct SkipFrame {
  std::uint8_t lane = 0;
  std::uint64_t to = 0;
};
inline constexpr std::size_t kSkipSize = 12;

// A sample of a stream (flag STREAM), or part of one. Not sent in a lane.
struct SampleFrame {
  std::uint8_t hops = 0;     // as of RecordPrefix::of_sample()
  std::uint32_t number = 0;  // number of the sample, counted per link
  std::uint32_t total = 0;   // size of the sample in bytes
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
// There was no memory for bytes of these lanes: try again later (the RNR NAK of InfiniBand). A
// hint, which may be lost: bytes that were not stored are not acknowledged either.
struct NotReadyFrame {
  std::uint16_t lanes = 0;  // one bit per lane
};
inline constexpr std::size_t kNotReadySize = 3;
// The sender is being restarted: it may be silent for so long, and continues the session then.
struct PauseFrame {
  std::uint16_t longest_ms = 0;
};

// What a router says before it is silent.
using LastFrame = std::variant<CloseFrame, PauseFrame>;

using Frame = std::variant<KeepAlive, Ack, StreamFrame, SkipFrame, SampleFrame, ProbeFrame,
                           ChallengeFrame, ResponseFrame, CloseFrame, NotReadyFrame, PauseFrame>;

// Iterates over the frames of a datagram. When next() returns nothing, ok() distinguishes the end
// from an invalid frame.
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

void put(ByteWriter& out, const KeepAlive& frame);
void put(ByteWriter& out, const Ack& frame);
void put(ByteWriter& out, const SkipFrame& frame);
void put(ByteWriter& out, const NotReadyFrame& frame);
void put(ByteWriter& out, const CloseFrame& frame);
void put(ByteWriter& out, const PauseFrame& frame);
void put_challenge(ByteWriter& out, FrameType type, std::uint64_t nonce);
// The headers only: the bytes follow.
void put_header(ByteWriter& out, std::uint8_t lane, std::uint64_t offset, std::size_t size);
void put_header(ByteWriter& out, const SampleFrame& frame, std::size_t size);

// --- messages in lanes

// A message as encoded in a lane: a prefix of four bytes, then the message.
//
//   0 hops u8 | 1 flags u8 (bit 0: compressed, bit 1: not to be delivered) | 2 waited u16: for
//   traced messages, time in the sender's queue
//
// The routers' own messages (ControlMessage) are encoded in the same form.
inline constexpr std::size_t kRecordPrefix = 4;
inline constexpr std::size_t kRecordHead = kRecordPrefix + kHeaderSize;
inline constexpr Duration kWaitedUnit = std::chrono::microseconds(100);

constexpr std::size_t record_size(std::size_t message) { return kRecordPrefix + message; }

struct RecordPrefix {
  std::uint8_t hops = 0;
  Duration waited{};
  bool packed = false;  // the body is compressed (packing.h)
  bool late = false;    // older than its lifetime: not to be delivered

  [[nodiscard]] std::array<std::byte, kRecordPrefix> encoded() const {
    const auto units =
        static_cast<std::uint16_t>(std::clamp<std::int64_t>(waited / kWaitedUnit, 0, 0xFFFF));
    const unsigned flags = (packed ? 1U : 0U) | (late ? 2U : 0U);
    return {std::byte{hops}, static_cast<std::byte>(flags), static_cast<std::byte>(units & 0xFF),
            static_cast<std::byte>(units >> 8)};
  }
  static RecordPrefix decode(std::span<const std::byte> bytes) {
    const auto low = std::to_integer<std::uint16_t>(bytes[2]);
    const auto high = std::to_integer<std::uint16_t>(bytes[3]);
    return {.hops = std::to_integer<std::uint8_t>(bytes[0]),
            .waited = (low | high << 8) * kWaitedUnit,
            .packed = (bytes[1] & std::byte{1}) != std::byte{0},
            .late = (bytes[1] & std::byte{2}) != std::byte{0}};
  }

  // Of a sample, in the first byte of its frames: hops, and bit 7 if it is compressed.
  static constexpr std::uint8_t kPackedSample = 0x80;
  [[nodiscard]] std::uint8_t of_sample() const { return packed ? hops | kPackedSample : hops; }
  static RecordPrefix decode_sample(std::uint8_t byte) {
    return {.hops = static_cast<std::uint8_t>(byte & ~kPackedSample),
            .packed = (byte & kPackedSample) != 0};
  }
};

// Receives the messages a link brings.
class ArrivalObserver : public core::Interface {
 public:
  // The bytes may be modified and stay valid until the turn is flushed.
  virtual void on_message(Time now, const RecordPrefix& prefix, core::Message& message) = 0;
  // False: a compressed message cannot be decompressed now. Then it is not handed on, and its last
  // bytes come again.
  [[nodiscard]] virtual bool has_room_to_unpack() { return true; }
  // A command that has arrived later than its lifetime, and is not delivered.
  virtual void on_late(Time /*now*/, const Header& /*header*/) {}
  virtual void on_control(Time now, const core::Message& message) = 0;
  virtual void on_frame(Time now, const KeepAlive& frame) = 0;
  virtual void on_frame(Time now, const ChallengeFrame& frame) = 0;
  virtual void on_frame(Time now, const ResponseFrame& frame) = 0;
  virtual void on_frame(Time now, const CloseFrame& frame) = 0;
  virtual void on_frame(Time now, const PauseFrame& frame) = 0;
};

// Receives messages that were accepted and will not arrive.
class LossObserver : public core::Interface {
 public:
  virtual void on_lost(Time now, const Header& header, core::Outcome why) = 0;
};

// --- the control lane

// The routers' own messages in the control lane, byte for byte: they have the form of other
// messages, with their meaning in the type.
//
//   WANT      number u32, hash u32                       I hold your table in this state: go on
//   SNAPSHOT  -                                          forget it: all of it follows
//   ADD       groups of: router u32, epoch u32, hops u8, 0 u8, count u16, count x address u32
//   REMOVE    address u32 ...
//   DONE      number u32, hash u32                       so far it is this state
//   LIST      number u64, size u32                       I have this list of the fleet
//   LIST_GET  number u64, offset u32                     send it from there
//   LIST_PART number u64, offset u32, bytes              some of it
//
// A table is numbered by its changes; its hash is the exclusive or over its mailboxes
// (ExportedTable). Lists: list_exchange.h.

namespace control {
inline constexpr std::int8_t kWant = 1;
inline constexpr std::int8_t kSnapshot = 2;
inline constexpr std::int8_t kAdd = 3;
inline constexpr std::int8_t kRemove = 4;
inline constexpr std::int8_t kDone = 5;
inline constexpr std::int8_t kList = 6;
inline constexpr std::int8_t kListGet = 7;
inline constexpr std::int8_t kListPart = 8;
}  // namespace control

struct TableState {
  std::uint32_t number = 0;
  std::uint32_t hash = 0;
  bool operator==(const TableState&) const = default;
};

// A list of the fleet, and a place in it: of LIST its end.
struct ListPlace {
  std::uint64_t number = 0;
  std::uint32_t offset = 0;
  bool operator==(const ListPlace&) const = default;
};
inline constexpr std::size_t kListPlaceSize = 12;

// A control message being built: its header and body.
class ControlMessage {
 public:
  static constexpr std::size_t kBodyMax = 16 << 10;

  explicit ControlMessage(std::int8_t type);

  void put(const TableState& state);
  void put(const ListPlace& place);
  void put(std::span<const std::byte> bytes);
  void put(Address address);
  // Adds to the group of the last address when the origin is the same.
  void put(Address address, const core::Origin& origin);
  [[nodiscard]] bool full() const { return bytes_.size() + 32 > kBodyMax; }
  [[nodiscard]] bool empty() const { return bytes_.size() == kHeaderSize; }

  // The whole message, with its header filled in.
  std::span<const std::byte> finish();

 private:
  void put_u32(std::uint32_t value);

  Header header_;
  std::vector<std::byte> bytes_;
  std::size_t group_ = 0;  // offset of the open group's count; 0: none
  core::Origin origin_{};
  std::uint16_t count_ = 0;
};

// Read the bodies; return false when a body does not match the type.
bool read_state(std::span<const std::byte> body, TableState& state);
// `rest`: what follows.
bool read_list_place(std::span<const std::byte> body, ListPlace& place,
                     std::span<const std::byte>& rest);
template <typename Visit>  // (Address)
bool read_addresses(std::span<const std::byte> body, Visit visit) {
  ByteReader in(body);
  while (!in.empty()) {
    const Address address(in.get<std::uint32_t>());
    if (!in.ok()) return false;
    visit(address);
  }
  return true;
}
// Calls visit(Address, const Origin&), with hops as counted by the other router.
template <typename Visit>
bool read_announcements(std::span<const std::byte> body, Visit visit) {
  ByteReader in(body);
  while (!in.empty()) {
    core::Origin origin;
    origin.router = Address(in.get<std::uint32_t>());
    std::uint8_t unused = 0;
    std::uint16_t count = 0;
    in.get(origin.epoch, origin.hops, unused, count);
    if (!in.ok() || count == 0) return false;
    for (std::size_t i = 0; i < count; ++i) {
      const Address address(in.get<std::uint32_t>());
      if (!in.ok()) return false;
      visit(address, origin);
    }
  }
  return true;
}

}  // namespace tims::link
