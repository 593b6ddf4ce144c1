#include "tools/configuration/rollout.h"

namespace timsctl::configuration {

void Rollout::take(Answer answer, const std::string& text) {
  const bool undoes = ask_ == Ask::kUndo || ask_ == Ask::kUnlock;
  if (answer == Answer::kNotYet) return;
  // Also who does not answer may have done it.
  if (ask_ == Ask::kLock) locked_ = host_ + 1;
  if (ask_ == Ask::kApply) applied_ = host_ + 1;
  if (answer != Answer::kDone && !undoes) return fail(text.empty() ? "a host went back" : text);
  go_on();
}

void Rollout::go_on() {
  const bool once = ask_ == Ask::kReconnect;
  // The lock of a host that applies ends with it.
  const std::size_t end = ask_ == Ask::kUndo ? applied_ : ask_ == Ask::kUnlock ? locked_ : hosts_;
  if (ask_ == Ask::kApply) {
    ask_ = Ask::kWait;
    return;
  }
  if (ask_ == Ask::kWait && host_ + 1 < end) {
    ask_ = Ask::kApply;
    ++host_;
    return;
  }
  if (!once && host_ + 1 < end) {
    ++host_;
    return;
  }
  switch (ask_) {
    case Ask::kLock:
      return begin(Ask::kApply);
    case Ask::kWait:
      return begin(Ask::kReconnect);
    case Ask::kReconnect:
      return begin(Ask::kVerify);
    case Ask::kVerify:
      return begin(Ask::kConfirm);
    case Ask::kConfirm:
      return begin(Ask::kSettle);
    case Ask::kUndo:
      return begin(Ask::kUnlock);
    default:
      return begin(Ask::kNothing);
  }
}

void Rollout::fail(const std::string& reason) {
  if (is_over() || !failure_.empty()) return;
  failure_ = reason.empty() ? "stopped" : reason;
  if (applied_ > 0) return begin(Ask::kUndo);
  begin(locked_ > 0 ? Ask::kUnlock : Ask::kNothing);
}

}  // namespace timsctl::configuration
