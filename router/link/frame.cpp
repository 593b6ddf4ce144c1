#include "router/link/frame.h"

#include "router/link/datagram.h"
#include "wire/header.h"

namespace tims::link {
namespace {

constexpr std::uint64_t kOffsetMax = std::uint64_t{1} << 62;

KeepAlive get_keep_alive(ByteReader& in) {
  KeepAlive frame;
  const auto state = in.get<std::uint8_t>();
  frame.nothing_received = (state & 1) != 0;
  frame.questions = state >> 1;
  in.get(frame.loss_permille, frame.held_us, frame.sent_ns, frame.echo_ns, frame.wall_ns,
         frame.table_number, frame.table_hash);
  return frame;
}

std::optional<Frame> get_ack(ByteReader& in) {
  Ack ack;
  in.get(ack.count, ack.delay);
  if (ack.count == 0 || ack.count > Ack::kRangesMax) return std::nullopt;
  for (PacketRange& range : std::span(ack.ranges).first(ack.count)) in.get(range.first, range.last);
  return ack;
}

std::optional<Frame> get_stream(ByteReader& in, std::span<std::byte> all) {
  StreamFrame frame;
  std::uint16_t size = 0;
  in.get(frame.lane, size, frame.offset);
  const std::size_t begin = all.size() - in.rest().size();
  in.take(size);
  if (!in.ok() || size == 0 || frame.lane >= kLanes || frame.offset > kOffsetMax)
    return std::nullopt;
  frame.bytes = all.subspan(begin, size);
  return frame;
}

std::optional<Frame> get_skip(ByteReader& in) {
  SkipFrame frame;
  std::uint16_t unused = 0;
  in.get(frame.lane, unused, frame.to);
  if (frame.lane >= kControlLane || frame.to > kOffsetMax) return std::nullopt;
  return frame;
}

std::optional<Frame> get_sample(ByteReader& in, std::span<std::byte> all) {
  SampleFrame frame;
  std::uint16_t size = 0;
  in.get(frame.hops, size, frame.number, frame.total, frame.offset);
  const std::size_t begin = all.size() - in.rest().size();
  in.take(size);
  const bool inside = std::uint64_t{frame.offset} + size <= frame.total;
  if (!in.ok() || size == 0 || !inside) return std::nullopt;
  frame.bytes = all.subspan(begin, size);
  return frame;
}

std::optional<Frame> get_frame(ByteReader& in, std::span<std::byte> all) {
  switch (static_cast<FrameType>(in.get<std::uint8_t>())) {
    case FrameType::kKeepAlive:
      return get_keep_alive(in);
    case FrameType::kAck:
      return get_ack(in);
    case FrameType::kStream:
      return get_stream(in, all);
    case FrameType::kSkip:
      return get_skip(in);
    case FrameType::kSample:
      return get_sample(in, all);
    case FrameType::kProbe:
      in.take(in.rest().size());
      return ProbeFrame{};
    case FrameType::kChallenge:
      return ChallengeFrame{in.get<std::uint64_t>()};
    case FrameType::kResponse:
      return ResponseFrame{in.get<std::uint64_t>()};
    case FrameType::kClose:
      return CloseFrame{in.get<std::uint8_t>()};
    case FrameType::kNotReady:
      return NotReadyFrame{in.get<std::uint16_t>()};
    case FrameType::kPause:
      return PauseFrame{in.get<std::uint16_t>()};
  }
  return std::nullopt;
}

}  // namespace

std::optional<Data> decode_data(std::span<std::byte> datagram) {
  if (datagram.size() < kDataHeaderSize ||
      datagram.front() != static_cast<std::byte>(DatagramKind::kData))
    return std::nullopt;
  ByteReader in(datagram.subspan(1));
  Data data{.head = datagram.first(kDataHeaderSize)};
  in.get(data.header.phase, data.header.generation);
  in.get<std::uint8_t>();
  in.get(data.header.packet, data.header.token);
  data.frames = datagram.subspan(kDataHeaderSize);
  return data;
}

void encode(const DataHeader& header, std::span<std::byte, kDataHeaderSize> to) {
  ByteWriter out(to);
  out.put(DatagramKind::kData, header.phase, header.generation, std::uint8_t{0}, header.packet,
          header.token);
}

std::optional<Frame> FrameReader::next() {
  if (rest_.empty()) return std::nullopt;
  ByteReader in(rest_);
  auto frame = get_frame(in, rest_);
  if (!frame || !in.ok()) return bad();
  rest_ = rest_.last(in.rest().size());
  return frame;
}

std::optional<Frame> FrameReader::bad() {
  rest_ = {};
  ok_ = false;
  return std::nullopt;
}

void put(ByteWriter& out, const KeepAlive& frame) {
  const auto state =
      static_cast<std::uint8_t>(frame.questions << 1 | (frame.nothing_received ? 1 : 0));
  out.put(FrameType::kKeepAlive, state, frame.loss_permille, frame.held_us, frame.sent_ns,
          frame.echo_ns, frame.wall_ns, frame.table_number, frame.table_hash);
}

void put(ByteWriter& out, const Ack& frame) {
  out.put(FrameType::kAck, frame.count, frame.delay);
  for (std::size_t i = 0; i < frame.count; ++i)
    out.put(frame.ranges[i].first, frame.ranges[i].last);
}

void put(ByteWriter& out, const SkipFrame& frame) {
  out.put(FrameType::kSkip, frame.lane, std::uint16_t{0}, frame.to);
}

void put(ByteWriter& out, const NotReadyFrame& frame) {
  out.put(FrameType::kNotReady, frame.lanes);
}

void put(ByteWriter& out, const CloseFrame& frame) { out.put(FrameType::kClose, frame.reason); }

void put(ByteWriter& out, const PauseFrame& frame) { out.put(FrameType::kPause, frame.longest_ms); }

void put_challenge(ByteWriter& out, FrameType type, std::uint64_t nonce) { out.put(type, nonce); }

void put_header(ByteWriter& out, std::uint8_t lane, std::uint64_t offset, std::size_t size) {
  out.put(FrameType::kStream, lane, static_cast<std::uint16_t>(size), offset);
}

void put_header(ByteWriter& out, const SampleFrame& frame, std::size_t size) {
  out.put(FrameType::kSample, frame.hops, static_cast<std::uint16_t>(size), frame.number,
          frame.total, frame.offset);
}

ControlMessage::ControlMessage(std::int8_t type)
    : header_{.flags = flag::kBodyLittleEndian, .type = type}, bytes_(kHeaderSize) {}

void ControlMessage::put_u32(std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8)
    bytes_.push_back(static_cast<std::byte>(value >> shift & 0xFF));
}

