// The router's events as lines of the log, within bounds: what is said of links that come and go,
// and of what is refused to clients. A link that does so again and again would fill it, and so
// would a client that asks again and again for what it cannot have: lines of one link, or of one
// kind of refusal, are held back beyond six a minute, and once a minute one line says what came
// last and how many they were.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "router/config/config.h"
#include "router/core/statistics.h"
#include "router/io/log.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::io {

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
    LineLimit limit;
    config::LogLevel level{};  // of its last line
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
