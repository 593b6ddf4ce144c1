#include "router/link/buffers.h"

#include <algorithm>
#include <cstring>

namespace tims::link {

std::size_t RangeSet::first_ending_at_or_after(std::uint64_t offset) const {
  // The common case is the last range.
  if (!ranges_.empty() && ranges_.back().begin <= offset) {
    return ranges_.back().end >= offset ? ranges_.size() - 1 : ranges_.size();
  }
  const auto found = std::ranges::lower_bound(ranges_, offset, {}, &Range::end);
  return static_cast<std::size_t>(found - ranges_.begin());
}

bool RangeSet::add(Range range) {
  if (range.begin >= range.end) return true;
  const std::size_t first = first_ending_at_or_after(range.begin);
  std::size_t last = first;  // one past the ranges that `range` touches
  while (last < ranges_.size() && ranges_[last].begin <= range.end) {
    range.begin = std::min(range.begin, ranges_[last].begin);
    range.end = std::max(range.end, ranges_[last].end);
    ++last;
  }
  const auto at = ranges_.begin() + static_cast<std::ptrdiff_t>(first);
  if (first == last) {
    if (ranges_.size() >= kRangesMax) return false;
    ranges_.insert(at, range);
    return true;
  }
  *at = range;
  ranges_.erase(at + 1, ranges_.begin() + static_cast<std::ptrdiff_t>(last));
  return true;
}

void RangeSet::remove(Range range) {
  std::size_t i = first_ending_at_or_after(range.begin);
  while (i < ranges_.size() && ranges_[i].begin < range.end) {
    const Range old = ranges_[i];
    if (old.end <= range.begin) {
      ++i;
      continue;
    }
    const Range left{old.begin, std::max(old.begin, range.begin)};
    const Range right{std::min(old.end, range.end), old.end};
    const auto at = ranges_.begin() + static_cast<std::ptrdiff_t>(i);
    if (left.size() > 0 && right.size() > 0) {
      *at = left;
      ranges_.insert(at + 1, right);
      return;
    }
    if (left.size() == 0 && right.size() == 0) {
      ranges_.erase(at);
    } else {
      *at = left.size() > 0 ? left : right;
      ++i;
    }
  }
}

void RangeSet::remove_below(std::uint64_t offset) {
  const auto keep = std::ranges::upper_bound(ranges_, offset, {}, &Range::end);
  ranges_.erase(ranges_.begin(), keep);
  if (!ranges_.empty()) ranges_.front().begin = std::max(ranges_.front().begin, offset);
}

bool RangeSet::contains(Range range) const {
  if (range.begin >= range.end) return true;
  const std::size_t i = first_ending_at_or_after(range.begin + 1);
  return i < ranges_.size() && ranges_[i].begin <= range.begin && ranges_[i].end >= range.end;
}

std::optional<Range> RangeSet::first_missing(Range range) const {
  for (const Range& have : ranges_) {
    if (have.end <= range.begin) continue;
    if (have.begin > range.begin) {
      range.end = std::min(range.end, have.begin);
      break;
    }
    range.begin = have.end;
    if (range.begin >= range.end) return std::nullopt;
  }
  if (range.begin >= range.end) return std::nullopt;
  return range;
}

void SentRanges::on_lost(Range range) {
  while (range.begin < range.end) {
    const auto missing = acked_.first_missing(range);
    if (!missing) return;
    if (!lost_.add(*missing)) {
      // Too many ranges: extend the last one and send more than necessary.
      const Range last = lost_.ranges().back();
      lost_.add({std::min(last.begin, missing->begin), std::max(last.end, missing->end)});
    }
    range.begin = missing->end;
  }
}

void SentRanges::clear() {
  acked_.clear();
  lost_.clear();
}

bool StreamBuffer::has_room(std::size_t size) const {
  const std::uint64_t free_in_last = base_ + count_ * kBlock - end_;
  if (size <= free_in_last) return true;
  return (size - free_in_last + kBlock - 1) / kBlock <= pool_.available();
}

void StreamBuffer::add_block() {
  if (count_ == ring_.size()) {
    std::vector<Block> larger(std::max<std::size_t>(4, 2 * ring_.size()));
    for (std::size_t i = 0; i < count_; ++i) larger[i] = slot(i);
    ring_ = std::move(larger);
    first_ = 0;
  }
  slot(count_) = {.index = pool_.allocate()};
  ++count_;
}

void StreamBuffer::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const std::size_t size = std::min(left_in_block(offset), bytes.size());
    std::memcpy(at(offset), bytes.data(), size);
    offset += size;
    bytes = bytes.subspan(size);
  }
}

void StreamBuffer::move_front(std::size_t size, StreamBuffer& to) {
  while (size > 0) {
    const std::size_t piece = std::min(left_in_block(begin_), size);
    to.append({at(begin_), piece});
    release_to(begin_ + piece);
    size -= piece;
  }
}

