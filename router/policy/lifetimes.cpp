#include "router/policy/lifetimes.h"

#include <algorithm>

#include "base/measure.h"
#include "base/text.h"

namespace tims::policy {

bool Lifetimes::add(std::string_view text) {
  text = base::trimmed(text);
  const std::size_t space = std::min(text.find(' '), text.size());
  const auto what = TypePattern::parse(text.substr(0, space));
  const auto time = base::parse_duration(base::trimmed(text.substr(space)));
  if (!what || !time || *time < kShortest || *time > kLongest || items_.size() >= kMost)
    return false;
  items_.push_back({*what, *time});
  return true;
}

Duration Lifetimes::find(const Header& header) const {
  const Query query{.dest = header.dest, .src = header.src, .type = header.type};
  const std::uint16_t class_id = query.class_id(widths_);
  const auto found = std::ranges::find_if(
      items_, [&](const Item& item) { return item.what.matches(query, class_id); });
  return found == items_.end() ? kForever : found->time;
}

}  // namespace tims::policy
