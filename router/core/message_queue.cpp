#include "router/core/message_queue.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <utility>

#include "tims/message.h"
#include "wire/header.h"

namespace tims::core {
namespace {

constexpr BlockPool::Index kMessageQueueNone = BlockPool::kNone;
constexpr std::size_t kIndexBlocks = 2;  // the index of levels and the spare block

bool same_stream(const Header& a, const Header& b) {
  return StreamCounters::is_sample(a) && StreamCounters::is_sample(b) && a.src == b.src &&
         a.dest == b.dest && a.type == b.type;
}

}  // namespace

MessageQueue::~MessageQueue() {
  LossCounts ignored{};
  clear(ignored);
}

bool MessageQueue::push(std::span<const std::byte> message, std::uint8_t priority,
                        LossCounts& replaced) {
  Header header;
  if (streams_ != nullptr) header = wire::decode_header(message.first<kHeaderSize>());
  const bool sample = is_sample(header);
  if (sample && replace_older(message, header, priority, replaced)) return true;
  ask_for_room(message.size());
  if (!open() || !make_room(message.size(), priority, replaced)) {
    if (empty()) close();
    if (sample) streams_->drop(header);
    return false;
  }
  if (sample) streams_->waits(header);
  Level& level = levels()[priority];
  level.messages.append(pool_, message);
  level.bytes += static_cast<std::uint32_t>(message.size());
  ++level.count;
  added(message.size());
  used_[priority / 64] |= std::uint64_t{1} << priority % 64;
  return true;
}

bool MessageQueue::reserve(std::size_t size) {
  const std::size_t blocks = size / ByteChain::kBlockBytes + 1 + kIndexBlocks;
  return pool_.available() >= blocks || (shares_ != nullptr && shares_->find_room(*this, blocks));
}

bool MessageQueue::push_rest(std::span<const std::byte> rest, const Header& header) {
  if (begun_.blocks_needed(pool_, rest.size()) > pool_.available()) return false;
  begun_.append(pool_, rest);
  begun_bytes_ = rest.size();
  begun_class_ = classes_.of(header);
  added(rest.size());
  return true;
}

std::size_t MessageQueue::gather(std::span<std::span<const std::byte>> pieces) const {
  std::size_t count = begun_.gather(pool_, pieces, 0);
  for (std::size_t word = used_.size(); word-- > 0;) {
    for (std::uint64_t bits = used_[word]; bits != 0 && count < pieces.size();) {
      const auto bit = static_cast<std::size_t>(std::bit_width(bits)) - 1;
      count = levels()[word * 64 + bit].messages.gather(pool_, pieces, count);
      bits &= ~(std::uint64_t{1} << bit);
    }
  }
  return count;
}

void MessageQueue::consume(std::uint64_t size) {
  if (size > 0 && shares_ != nullptr) progress_at_ = shares_->now();
  size -= consume_begun(size);
  while (size > 0) size -= consume_first(size);
  if (empty()) close();
}

void MessageQueue::clear(LossCounts& lost) {
  if (begun_bytes_ > 0) lost[begun_class_].add(begun_bytes_);
  begun_.clear(pool_);
  removed(std::exchange(begun_bytes_, 0));
  for (std::size_t i = lowest(); i != kNoLevel; i = lowest()) drop_oldest(i, lost);
  close();
}

// Allocates the blocks for the index of levels and the spare block.
bool MessageQueue::open() {
  if (index_ != kMessageQueueNone) return true;
  if (pool_.available() < kIndexBlocks) return false;
  index_ = pool_.allocate();
  spare_ = pool_.allocate();
  std::uninitialized_fill_n(levels(), kLevels, Level{});
  return true;
}

void MessageQueue::close() {
  if (index_ != kMessageQueueNone) pool_.release(index_);
  if (spare_ != kMessageQueueNone) pool_.release(spare_);
  index_ = spare_ = kMessageQueueNone;
}

void MessageQueue::added(std::uint64_t size) {
  if (shares_ != nullptr && bytes_ == 0 && size > 0) {
    progress_at_ = shares_->now();
    shares_->join(*this);
  }
  bytes_ += size;
}

void MessageQueue::removed(std::uint64_t size) {
  if (size == 0) return;
  bytes_ -= size;
  if (shares_ != nullptr && bytes_ == 0) shares_->leave(*this);
}

// So that limit() permits `size` more bytes, if the bound of this queue does.
void MessageQueue::ask_for_room(std::size_t size) {
  if (shares_ == nullptr || bytes_ + size > bytes_max_ || bytes_ + size <= limit()) return;
  const std::uint64_t left = 3 * (bytes_ + size) - bytes_;
  shares_->find_room(*this,
                     static_cast<std::size_t>(left / BlockPool::kBlockSize) + 1 + kIndexBlocks);
}

// Drops waiting messages, the oldest of the lowest priority first, until the pool has `blocks` free
// ones or the queue has at most `keep` bytes.
void MessageQueue::drop_for_others(std::size_t blocks, std::uint64_t keep) {
  LossCounts lost{};
  while (pool_.available() < blocks && bytes_ > keep && waiting_bytes() > 0)
    drop_oldest(lowest(), lost);
  if (empty()) close();
  owner_->on_dropped(lost);
}

// Solves bytes <= (left + bytes) / 3: the queue takes at most half of what it leaves in the pool.
std::uint64_t MessageQueue::limit() const {
  if (shares_ == nullptr) return bytes_max_;
  const std::uint64_t left = std::uint64_t{pool_.available()} * BlockPool::kBlockSize;
  return std::min(bytes_max_, (left + bytes_) / 3);
}

// Drops nothing for a message that would be refused anyway, unless it is the pool itself that is
// short of memory.
bool MessageQueue::make_room(std::size_t size, std::uint8_t priority, LossCounts& replaced) {
  if (bytes_ + size > limit()) {
    const std::uint64_t stays = bytes_ - bytes_up_to(priority);
    if (stays + size > limit()) return false;
  }
  while (!fits(size, priority)) {
    const std::size_t victim = lowest();
    if (victim > priority) return false;
    drop_oldest(victim, replaced);
  }
  return true;
}

bool MessageQueue::fits(std::size_t size, std::uint8_t priority) const {
  return bytes_ + size <= limit() &&
         levels()[priority].messages.blocks_needed(pool_, size) <= pool_.available();
}

// False: no older one was found, or there is no room for the difference; then the sample is queued
// like any message.
bool MessageQueue::replace_older(std::span<const std::byte> sample, const Header& header,
                                 std::uint8_t priority, LossCounts& replaced) {
  if (index_ == kMessageQueueNone || !streams_->has_waiting(header)) return false;
  Level& level = levels()[priority];
  ByteChain::Place place = level.messages.front(pool_);
  for (std::size_t i = 0; i < std::min<std::size_t>(level.count, kSearchMax); ++i) {
    std::array<std::byte, kHeaderSize> bytes{};
    ByteChain::peek(pool_, place, bytes);
    const Header older = wire::decode_header(bytes);
    if (!same_stream(older, header)) {
      place = ByteChain::advanced(pool_, place, older.length);
      continue;
    }
    if (bytes_ - older.length + sample.size() > limit() ||
        ByteChain::replace_blocks_max(sample.size()) > pool_.available())
      return false;
    level.messages.replace(pool_, place, older.length, sample);
    level.bytes += static_cast<std::uint32_t>(sample.size()) - older.length;
    bytes_ += sample.size();
    bytes_ -= older.length;
    replaced[classes_.of(older)].add(older.length);
    streams_->drop(older);
    return true;
  }
  return false;
}

std::uint64_t MessageQueue::bytes_up_to(std::uint8_t priority) const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i <= priority; ++i) sum += levels()[i].bytes;
  return sum;
}

