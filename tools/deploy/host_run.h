// What a deployment does with one host, step by step: every step is a command over ssh that may be
// called again, so that a lost connection is made again and the step repeated. Nothing on the host
// changes before kApply; from then on its own job goes on, with or without us, and ends with the
// new state or with the former one. Pure: steps come out, outcomes and times go in.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "tims/time.h"

namespace timsctl::deploy {

enum class Step : std::uint8_t {
  kConnect,
  kLook,     // what is there
  kRecover,  // a deployment that was interrupted there ends
  kStage,    // files and wishes are sent; of --undo: those of before are taken
  kCarry,    // packages are sent, one a step
  kPrepare,  // apt downloads, room on the disk is reserved
  kReady,    // no command: it waits for the other hosts
  kStop,     // the job is told to go back
  kApply,    // the job, until its end
  kRelease,  // what was sent is removed
  kOver,
};
std::string_view name_of(Step step);

enum class End : std::uint8_t {
  kNone,       // it is not over
  kKept,       // the host came up with what was deployed
  kSame,       // it was there already, and runs
  kWentBack,   // the host is as it was
  kBroken,     // it did not go back either
  kUntouched,  // nothing was changed
  kUnknown,    // the connection was lost during kApply, and how that has ended was not learned
};
std::string_view name_of(End end);

// A lost connection is made again after pauses that double, and given up after this time.
inline constexpr tims::Duration kFirstPause = std::chrono::seconds(1);
inline constexpr tims::Duration kLongestPause = std::chrono::seconds(10);
inline constexpr tims::Duration kGiveUp = std::chrono::seconds(60);
// During kApply the host may be busy with itself, or start its network again.
inline constexpr tims::Duration kGiveUpApplying = std::chrono::seconds(180);

class HostRun {
 public:
  explicit HostRun(bool undo) : undo_(undo) {}

  // The step to be begun now; it ends by done(), lost(), failed() or cancel(). Empty: none.
  std::optional<Step> begin(tims::Time now);
  // When begin() is to be asked again; kNever: after the next outcome.
  [[nodiscard]] tims::Time next_begin() const;

  // The step has succeeded.
  void done();
  // kLook: a former deployment was interrupted there, and so many packages are to be sent.
  void looked(bool interrupted, std::size_t packages);
  // kApply: how the job has ended. kRecover, too; then the host is looked at again.
  void applied(End end, std::string reason);
  // The connection broke, or was not made.
  void lost(tims::Time now, const std::string& reason);
  // The step has refused, or was refused; once kApply was begun before, it may have done its work.
  void failed(const std::string& reason);

  // All hosts are ready.
  void go();
  // Nothing is to be changed there. Not once it applies.
  void cancel(const std::string& reason);
  // Ctrl-C: what has not begun does not begin, what has begun goes back. The caller has ended the
  // command of the step.
  void stop();

  [[nodiscard]] Step step() const { return step_; }
  [[nodiscard]] bool is_connected() const { return connected_; }
  [[nodiscard]] bool is_over() const { return step_ == Step::kOver; }
  [[nodiscard]] bool is_ready() const { return step_ == Step::kReady; }
  // Whether it has changed or may change something.
  [[nodiscard]] bool applies() const { return step_ == Step::kApply || step_ == Step::kStop; }
  [[nodiscard]] End end() const { return end_; }
  [[nodiscard]] const std::string& reason() const { return reason_; }
  [[nodiscard]] std::size_t packages_sent() const { return sent_; }

 private:
  void finish(End end, const std::string& reason);

  bool undo_;
  Step step_ = Step::kLook;
  bool connected_ = false;
  bool was_connected_ = false;
  bool holds_ = false;  // something of ours may be on the host
  bool running_ = false;
  int applies_begun_ = 0;
  std::optional<Step> begun_{};
  std::size_t packages_ = 0;
  std::size_t sent_ = 0;
  tims::Time not_before_{};
  std::optional<tims::Time> lost_at_{};
  tims::Duration pause_ = kFirstPause;
  End end_ = End::kNone;
  std::string reason_{};
};

}  // namespace timsctl::deploy
