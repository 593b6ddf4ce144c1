// Log texts of a component: to the log sink of the robot, and to standard error.
//
// Writing a text only puts it into a ring, so that the data task never waits for a terminal or a
// socket; the component's main thread sends it.
#pragma once

#include <atomic>
#include <initializer_list>
#include <memory>
#include <string_view>

#include "rack/proxies/gdos.h"
#include "tims/mailbox.h"
#include "tims/time.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

class TextLog {
 public:
  explicit TextLog(gdos::Level threshold);
  ~TextLog();

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

  // Readable when texts are pending.
  [[nodiscard]] int descriptor() const;
  // Sends the pending texts from `mailbox` to the mailbox of the sink.
  void pass_on(tims::Time now, tims::Mailbox& mailbox);

 private:
  struct [[gnu::visibility("hidden")]] Ring;

  std::atomic<gdos::Level> threshold_;
  std::unique_ptr<Ring> ring_;
};

}  // namespace rack

#pragma GCC visibility pop
