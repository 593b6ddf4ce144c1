// What the log says of links that come and go. One that does so again and again would fill it: its
// lines are held back then, and once a minute one line says what it is now and how many they were.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "router/config/config.h"
#include "router/core/event.h"
#include "router/io/log.h"
#include "tims/time.h"

namespace tims::io {

class LinkLog {
 public:
  using Write = std::function<void(config::LogLevel, std::string_view)>;
  explicit LinkLog(Write write) : write_(std::move(write)) {}
  explicit LinkLog(const Log& log);
  LinkLog(const LinkLog&) = delete;
  LinkLog& operator=(const LinkLog&) = delete;
  ~LinkLog();  // tells what is held back

  // kLinkUp, kLinkDown, kLinkPath and kUplinkChanged.
  void on_event(Time now, const core::Event& event);

  [[nodiscard]] Time next_timeout() const;
  void on_timeout(Time now);

 private:
  struct History {
    Time since{};  // begin of its minute
    std::uint32_t lines = 0;
    std::uint32_t held_back = 0;
    config::LogLevel level{};  // of its last line
    std::string text{};
  };

  void summarise(History& link);

  const Write write_;
  std::map<std::string, History, std::less<>> links_;  // that have changed within a minute
};

}  // namespace tims::io
