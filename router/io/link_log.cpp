#include "router/io/link_log.h"

#include <algorithm>

#include <fmt/core.h>

#include "router/io/report_json.h"

namespace tims::io {
namespace {

using config::LogLevel;
using core::EventKind;

constexpr Duration kInterval = std::chrono::minutes(1);
constexpr std::uint32_t kLinesMax = 6;  // of a link, or of a kind, in that time
constexpr std::size_t kLinksMax = 256;

// Else something is wrong.
bool is_news(EventKind kind) {
  return kind == EventKind::kLinkUp || kind == EventKind::kLinkPath ||
         kind == EventKind::kUplinkChanged;
}

}  // namespace

LinkLog::LinkLog(const Log& log)
    : LinkLog([&log](LogLevel level, std::string_view text) { log.always(level, text); }) {}

LinkLog::~LinkLog() {
  for (auto& [name, link] : links_) summarise(link);
}

std::string LinkLog::key_of(const core::Event& event) const {
  switch (event.kind) {
    case EventKind::kLinkUp:
    case EventKind::kLinkDown:
    case EventKind::kLinkPath:
      break;
    default:
      return std::string(core::name(event.kind));
  }
  // Names of links are texts of others; with so many, those that are new share their lines.
  const std::string name = fmt::format("link {}", event.client.name.view());
  return links_.size() < kLinksMax || links_.contains(name) ? name : "link";
}

void LinkLog::on_event(Time now, const core::Event& event, const AddressWidths& widths) {
  const auto [at, first] = links_.try_emplace(key_of(event));
  History& link = at->second;
  if (first) link.since = now;
  link.level = is_news(event.kind) ? LogLevel::kInfo : LogLevel::kWarning;
  link.text = event_text(event, widths);
  if (link.lines == kLinesMax) {
    ++link.held_back;
    return;
  }
  ++link.lines;
  write_(link.level, link.text);
}

Time LinkLog::next_timeout() const {
  Time next = kNever;
  for (const auto& [name, link] : links_) next = std::min(next, link.since + kInterval);
  return next;
}

// Who was held back has to be quiet for a while before its lines are written again.
void LinkLog::on_timeout(Time now) {
  for (auto at = links_.begin(); at != links_.end();) {
    History& link = at->second;
    const bool over = now >= link.since + kInterval;
    if (over && link.held_back == 0) {
      at = links_.erase(at);
      continue;
    }
    if (over) {
      summarise(link);
      link.since = now;
    }
    ++at;
  }
}

void LinkLog::summarise(History& link) {
  if (link.held_back == 0) return;
  write_(link.level, fmt::format("{} ({} lines like this were held back)", link.text,
                                 std::exchange(link.held_back, 0)));
}

}  // namespace tims::io
