#include "router/link/lane_sender.h"

#include <algorithm>

#include "wire/header.h"

namespace tims::link {

void LaneSender::push(Time now, const RecordPrefix& prefix, std::span<const std::byte> message,
                      std::uint64_t committed_max) {
  const bool at_once = waiting_.empty() && stream_.end() - next_ < committed_max;
  StreamBuffer& to = at_once ? stream_ : waiting_;
  (at_once ? stream_since_ : waiting_since_).add(to.end(), now);
  to.append(prefix.encoded());
  to.append(message);
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

// Of the message at the front, a part may have arrived.
std::uint64_t LaneSender::window_end() const {
  const std::uint64_t begin = stream_.begin();
  const bool arrived = !acked_.empty() && acked_.front().begin <= begin;
  return (arrived ? acked_.front().end : begin) + window_;
}

bool LaneSender::wants_to_send() const {
  if (!lost_.empty()) return true;
  if (next_ >= window_end()) return false;
  return next_ < stream_.end() || (!waiting_.empty() && can_commit());
}

std::optional<Range> LaneSender::take(Time now, std::size_t size, std::uint64_t committed_max) {
  if (!lost_.empty()) {
    Range range = lost_.front();
    range.end = std::min(range.end, range.begin + size);
    lost_.remove(range);
    return range;
  }
  if (stream_.end() - next_ < committed_max) commit(now, committed_max);
  const std::uint64_t end = std::min({stream_.end(), next_ + size, window_end()});
  if (end <= next_) return std::nullopt;
  const Range range{next_, end};
  next_ = end;
  return range;
}

void LaneSender::on_acked(Range range) {
  range.begin = std::max(range.begin, stream_.begin());
  if (range.begin >= range.end) return;
  lost_.remove(range);
  // A set that is full forgets: the range is sent once more, and the other side knows it already.
  if (!acked_.add(range)) {
    on_lost(range);
    return;
  }
  // What is acknowledged from the front on is released, message by message.
  std::uint64_t begin = stream_.begin();
  const std::uint64_t acked_to = acked_.front().begin <= begin ? acked_.front().end : begin;
  while (begin < acked_to) {
    if (begin + kRecordHead > acked_to) break;
    const std::uint64_t end = begin + record_size(header_at(stream_, begin).length);
    if (end > acked_to) break;
    begin = end;
  }
  if (begin == stream_.begin()) return;
  stream_.release_to(begin);
  stream_since_.forget_below(begin);
  acked_.remove_below(begin);
  lost_.remove_below(begin);
}

void LaneSender::on_lost(Range range) {
  range.begin = std::max(range.begin, stream_.begin());
  range.end = std::min(range.end, next_);
  while (range.begin < range.end) {
    const auto missing = acked_.first_missing(range);
    if (!missing) return;
    if (!lost_.add(*missing)) {
      // Too many pieces: send more than necessary instead.
      const Range last = lost_.ranges().back();
      lost_.add({std::min(last.begin, missing->begin), std::max(last.end, missing->end)});
    }
    range.begin = missing->end;
  }
}

// Tells of all messages that begin below `to` and releases them; where the first behind them
// begins.
std::uint64_t LaneSender::lose(Time now, StreamBuffer& buffer, std::uint64_t to, core::Outcome why,
                               Losses& losses) {
  std::uint64_t offset = buffer.begin();
  while (offset < to) {
    const Header header = header_at(buffer, offset);
    offset += record_size(header.length);
    losses.on_lost(now, header, why);
  }
  buffer.release_to(offset);
  return offset;
}

void LaneSender::expire(Time now, Duration lifetime, Losses& losses) {
  const Time limit = now - lifetime;
  if (!stream_.empty() && stream_since_.oldest(stream_.begin()) <= limit) {
    const std::uint64_t old = stream_.begin();
    const std::uint64_t to = lose(now, stream_, stream_since_.older_than(limit, stream_.end()),
                                  core::Outcome::kExpired, losses);
    if (to > old) {
      skip_to_ = to;
      skip_due_ = true;
      next_ = std::max(next_, to);
      acked_.remove_below(to);
      lost_.remove_below(to);
      stream_since_.forget_below(to);
    }
  }
  if (!waiting_.empty() && waiting_since_.oldest(waiting_.begin()) <= limit) {
    lose(now, waiting_, waiting_since_.older_than(limit, waiting_.end()), core::Outcome::kExpired,
         losses);
    waiting_since_.forget_below(waiting_.begin());
  }
}

void LaneSender::clear(Time now, core::Outcome why, Losses& losses) {
  lose(now, stream_, stream_.end(), why, losses);
  lose(now, waiting_, waiting_.end(), why, losses);
  stream_.reset(0);
  waiting_.reset(0);
  stream_since_.clear();
  waiting_since_.clear();
  acked_.clear();
  lost_.clear();
  next_ = skip_to_ = skip_acked_ = 0;
  skip_due_ = false;
}

}  // namespace tims::link
