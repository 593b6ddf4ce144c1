#include "components/runtime/logic/repeats.h"

#include <algorithm>
#include <utility>

namespace rack {

std::uint64_t without_numbers(std::string_view text) {
  std::uint64_t hash = 14695981039346656037U;  // FNV-1a
  char before = ' ';
  for (char c : text) {
    if (c >= '0' && c <= '9') c = '0';
    if (c != '0' || before != '0') hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
    before = c;
  }
  return hash;
}

RefusalLog::Verdict RefusalLog::take(tims::Time now, const tims::Header& request,
                                     std::string_view why) {
  const std::uint64_t key = without_numbers(why);
  auto known = std::ranges::find_if(known_, [&](const Known& any) {
    return any.key == key && any.from == request.src && any.type == request.type;
  });
  const bool is_new = known == known_.end();
  if (is_new) known = std::ranges::min_element(known_, {}, &Known::last);
  if (is_new) *known = {.key = key, .from = request.src, .type = request.type};
  known->last = now;
  if (!is_new && now - known->written < kReportEach) {
    ++known->repeats;
    return {};
  }
  known->written = now;
  return {.write = true, .repeats = std::exchange(known->repeats, 0)};
}

bool FailureLog::failed(std::string_view why) {
  const std::uint64_t reason = without_numbers(why);
  const bool was_on = std::exchange(on_, false);
  if (!any_ || std::ranges::find(reasons_, reason) == reasons_.end()) {
    reasons_[next_++ % reasons_.size()] = reason;
    any_ = true;
    returns_ = false;
    return true;
  }
  if (was_on && !std::exchange(returns_, true)) return true;
  ++repeats_;
  return false;
}

bool FailureLog::turned_on(tims::Time now) {
  on_ = true;
  on_since_ = now;
  says_on_later_ = returns_;
  return !returns_;
}

std::optional<std::uint32_t> FailureLog::settled(tims::Time now) {
  if (!any_ || now - on_since_ < kSettled) return std::nullopt;
  const bool says_on = says_on_later_;
  const std::uint32_t repeats = repeats_;
  *this = {};
  on_ = true;
  return says_on ? std::optional(repeats) : std::nullopt;
}

}  // namespace rack
