#include "router/link/samples.h"

#include <algorithm>
#include <cstring>

#include "wire/header.h"

namespace tims::link {
namespace {

bool same_stream(const Header& a, const Header& b) {
  return a.src == b.src && a.dest == b.dest && a.type == b.type;
}

// Numbers run on past their end.
bool is_older(std::uint32_t number, std::uint32_t than) {
  return static_cast<std::int32_t>(number - than) < 0;
}

}  // namespace

void SampleSender::push(Time now, std::uint8_t hops, const Header& header,
                        std::span<const std::byte> message) {
  for (std::size_t i = sent_ > 0 ? 1 : 0; i < samples_.size(); ++i) {
    Sample& old = samples_[i];
    if (!old.replaceable || old.replaced || !same_stream(old.header, header)) continue;
    old.replaced = true;
    losses_.on_lost(now, old.header, core::Outcome::kQueueReplaced);
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

void SampleSender::expire(Time now, Duration lifetime) {
  while (!samples_.empty() && samples_.front().since + lifetime <= now) {
    if (!samples_.front().replaced)
      losses_.on_lost(now, samples_.front().header, core::Outcome::kExpired);
    pop();
  }
}

void SampleSender::clear(Time now, core::Outcome why) {
  for (const Sample& sample : samples_)
    if (!sample.replaced) losses_.on_lost(now, sample.header, why);
  samples_.clear();
  bytes_.reset(0);
  sent_ = 0;
}

bool SampleReceiver::on_frame(Time now, const SampleFrame& frame) {
  if (frame.total < kHeaderSize || frame.total > reassembly_.message_max || frame.number == 0)
    return false;
  if (frame.bytes.size() == frame.total) return hand_on(now, frame.hops, frame.number, frame.bytes);
  Part* part = part_for(now, frame);
  if (part == nullptr) return true;  // no memory, and samples may be lost
  if (part->total != frame.total) return false;
  const std::size_t end = frame.offset + frame.bytes.size();
  // Memory reaches as far as what came, so it must not come from far ahead.
  if (end > kAheadMin + kAheadTimes * part->received) return true;
  if (!reassembly_.grow(now, part->bytes, end, false)) return true;
  part->received += frame.bytes.size();
  std::memcpy(part->bytes.bytes().data() + frame.offset, frame.bytes.data(), frame.bytes.size());
  part->have.add({frame.offset, end});
  if (!part->have.contains({0, part->total})) return true;
  const std::span message = part->bytes.bytes().first(part->total);
  reassembly_.hand_on(part->bytes);
  give_up(*part);
  return hand_on(now, frame.hops, frame.number, message);
}

// The sample this is a part of; else a free place, or that of the oldest.
SampleReceiver::Part* SampleReceiver::part_for(Time now, const SampleFrame& frame) {
  Part* place = &parts_[0];
  for (Part& part : parts_) {
    if (part.bytes && part.number == frame.number) return &part;
    const bool better = !part.bytes || is_older(part.number, place->number);
    if (place->bytes && better) place = &part;
  }
  if (place->bytes) {
    if (is_older(frame.number, place->number)) return nullptr;
    ++incomplete_;
  }
  give_up(*place);
  (void)reassembly_.grow(now, place->bytes, kHeaderSize, false);
  place->number = frame.number;
  place->total = frame.total;
  place->since = now;
  return place->bytes ? place : nullptr;
}

bool SampleReceiver::hand_on(Time now, std::uint8_t hops, std::uint32_t number,
                             std::span<std::byte> message) {
  const Header header = wire::decode_header(message.first<kHeaderSize>());
  if (header.length != message.size()) return false;
  const std::size_t hash = (header.src.raw() * 0x9E3779B1U ^ header.dest.raw() * 0x85EBCA6BU ^
                            static_cast<std::uint8_t>(header.type)) >>
                           16;
  Stream& stream = streams_[hash % kStreams];
  const bool same = stream.src == header.src && stream.dest == header.dest &&
                    stream.type == header.type && stream.newest != 0;
  if (same && is_older(number, stream.newest)) {
    ++overtaken_;
    return true;
  }
  stream = {header.src, header.dest, header.type, number};
  core::Message whole{header, message};
  arrivals_.on_message(now, {.hops = hops}, whole);
  return true;
}

void SampleReceiver::expire(Time now) {
  for (Part& part : parts_) {
    if (!part.bytes || now < part.since + kPatience) continue;
    ++incomplete_;
    give_up(part);
  }
}

void SampleReceiver::give_up(Part& part) {
  reassembly_.give(part.bytes);
  part.received = 0;
  part.have.clear();
}

void SampleReceiver::clear() {
  for (Part& part : parts_) give_up(part);
  streams_.fill({});
}

}  // namespace tims::link
