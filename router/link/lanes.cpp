#include "router/link/lanes.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "wire/header.h"

namespace tims::link {
namespace {

constexpr std::size_t kBlock = core::BlockPool::kBlockSize;
// One block more than the window, which may start inside a block; rounded up to a power of two.
constexpr std::size_t kRing = 2 * kLaneWindow / kBlock;
// Offsets that a router has left to the next one are below: none ever gets there.
constexpr std::uint64_t kRestoredMax = std::uint64_t{1} << 62;

}  // namespace

void LaneSender::push(Time now, const RecordPrefix& prefix, std::span<const std::byte> message,
                      std::uint64_t committed_max) {
  const bool at_once = waiting_.empty() && stream_.end() - next_ < committed_max;
  StreamBuffer& to = at_once ? stream_ : waiting_;
  (at_once ? stream_since_ : waiting_since_).add(to.end(), now);
  if (at_once && lifetimes_ != nullptr)
    add_deadline(wire::decode_header(message.first<kHeaderSize>()), now);
  to.append(prefix.encoded());
  to.append(message);
}

// Precondition: the message is appended to the stream next.
void LaneSender::add_deadline(const Header& header, Time since) {
  const Duration lifetime = lifetimes_->of(header);
  if (lifetime != policy::Lifetimes::kForever) deadlines_.add(stream_.end(), since + lifetime);
}

// A stream has no gaps: a message that is too old is sent, but not to be delivered.
void LaneSender::mark_late(Time now, Range range) {
  deadlines_.take_passed(now, range, [&](std::uint64_t offset) {
    std::array<std::byte, kRecordPrefix> bytes;
    stream_.read(offset, bytes);
    RecordPrefix prefix = RecordPrefix::decode(bytes);
    prefix.late = true;
    stream_.write(offset, prefix.encoded());
    losses_.on_lost(now, header_at(stream_, offset), core::Outcome::kExpired);
  });
}

Header LaneSender::header_at(const StreamBuffer& buffer, std::uint64_t offset) {
  std::array<std::byte, kHeaderSize> bytes;
  buffer.read(offset + kRecordPrefix, bytes);
  return wire::decode_header(bytes);
}

Header LaneSender::drop_oldest() {
  const Header header = header_at(waiting_, waiting_.begin());
  waiting_.release_to(waiting_.begin() + record_size(header.length));
  waiting_since_.forget_below(waiting_.begin());
  return header;
}

void LaneSender::commit(Time now, std::uint64_t committed_max) {
  while (!waiting_.empty() && stream_.end() - next_ < committed_max) {
    const Header header = header_at(waiting_, waiting_.begin());
    if (!can_commit()) return;
    const Time since = waiting_since_.oldest(waiting_.begin());
    if (is_late(now, header, since)) {
      (void)drop_oldest();
      losses_.on_lost(now, header, core::Outcome::kExpired);
      continue;
    }
    if (lifetimes_ != nullptr) add_deadline(header, since);
    if ((header.flags & flag::kTrace) != 0) {
      std::array<std::byte, kRecordPrefix> bytes;
      waiting_.read(waiting_.begin(), bytes);
      RecordPrefix prefix = RecordPrefix::decode(bytes);
      prefix.waited = now - since;
      waiting_.write(waiting_.begin(), prefix.encoded());
    }
    stream_since_.add(stream_.end(), since);
    waiting_.move_front(record_size(header.length), stream_);
  }
}

// A part of the first message may have arrived.
std::uint64_t LaneSender::window_end() const {
  const std::uint64_t begin = stream_.begin();
  const RangeSet& acked = sent_.acked();
  const bool arrived = !acked.empty() && acked.front().begin <= begin;
  return (arrived ? acked.front().end : begin) + window_;
}

bool LaneSender::wants_to_send() const {
  if (repeats()) return true;
  if (next_ >= window_end()) return false;
  return next_ < stream_.end() || (!waiting_.empty() && can_commit());
}

std::optional<Range> LaneSender::take(Time now, std::size_t size, std::uint64_t committed_max) {
  if (repeats()) {
    Range range = sent_.first_lost();
    range.end = std::min(range.end, range.begin + size);
    sent_.on_sent_again(range);
    mark_late(now, range);
    return range;
  }
  if (stream_.end() - next_ < committed_max) commit(now, committed_max);
  const std::uint64_t end = std::min({stream_.end(), next_ + size, window_end()});
  if (end <= next_) return std::nullopt;
  const Range range{next_, end};
  next_ = end;
  mark_late(now, range);
  return range;
}

void LaneSender::on_acked(Range range) {
  range.begin = std::max(range.begin, stream_.begin());
  if (range.begin >= range.end) return;
  if (!sent_.on_acked(range)) return;
  // Acknowledged bytes at the front are released message by message.
  std::uint64_t begin = stream_.begin();
  const Range first = sent_.acked().front();
  const std::uint64_t acked_to = first.begin <= begin ? first.end : begin;
  while (begin < acked_to) {
    if (begin + kRecordHead > acked_to) break;
    const std::uint64_t end = begin + record_size(header_at(stream_, begin).length);
    if (end > acked_to) break;
    begin = end;
  }
  if (begin == stream_.begin()) return;
  stream_.release_to(begin);
  stream_since_.forget_below(begin);
  deadlines_.forget_below(begin);
  sent_.forget_below(begin);
}

void LaneSender::on_lost(Range range) {
  range.begin = std::max(range.begin, stream_.begin());
  range.end = std::min(range.end, next_);
  sent_.on_lost(range);
}

// Reports all messages that begin below `to` as lost and releases them; returns the beginning of
// the first message after them.
std::uint64_t LaneSender::lose(Time now, StreamBuffer& buffer, std::uint64_t to,
                               core::Outcome why) {
  std::uint64_t offset = buffer.begin();
  while (offset < to) {
    const Header header = header_at(buffer, offset);
    std::array<std::byte, kRecordPrefix> prefix;
    buffer.read(offset, prefix);
    offset += record_size(header.length);
    if (!RecordPrefix::decode(prefix).late) losses_.on_lost(now, header, why);  // else it was
  }
  buffer.release_to(offset);
  return offset;
}

// What is in flight is perhaps not sent again for a long time: its sender learns now that it is
// late.
void LaneSender::expire(Time now, Duration lifetime) {
  mark_late(now, {stream_.begin(), stream_.end()});
  const Time limit = now - lifetime;
  if (!stream_.empty() && stream_since_.oldest(stream_.begin()) <= limit) {
    const std::uint64_t old = stream_.begin();
    const std::uint64_t to =
        lose(now, stream_, stream_since_.older_than(limit, stream_.end()), core::Outcome::kExpired);
    if (to > old) {
      skip_to_ = to;
      skip_due_ = true;
      next_ = std::max(next_, to);
      sent_.forget_below(to);
      stream_since_.forget_below(to);
      deadlines_.forget_below(to);
    }
  }
  if (!waiting_.empty() && waiting_since_.oldest(waiting_.begin()) <= limit) {
    lose(now, waiting_, waiting_since_.older_than(limit, waiting_.end()), core::Outcome::kExpired);
    waiting_since_.forget_below(waiting_.begin());
  }
}

void LaneSender::clear(Time now, core::Outcome why) {
  lose(now, stream_, stream_.end(), why);
  lose(now, waiting_, waiting_.end(), why);
  stream_.reset(0);
  waiting_.reset(0);
  stream_since_.clear();
  waiting_since_.clear();
  deadlines_.clear();
  sent_.clear();
  next_ = skip_to_ = skip_acked_ = 0;
  skip_due_ = false;
}

// --- for the next router

namespace {

// What follows in the state of a lane that sends.
enum class Saved : std::uint8_t { kEnd, kCommitted, kWaiting };

void save_messages(StateWriter& to, Saved kind, const StreamBuffer& buffer, const AgeMarks& ages) {
  for (std::uint64_t offset = buffer.begin(); offset < buffer.end();) {
    std::array<std::byte, kRecordHead> head{};
    buffer.read(offset, head);
    const Header header = wire::decode_header(std::span(head).last<kHeaderSize>());
    to.put(kind, ages.at(offset));
    const std::span<std::byte> record = to.reserve(record_size(header.length));
    buffer.read(offset, record);
    offset += record.size();
  }
}

}  // namespace

void LaneSender::save(StateWriter& to) const {
  to.put(stream_.begin(), skip_to_, skip_acked_);
  save_messages(to, Saved::kCommitted, stream_, stream_since_);
  save_messages(to, Saved::kWaiting, waiting_, waiting_since_);
  to.put(Saved::kEnd);
}

bool LaneSender::restore(StateReader& from) {
  std::uint64_t begin = 0;
  from.get(begin, skip_to_, skip_acked_);
  if (!from.ok() || begin > kRestoredMax || skip_to_ > begin || skip_acked_ > skip_to_)
    return false;
  stream_.reset(begin);
  next_ = begin;
  skip_due_ = skip_to_ > skip_acked_;
  for (Saved kind{}; get_enum(from, Saved::kWaiting, kind) && from.ok();) {
    if (kind == Saved::kEnd) return true;
    const Time since = from.time();
    const auto record = from.bytes();
    const bool committed = kind == Saved::kCommitted;
    if (committed && !waiting_.empty()) return false;
    if (!(committed ? restore_message(stream_, stream_since_, since, record)
                    : restore_message(waiting_, waiting_since_, since, record)))
      return false;
  }
  return false;
}

bool LaneSender::restore_message(StreamBuffer& to, AgeMarks& ages, Time since,
                                 std::span<const std::byte> record) {
  if (record.size() < kRecordHead) return false;
  const Header header = wire::decode_header(record.subspan<kRecordPrefix, kHeaderSize>());
  if (header.length < kHeaderSize || record_size(header.length) != record.size() ||
      !to.has_room(record.size() + 2 * kBlock))
    return false;
  const bool late = RecordPrefix::decode(record.first<kRecordPrefix>()).late;
  if (&to == &stream_ && lifetimes_ != nullptr && !late) add_deadline(header, since);
  ages.add(to.end(), since);
  to.append(record);
  return true;
}

// The beginning of a message, and what arrived out of order.
void LaneReceiver::save(StateWriter& to) const {
  const std::size_t head = body_ ? kRecordPrefix : head_size_;
  const std::size_t size = body_ ? body_size_ : 0;
  to.put(next_ - head - size, static_cast<std::uint64_t>(discarded_), begun_);
  const std::span<std::byte> begun = to.reserve(head + size);
  std::ranges::copy(std::span(head_).first(head), begun.begin());
  if (size > 0) std::ranges::copy(body_.bytes().first(size), begun.begin() + kRecordPrefix);
  to.put(static_cast<std::uint16_t>(early_.ranges().size()));
  for (const Range& range : early_.ranges()) {
    to.put(range.begin, early_since_.at(range.begin));
    std::span<std::byte> bytes = to.reserve(static_cast<std::size_t>(range.size()));
    for (std::uint64_t at = range.begin; at < range.end;) {
      const auto part =
          static_cast<std::size_t>(std::min<std::uint64_t>(kBlock - at % kBlock, range.end - at));
      std::memcpy(bytes.data(),
                  reassembly_.pool.at(early_blocks_[at / kBlock % kRing]) + at % kBlock, part);
      bytes = bytes.subspan(part);
      at += part;
    }
  }
}

// Nothing is handed on here: what is early stays so until the next bytes arrive.
bool LaneReceiver::restore(Time now, StateReader& from) {
  std::uint64_t discarded = 0;
  from.get(next_, discarded);
  const Time begun = from.time();
  const auto bytes = from.bytes();
  if (!from.ok() || next_ > kRestoredMax || discarded > reassembly_.message_max ||
      (discarded > 0 && !bytes.empty()))
    return false;
  constexpr std::size_t kPart = 64 << 10;
  for (std::size_t at = 0; at < bytes.size(); at += kPart) {
    const auto part = bytes.subspan(at, std::min(kPart, bytes.size() - at));
    std::vector<std::byte> copy(part.begin(), part.end());
    if (on_bytes(now, next_, copy) != Verdict::kTaken) return false;
  }
  begun_ = begun;
  discarded_ = static_cast<std::size_t>(discarded);
  for (auto ranges = from.get<std::uint16_t>(); ranges > 0; --ranges) {
    const auto offset = from.get<std::uint64_t>();
    const Time since = from.time();
    const auto early = from.bytes();
    const std::uint64_t window = control_ ? kControlWindow : kLaneWindow;
    if (!from.ok() || early.empty() || offset < next_ || offset > kRestoredMax ||
        offset + early.size() > next_ + window || !keep_early(since, offset, early))
      return false;
  }
  return from.ok();
}

// --- receiving

LaneReceiver::Verdict LaneReceiver::on_bytes(Time now, std::uint64_t offset,
                                             std::span<std::byte> bytes) {
  if (is_stuck()) {
    const Verdict verdict = drain_early(now);
    if (verdict != Verdict::kTaken) return verdict;
  }
  if (offset + bytes.size() <= next_) return Verdict::kTaken;
  const std::uint64_t window = control_ ? kControlWindow : kLaneWindow;
  if (offset + bytes.size() > next_ + window) return Verdict::kRefused;
  if (offset > next_) return keep_early(now, offset, bytes) ? Verdict::kTaken : Verdict::kRefused;
  bytes = bytes.subspan(static_cast<std::size_t>(next_ - offset));
  arrived_ = now;
  const std::size_t taken = consume(now, bytes, true);
  next_ += taken;
  if (broken_) return Verdict::kBroken;
  if (taken < bytes.size()) return Verdict::kRefused;
  return early_.empty() ? Verdict::kTaken : drain_early(now);
}

LaneReceiver::Verdict LaneReceiver::on_skip(Time now, std::uint64_t to) {
  if (to <= next_) return Verdict::kTaken;
  next_ = to;
  head_size_ = discarded_ = 0;
  reassembly_.give(body_);
  return drain_early(now);
}

// --- out-of-order bytes

core::BlockPool::Index& LaneReceiver::block_of(std::uint64_t offset) {
  if (early_blocks_.empty()) early_blocks_.assign(kRing, core::BlockPool::kNone);
  return early_blocks_[offset / kBlock % kRing];
}

bool LaneReceiver::keep_early(Time now, std::uint64_t offset, std::span<const std::byte> bytes) {
  const Range all{offset, offset + bytes.size()};
  bool room = true;
  for (std::uint64_t at = offset / kBlock * kBlock; at < all.end; at += kBlock) {
    core::BlockPool::Index& block = block_of(at);
    if (block == core::BlockPool::kNone) block = reassembly_.take_block();
    if (block == core::BlockPool::kNone) room = false;
  }
  const bool is_newest = early_.empty() || offset >= early_.ranges().back().end;
  if (!room || !early_.add(all)) {
    // Releases blocks that were not used.
    if (early_.empty()) drop_early();
    return false;
  }
  if (is_newest) early_since_.add(offset, now);
  while (!bytes.empty()) {
    const std::size_t inside = offset % kBlock;
    const std::size_t size = std::min(kBlock - inside, bytes.size());
    std::memcpy(reassembly_.pool.at(block_of(offset)) + inside, bytes.data(), size);
    offset += size;
    bytes = bytes.subspan(size);
  }
  return true;
}

LaneReceiver::Verdict LaneReceiver::drain_early(Time now) {
  Verdict verdict = Verdict::kTaken;
  const std::uint64_t first = early_.empty() ? next_ : std::min(next_, early_.front().begin);
  while (!early_.empty() && early_.front().begin <= next_ && verdict == Verdict::kTaken) {
    const std::uint64_t end = early_.front().end;
    while (next_ < end) {
      arrived_ = early_since_.oldest(next_);
      const std::size_t inside = next_ % kBlock;
      const auto size = static_cast<std::size_t>(std::min(
          {std::uint64_t{kBlock - inside}, end - next_, early_since_.oldest_end() - next_}));
      std::byte* block = reassembly_.pool.at(block_of(next_));
      const std::size_t taken = consume(now, {block + inside, size}, false);
      next_ += taken;
      if (broken_) return Verdict::kBroken;
      if (taken < size) {
        // No memory now: the rest stays stored, and a later datagram triggers another attempt.
        verdict = Verdict::kRefused;
        break;
      }
    }
    early_.remove_below(next_);
  }
  // Releases blocks that are no longer needed. When nothing is left, all are released: a block
  // may have been allocated for bytes that were then refused.
  if (early_.empty()) {
    drop_early();
  } else {
    const std::uint64_t keep = std::min(next_, early_.front().begin) / kBlock;
    for (std::uint64_t b = first / kBlock; b < keep && b < first / kBlock + kRing; ++b) {
      reassembly_.give_block(early_blocks_[b % kRing]);
    }
  }
  return verdict;
}

void LaneReceiver::drop_early() {
  early_.clear();
  early_since_.clear();
  for (core::BlockPool::Index& block : early_blocks_) reassembly_.give_block(block);
}

void LaneReceiver::clear() {
  drop_early();
  next_ = 0;
  head_size_ = discarded_ = 0;
  reassembly_.give(body_);
  broken_ = false;
}

// --- extracting messages from the stream

bool LaneReceiver::is_bad(const Header& header) const {
  return wire::check_length(header.length, reassembly_.message_max) != wire::LengthVerdict::kOk;
}

std::size_t LaneReceiver::consume(Time now, std::span<std::byte> bytes, bool stable) {
  const std::size_t all = bytes.size();
  while (!bytes.empty() && !broken_) {
    std::size_t taken = 0;
    if (discarded_ > 0) {
      taken = std::min(discarded_, bytes.size());
      discarded_ -= taken;
    } else if (body_) {
      taken = consume_body(now, bytes);
      if (taken == 0) break;
    } else if (head_size_ > 0 || bytes.size() < kRecordHead || !stable) {
      taken = consume_head(now, bytes);
      if (taken == 0) break;
      if (body_ && body_size_ == header_.length) consume_body(now, {});
    } else {
      const auto record = bytes.subspan(kRecordPrefix);
      const Header header = wire::decode_header(record.first<kHeaderSize>());
      if (is_bad(header)) {
        broken_ = true;
      } else if (record.size() >= header.length) {
        if (!can_hand_on(now, bytes)) break;
        begun_ = arrived_;
        hand_on(now, bytes.first(kRecordPrefix), {header, record.first(header.length)});
        taken = record_size(header.length);
      } else {
        taken = consume_head(now, bytes);
        if (taken == 0) break;
      }
    }
    bytes = bytes.subspan(taken);
  }
  return all - bytes.size();
}

// Takes bytes until the head of the next message is complete and there is memory for its
// beginning.
std::size_t LaneReceiver::consume_head(Time now, std::span<const std::byte> bytes) {
  if (head_size_ == 0) begun_ = arrived_;
  const std::size_t size = std::min(kRecordHead - head_size_, bytes.size());
  std::memcpy(head_.data() + head_size_, bytes.data(), size);
  if (head_size_ + size < kRecordHead) {
    head_size_ += size;
    return size;
  }
  const Header header = wire::decode_header(std::span(head_).last<kHeaderSize>());
  if (is_bad(header)) {
    broken_ = true;
    return size;
  }
  if (!begin_message(now, header)) return 0;
  return size;
}

bool LaneReceiver::begin_message(Time now, const Header& header) {
  if (!reassembly_.grow(now, body_, kHeaderSize, true)) {
    refused_ = now;
    return false;
  }
  progress_ = now;
  progress_at_ = 0;
  header_ = header;
  std::memcpy(body_.bytes().data(), head_.data() + kRecordPrefix, kHeaderSize);
  body_size_ = kHeaderSize;
  head_size_ = 0;
  return true;
}

std::size_t LaneReceiver::consume_body(Time now, std::span<const std::byte> bytes) {
  std::size_t size = std::min<std::size_t>(header_.length - body_size_, bytes.size());
  if (body_size_ + size > body_.size() && !reassembly_.grow(now, body_, body_size_ + size, true)) {
    refused_ = now;
    size = body_.size() - body_size_;
  }
  const bool completes = body_size_ + size == header_.length;
  if (completes && size > 0 && !can_hand_on(now, head_)) --size;
  if (size > 0) std::memcpy(body_.bytes().data() + body_size_, bytes.data(), size);
  body_size_ += size;
  if (body_size_ >= progress_at_ + kProgress) {
    progress_ = now;
    progress_at_ = body_size_;
  }
  if (body_size_ == header_.length) {
    const std::span message = body_.bytes().first(header_.length);
    reassembly_.hand_on(body_);
    hand_on(now, std::span(head_).first(kRecordPrefix), {header_, message});
  }
  return size;
}

bool LaneReceiver::can_hand_on(Time now, std::span<const std::byte> prefix) {
  if (!RecordPrefix::decode(prefix).packed || control_ || arrivals_.has_room_to_unpack())
    return true;
  refused_ = now;
  return false;
}

std::optional<Header> LaneReceiver::give_up_stalled(Time now) {
  const Duration patience =
      reassembly_.memory.is_wanted(now, &reassembly_) ? kPatienceIfWanted : kPatience;
  if (!body_ || now < progress_ + patience) return std::nullopt;
  const bool waits = now < refused_ + kPatienceIfWanted;
  if (waits && !reassembly_.is_over_share(now, reassembly_.bytes)) return std::nullopt;
  discarded_ = header_.length - body_size_;
  reassembly_.give(body_);
  return header_;
}

void LaneReceiver::hand_on(Time now, std::span<const std::byte> prefix, core::Message message) {
  if (control_) return arrivals_.on_control(now, message);
  const RecordPrefix record = RecordPrefix::decode(prefix);
  if (record.late) return;
  const policy::Lifetimes* lifetimes = reassembly_.lifetimes;
  if (lifetimes != nullptr && now - begun_ > lifetimes->of(message.header))
    return arrivals_.on_late(now, message.header);
  arrivals_.on_message(now, record, message);
}

}  // namespace tims::link
