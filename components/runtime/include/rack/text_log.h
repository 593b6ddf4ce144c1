// Texts of a component for people: to the sink of the robot, and to standard error.
//
// Whoever writes a text only puts it into a ring, so that the data task never waits for a terminal
// or a socket; the component's main thread passes it on.
#pragma once

#include <array>
#include <atomic>
#include <mutex>

#include "components/runtime/logic/text_limiter.h"
#include "os/file.h"
#include "rack/priority_mutex.h"
#include "rack/proxies/gdos.h"
#include "tims/mailbox.h"

namespace rack {

class TextLog {
 public:
  explicit TextLog(gdos::Level threshold);

  // "%d %s %n": conversions as in gdos.h. Any thread; allocates nothing.
  template <typename... Args>
  void print(std::string_view format, const Args&... args) {
    write(gdos::Level::kPrint, format, {gdos::Argument(args)...});
  }
  template <typename... Args>
  void error(std::string_view format, const Args&... args) {
    write(gdos::Level::kError, format, {gdos::Argument(args)...});
  }
  template <typename... Args>
  void warning(std::string_view format, const Args&... args) {
    write(gdos::Level::kWarning, format, {gdos::Argument(args)...});
  }
  template <typename... Args>
  void info(std::string_view format, const Args&... args) {
    write(gdos::Level::kInfo, format, {gdos::Argument(args)...});
  }
  template <typename... Args>
  void detail(std::string_view format, const Args&... args) {
    write(gdos::Level::kDetail, format, {gdos::Argument(args)...});
  }
  void write(gdos::Level level, std::string_view format,
             std::initializer_list<gdos::Argument> arguments);

  void set_threshold(gdos::Level level) { threshold_.store(level, std::memory_order_relaxed); }

  // --- the main thread

  // Readable when texts wait.
  [[nodiscard]] int descriptor() const { return doorbell_.get(); }
  // Passes on what waits, with the sink's mailbox as destination, from `mailbox`.
  void pass_on(tims::Time now, tims::Mailbox& mailbox);

 private:
  struct Text {
    gdos::Level level{};
    std::uint16_t size = 0;
    gdos::Body body{};
  };
  static constexpr std::size_t kRing = 64;

  bool take(Text& text);
  void pass_on(const Text& text, tims::Mailbox& mailbox);
  void say_suppressed(tims::Mailbox& mailbox, std::uint32_t count);

  std::atomic<gdos::Level> threshold_;
  tims::os::File doorbell_;
  TextLimiter limiter_;
  PriorityMutex mutex_;  // what follows
  std::array<Text, kRing> ring_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::uint32_t lost_ = 0;  // the ring was full
};

}  // namespace rack
