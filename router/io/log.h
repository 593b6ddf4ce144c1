// Lines for people on stderr. In the journal each carries its priority, elsewhere the time. Never
// called for a message. What is in a line may come from anybody: it is written so that it stays one
// line, and moves no terminal. A reader who does not read stops nobody: lines that find no room are
// left out, and the next one that does says how many.
//
// Nothing fills the log. A line that comes again and again is written once and then summarised.
// Of the router's events, those of links that come and go and of what is refused to clients are
// held back beyond six a minute of one link or of one kind of refusal (LimitedLog); once a minute
// one line says what came last and how many they were.
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
  ~Log();  // writes what is still to be summarised

  void set_level(config::LogLevel level) { level_ = level; }

  [[nodiscard]] bool writes(config::LogLevel level) const { return level <= level_; }

  void error(std::string_view text) { write(config::LogLevel::kError, text); }
  void warning(std::string_view text) { write(config::LogLevel::kWarning, text); }
  void info(std::string_view text) { write(config::LogLevel::kInfo, text); }
  void debug(std::string_view text) { write(config::LogLevel::kDebug, text); }
  // However often it comes.
  void always(config::LogLevel level, std::string_view text) const {
    if (writes(level)) put(level, text);
  }

 private:
  struct Recent {
    std::string text{};
    config::LogLevel level{};
    Time written{};
    std::uint32_t held_back = 0;  // times it came since
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
  mutable std::uint64_t left_out_ = 0;  // lines, since the last one that found room
};

// Control characters, and bytes that are no UTF-8, as "\\n", "\\x1b"; at most kLogTextMax bytes.
inline constexpr std::size_t kLogTextMax = 2048;
std::string printable(std::string_view text);

class LimitedLog {
 public:
  using Write = std::function<void(config::LogLevel, std::string_view)>;
  explicit LimitedLog(Write write) : write_(std::move(write)) {}
  explicit LimitedLog(const Log& log);
  LimitedLog(const LimitedLog&) = delete;
  LimitedLog& operator=(const LimitedLog&) = delete;
  ~LimitedLog();  // tells what is held back

  void on_event(Time now, const core::Event& event, const AddressWidths& widths = {});

  [[nodiscard]] Time next_timeout() const;
  void on_timeout(Time now);

 private:
  struct History {
    Time begin{};  // of this minute
    std::uint32_t lines = 0;
    std::uint64_t held_back = 0;  // since the last line
    config::LogLevel level{};     // of its last line
    std::string text{};
  };

  [[nodiscard]] std::string key_of(const core::Event& event) const;
  void summarise(History& history);

  const Write write_;
  std::map<std::string, History, std::less<>> histories_;  // by link or kind, of the last minute
};

// Which of the router's events become lines of the log.
void log_event(Log& log, LimitedLog& limited_log, const core::Event& event,
               const AddressWidths& widths);

}  // namespace tims::io
