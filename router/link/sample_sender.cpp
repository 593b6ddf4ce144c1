#include "router/link/sample_sender.h"

#include <algorithm>

namespace tims::link {
namespace {

bool same_stream(const Header& a, const Header& b) {
  return a.src == b.src && a.dest == b.dest && a.type == b.type;
}

}  // namespace

void SampleSender::push(Time now, std::uint8_t hops, const Header& header,
                        std::span<const std::byte> message, Losses& losses) {
  for (std::size_t i = sent_ > 0 ? 1 : 0; i < samples_.size(); ++i) {
    Sample& old = samples_[i];
    if (!old.replaceable || old.replaced || !same_stream(old.header, header)) continue;
    old.replaced = true;
    losses.on_lost(now, old.header, core::Outcome::kQueueReplaced);
  }
  if (sent_ == 0) skip_replaced();
  samples_.push_back({.header = header, .at = bytes_.end(), .since = now, .hops = hops});
  bytes_.append(message);
}

Header SampleSender::drop_oldest() {
  const Header header = samples_.front().header;
  pop();
  skip_replaced();
  return header;
}

void SampleSender::pop() {
  const Sample& front = samples_.front();
  bytes_.release_to(front.at + front.header.length);
  samples_.pop_front();
  sent_ = 0;
}

void SampleSender::skip_replaced() {
  while (!samples_.empty() && samples_.front().replaced) pop();
}

SampleSender::Piece SampleSender::next(std::size_t size, std::uint32_t& last_number) {
  const Sample& front = samples_.front();
  if (sent_ == 0) number_ = ++last_number != 0 ? last_number : ++last_number;  // 0 is none
  Piece piece{.frame = {.hops = front.hops,
                        .number = number_,
                        .total = front.header.length,
                        .offset = sent_,
                        .bytes = {}},
              .size = std::min<std::size_t>(size, front.header.length - sent_),
              .at = front.at + sent_};
  return piece;
}

void SampleSender::sent(const Piece& piece) {
  sent_ += static_cast<std::uint32_t>(piece.size);
  if (sent_ < samples_.front().header.length) return;
  pop();
  skip_replaced();
}

void SampleSender::congested() {
  for (Sample& sample : samples_) sample.replaceable = true;
}

void SampleSender::expire(Time now, Duration lifetime, Losses& losses) {
  while (!samples_.empty() && samples_.front().since + lifetime <= now) {
    if (!samples_.front().replaced)
      losses.on_lost(now, samples_.front().header, core::Outcome::kExpired);
    pop();
  }
}

void SampleSender::clear(Time now, core::Outcome why, Losses& losses) {
  for (const Sample& sample : samples_)
    if (!sample.replaced) losses.on_lost(now, sample.header, why);
  samples_.clear();
  bytes_.reset(0);
  sent_ = 0;
}

}  // namespace tims::link
