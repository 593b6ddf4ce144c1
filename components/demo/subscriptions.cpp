#include "components/demo/subscriptions.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

namespace tims::demo {

namespace {

std::uint32_t number_at(const Header& header, std::span<const std::byte> body, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, body.data() + at, sizeof value);
  return header.body_order() == std::endian::native ? value : __builtin_bswap32(value);
}

}  // namespace

std::optional<std::uint32_t> Subscriptions::add(const Header& request,
                                                std::span<const std::byte> body,
                                                std::uint32_t sample_ms) {
  if (body.size() < 8) return std::nullopt;
  const Address data_mailbox(number_at(request, body, 4));
  std::erase_if(list_, [&](const Subscriber& s) { return s.data_mailbox == data_mailbox; });
  if (list_.size() == kMax) return std::nullopt;
  // Shorter than a sample, and 0, mean every sample; else the next lower multiple.
  const std::uint32_t asked = number_at(request, body, 0);
  const std::uint32_t granted = std::max(asked / sample_ms, 1U) * sample_ms;
  // Half a sample early: a sample that comes a little before its time is the one that was meant.
  const Duration period = granted == sample_ms ? Duration{}
                                               : std::chrono::milliseconds(granted) -
                                                     std::chrono::milliseconds(sample_ms) / 2;
  list_.push_back({data_mailbox, request.priority, request.seq_nr, period, Time{}});
  return granted;
}

void Subscriptions::remove(const Header& request, std::span<const std::byte> body) {
  if (body.size() < 4) return;
  const Address data_mailbox(number_at(request, body, 0));
  std::erase_if(list_, [&](const Subscriber& s) { return s.data_mailbox == data_mailbox; });
}

}  // namespace tims::demo
