#include "router/link/samples.h"

#include <algorithm>
#include <cstring>

#include "wire/header.h"

namespace tims::link {
namespace {

bool same_stream(const Header& a, const Header& b) {
  return a.src == b.src && a.dest == b.dest && a.type == b.type;
}

// Sample numbers wrap around.
bool is_older(std::uint32_t number, std::uint32_t than) {
  return static_cast<std::int32_t>(number - than) < 0;
}

}  // namespace

// --- sending

// The sample takes the position of the one it replaces, so that a fast stream does not delay the
// others.
void SampleSender::push(Time now, std::uint8_t hops, const Header& header,
                        std::span<const std::byte> message) {
  const auto droppable = waiting_.begin() + static_cast<std::ptrdiff_t>(first_droppable());
  auto place = waiting_.end();
  for (auto old = droppable; old != waiting_.end(); ++old) {
    if (!same_stream(old->header, header)) continue;
    // If the old one stays, append.
    if (!old->replaceable) place = waiting_.end();
    if (old->replaceable && place == waiting_.end()) place = old;
  }
  const auto at = place - waiting_.begin();
  const bool last = place == waiting_.end();
  const auto gone = std::remove_if(droppable, waiting_.end(), [&](const Sample& old) {
    const bool replaced = old.replaceable && same_stream(old.header, header);
    if (replaced) lose(now, old, core::Outcome::kQueueReplaced);
    return replaced;
  });
  waiting_.erase(gone, waiting_.end());
  waiting_.insert(last ? waiting_.end() : waiting_.begin() + at,
                  {.header = header, .at = bytes_.end(), .since = now, .hops = hops});
  bytes_.append(message);
  held_ += header.length;
}

void SampleSender::free(const Sample& sample) {
  held_ -= sample.header.length;
  bytes_.free(sample.range());
  ranges_.forget(sample.range());
}

void SampleSender::lose(Time now, const Sample& sample, core::Outcome why) {
  losses_.on_lost(now, sample.header, why);
  free(sample);
}

bool SampleSender::drop_one(Time now) {
  if (!kept_.empty()) {
    free(kept_.front());
    kept_.erase(kept_.begin());
    return true;
  }
  if (waiting_.size() == first_droppable()) return false;
  const auto oldest = waiting_.begin() + static_cast<std::ptrdiff_t>(first_droppable());
  lose(now, *oldest, core::Outcome::kQueueReplaced);
  waiting_.erase(oldest);
  return true;
}

// The sample that this sent byte belongs to; null when it is no longer kept.
const SampleSender::Sample* SampleSender::sent_at(std::uint64_t offset) const {
  const auto has = [offset](const Sample& sample, std::uint64_t sent) {
    return offset >= sample.at && offset - sample.at < sent;
  };
  for (const Sample& sample : kept_)
    if (has(sample, sample.header.length)) return &sample;
  return sent_ > 0 && has(waiting_.front(), sent_) ? &waiting_.front() : nullptr;
}

SampleSender::Piece SampleSender::piece_of(const Sample& sample, Range range) {
  return {.frame = {.hops = sample.hops,
                    .number = sample.number,
                    .total = sample.header.length,
                    .offset = static_cast<std::uint32_t>(range.begin - sample.at),
                    .bytes = {}},
          .size = static_cast<std::size_t>(range.size()),
          .at = range.begin};
}

std::optional<SampleSender::Piece> SampleSender::next_lost(std::size_t size) {
  while (ranges_.repeats()) {
    Range range = ranges_.first_lost();
    const Sample* sample = sent_at(range.begin);
    // A full range set has merged separate ranges.
    if (sample == nullptr) {
      ranges_.forget(range);
      continue;
    }
    range.end = std::min({range.end, range.begin + size, sample->range().end});
    Piece piece = piece_of(*sample, range);
    piece.again = true;
    return piece;
  }
  return std::nullopt;
}

std::optional<SampleSender::Piece> SampleSender::next(std::size_t size,
                                                      std::uint32_t& last_number) {
  if (auto lost = next_lost(size)) return lost;
  if (waiting_.empty()) return std::nullopt;
  Sample& sample = waiting_.front();
  // The number 0 is reserved for "none".
  if (sample.number == 0) sample.number = ++last_number != 0 ? last_number : ++last_number;
  const std::uint64_t begin = sample.at + sent_;
  return piece_of(sample, {begin, std::min(begin + size, sample.range().end)});
}

void SampleSender::sent(Time now, const Piece& piece) {
  if (piece.again) {
    ranges_.on_sent_again(piece.range());
    return;
  }
  Sample& sample = waiting_.front();
  sent_ += static_cast<std::uint32_t>(piece.size);
  if (sent_ < sample.header.length) return;
  sent_ = 0;
  if (piece.is_sent_once()) {
    free(sample);
  } else {
    if (kept_.size() == kKeptMax) (void)drop_one(now);
    sample.since = now;
    kept_.push_back(sample);
  }
  waiting_.pop_front();
}

void SampleSender::on_acked(Range range) {
  const Sample* found = sent_at(range.begin);
  if (found == nullptr || !ranges_.on_acked(range)) return;
  if (!ranges_.acked().contains(found->range())) return;
  // Older samples of the stream would be discarded by the receiver.
  std::erase_if(kept_, [&, newest = *found](const Sample& sample) {
    const bool done =
        same_stream(sample.header, newest.header) && !is_older(newest.number, sample.number);
    if (done) free(sample);
    return done;
  });
}

void SampleSender::on_lost(Range range) {
  if (sent_at(range.begin) != nullptr) ranges_.on_lost(range);
}

void SampleSender::congested() {
  for (Sample& sample : waiting_) sample.replaceable = true;
}

void SampleSender::expire(Time now, Duration lifetime) {
  while (!kept_.empty() && kept_.front().since + kSamplePatience <= now) (void)drop_one(now);
  const bool ends = sent_ > 0 && waiting_.front().since + lifetime <= now;
  std::erase_if(waiting_, [&](const Sample& sample) {
    const bool old = sample.since + lifetime <= now;
    if (old) lose(now, sample, core::Outcome::kExpired);
    return old;
  });
  if (ends) sent_ = 0;
}

void SampleSender::clear(Time now, core::Outcome why) {
  for (const Sample& sample : waiting_) losses_.on_lost(now, sample.header, why);
  waiting_.clear();
  kept_.clear();
  bytes_.reset(0);
  ranges_.clear();
  sent_ = 0;
  held_ = 0;
}

// --- receiving

bool SampleReceiver::on_frame(Time now, const SampleFrame& frame) {
  if (frame.total < kHeaderSize || frame.total > reassembly_.message_max || frame.number == 0)
    return false;
  if (frame.bytes.size() == frame.total)
    return !finish(frame.number) || hand_on(now, frame.hops, frame.number, frame.bytes);
  Part* part = part_for(now, frame);
  if (part == nullptr) return true;  // no memory; samples may be lost
  if (part->total != frame.total) return false;
  const std::size_t end = frame.offset + frame.bytes.size();
  // Memory is used up to the highest offset received, so parts far ahead are refused.
  if (end > kAheadMin + kAheadTimes * part->received) return true;
  if (part->have.contains({frame.offset, end})) return true;  // a duplicate
  if (!reassembly_.grow(now, part->bytes, end, false)) return true;
  part->received += frame.bytes.size();
  if (part->received >= part->progress_at + LaneReceiver::kProgress) {
    part->progress = now;
    part->progress_at = part->received;
  }
  std::memcpy(part->bytes.bytes().data() + frame.offset, frame.bytes.data(), frame.bytes.size());
  part->have.add({frame.offset, end});
  if (!part->have.contains({0, part->total})) return true;
  const std::span message = part->bytes.bytes().first(part->total);
  reassembly_.hand_on(part->bytes);
  drop(*part);
  return hand_on(now, frame.hops, frame.number, message);
}

// The sample this part belongs to; otherwise a free slot, or the slot of the oldest. Null when
// there is no memory, or the sample was already delivered or given up.
SampleReceiver::Part* SampleReceiver::part_for(Time now, const SampleFrame& frame) {
  Part* place = &parts_[0];
  for (Part& part : parts_) {
    if (part.bytes && part.number == frame.number) return &part;
    const bool better = !part.bytes || is_older(part.number, place->number);
    if (place->bytes && better) place = &part;
  }
  if (!finished_.is_new(finished_.expand(frame.number))) return nullptr;
  if (place->bytes) {
    if (is_older(frame.number, place->number)) return nullptr;
    ++incomplete_;
    drop(*place);
  }
  (void)reassembly_.grow(now, place->bytes, kHeaderSize, false);
  place->number = frame.number;
  place->total = frame.total;
  place->progress = now;
  place->progress_at = 0;
  return place->bytes ? place : nullptr;
}

// Returns false when it was finished before.
bool SampleReceiver::finish(std::uint32_t number) {
  const std::uint64_t whole = finished_.expand(number);
  if (!finished_.is_new(whole)) return false;
  finished_.add(whole);
  return true;
}

void SampleReceiver::drop(Part& part) {
  reassembly_.give(part.bytes);
  part.received = 0;
  part.have.clear();
  (void)finish(part.number);
}

// Incomplete older samples of the same stream are no longer needed, nor is an incomplete copy of
// the same sample when all of it arrived in a larger datagram.
void SampleReceiver::drop_overtaken(const Header& header, std::uint32_t number) {
  if (!reassembly_.is_used()) return;
  for (Part& part : parts_) {
    if (!part.bytes) continue;
    const auto is_of_stream = [&] {
      return part.have.contains({0, kHeaderSize}) &&
             same_stream(wire::decode_header(part.bytes.bytes().first<kHeaderSize>()), header);
    };
    const bool overtaken = is_older(part.number, number) && is_of_stream();
    if (overtaken) ++overtaken_;
    if (overtaken || part.number == number) drop(part);
  }
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
  drop_overtaken(header, number);
  core::Message whole{header, message};
  arrivals_.on_message(now, RecordPrefix::decode_sample(hops), whole);
  return true;
}

void SampleReceiver::expire(Time now) {
  for (Part& part : parts_) {
    if (!part.bytes || now < part.progress + kSamplePatience) continue;
    ++incomplete_;
    drop(part);
  }
}

void SampleReceiver::clear() {
  for (Part& part : parts_)
    if (part.bytes) drop(part);
  finished_ = {};
  streams_.fill({});
}

}  // namespace tims::link