void ControlMessage::put(const TableState& state) {
  put_u32(state.number);
  put_u32(state.hash);
}

void ControlMessage::put(const ListPlace& place) {
  put_u32(static_cast<std::uint32_t>(place.number & 0xFFFF'FFFF));
  put_u32(static_cast<std::uint32_t>(place.number >> 32));
  put_u32(place.offset);
}

void ControlMessage::put(std::span<const std::byte> bytes) {
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
}

void ControlMessage::put(Address address) { put_u32(address.raw()); }

void ControlMessage::put(Address address, const core::Origin& origin) {
  if (group_ == 0 || origin_ != origin || count_ == 0xFFFF) {
    put_u32(origin.router.raw());
    put_u32(origin.epoch);
    bytes_.push_back(std::byte{origin.hops});
    bytes_.push_back(std::byte{0});
    group_ = bytes_.size();
    bytes_.resize(group_ + 2);
    origin_ = origin;
    count_ = 0;
  }
  ++count_;
  bytes_[group_] = static_cast<std::byte>(count_ & 0xFF);
  bytes_[group_ + 1] = static_cast<std::byte>(count_ >> 8);
  put(address);
}

std::span<const std::byte> ControlMessage::finish() {
  header_.length = static_cast<std::uint32_t>(bytes_.size());
  wire::encode_header(header_, std::span(bytes_).first<kHeaderSize>(), std::endian::little);
  return bytes_;
}

bool read_state(std::span<const std::byte> body, TableState& state) {
  ByteReader in(body);
  in.get(state.number, state.hash);
  return in.ok();
}

bool read_list_place(std::span<const std::byte> body, ListPlace& place,
                     std::span<const std::byte>& rest) {
  ByteReader in(body);
  in.get(place.number, place.offset);
  rest = in.rest();
  return in.ok();
}

}  // namespace tims::link
