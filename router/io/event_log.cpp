#include "router/io/event_log.h"

#include <algorithm>

#include <fmt/core.h>

#include "router/io/reports.h"

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
  const auto [at, first] = histories_.try_emplace(key_of(event), History{{kLinesMax, kInterval}});
  History& history = at->second;
  if (first) history.limit.begin(now);
  history.level = is_news(event.kind) ? LogLevel::kInfo : LogLevel::kWarning;
  history.text = event_text(event, widths);
  if (history.limit.take()) write_(history.level, history.text);
}

Time LimitedLog::next_timeout() const {
  Time next = kNever;
  for (const auto& [name, history] : histories_) next = std::min(next, history.limit.end());
  return next;
}

// Who was held back has to be quiet for a while before its lines are written again.
void LimitedLog::on_timeout(Time now) {
  for (auto at = histories_.begin(); at != histories_.end();) {
    History& history = at->second;
    const bool over = now >= history.limit.end();
    if (over && history.limit.held_back() == 0) {
      at = histories_.erase(at);
      continue;
    }
    if (over) {
      summarise(history);
      history.limit.begin(now);
    }
    ++at;
  }
}

void LimitedLog::summarise(History& history) {
  if (history.limit.held_back() == 0) return;
  write_(history.level, fmt::format("{} ({} lines like this were held back)", history.text,
                                    history.limit.take_held_back()));
}

void log_event(Log& log, LimitedLog& limited_log, const core::Event& event,
               const AddressWidths& widths) {
  using Kind = core::EventKind;
  switch (event.kind) {
    // A guest can cause any number of these, each with another text.
    case Kind::kClientRefused:
    case Kind::kAddressRefused:
    case Kind::kMailboxLimit:
    case Kind::kDeleteRefused:
    case Kind::kWatchdogClosed:
    case Kind::kProtocolError:
    case Kind::kLinkRefused:
    case Kind::kDuplicateAddress:
    case Kind::kDuplicateRouter:
    case Kind::kLoop:
    case Kind::kLinkUp:
    case Kind::kLinkDown:
    case Kind::kLinkPath:
    case Kind::kUplinkChanged:
      return limited_log.on_event(event.at, event, widths);
    default:
      // A restart of the fleet brings a hundred thousand of these.
      if (log.writes(config::LogLevel::kDebug)) log.debug(event_text(event, widths));
  }
}

}  // namespace tims::io
