// The task list of a robot: parses tasks that users type, and selects the next one. Pure.
//
//   goto X Y [HEADING [SPEED]]   mm, degrees clockwise from north, mm/s
//   route                        the route of the path component
//   wait SECONDS
//   stop
#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/pilot.h"
#include "tims/result.h"

namespace rack::path {

struct Task {
  enum class Kind : std::uint8_t { kGoto, kRoute, kWait, kStop };
  Kind kind = Kind::kWait;
  PilotDestData destination{};
  std::chrono::milliseconds time{0};
  std::string text;
};

// The keyword of each task.
inline constexpr std::array<std::string_view, 4> kTaskNames = {"goto", "route", "wait", "stop"};

// The error kMalformed states the problem and the valid forms. The number may follow without a
// space: the original's graphical interface appends the typed text directly to the chosen name.
tims::Result<Task> read_task(std::string_view text);

class TaskList {
 public:
  enum class State : i32 { kIdle = 0, kAtWork = 1, kFailed = 2 };

  void begin(std::vector<Task> tasks);
  void fail(std::string why);

  // The task to start now, if any. `passed`: time since the last call.
  const Task* next(const PilotStatusData& pilot, std::chrono::milliseconds passed);

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const std::vector<Task>& tasks() const { return tasks_; }
  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] const std::string& why() const { return why_; }

 private:
  [[nodiscard]] bool is_done(const PilotStatusData& pilot) const;

  std::vector<Task> tasks_;
  std::size_t at_ = 0;  // index of the current task; it has started when `begun_`
  bool begun_ = false;
  std::chrono::milliseconds since_{0};
  State state_ = State::kIdle;
  std::string why_;
};

}  // namespace rack::path
