#include "router/io/log.h"

#include <algorithm>
#include <utility>

#include <fmt/core.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/measure.h"
#include "base/text.h"
#include "os/clock.h"
#include "os/environment.h"
#include "router/io/event_text.h"

namespace tims::io {
namespace {

using config::LogLevel;
using core::EventKind;

constexpr Duration kSummaryInterval = std::chrono::seconds(10);

// $JOURNAL_STREAM names the journal's file; a parent may have redirected stderr since it was set.
bool is_journal(int file) {
  const std::string stream = os::environment("JOURNAL_STREAM");
  struct stat status {};
  if (stream.empty() || ::fstat(file, &status) != 0) return false;
  return fmt::format("{}:{}", status.st_dev, status.st_ino) == stream;
}

int journal_priority(LogLevel level) {
  constexpr std::array kPriorities{3, 4, 6, 7};  // err, warning, info, debug
  return kPriorities[static_cast<std::size_t>(level)];
}

std::string_view prefix(LogLevel level) {
  constexpr std::array<std::string_view, 4> kPrefixes{"error: ", "warning: ", "", "debug: "};
  return kPrefixes[static_cast<std::size_t>(level)];
}

std::string local_time() {
  const auto now = os::wall_now();
  const auto local = now + os::utc_offset(now);
  return base::date(local) + " " + base::time_of_day(local);
}

// False for terminal control characters, line separators (U+2028) and characters that change the
// writing direction.
bool may_be_shown(std::uint32_t code) {
  const bool turns = code >= 0x2028 && code <= 0x202E;
  const bool isolates = code >= 0x2066 && code <= 0x2069;
  return !base::is_control(code) && !turns && !isolates;
}

constexpr Duration kInterval = std::chrono::minutes(1);
constexpr std::uint32_t kLinesMax = 6;  // per link or kind, in that time
constexpr std::size_t kLinksMax = 256;

// Other events are problems.
bool is_routine(EventKind kind) {
  return kind == EventKind::kLinkUp || kind == EventKind::kLinkPath ||
         kind == EventKind::kLinkRenamed || kind == EventKind::kUplinkChanged ||
         kind == EventKind::kPolicyChanged || kind == EventKind::kRouterChanged;
}

}  // namespace

Log::Log(LogLevel level, int file) : level_(level), file_(file), journal_(is_journal(file)) {}

Log::~Log() {
  for (Recent& line : recent_) summarise(line);
}

void Log::write(LogLevel level, std::string_view text) {
  if (level > level_) return;
  const Time now = os::now();
  bool known = false;
  Recent& line = slot_for(text, known);
  if (known) {
    ++line.held_back;
    if (now - line.written >= kSummaryInterval) {
      summarise(line);
      line.written = now;
    }
    return;
  }
  summarise(line);
  line = {.text = std::string(text), .level = level, .written = now};
  put(level, text);
}

Log::Recent& Log::slot_for(std::string_view text, bool& known) {
  const auto found = std::ranges::find(recent_, text, &Recent::text);
  known = found != recent_.end();
  if (known) return *found;
  Recent& oldest = recent_[oldest_];
  oldest_ = (oldest_ + 1) % recent_.size();
  return oldest;
}

void Log::summarise(Recent& line) {
  if (line.held_back == 0) return;
  put(line.level, fmt::format("{} ({} more times)", line.text, line.held_back));
  line.held_back = 0;
}

// Write only when poll() reports room: a line is shorter than the room that pipes (a page),
// terminals and sockets then have. The file is shared with other programs, so it stays blocking.
void Log::put(LogLevel level, std::string_view text) const {
  pollfd ready{.fd = file_, .events = POLLOUT, .revents = 0};
  if (::poll(&ready, 1, 0) == 0) {
    ++left_out_;
    return;
  }
  const std::string before =
      left_out_ == 0 ? "" : fmt::format(" ({} lines before this one were dropped)", left_out_);
  left_out_ = 0;
  const std::string line =
      journal_ ? fmt::format("<{}>{}{}{}\n", journal_priority(level), prefix(level),
                             printable(text), before)
               : fmt::format("{} {}{}{}\n", local_time(), prefix(level), printable(text), before);
  // An error of stderr cannot be reported anywhere.
  [[maybe_unused]] const auto written = ::write(file_, line.data(), line.size());
}

std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    if (out.size() >= kLogTextMax - 7) return out + "...";
    const base::Character c = base::first_character(text);
    const std::size_t length = may_be_shown(c.code) ? c.bytes : 0;
    if (length > 0)
      out += text.substr(0, length);
    else if (text.front() == '\n')
      out += "\\n";
    else
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

// --- the router's events

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
    case EventKind::kLinkRenamed:
      break;
    default:
      return std::string(core::name(event.kind));
  }
  // Names of links are untrusted texts; beyond a maximum number, new names share one history.
  const std::string name = fmt::format("link {}", event.client.name.view());
  return histories_.size() < kLinksMax || histories_.contains(name) ? name : "link";
}

void LimitedLog::on_event(Time now, const core::Event& event, const AddressWidths& widths) {
  write(now, key_of(event), is_routine(event.kind) ? LogLevel::kInfo : LogLevel::kWarning,
        event_text(event, widths));
}

void LimitedLog::write(Time now, std::string_view key, LogLevel level, std::string text) {
  const auto [at, first] = histories_.try_emplace(std::string(key));
  History& history = at->second;
  if (first) history.begin = now;
  history.level = level;
  history.text = std::move(text);
  if (history.lines == kLinesMax) {
    ++history.held_back;
  } else {
    ++history.lines;
    write_(history.level, history.text);
  }
}

Time LimitedLog::next_timeout() const {
  Time next = kNever;
  for (const auto& [name, history] : histories_) next = std::min(next, history.begin + kInterval);
  return next;
}

// Suppression ends after a quiet period.
void LimitedLog::on_timeout(Time now) {
  for (auto at = histories_.begin(); at != histories_.end();) {
    History& history = at->second;
    const bool over = now >= history.begin + kInterval;
    if (over && history.held_back == 0) {
      at = histories_.erase(at);
      continue;
    }
    if (over) {
      summarise(history);
      history.begin = now;
    }
    ++at;
  }
}

void LimitedLog::summarise(History& history) {
  if (history.held_back == 0) return;
  write_(history.level, fmt::format("{} ({} similar lines were suppressed)", history.text,
                                    std::exchange(history.held_back, 0)));
}

void log_event(Log& log, LimitedLog& limited_log, const core::Event& event,
               const AddressWidths& widths) {
  using Kind = core::EventKind;
  switch (event.kind) {
    // A client can cause any number of these, each with a different text.
    case Kind::kClientRefused:
    case Kind::kAddressRefused:
    case Kind::kMailboxLimit:
    case Kind::kDeleteRefused:
    case Kind::kWatchdogClosed:
    case Kind::kProtocolError:
    case Kind::kMemoryClosed:
    case Kind::kLinkRefused:
    case Kind::kDuplicateAddress:
    case Kind::kDuplicateRouter:
    case Kind::kLoop:
    case Kind::kLinkUp:
    case Kind::kLinkDown:
    case Kind::kLinkPath:
    case Kind::kLinkRenamed:
    case Kind::kUplinkChanged:
    case Kind::kDenied:
    case Kind::kObserved:
    case Kind::kPolicyChanged:
    case Kind::kRouterChanged:
      return limited_log.on_event(event.at, event, widths);
    default:
      // A restart of the fleet causes a hundred thousand of these.
      if (log.writes(config::LogLevel::kDebug)) log.debug(event_text(event, widths));
  }
}

}  // namespace tims::io
