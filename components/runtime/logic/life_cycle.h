// The life of a component (specification, section 5.2): what it is to do next, and who is answered.
//
// ON and OFF say what is wanted, at any moment. What it leads to are steps, one after the other:
// the component is turned on, loops, is turned off. One that fails puts it into error; it is then
// tried again after some seconds, until it works or nobody wants it on. ON is answered when the
// component is on, or could not be turned on; OFF at once. Other than in the original, the OFF of
// an operator holds: components that need this one do not turn it on again.
//
// Pure. The command task brings commands, the data task asks for steps and says how they went; the
// module's mutex sees to it that they do so one after the other (module.cpp).
#pragma once

#include <cstdint>
#include <optional>
#include <random>

#include "rack/proxies/generic.h"
#include "tims/message.h"
#include "tims/time.h"

namespace rack {

class LifeCycle {
 public:
  // error_retry: how long to wait after an error; nothing: 2 to 4 seconds, drawn anew each time.
  LifeCycle(std::optional<tims::Duration> error_retry, std::uint32_t seed);

  // --- the command task

  // Who commands: a person, with a program for people, or another component that needs this one.
  enum class By : std::uint8_t { kOperator, kComponent };
  // ON. The type to answer with now; nothing: the data task answers `request` when it is on, or
  // when it could not be turned on. After an error it is tried at once. kError: an earlier ON is
  // under way, or it is held off and only another component wants it on.
  std::optional<std::int8_t> turn_on(tims::Time now, const tims::Header& request, By by);
  void turn_on() { wants_on_ = true; }  // nobody waits for an answer
  // OFF is always answered kOk at once; an operator's also holds. Returns the request of an ON that
  // will not come about now, which is to be answered kError.
  std::optional<tims::Header> turn_off(const tims::Header& request, By by);
  // As if the operator's program `by` had turned it off: it did, before this one crashed.
  void hold_off(tims::Address by) { held_off_by_ = by; }
  // The operator's program that has turned it off, when none has turned it on since.
  [[nodiscard]] std::optional<tims::Address> held_off_by() const { return held_off_by_; }
  [[nodiscard]] bool wants_on() const { return wants_on_; }
  [[nodiscard]] Status status() const;

  // --- the data task

  enum class Step : std::uint8_t {
    kWait,  // until wait_until(), or until a command has come
    kTurnOn,
    kLoop,
    kTurnOff,
  };
  [[nodiscard]] Step next(tims::Time now);
  [[nodiscard]] tims::Time wait_until() const;

  // What a step led to.
  struct Change {
    enum class Kind : std::uint8_t {
      kNone,
      kOn,
      kOff,
      kCannotTurnOn,  // clean up with module_off
      kError,         // while it was on: clean up with module_off
    };
    Kind kind = Kind::kNone;
    // A waiting ON, and the answer to it.
    std::optional<tims::Header> request{};
    std::int8_t answer = tims::type::kOk;
  };
  Change turned_on(tims::Time now, bool success);
  Change looped(tims::Time now, bool success);
  Change turned_off();

 private:
  enum class State : std::uint8_t { kDisabled, kEnabled, kErrorWait };

  Change change(Change::Kind kind, std::int8_t answer);
  void fail(tims::Time now);

  const std::optional<tims::Duration> error_retry_;
  std::minstd_rand random_;
  State state_ = State::kDisabled;
  bool wants_on_ = false;
  tims::Time retry_at_{};
  std::optional<tims::Header> request_;  // ON, not answered yet
  std::optional<tims::Address> held_off_by_;
};

}  // namespace rack
