// A program of a robot: it is started, monitored, stopped and restarted.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <sys/types.h>

#include "os/file.h"
#include "tims/time.h"
#include "tools/cli/service.h"
#include "tools/robot/output.h"
#include "tools/robot/robot_file.h"

namespace timsctl::robot {

// --- Restart policy with increasing pauses (backoff). Pure

inline constexpr tims::Duration kFirstPause = std::chrono::milliseconds(200);
inline constexpr tims::Duration kLongestPause = std::chrono::seconds(10);
// A program that has run for this time starts again with the first pause.
inline constexpr tims::Duration kStableAfter = std::chrono::seconds(10);
inline constexpr int kUsage =
    2;  // exit status: only another command line helps, so there is no restart

class RestartPolicy {
 public:
  explicit RestartPolicy(Restart when) : when_(when) {}

  // Called when the program has ended with this exit status (128 and more: by a signal) after
  // running for `ran`. Returns the pause until the restart; empty: no restart.
  std::optional<tims::Duration> ended(int status, tims::Duration ran);

 private:
  Restart when_;
  tims::Duration pause_ = kFirstPause;
};

// --- Status notifications, as services send them to systemd (sd_notify(3)). Components send them
// over a connection of their own (os/service_manager.h); this socket is for other programs.

class StatusSocket {
 public:
  // A socket in the file system, for this user only. Throws Failure.
  explicit StatusSocket(std::string path);
  ~StatusSocket();
  StatusSocket(const StatusSocket&) = delete;
  StatusSocket& operator=(const StatusSocket&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] int descriptor() const { return socket_.get(); }
  struct Notification {
    pid_t pid = 0;  // from the kernel, not from the sender
    std::string text;
  };
  // Returns the next waiting notification.
  std::optional<Notification> take();

 private:
  std::string path_;
  tims::os::File socket_;
};

// The text after STATUS= in "READY=1\nSTATUS=on"; empty optional if there is none.
std::optional<std::string> status_in(std::string_view text);
bool is_ready_notification(std::string_view text);
std::optional<std::string> address_in(
    std::string_view text);  // address of the component: "0x01110000"
// A parameter that was set at run time ("X_TIMS_PARAMETER=vxMax=900"), and a value with which the
// component continues after a crash ("X_TIMS_STATE=initPosX=120"; without a value: cancelled).
struct Setting {
  std::string name;
  std::string value;
};
inline constexpr std::string_view kParameterKey = "X_TIMS_PARAMETER=";
inline constexpr std::string_view kStateKey = "X_TIMS_STATE=";
std::optional<Setting> setting_in(std::string_view text, std::string_view what);

// --- A program

// States according to sd_notify(3).
enum class State : std::uint8_t { kDown, kStarting, kReady };

class Program {
 public:
  struct Config {
    Restart restart = Restart::kOnFailure;
    bool notifies = true;  // sends READY=1; other programs count as ready at once
    std::string input{};   // written to its stdin, which is closed when this object is destroyed
  };
  Program(std::string name, Launch launch, Config config);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const tims::os::Command& command() const { return launch_.command; }
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const std::string& status() const { return status_; }    // "on", "error: ..."
  [[nodiscard]] const std::string& address() const { return address_; }  // empty: unknown
  using Parameters = std::map<std::string, std::string>;
  [[nodiscard]] const Parameters& parameters() const { return parameters_; }  // set at run time
  [[nodiscard]] const Child& child() const { return child_; }

  // Throws Failure if it cannot be executed. A component that was on when it ended is turned on
  // again, with the parameters that were set at run time.
  void start(tims::Time now);
  void on_notification(std::string_view text);  // received at the status socket
  // Takes what has arrived over its connection, in bounded pieces. False: nothing.
  bool take_notifications();

  // Readable when there is output or a notification, or the program has ended.
  [[nodiscard]] std::vector<int> descriptors(tims::Time now) const;
  // When take_lines() is to be called even if no descriptor is readable; kNever: then only.
  [[nodiscard]] tims::Time look_again_at(tims::Time now) const;
  struct End {
    tims::os::ExitStatus status;
    std::optional<tims::Duration> pause;  // until the restart
  };
  // Reports each end once.
  std::optional<End> ended(tims::Time now);
  // Handles a failed start like a program that ended at once.
  End could_not_start(tims::Time now);
  // The output since the last call, as far as it is no flood. A back-trace may follow the end of
  // the program: a process that it has started writes it (components/runtime/crash.h).
  std::vector<std::string> take_lines(tims::Time now);
  [[nodiscard]] tims::Time start_at() const { return start_at_; }  // kNever: no restart
  void stay_down() { start_at_ = tims::kNever; }

 private:
  End end_with(tims::os::ExitStatus status, tims::Time now, tims::Duration ran);
  bool take_notifications(int most);

  std::string name_;
  Launch launch_;
  Config config_;
  RestartPolicy policy_;

  Child child_;
  tims::os::File input_;
  tims::os::File connection_;  // of its notifications
  FloodGate gate_;
  ProgramOutput output_;
  ProgramOutput previous_output_;  // of the process before the last restart
  State state_ = State::kDown;
  std::string status_;
  std::string address_;
  Parameters parameters_;
  Parameters state_to_keep_;  // values for a restart after a crash
  tims::Time started_{};
  tims::Time start_at_ = tims::kNever;
};

}  // namespace timsctl::robot
