// A program of a robot: it is started, heard, ended and started again.
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
#include "tools/robot/robot_file.h"

namespace timsctl::robot {

// --- When it starts again: soon at first, then less and less often. Pure

inline constexpr tims::Duration kFirstPause = std::chrono::milliseconds(200);
inline constexpr tims::Duration kLongestPause = std::chrono::seconds(10);
// Who has run for so long begins with the first pause.
inline constexpr tims::Duration kStableAfter = std::chrono::seconds(10);
inline constexpr int kUsage = 2;  // exit status: nothing but another command line mends that

class RestartPolicy {
 public:
  explicit RestartPolicy(Restart when) : when_(when) {}

  // It ended with this exit status (128 and more: by a signal) after running for `ran`. How long to
  // wait until it starts again; nothing: it stays down.
  std::optional<tims::Duration> ended(int status, tims::Duration ran);

 private:
  Restart when_;
  tims::Duration pause_ = kFirstPause;
};

// --- What it writes, line by line. Pure

inline constexpr std::size_t kLineMax = 4096;  // a longer one is cut in pieces

class LineBuffer {
 public:
  // The lines that are complete now, without their ends.
  std::vector<std::string> add(std::string_view text);
  // What is left at the end of all.
  std::string take_rest() { return std::exchange(rest_, {}); }

 private:
  std::string rest_;
};

// --- Where it says how it is, as services do to systemd (sd_notify(3))

class StatusSocket {
 public:
  // A socket in the file system, for this user only. Throws Failure.
  explicit StatusSocket(std::string path);
  ~StatusSocket();
  StatusSocket(const StatusSocket&) = delete;
  StatusSocket& operator=(const StatusSocket&) = delete;

  [[nodiscard]] int descriptor() const { return socket_.get(); }
  struct Notification {
    pid_t pid = 0;  // the system's word, not the sender's
    std::string text;
  };
  // What waits to be read, one by one.
  std::optional<Notification> take();

 private:
  std::string path_;
  tims::os::File socket_;
};

// "READY=1\nSTATUS=on": what stands behind STATUS=; nothing when nothing does.
std::optional<std::string> status_in(std::string_view text);
bool says_ready(std::string_view text);
std::optional<std::string> address_in(std::string_view text);  // of a component: "0x01110000"
// Of a component: a parameter that was set while it ran ("X_TIMS_PARAMETER=vxMax=900"), and what it
// goes on with after a crash ("X_TIMS_STATE=initPosX=120"; without a value: no more).
struct Setting {
  std::string name;
  std::string value;
};
inline constexpr std::string_view kParameterKey = "X_TIMS_PARAMETER=";
inline constexpr std::string_view kStateKey = "X_TIMS_STATE=";
std::optional<Setting> setting_in(std::string_view text, std::string_view what);

// --- A program

// In the words of sd_notify(3), as far as a program speaks them.
enum class State : std::uint8_t { kDown, kStarting, kReady };

class Program {
 public:
  struct Config {
    Restart restart = Restart::kOnFailure;
    bool notifies = true;  // when it is ready; who does not is so at once
    std::string input{};   // what it reads first; its stdin ends when this object does
  };
  Program(std::string name, Launch launch, Config config);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const std::string& status() const { return status_; }    // "on", "error: ..."
  [[nodiscard]] const std::string& address() const { return address_; }  // empty: none is known
  using Parameters = std::map<std::string, std::string>;
  [[nodiscard]] const Parameters& parameters() const { return parameters_; }  // set while it ran
  [[nodiscard]] std::optional<pid_t> pid() const;

  // Throws Failure when it cannot be executed. A component that was on when it ended is told to be
  // on again, and has the parameters that were set while it ran.
  void start(tims::Time now);
  void on_notification(std::string_view text);  // at the status socket
  void signal(int number) const;

  // Its output and its end can be read there.
  [[nodiscard]] std::vector<int> descriptors() const;
  struct End {
    tims::os::ExitStatus status;
    std::optional<tims::Duration> pause;  // until it starts again
  };
  // Once for each end.
  std::optional<End> ended(tims::Time now);
  // As if it had been started and had ended at once.
  End could_not_start(tims::Time now);
  // What it has written since; all of it behind ended().
  std::vector<std::string> take_lines();
  [[nodiscard]] tims::Time start_at() const { return start_at_; }  // kNever: not
  void stay_down() { start_at_ = tims::kNever; }

 private:
  End end_with(tims::os::ExitStatus status, tims::Time now, tims::Duration ran);

  std::string name_;
  Launch launch_;
  Config config_;
  RestartPolicy policy_;

  std::optional<Process> child_;
  tims::os::File input_;
  tims::os::File output_;
  LineBuffer lines_;
  State state_ = State::kDown;
  std::string status_;
  std::string address_;
  Parameters parameters_;
  Parameters state_to_keep_;  // what it goes on with after a crash
  tims::Time started_{};
  tims::Time start_at_ = tims::kNever;
};

}  // namespace timsctl::robot
