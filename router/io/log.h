// Log lines on stderr. In the journal each has its priority, elsewhere the time. Never called for
// a message. A line may contain text from any source: it is escaped so that it remains a single
// line and contains no terminal control sequences. A reader that does not read blocks nothing:
// lines without room are dropped, and the next line states how many.
//
// The log cannot be flooded. A repeated line is written once and then summarised. Of the router's
// events, those of links that come and go and those of refused clients are limited to six per
// minute for each link or kind of refusal (LimitedLog); once a minute one line reports the last
// of them and their number.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include <unistd.h>

#include "router/config/config.h"
#include "router/core/statistics.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::io {

class Log {
 public:
  explicit Log(config::LogLevel level, int file = STDERR_FILENO);
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;
  ~Log();  // writes pending summaries

  void set_level(config::LogLevel level) { level_ = level; }

  [[nodiscard]] bool writes(config::LogLevel level) const { return level <= level_; }

  void error(std::string_view text) { write(config::LogLevel::kError, text); }
  void warning(std::string_view text) { write(config::LogLevel::kWarning, text); }
  void info(std::string_view text) { write(config::LogLevel::kInfo, text); }
  void debug(std::string_view text) { write(config::LogLevel::kDebug, text); }
  // Written however often it is repeated.
  void always(config::LogLevel level, std::string_view text) const {
    if (writes(level)) put(level, text);
  }

 private:
  struct Recent {
    std::string text{};
    config::LogLevel level{};
    Time written{};
    std::uint32_t held_back = 0;  // repetitions since then
  };

  void write(config::LogLevel level, std::string_view text);
  Recent& slot_for(std::string_view text, bool& known);
  void summarise(Recent& line);
  void put(config::LogLevel level, std::string_view text) const;

  config::LogLevel level_;
  int file_;
  bool journal_;
  std::array<Recent, 8> recent_;
  std::size_t oldest_ = 0;
  mutable std::uint64_t left_out_ = 0;  // lines dropped since the last one written
};

// Escapes control characters and invalid UTF-8, as "\\n" or "\\x1b"; truncates to kLogTextMax
// bytes.
inline constexpr std::size_t kLogTextMax = 2048;
std::string printable(std::string_view text);

class LimitedLog {
 public:
  using Write = std::function<void(config::LogLevel, std::string_view)>;
  explicit LimitedLog(Write write) : write_(std::move(write)) {}
  explicit LimitedLog(const Log& log);
  LimitedLog(const LimitedLog&) = delete;
  LimitedLog& operator=(const LimitedLog&) = delete;
  ~LimitedLog();  // reports suppressed lines

  void on_event(Time now, const core::Event& event, const AddressWidths& widths = {});
  // `key`: lines with the same one are limited together.
  void write(Time now, std::string_view key, config::LogLevel level, std::string text);

  [[nodiscard]] Time next_timeout() const;
  void on_timeout(Time now);

 private:
  struct History {
    Time begin{};  // start of this minute
    std::uint32_t lines = 0;
    std::uint64_t held_back = 0;  // since the last line
    config::LogLevel level{};     // of its last line
    std::string text{};
  };

  [[nodiscard]] std::string key_of(const core::Event& event) const;
  void summarise(History& history);

  const Write write_;
  std::map<std::string, History, std::less<>> histories_;  // by link or kind, for the last minute
};

// Decides which of the router's events are logged.
void log_event(Log& log, LimitedLog& limited_log, const core::Event& event,
               const AddressWidths& widths);

}  // namespace tims::io
