#include "wire/tcp_protocol.h"

#include <algorithm>

namespace tims::wire {

namespace {

// A buffer up to this size is kept for the next message that spans chunks: a stream of small
// messages causes one allocation, not one for every chunk.
constexpr std::size_t kKeptBytesMax = 64 << 10;
constexpr std::size_t kBufferBytesMin = 4 << 10;

// Smaller remainders are copied: reading them directly would need a system call of its own, which
// could not fetch the following messages.
constexpr std::size_t kRoomBytesMin = 16 << 10;

// Beyond this, lifesigns are no longer answered.
constexpr std::size_t kAnswersBytesMax = 1 << 20;

}  // namespace

StreamReader::Item StreamReader::next(std::span<std::byte>& chunk) {
  if (broken_) return *broken_;
  if (handed_out_) release();
  if (filled_ > 0 || chunk.size() < kHeaderSize) return gather(chunk);

  const Header header = decode_header(chunk.first<kHeaderSize>());
  if (const auto refused = check(header)) return *refused;
  if (header.length > chunk.size()) return gather(chunk);
  const std::span<std::byte> message = chunk.first(header.length);
  chunk = chunk.subspan(header.length);
  return {Status::kMessage, message, header};
}

std::span<std::byte> StreamReader::room() {
  if (handed_out_) release();
  if (broken_ || filled_ < kHeaderSize) return {};
  const std::size_t missing = header_.length - filled_;
  if (missing < kRoomBytesMin) return {};
  return {buffer_.get() + filled_, missing};
}

void StreamReader::advance(std::size_t n) { filled_ += n; }

StreamReader::Item StreamReader::gather(std::span<std::byte>& chunk) {
  if (filled_ < kHeaderSize) {
    if (chunk.empty()) return {Status::kNeedMore, {}, {}};
    reserve(kHeaderSize);
    take(chunk, kHeaderSize);
    if (filled_ < kHeaderSize) return {Status::kNeedMore, {}, {}};
    header_ = decode_header(ConstHeaderBytes(buffer_.get(), kHeaderSize));
    if (const auto refused = check(header_)) return *refused;
    reserve(header_.length);
  }
  take(chunk, header_.length);
  if (filled_ < header_.length) return {Status::kNeedMore, {}, {}};
  handed_out_ = true;
  return {Status::kMessage, {buffer_.get(), header_.length}, header_};
}

std::optional<StreamReader::Item> StreamReader::check(const Header& header) {
  switch (check_length(header.length, length_max_)) {
    case LengthVerdict::kOk:
      return std::nullopt;
    case LengthVerdict::kTooShort:
      broken_ = {Status::kTooShort, {}, header};
      break;
    case LengthVerdict::kTooLong:
      broken_ = {Status::kTooLong, {}, header};
      break;
  }
  filled_ = 0;
  buffer_.reset();
  capacity_ = 0;
  return broken_;
}

// Moves bytes from the chunk until `filled_end` bytes of the message are here.
void StreamReader::take(std::span<std::byte>& chunk, std::size_t filled_end) {
  const std::size_t n = std::min(chunk.size(), filled_end - filled_);
  std::copy_n(chunk.begin(), n, buffer_.get() + filled_);
  filled_ += n;
  chunk = chunk.subspan(n);
}

// Not zeroed: the pages of a large buffer are allocated only when the bytes arrive.
void StreamReader::reserve(std::size_t bytes) {
  if (bytes <= capacity_) return;
  const std::size_t capacity = std::max(bytes, kBufferBytesMin);
  auto larger = std::make_unique_for_overwrite<std::byte[]>(capacity);
  std::copy_n(buffer_.get(), filled_, larger.get());
  buffer_ = std::move(larger);
  capacity_ = capacity;
}

void StreamReader::release() {
  handed_out_ = false;
  filled_ = 0;
  if (capacity_ <= kKeptBytesMax) return;
  buffer_.reset();
  capacity_ = 0;
}

// --- The client's end

std::array<std::byte, kHeaderSize> TcpClientProtocol::encode(Header header,
                                                             std::size_t body_size) const {
  std::array<std::byte, kHeaderSize> bytes;
  header.length = static_cast<std::uint32_t>(kHeaderSize + body_size);
  encode_header(header, bytes, order_);
  return bytes;
}

void TcpClientProtocol::put(Header header, std::span<const std::byte> body) {
  const auto head = encode(header, body.size());
  output_.insert(output_.end(), head.begin(), head.end());
  output_.insert(output_.end(), body.begin(), body.end());
}

void TcpClientProtocol::put_command(std::int8_t type) {
  put({.flags = body_order(), .type = type});
}

void TcpClientProtocol::put_command(std::int8_t type, Address mailbox) {
  std::array<std::byte, sizeof(std::uint32_t)> body{};
  HeaderWord::store(body.data(), mailbox.raw(), order_);
  put({.flags = body_order(), .type = type}, body);
}

void TcpClientProtocol::sent(std::size_t bytes) {
  sent_ += bytes;
  if (sent_ < output_.size()) return;
  output_.clear();
  sent_ = 0;
}

StreamReader::Item TcpClientProtocol::next(std::span<std::byte>& chunk) {
  for (;;) {
    StreamReader::Item item = reader_.next(chunk);
    if (item.status != StreamReader::Status::kMessage || !is_router_message(item.header))
      return item;
    if (item.header.type == router_command::kLifesign) {
      answer(item.header);
    } else if (item.header.type == router_command::kAddressWidths) {
      const auto widths = router_command::decode_widths(item.message.subspan(kHeaderSize));
      widths_ = widths.value_or(widths_);
    } else {
      return item;
    }
  }
}

// A router that sends lifesigns but does not read the answers gets no more of them.
void TcpClientProtocol::answer(const Header& lifesign) {
  ++lifesigns_;
  if (!answers_lifesigns_ || unsent().size() > kAnswersBytesMax) return;
  Header reply = reply_to(lifesign, type::kOk);
  reply.flags = body_order();
  put(reply);
}

}  // namespace tims::wire
