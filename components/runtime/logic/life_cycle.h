// The life cycle of a component (specification, section 5.2): its next step, and the answers to
// requests.
//
// ON and OFF set the target state at any time. The steps follow in order: the component is turned
// on, loops, is turned off. A failing step puts it into the error state; it is tried again after
// some seconds, until it succeeds or is turned off. ON is answered when the component is on, or
// could not be turned on; OFF immediately.
//
// Unlike in the original:
//   - An operator's OFF holds: components that need this one do not turn it on again.
//   - OFF is always carried out, also if ON follows at once.
//   - Several requests of ON may wait for the same result, if their senders know that.
//   - In the first seconds of a program, a partner that does not exist yet is waited for: the
//     programs of a robot start in any order.
//
// Pure. The command task passes commands, the data task requests steps and reports their results;
// the module's mutex serialises the calls (module.cpp).
#pragma once

#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "rack/proxies/generic.h"
#include "tims/message.h"
#include "tims/time.h"

namespace rack {

class LifeCycle {
 public:
  // error_retry: delay after an error, at least 10 ms; nothing: 2 to 4 seconds, random each time.
  LifeCycle(std::optional<tims::Duration> error_retry, std::uint32_t seed);

  // --- the command task

  // The origin of a command: an operator's program, or another component that needs this one.
  enum class By : std::uint8_t { kOperator, kComponent };
  // ON. Returns the type of an immediate answer; nothing: the data task answers `request` when the
  // component is on, or could not be turned on. After an error it is tried immediately. kError: an
  // operator has turned it off and another component requests ON; or an earlier ON is in progress,
  // and the sender is a program of the original, which does not wait for that (`may_wait`).
  std::optional<std::int8_t> turn_on(tims::Time now, const tims::Header& request, By by,
                                     bool may_wait = false);
  // At the start of the program, without an answer.
  void turn_on() { wants_on_ = true; }
  // Until then, a missing partner is waited for.
  void wait_for_partners(tims::Time until) { partners_until_ = until; }
  static constexpr std::size_t kWaitingMax = 32;  // requests of ON
  // OFF is always answered kOk immediately; an operator's OFF also holds. Returns the requests of
  // pending ON, which are to be answered kError.
  std::vector<tims::Header> turn_off(const tims::Header& request, By by);
  // Restores the OFF of the operator's program `by` from before a crash.
  void hold_off(tims::Address by) { held_off_by_ = by; }
  // The operator's program whose OFF holds, if any.
  [[nodiscard]] std::optional<tims::Address> held_off_by() const { return held_off_by_; }
  [[nodiscard]] bool wants_on() const { return wants_on_; }
  [[nodiscard]] Status status() const;

  // --- the data task

  enum class Step : std::uint8_t {
    kWait,  // until wait_until(), or until a command is received
    kTurnOn,
    kLoop,
    kTurnOff,
  };
  [[nodiscard]] Step next(tims::Time now);
  [[nodiscard]] tims::Time wait_until() const;

  // The result of a step.
  struct Change {
    enum class Kind : std::uint8_t {
      kNone,
      kOn,
      kOff,
      kCannotTurnOn,  // clean up with module_off
      kWaits,         // for a partner: clean up with module_off
      kError,         // failed while on: clean up with module_off
    };
    Kind kind = Kind::kNone;
    // Requests of ON, and the answer to them.
    std::vector<tims::Header> requests{};
    std::int8_t answer = tims::type::kOk;
  };
  enum class Turned : std::uint8_t { kOn, kFailed, kPartnerIsMissing };
  Change turned_on(tims::Time now, Turned result);
  Change looped(tims::Time now, bool success);
  Change turned_off();

 private:
  enum class State : std::uint8_t { kDisabled, kEnabled, kErrorWait };

  Change change(Change::Kind kind, std::int8_t answer);
  void fail(tims::Time now);

  std::optional<tims::Duration> error_retry_;
  std::minstd_rand random_;
  State state_ = State::kDisabled;
  bool wants_on_ = false;
  bool must_turn_off_ = false;  // an OFF has not been carried out yet
  bool by_operator_ = false;    // an operator waits for the answer to ON
  tims::Time retry_at_{};
  tims::Time partners_until_{};
  std::vector<tims::Header> requests_;  // pending ON
  std::optional<tims::Address> held_off_by_;
};

}  // namespace rack
