#include "rack/devices/replay.h"

#include <algorithm>

namespace rack::device {
namespace {

// Times of a recording begin at 0, but dialogues use Time{} for "not set".
constexpr Time kBegin{std::chrono::seconds(1000)};

}  // namespace

Checksum checksum_of(std::span<const std::byte> bytes) {
  constexpr std::uint64_t kBasis = 0xCBF29CE484222325;
  constexpr std::uint64_t kPrime = 0x100000001B3;
  std::uint64_t sum = kBasis;
  for (const std::byte byte : bytes) sum = (sum ^ std::to_integer<std::uint64_t>(byte)) * kPrime;
  Checksum checksum{};
  for (std::size_t i = 0; i < checksum.size(); ++i)
    checksum.at(i) = static_cast<std::byte>(sum >> 8 * (checksum.size() - 1 - i));
  return checksum;
}

tims::Result<void> Replay::take(const CaptureRecord& record) {
  if (record.direction == Direction::kStarted) return start(record);
  if (record.direction == Direction::kMade) {
    compare(record);
    return {};
  }
  const bool is_time = record.direction == Direction::kTime;
  const bool is_received = is_time || record.direction == Direction::kReceived;
  if (!is_received) return {};
  if (!conversation_) return {};
  count_unmatched(record.time);
  ++records_;
  const Time now = kBegin + record.time;
  if (is_time)
    conversation_->on_timeout(now, *this);
  else
    conversation_->receive(
        {.bytes = record.bytes, .first = now - record.took, .last = now, .id = record.id}, *this);
  return {};
}

tims::Result<void> Replay::start(const CaptureRecord& record) {
  count_unmatched(record.time);
  conversation_.reset();
  auto side = make_();
  if (!side) return side.error();
  conversation_.emplace(*side->dialogue, std::move(side->take));
  ++openings_;
  records_ = 1;
  conversation_->start(kBegin + record.time, *this);
  return {};
}

// A measurement may be earlier than the start of the recording; its recorded time is then 0.
void Replay::made(Time measured, std::span<const std::byte> message) {
  made_.push_back(
      {.measured = std::max(Duration(0), measured - kBegin), .checksum = checksum_of(message)});
}

void Replay::compare(const CaptureRecord& record) {
  if (record.id != records_) conversation_.reset();
  if (!conversation_) {
    ++lost_;
    made_.clear();
    return;
  }
  ++messages_;
  if (made_.empty()) return differs(record.time, "the replay produces no data set");
  const Made now = made_.front();
  made_.pop_front();
  if (now.measured != record.time)
    return differs(record.time, "it was measured " +
                                    std::to_string((now.measured - record.time).count()) +
                                    " ns later in the replay");
  if (!std::ranges::equal(now.checksum, record.bytes)) differs(record.time, "the data differ");
}

// Counts data sets that the replay produces but the recording does not have.
void Replay::count_unmatched(Duration at) {
  for (; !made_.empty(); made_.pop_front()) {
    ++messages_;
    differs(at, "the replay produces additional data before this time");
  }
}

void Replay::differs(Duration at, std::string text) {
  ++different_;
  if (!first_) first_ = {.at = at, .text = std::move(text)};
}

std::string Replay::report() const {
  std::string text;
  if (first_) {
    const auto at = std::chrono::duration_cast<std::chrono::microseconds>(first_->at);
    text = "at " + std::to_string(at.count()) + " us: " + first_->text + "\n";
  }
  text += std::to_string(messages_) + " data sets replayed: " + std::to_string(different_) +
          " different";
  if (lost_ > 0)
    text += "; " + std::to_string(lost_) + " more cannot be replayed: earlier records are missing";
  return text + "\n";
}

}  // namespace rack::device
