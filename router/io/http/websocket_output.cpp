#include "router/io/http/websocket_output.h"

#include <algorithm>

#include "wire/header.h"

namespace tims::io {

core::Outcome WebSocketOutput::add(std::span<const std::byte> message, std::uint8_t priority) {
  const bool taken = queue_.push(message, priority, replaced_);
  has_replaced_ = true;
  return taken ? core::Outcome::kDelivered : core::Outcome::kQueueFull;
}

std::optional<WebSocketOutput::Frame> WebSocketOutput::begin_frame() {
  if (queue_.empty()) return std::nullopt;
  std::size_t count = rest_ == 0 ? begin_message() : 0;
  count = add_rest(count);
  in_frame_ = true;
  return Frame{std::span(pieces_).first(count), rest_ == 0};
}

// Takes the header out of the queue: from then on the rest of the message is safe in it.
std::size_t WebSocketOutput::begin_message() {
  // In two blocks at most.
  const std::size_t available = queue_.gather(std::span(pieces_).first<2>());
  std::size_t filled = 0;
  for (std::size_t i = 0; i < available && filled < kHeaderSize; ++i) {
    const auto part = pieces_[i].first(std::min(pieces_[i].size(), kHeaderSize - filled));
    std::ranges::copy(part, header_.begin() + static_cast<std::ptrdiff_t>(filled));
    filled += part.size();
  }
  queue_.consume(kHeaderSize);
  rest_ = wire::decode_header(header_).length - kHeaderSize;
  pieces_[0] = header_;
  return 1;
}

// As much of the message as there are pieces for. What lies behind it belongs to other messages.
std::size_t WebSocketOutput::add_rest(std::size_t count) {
  const std::size_t blocks_max = rest_ / core::ByteChain::kBlockBytes + 2;
  const std::size_t room = rest_ == 0 ? 0 : std::min(kFramePiecesMax - count, blocks_max);
  const std::size_t available = count + queue_.gather(std::span(pieces_).subspan(count, room));
  frame_body_ = 0;
  for (; count < available && rest_ > 0; ++count) {
    auto& piece = pieces_[count];
    piece = piece.first(std::min<std::uint64_t>(piece.size(), rest_));
    frame_body_ += piece.size();
    rest_ -= piece.size();
  }
  return count;
}

void WebSocketOutput::end_frame() {
  queue_.consume(frame_body_);
  frame_body_ = 0;
  in_frame_ = false;
}

void WebSocketOutput::clear(core::LossCounts& lost) {
  queue_.clear(lost);
  rest_ = 0;
  frame_body_ = 0;
  in_frame_ = false;
}

void WebSocketOutput::forget_replaced() {
  replaced_ = core::LossCounts{};
  has_replaced_ = false;
}

}  // namespace tims::io
