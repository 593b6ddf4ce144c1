#include "components/gdos_log/text_flood.h"

namespace rack::gdos_log {
namespace {

constexpr tims::Address kEverybodyElse{0};

}  // namespace

bool TextFlood::take(tims::Time now, tims::Address sender, gdos::Level level) {
  Sender& from = find(now, sender);
  tims::base::LineLimiter& limiter = level >= gdos::Level::kWarning ? from.urgent : from.other;
  if (limiter.take(now)) return true;
  if (!any_suppressed_) next_word_ = now + kTellEach;
  any_suppressed_ = true;
  return false;
}

TextFlood::Sender& TextFlood::find(tims::Time now, tims::Address sender) {
  const auto known = senders_.find(sender);
  if (known != senders_.end()) return known->second;
  if (senders_.size() >= kSendersMax) {
    std::erase_if(senders_, [now](const auto& entry) {
      return entry.second.urgent.is_idle(now) && entry.second.other.is_idle(now);
    });
  }
  return senders_[senders_.size() < kSendersMax ? sender : kEverybodyElse];
}

std::vector<TextFlood::Suppressed> TextFlood::take_suppressed(tims::Time now) {
  std::vector<Suppressed> all;
  if (!any_suppressed_ || now < next_word_) return all;
  any_suppressed_ = false;
  for (auto& [address, sender] : senders_) {
    const std::uint32_t count = sender.urgent.take_held_back() + sender.other.take_held_back();
    if (count > 0) all.push_back({address, count});
  }
  return all;
}

}  // namespace rack::gdos_log
