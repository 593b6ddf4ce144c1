// What the log says of links that come and go, and of what is refused to clients. A link that does
// so again and again would fill it, and so would a client that asks again and again for what it
// cannot have: lines of one link, or of one kind of refusal, are held back beyond six a minute, and
// once a minute one line says what came last and how many they were.
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

  void on_event(Time now, const core::Event& event, const AddressWidths& widths = {});

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

  [[nodiscard]] std::string key_of(const core::Event& event) const;
  void summarise(History& link);

  const Write write_;
  std::map<std::string, History, std::less<>> links_;  // and kinds, of the last minute
};

}  // namespace tims::io
