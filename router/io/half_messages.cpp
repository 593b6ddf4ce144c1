#include "router/io/half_messages.h"

namespace tims::io {

void HalfMessages::set(Time now, std::uint32_t token, std::uint64_t bytes) {
  if (bytes <= kStepBytes && holders_.empty()) return;
  auto at = std::ranges::find(holders_, token, &Holder::token);
  if (bytes <= kStepBytes) {
    if (at == holders_.end()) return;
    bytes_ -= at->bytes;
    holders_.erase(at);
    return;
  }
  if (at == holders_.end()) at = holders_.insert(at, {.token = token, .since = now});
  bytes_ += bytes - at->bytes;
  at->bytes = bytes;
  // Less than before: another message. Who sends byte by byte does not win time.
  if (bytes < at->noted || bytes >= at->noted + kStepBytes) {
    at->noted = bytes;
    at->since = now;
  }
}

std::optional<HalfMessages::Victim> HalfMessages::victim() const {
  if (bytes_ <= bytes_max_) return std::nullopt;
  const Holder* victim = nullptr;
  for (const Holder& holder : holders_) {
    if (holder.bytes * holders_.size() < bytes_) continue;
    if (victim == nullptr || holder.since < victim->since) victim = &holder;
  }
  return Victim{victim->token, victim->bytes};
}

}  // namespace tims::io
