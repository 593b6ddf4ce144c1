#include "router/io/log.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>

#include <fmt/core.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include "os/clock.h"

namespace tims::io {
namespace {

using config::LogLevel;

constexpr Duration kSummaryInterval = std::chrono::seconds(10);

// The journal says so in $JOURNAL_STREAM; it may be a stderr of a parent that was redirected since.
bool is_journal(int file) {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (stream == nullptr || ::fstat(file, &status) != 0) return false;
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

// There is room for a line where poll() says so: lines are shorter than what pipes (a page),
// terminals and sockets then have. The file is shared with other programs, so it stays blocking.
void Log::put(LogLevel level, std::string_view text) const {
  pollfd ready{.fd = file_, .events = POLLOUT, .revents = 0};
  if (::poll(&ready, 1, 0) == 0) {
    ++left_out_;
    return;
  }
  const std::string before =
      left_out_ == 0 ? "" : fmt::format(" ({} lines before this one were left out)", left_out_);
  left_out_ = 0;
  const std::string line =
      journal_ ? fmt::format("<{}>{}{}{}\n", journal_priority(level), word(level), printable(text),
                             before)
               : fmt::format("{} {}{}{}\n", local_time(), word(level), printable(text), before);
  // Nothing can be done about a stderr that takes nothing.
  [[maybe_unused]] const auto written = ::write(file_, line.data(), line.size());
}

namespace {

// Of the character at the beginning of `text`, in bytes; 0 when it is not to be printed.
std::size_t printable_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x80) return byte(0) >= 0x20 && byte(0) != 0x7F ? 1 : 0;
  const std::size_t length = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : 2;
  if (byte(0) < 0xC2 || byte(0) > 0xF4 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if (byte(i) >> 6 != 2) return 0;
  const bool control = byte(0) == 0xC2 && byte(1) < 0xA0;
  // U+2028 to U+202E, U+2066 to U+2069: line ends, and what turns the direction of writing.
  const bool turns = text.starts_with("\xE2\x80") && byte(2) >= 0xA8 && byte(2) <= 0xAE;
  const bool isolates = text.starts_with("\xE2\x81") && byte(2) >= 0xA6 && byte(2) <= 0xA9;
  return control || turns || isolates ? 0 : length;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    if (out.size() >= kLogTextMax - 7) return out + "...";
    const std::size_t length = printable_length(text);
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

}  // namespace tims::io