void MessageQueue::drop_oldest(std::size_t level, LossCounts& replaced) {
  const Header header = header_of_first(levels()[level]);
  levels()[level].messages.drop(pool_, header.length);
  replaced[classes_.of(header)].add(header.length);
  if (is_sample(header)) {
    streams_->drop(header);
    streams_->left(header);
  }
  removed(header.length);
  took(level, header.length);
}

// Returns the number of bytes consumed.
std::uint64_t MessageQueue::consume_begun(std::uint64_t size) {
  const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(size, begun_bytes_));
  begun_.drop(pool_, n);
  begun_bytes_ -= n;
  removed(n);
  // The blocks just released are enough for a new spare block.
  if (begun_bytes_ == 0 && index_ != kMessageQueueNone && spare_ == kMessageQueueNone)
    spare_ = pool_.allocate();
  return n;
}

// Consumes from the first message of the highest level; the rest of the message becomes begun_.
std::uint64_t MessageQueue::consume_first(std::uint64_t size) {
  const std::size_t i = highest();
  Level& level = levels()[i];
  const Header header = header_of_first(level);
  if (is_sample(header)) streams_->left(header);
  const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(size, header.length));
  level.messages.drop(pool_, n);
  removed(n);
  if (n < header.length) {
    level.messages.move_front(pool_, header.length - n, begun_, spare_);
    begun_bytes_ = header.length - n;
    begun_class_ = classes_.of(header);
  }
  took(i, header.length);
  return n;
}

Header MessageQueue::header_of_first(const Level& level) const {
  std::array<std::byte, kHeaderSize> header{};
  level.messages.peek(pool_, header);
  return wire::decode_header(header);
}

// Updates the level after a message was removed.
void MessageQueue::took(std::size_t i, std::uint32_t length) {
  Level& level = levels()[i];
  level.bytes -= length;
  if (--level.count == 0) used_[i / 64] &= ~(std::uint64_t{1} << i % 64);
}

std::size_t MessageQueue::lowest() const {
  for (std::size_t word = 0; word < used_.size(); ++word) {
    if (used_[word] != 0) {
      return word * 64 + static_cast<std::size_t>(std::countr_zero(used_[word]));
    }
  }
  return kNoLevel;
}

std::size_t MessageQueue::highest() const {
  for (std::size_t word = used_.size(); word-- > 0;) {
    if (used_[word] != 0) {
      return word * 64 + static_cast<std::size_t>(std::bit_width(used_[word])) - 1;
    }
  }
  return kNoLevel;
}

}  // namespace tims::core
