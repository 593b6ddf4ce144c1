// Log texts of a component: to the log sink of the robot, and to standard error.
//
//   log().warning("{} has sent no data for {} ms", address, waited.count());
//
// The compiler checks formats (those of fmt and std::format). Writing a text only formats it into a
// ring, so that the data task never waits for a terminal or a socket; the component's main thread
// sends it.
#pragma once

#include <atomic>
#include <memory>
#include <type_traits>

#include <fmt/core.h>

#include "rack/address_text.h"
#include "rack/proxies/gdos.h"
#include "tims/mailbox.h"
#include "tims/time.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

class TextLog {
  template <typename Arg>
  using Shown = std::conditional_t<std::is_same_v<Arg, tims::Address>, AddressText, Arg>;

 public:
  template <typename... Args>
  using Format = fmt::format_string<Shown<Args>...>;

  explicit TextLog(gdos::Level threshold);
  ~TextLog();

  // Any thread; allocates nothing. A text is cut at 255 bytes.
  template <typename... Args>
  void print(Format<Args...> format, const Args&... args) {
    write<Args...>(gdos::Level::kPrint, format, args...);
  }
  template <typename... Args>
  void error(Format<Args...> format, const Args&... args) {
    write<Args...>(gdos::Level::kError, format, args...);
  }
  template <typename... Args>
  void warning(Format<Args...> format, const Args&... args) {
    write<Args...>(gdos::Level::kWarning, format, args...);
  }
  template <typename... Args>
  void info(Format<Args...> format, const Args&... args) {
    write<Args...>(gdos::Level::kInfo, format, args...);
  }
  template <typename... Args>
  void detail(Format<Args...> format, const Args&... args) {
    write<Args...>(gdos::Level::kDetail, format, args...);
  }
  template <typename... Args>
  void write(gdos::Level level, Format<Args...> format, const Args&... args) {
    format_and_queue(level, format, shown(args)...);
  }

  void set_threshold(gdos::Level level) { threshold_.store(level, std::memory_order_relaxed); }
  // Those of the fleet, as soon as they are known: for addresses in texts.
  void set_widths(tims::AddressWidths widths) { widths_.store(widths, std::memory_order_relaxed); }

  // --- the main thread

  // Readable when texts are pending.
  [[nodiscard]] int descriptor() const;
  // Sends the pending texts from `mailbox` to the mailbox of the sink.
  void pass_on(tims::Time now, tims::Mailbox& mailbox);

 private:
  struct [[gnu::visibility("hidden")]] Ring;

  template <typename Arg>
  [[nodiscard]] const Arg& shown(const Arg& arg) const {
    return arg;
  }
  [[nodiscard]] AddressText shown(tims::Address arg) const {
    return {arg, widths_.load(std::memory_order_relaxed)};
  }
  template <typename... Args>
  void format_and_queue(gdos::Level level, fmt::string_view format, const Args&... args) {
    queue(level, format, fmt::make_format_args(args...));
  }
  void queue(gdos::Level level, fmt::string_view format, fmt::format_args arguments);

  std::atomic<gdos::Level> threshold_;
  std::atomic<tims::AddressWidths> widths_{};
  std::unique_ptr<Ring> ring_;
};

}  // namespace rack

#pragma GCC visibility pop