void StreamBuffer::free(Range range) {
  while (range.begin < range.end) {
    const std::uint64_t i = (range.begin - base_) / kBlock;
    const std::uint64_t block_end = base_ + (i + 1) * kBlock;
    const std::uint64_t end = std::min(range.end, block_end);
    Block& block = slot(i);
    block.needed -= static_cast<std::uint32_t>(end - range.begin);
    if (block.needed == 0 && block_end <= end_) give_back(block);  // otherwise it is not full yet
    range.begin = end;
  }
  while (count_ > 1 && slot(0).index == core::BlockPool::kNone) release_to(base_ + kBlock);
  if (count_ == 1 && slot(0).needed == 0) release_to(end_);
}

void StreamBuffer::release_to(std::uint64_t offset) {
  begin_ = offset;
  while (count_ > 0 && (base_ + kBlock <= begin_ || begin_ == end_)) {
    give_back(slot(0));
    first_ = (first_ + 1) & (ring_.size() - 1);
    --count_;
    base_ += kBlock;
  }
  if (count_ == 0) base_ = begin_;
}

void StreamBuffer::reset(std::uint64_t offset) {
  release_to(end_);
  base_ = begin_ = end_ = offset;
}

MessageMemory::MessageMemory(std::span<std::byte> address_space, std::uint32_t message_max,
                             std::size_t bytes_max)
    : memory_(address_space.data()),
      place_bytes_(place_bytes(message_max)),
      bytes_max_(std::max(bytes_max, place_bytes_)),
      touched_(std::min(address_space.size() / place_bytes_, kPlacesMax)) {
  for (std::size_t place = touched_.size(); place > 0; --place)
    free_.push_back(static_cast<std::uint32_t>(place - 1));
}

std::uint32_t MessageMemory::take_place() {
  if (free_.empty()) return kNone;
  const std::uint32_t place = free_.back();
  free_.pop_back();
  return place;
}

bool MessageMemory::grow(std::uint32_t place, std::size_t size, std::size_t larger) {
  if (place == has_kept_) return grow_as_kept(place, size, larger);
  if (larger - size > free_bytes() || larger > place_bytes_) return false;
  used_ += larger - size;
  touch(place, larger);
  return true;
}

bool MessageMemory::grow_as_kept(std::uint32_t place, std::size_t size, std::size_t larger) {
  if ((has_kept_ != kNone && has_kept_ != place) || larger > place_bytes_) return false;
  // Its own memory becomes available to others.
  if (has_kept_ == kNone) used_ -= size;
  has_kept_ = place;
  kept_used_ = larger;
  touch(place, larger);
  return true;
}

void MessageMemory::touch(std::uint32_t place, std::size_t size) {
  if (size <= touched_[place]) return;
  touched_bytes_ += size - touched_[place];
  touched_[place] = size;
}

void MessageMemory::release(std::uint32_t place, std::size_t size) {
  if (place == has_kept_) {
    has_kept_ = kNone;
    kept_used_ = 0;
  } else {
    used_ -= size;
  }
  free_.push_back(place);
}

std::span<std::byte> MessageMemory::surplus() {
  const bool idle = free_.size() == touched_.size();
  if (touched_bytes_ <= (idle ? std::min(kTouchedIfIdle, bytes_max_) : bytes_max_)) return {};
  const auto place =
      std::ranges::find_if(free_, [&](std::uint32_t free) { return touched_[free] > 0; });
  if (place == free_.end()) return {};
  const std::size_t size = std::exchange(touched_[*place], 0);
  touched_bytes_ -= size;
  return {at(*place), size};
}

// --- memory shared by the lanes of one link

core::BlockPool::Index Reassembly::take_block() {
  if (blocks >= pool.available()) return core::BlockPool::kNone;
  ++blocks;
  return pool.allocate();
}

void Reassembly::give_block(core::BlockPool::Index& block) {
  if (block == core::BlockPool::kNone) return;
  pool.release(std::exchange(block, core::BlockPool::kNone));
  --blocks;
}

bool Reassembly::grow(Time now, MessageBuffer& buffer, std::size_t size, bool will_retry) {
  MessageBuffer fresh;
  if (!buffer && places < memory.free_places()) fresh = MessageBuffer(memory);
  MessageBuffer& grown = buffer ? buffer : fresh;
  const std::size_t before = grown.size();
  bool larger = false;
  if (grown) {
    const std::size_t after = bytes + MessageMemory::whole_chunks(size) - before;
    larger = !is_over_share(now, after) && grown.grow(size);
    if (!larger) memory.note_wanted(now, this);
    larger = larger || (will_retry && grown.grow_as_kept(size));
  }
  if (!larger) return false;
  bytes += grown.size() - before;
  if (buffer) return true;
  if (places++ == 0) memory.add_user();
  buffer = std::move(fresh);
  return true;
}

void Reassembly::give(MessageBuffer& buffer) {
  if (!buffer) return;
  forget(buffer);
  buffer.reset();
}

void Reassembly::forget(const MessageBuffer& buffer) {
  bytes -= buffer.size();
  if (--places == 0) memory.remove_user();
}

void Reassembly::hand_on(MessageBuffer& buffer) {
  forget(buffer);
  done.push_back(std::move(buffer));
}

}  // namespace tims::link
