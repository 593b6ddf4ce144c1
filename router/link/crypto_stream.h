// Carries the bytes of a handshake over datagrams, in both directions: in order, repeated until
// they are acknowledged. Flights are short, so the receiver keeps nothing that arrives too early.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "router/link/datagram.h"
#include "tims/time.h"

namespace tims::link {

class CryptoStream {
 public:
  static constexpr std::size_t kBytesMax = 16 << 10;  // each way
  static constexpr Duration kRepeatFirst = std::chrono::milliseconds(300);
  static constexpr Duration kRepeatMax = std::chrono::seconds(3);

  // Returns false when that would be more than kBytesMax.
  [[nodiscard]] bool write(std::span<const std::byte> bytes);
  // Returns what is new; false: the other side sends more than kBytesMax, or acknowledges what was
  // never sent.
  [[nodiscard]] bool receive(const Crypto& crypto, std::span<const std::byte>& bytes);

  // Calls send(const Crypto&) for each datagram that is due: new bytes, repetitions, and an
  // acknowledgement if there are none.
  template <typename Send>
  void flush(Time now, Crypto head, Send send) {
    if (now >= repeat_at_) repeat();
    const std::size_t piece = repeats_ < kSmallAfter ? kPiece : kSmallPiece;
    head.acknowledged = received_;
    while (sent_ < out_.size() || owes_answer_) {
      owes_answer_ = false;
      head.offset = sent_;
      head.bytes = std::span(out_).subspan(sent_);
      if (head.bytes.size() > piece) head.bytes = head.bytes.first(piece);
      sent_ += static_cast<std::uint32_t>(head.bytes.size());
      send(head);
    }
    if (!is_acknowledged() && repeat_at_ == kNever) repeat_at_ = now + spread(head.token);
  }
  // The next flush() sends everything again that is not acknowledged.
  void repeat();
  [[nodiscard]] Time next_timeout() const { return repeat_at_; }
  [[nodiscard]] bool is_acknowledged() const { return acknowledged_ == out_.size(); }

 private:
  static constexpr std::size_t kPiece = kDatagramBase - kCryptoHeaderSize;
  static constexpr std::size_t kSmallPiece = kDatagramMin - kCryptoHeaderSize;
  static constexpr int kSmallAfter = 2;  // repetitions: the path may lose larger datagrams

  // Half to one and a half intervals: a thousand routers that begin together do not repeat
  // together.
  [[nodiscard]] Duration spread(std::uint64_t token) const {
    return interval_ / 2 + interval_ / 1024 * static_cast<std::int64_t>(token % 1024);
  }

  std::vector<std::byte> out_;
  std::uint32_t sent_ = 0;
  std::uint32_t acknowledged_ = 0;
  std::uint32_t received_ = 0;
  bool owes_answer_ = false;
  int repeats_ = 0;  // since the last progress
  Duration interval_ = kRepeatFirst;
  Time repeat_at_ = kNever;
};

}  // namespace tims::link
