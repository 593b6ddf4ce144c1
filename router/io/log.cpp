#include "router/io/log.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>

#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include "os/clock.h"

namespace tims::io {
namespace {

using config::LogLevel;

constexpr Duration kSummaryInterval = std::chrono::seconds(10);

// The journal says so in $JOURNAL_STREAM; it may be a stderr of a parent that was redirected since.
bool stderr_is_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (stream == nullptr || ::fstat(STDERR_FILENO, &status) != 0) return false;
  return fmt::format("{}:{}", status.st_dev, status.st_ino) == stream;
}

int journal_priority(LogLevel level) {
  constexpr std::array kPriorities{3, 4, 6, 7};  // err, warning, info, debug
  return kPriorities[static_cast<std::size_t>(level)];
}

std::string_view word(LogLevel level) {
  constexpr std::array<std::string_view, 4> kWords{"error: ", "warning: ", "", "debug: "};
  return kWords[static_cast<std::size_t>(level)];
}

std::string local_time() {
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  tm parts{};
  ::localtime_r(&now.tv_sec, &parts);
  std::array<char, 32> text{};
  const std::size_t size = std::strftime(text.data(), text.size(), "%F %T", &parts);
  return fmt::format("{}.{:03}", std::string_view(text.data(), size), now.tv_nsec / 1'000'000);
}

}  // namespace

Log::Log(LogLevel level) : level_(level), journal_(stderr_is_journal()) {}

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

void Log::put(LogLevel level, std::string_view text) const {
  const std::string line =
      journal_ ? fmt::format("<{}>{}{}\n", journal_priority(level), word(level), text)
               : fmt::format("{} {}{}\n", local_time(), word(level), text);
  // Nothing can be done about a stderr that takes nothing.
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), line.size());
}

}  // namespace tims::io
