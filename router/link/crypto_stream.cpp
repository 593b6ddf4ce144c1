#include "router/link/crypto_stream.h"

#include <algorithm>

namespace tims::link {

bool CryptoStream::write(std::span<const std::byte> bytes) {
  if (out_.size() + bytes.size() > kBytesMax) return false;
  out_.insert(out_.end(), bytes.begin(), bytes.end());
  return true;
}

bool CryptoStream::receive(const Crypto& crypto, std::span<const std::byte>& bytes) {
  bytes = {};
  if (crypto.acknowledged > out_.size() || crypto.offset > kBytesMax ||
      crypto.offset + crypto.bytes.size() > kBytesMax)
    return false;
  if (crypto.acknowledged > acknowledged_) {
    acknowledged_ = crypto.acknowledged;
    sent_ = std::max(sent_, acknowledged_);
    repeats_ = 0;
    interval_ = kRepeatFirst;
    repeat_at_ = kNever;
  }
  if (crypto.bytes.empty()) return true;
  owes_answer_ = true;
  const std::size_t end = crypto.offset + crypto.bytes.size();
  if (crypto.offset > received_ || end <= received_) return true;
  bytes = crypto.bytes.subspan(received_ - crypto.offset);
  received_ = static_cast<std::uint32_t>(end);
  return true;
}

void CryptoStream::repeat() {
  sent_ = acknowledged_;
  ++repeats_;
  interval_ = std::min<Duration>(2 * interval_, kRepeatMax);
  repeat_at_ = kNever;
}

}  // namespace tims::link
