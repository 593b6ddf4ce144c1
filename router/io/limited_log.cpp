#include "router/io/limited_log.h"

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

LimitedLog::LimitedLog(const Log& log)
    : LimitedLog([&log](LogLevel level, std::string_view text) { log.always(level, text); }) {}

LimitedLog::~LimitedLog() {
  for (auto& [name, history] : histories_) summarise(history);
}

std::string LimitedLog::key_of(const core::Event& event) const {
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
  return histories_.size() < kLinksMax || histories_.contains(name) ? name : "link";
}

void LimitedLog::on_event(Time now, const core::Event& event, const AddressWidths& widths) {
  const auto [at, first] = histories_.try_emplace(key_of(event));
  History& history = at->second;
  if (first) history.since = now;
  history.level = is_news(event.kind) ? LogLevel::kInfo : LogLevel::kWarning;
  history.text = event_text(event, widths);
  if (history.lines == kLinesMax) {
    ++history.held_back;
    return;
  }
  ++history.lines;
  write_(history.level, history.text);
}

Time LimitedLog::next_timeout() const {
  Time next = kNever;
  for (const auto& [name, history] : histories_) next = std::min(next, history.since + kInterval);
  return next;
}

// Who was held back has to be quiet for a while before its lines are written again.
void LimitedLog::on_timeout(Time now) {
  for (auto at = histories_.begin(); at != histories_.end();) {
    History& history = at->second;
    const bool over = now >= history.since + kInterval;
    if (over && history.held_back == 0) {
      at = histories_.erase(at);
      continue;
    }
    if (over) {
      summarise(history);
      history.since = now;
    }
    ++at;
  }
}

void LimitedLog::summarise(History& history) {
  if (history.held_back == 0) return;
  write_(history.level, fmt::format("{} ({} lines like this were held back)", history.text,
                                    std::exchange(history.held_back, 0)));
}

}  // namespace tims::io
