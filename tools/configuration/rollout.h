// A change on several hosts, from the side of who makes it: which host is asked what next. All
// hosts are locked before the first is changed, leaves of the tree before their super routers; the
// confirmation goes over a connection that was made after the last change. If anything fails before
// all are confirmed, all hosts go back; who cannot be told does so by itself (host_change.h). Pure:
// questions come out, answers go in.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tims/time.h"

namespace timsctl::configuration {

class Rollout {
 public:
  enum class Ask : std::uint8_t {
    kLock,
    kApply,      // answered when the host has written the change
    kWait,       // its state, until it is `waiting`
    kReconnect,  // of the connection; no host
    kVerify,     // its state over the new connection: still `waiting`
    kConfirm,
    kSettle,  // its state, until it is `idle`
    kUndo,
    kUnlock,
    kNothing,  // it is over
  };
  struct Question {
    Ask ask = Ask::kNothing;
    std::size_t host = 0;
    bool operator==(const Question&) const = default;
  };
  enum class Answer : std::uint8_t {
    kDone,
    kNotYet,  // of kWait and kSettle: to be asked again
    kWentBack,
    kRefused,  // also: no answer
  };

  // `hosts`: in the order in which they are to be changed.
  explicit Rollout(std::size_t hosts) : hosts_(hosts) {}

  [[nodiscard]] Question next() const { return {ask_, host_}; }
  // `text`: why not.
  void take(Answer answer, const std::string& text = {});
  // Ctrl-C: all that were changed go back.
  void stop(const std::string& reason) { fail(reason); }

  [[nodiscard]] bool is_over() const { return ask_ == Ask::kNothing; }
  // When it is over: whether all hosts are confirmed.
  [[nodiscard]] bool is_kept() const { return failure_.empty(); }
  [[nodiscard]] const std::string& failure() const { return failure_; }
  // Whether a host may have been changed, so that it is to be watched until it has gone back.
  [[nodiscard]] bool has_begun() const { return applied_ > 0; }

 private:
  void fail(const std::string& reason);
  void begin(Ask ask) {
    ask_ = ask;
    host_ = 0;
  }
  void go_on();

  std::size_t hosts_;
  Ask ask_ = Ask::kLock;
  std::size_t host_ = 0;
  std::size_t applied_ = 0;  // hosts that were asked to apply
  std::size_t locked_ = 0;
  std::string failure_;
};

}  // namespace timsctl::configuration
