#include "router/link/sample_receiver.h"

#include <algorithm>
#include <cstring>

#include "wire/header.h"

namespace tims::link {
namespace {

// Numbers run on past their end.
bool is_older(std::uint32_t number, std::uint32_t than) {
  return static_cast<std::int32_t>(number - than) < 0;
}

}  // namespace

bool SampleReceiver::on_frame(Time now, const SampleFrame& frame, Arrivals& arrivals) {
  if (frame.total < kHeaderSize || frame.total > assembly_.message_max || frame.number == 0)
    return false;
  if (frame.bytes.size() == frame.total)
    return hand_on(now, frame.hops, frame.number, frame.bytes, arrivals);
  Part* part = part_for(now, frame);
  if (part == nullptr) return true;  // no memory, and samples may be lost
  if (part->total != frame.total) return false;
  const std::size_t end = frame.offset + frame.bytes.size();
  // Memory reaches as far as what came, so it must not come from far ahead.
  if (end > kAheadMin + kAheadTimes * part->received) return true;
  if (!assembly_.grow(now, part->bytes, end, false)) return true;
  part->received += frame.bytes.size();
  std::memcpy(part->bytes.bytes().data() + frame.offset, frame.bytes.data(), frame.bytes.size());
  part->have.add({frame.offset, end});
  if (!part->have.contains({0, part->total})) return true;
  const std::span message = part->bytes.bytes().first(part->total);
  assembly_.hand_on(part->bytes);
  give_up(*part);
  return hand_on(now, frame.hops, frame.number, message, arrivals);
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
  (void)assembly_.grow(now, place->bytes, kHeaderSize, false);
  place->number = frame.number;
  place->total = frame.total;
  place->since = now;
  return place->bytes ? place : nullptr;
}

bool SampleReceiver::hand_on(Time now, std::uint8_t hops, std::uint32_t number,
                             std::span<std::byte> message, Arrivals& arrivals) {
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
  arrivals.on_message(now, {.hops = hops}, whole);
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
  assembly_.give(part.bytes);
  part.received = 0;
  part.have.clear();
}

void SampleReceiver::clear() {
  for (Part& part : parts_) give_up(part);
  streams_.fill({});
}

}  // namespace tims::link
