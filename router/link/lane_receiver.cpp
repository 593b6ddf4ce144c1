#include "router/link/lane_receiver.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "router/link/lane_sender.h"
#include "wire/header.h"

namespace tims::link {
namespace {

constexpr std::size_t kBlock = core::BlockPool::kBlockSize;
// One block more than the window, which need not begin with a block; a power of two above that.
constexpr std::size_t kRing = 2 * kLaneWindow / kBlock;

}  // namespace

// --- memory

core::BlockPool::Index Assembly::take_block() {
  if (blocks >= pool.available()) return core::BlockPool::kNone;
  ++blocks;
  return pool.allocate();
}

void Assembly::give_block(core::BlockPool::Index& block) {
  if (block == core::BlockPool::kNone) return;
  pool.release(std::exchange(block, core::BlockPool::kNone));
  --blocks;
}

bool Assembly::grow(Time now, MessageBuffer& buffer, std::size_t size, bool insists) {
  MessageBuffer fresh;
  if (!buffer && places < memory.free_places()) fresh = MessageBuffer(memory);
  MessageBuffer& grown = buffer ? buffer : fresh;
  const std::size_t before = grown.size();
  bool larger = false;
  if (grown) {
    const std::size_t after = bytes + MessageMemory::whole_chunks(size) - before;
    larger = !is_over_share(now, after) && grown.grow(size);
    if (!larger) memory.note_wanted(now, this);
    larger = larger || (insists && grown.grow_as_kept(size));
  }
  if (!larger) return false;
  bytes += grown.size() - before;
  if (buffer) return true;
  if (places++ == 0) memory.add_user();
  buffer = std::move(fresh);
  return true;
}

void Assembly::give(MessageBuffer& buffer) {
  if (!buffer) return;
  forget(buffer);
  buffer.reset();
}

void Assembly::forget(const MessageBuffer& buffer) {
  bytes -= buffer.size();
  if (--places == 0) memory.remove_user();
}

void Assembly::hand_on(MessageBuffer& buffer) {
  forget(buffer);
  done.push_back(std::move(buffer));
}

// --- what comes

LaneReceiver::Verdict LaneReceiver::on_bytes(Time now, std::uint64_t offset,
                                             std::span<std::byte> bytes, bool control,
                                             Arrivals& arrivals) {
  if (is_stuck()) {
    const Verdict verdict = drain_early(now, control, arrivals);
    if (verdict != Verdict::kTaken) return verdict;
  }
  if (offset + bytes.size() <= next_) return Verdict::kTaken;
  const std::uint64_t window = control ? kControlWindow : kLaneWindow;
  if (offset + bytes.size() > next_ + window) return Verdict::kRefused;
  if (offset > next_) return keep_early(offset, bytes) ? Verdict::kTaken : Verdict::kRefused;
  bytes = bytes.subspan(next_ - offset);
  const std::size_t taken = consume(now, bytes, true, control, arrivals);
  next_ += taken;
  if (broken_) return Verdict::kBroken;
  if (taken < bytes.size()) return Verdict::kRefused;
  return early_.empty() ? Verdict::kTaken : drain_early(now, control, arrivals);
}

LaneReceiver::Verdict LaneReceiver::on_skip(Time now, std::uint64_t to, bool control,
                                            Arrivals& arrivals) {
  if (to <= next_) return Verdict::kTaken;
  next_ = to;
  head_size_ = thrown_away_ = 0;
  assembly_.give(body_);
  return drain_early(now, control, arrivals);
}

// --- what comes too early

core::BlockPool::Index& LaneReceiver::block_of(std::uint64_t offset) {
  if (early_blocks_.empty()) early_blocks_.assign(kRing, core::BlockPool::kNone);
  return early_blocks_[offset / kBlock % kRing];
}

bool LaneReceiver::keep_early(std::uint64_t offset, std::span<const std::byte> bytes) {
  const Range all{offset, offset + bytes.size()};
  bool room = true;
  for (std::uint64_t at = offset / kBlock * kBlock; at < all.end; at += kBlock) {
    core::BlockPool::Index& block = block_of(at);
    if (block == core::BlockPool::kNone) block = assembly_.take_block();
    if (block == core::BlockPool::kNone) room = false;
  }
  if (!room || !early_.add(all)) {
    // Blocks that were taken for nothing.
    if (early_.empty()) drop_early();
    return false;
  }
  while (!bytes.empty()) {
    const std::size_t inside = offset % kBlock;
    const std::size_t size = std::min(kBlock - inside, bytes.size());
    std::memcpy(assembly_.pool.at(block_of(offset)) + inside, bytes.data(), size);
    offset += size;
    bytes = bytes.subspan(size);
  }
  return true;
}

LaneReceiver::Verdict LaneReceiver::drain_early(Time now, bool control, Arrivals& arrivals) {
  Verdict verdict = Verdict::kTaken;
  const std::uint64_t first = early_.empty() ? next_ : std::min(next_, early_.front().begin);
  while (!early_.empty() && early_.front().begin <= next_ && verdict == Verdict::kTaken) {
    const std::uint64_t end = early_.front().end;
    while (next_ < end) {
      const std::size_t inside = next_ % kBlock;
      const std::size_t size = std::min<std::uint64_t>(kBlock - inside, end - next_);
      std::byte* block = assembly_.pool.at(block_of(next_));
      const std::size_t taken = consume(now, {block + inside, size}, false, control, arrivals);
      next_ += taken;
      if (broken_) return Verdict::kBroken;
      if (taken < size) {
        // No memory now: what is left stays here, and a later datagram brings us back.
        verdict = Verdict::kRefused;
        break;
      }
    }
    early_.remove_below(next_);
  }
  // Blocks of which nothing is needed any more. (With nothing left, all of them: a block may have
  // been taken for bytes that were then refused.)
  if (early_.empty()) {
    drop_early();
  } else {
    const std::uint64_t keep = std::min(next_, early_.front().begin) / kBlock;
    for (std::uint64_t b = first / kBlock; b < keep && b < first / kBlock + kRing; ++b) {
      assembly_.give_block(early_blocks_[b % kRing]);
    }
  }
  return verdict;
}

void LaneReceiver::drop_early() {
  early_.clear();
  for (core::BlockPool::Index& block : early_blocks_) assembly_.give_block(block);
}

void LaneReceiver::clear() {
  drop_early();
  next_ = 0;
  head_size_ = thrown_away_ = 0;
  assembly_.give(body_);
  broken_ = false;
}

// --- messages out of the stream

bool LaneReceiver::is_bad(const Header& header) const {
  return wire::check_length(header.length, assembly_.message_max) != wire::LengthVerdict::kOk;
}

std::size_t LaneReceiver::consume(Time now, std::span<std::byte> bytes, bool stable, bool control,
                                  Arrivals& arrivals) {
  const std::size_t all = bytes.size();
  while (!bytes.empty() && !broken_) {
    std::size_t taken = 0;
    if (thrown_away_ > 0) {
      taken = std::min(thrown_away_, bytes.size());
      thrown_away_ -= taken;
    } else if (body_) {
      taken = consume_body(now, bytes, control, arrivals);
      if (taken == 0) break;
    } else if (head_size_ > 0 || bytes.size() < kRecordHead || !stable) {
      taken = consume_head(now, bytes);
      if (taken == 0) break;
      if (body_ && body_size_ == header_.length) consume_body(now, {}, control, arrivals);
    } else {
      const auto record = bytes.subspan(kRecordPrefix);
      const Header header = wire::decode_header(record.first<kHeaderSize>());
      if (is_bad(header)) {
        broken_ = true;
      } else if (record.size() >= header.length) {
        hand_on(now, bytes.first(kRecordPrefix), {header, record.first(header.length)}, control,
                arrivals);
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

// Takes bytes until the head of the next message is complete and there is memory for its beginning.
std::size_t LaneReceiver::consume_head(Time now, std::span<const std::byte> bytes) {
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
  if (!assembly_.grow(now, body_, kHeaderSize, true)) {
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

std::size_t LaneReceiver::consume_body(Time now, std::span<const std::byte> bytes, bool control,
                                       Arrivals& arrivals) {
  std::size_t size = std::min<std::size_t>(header_.length - body_size_, bytes.size());
  if (body_size_ + size > body_.size() && !assembly_.grow(now, body_, body_size_ + size, true)) {
    refused_ = now;
    size = body_.size() - body_size_;
  }
  if (size > 0) std::memcpy(body_.bytes().data() + body_size_, bytes.data(), size);
  body_size_ += size;
  if (body_size_ >= progress_at_ + kProgress) {
    progress_ = now;
    progress_at_ = body_size_;
  }
  if (body_size_ == header_.length) {
    const std::span message = body_.bytes().first(header_.length);
    assembly_.hand_on(body_);
    hand_on(now, std::span(head_).first(kRecordPrefix), {header_, message}, control, arrivals);
  }
  return size;
}

std::optional<Header> LaneReceiver::give_up_stalled(Time now) {
  const Duration patience =
      assembly_.memory.is_wanted(now, &assembly_) ? kPatienceIfWanted : kPatience;
  if (!body_ || now < progress_ + patience) return std::nullopt;
  const bool waits = now < refused_ + kPatienceIfWanted;
  if (waits && !assembly_.is_over_share(now, assembly_.bytes)) return std::nullopt;
  thrown_away_ = header_.length - body_size_;
  assembly_.give(body_);
  return header_;
}

void LaneReceiver::hand_on(Time now, std::span<const std::byte> prefix, core::Message message,
                           bool control, Arrivals& arrivals) {
  if (control) {
    arrivals.on_control(now, message);
  } else {
    arrivals.on_message(now, RecordPrefix::decode(prefix), message);
  }
}

}  // namespace tims::link
