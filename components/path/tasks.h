// What a robot shall do, one after the other: tasks as people type them, and which is next. Pure.
//
//   goto X Y [HEADING [SPEED]]   mm, degrees clockwise from north, mm/s
//   route                        the route that the path has
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

// How tasks begin.
inline constexpr std::array<std::string_view, 4> kTaskNames = {"goto", "route", "wait", "stop"};

// kMalformed says what is wrong, and what would be right. The number may follow without a space:
// the original's graphical interface puts what was typed right behind the name that was chosen.
tims::Result<Task> read_task(std::string_view text);

class TaskList {
 public:
  enum class State : i32 { kIdle = 0, kAtWork = 1, kFailed = 2 };

  void begin(std::vector<Task> tasks);
  void fail(std::string why);

  // The task to begin now, if any. `passed`: since the last call.
  const Task* next(const PilotStatusData& pilot, std::chrono::milliseconds passed);

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const std::vector<Task>& tasks() const { return tasks_; }
  [[nodiscard]] std::size_t at() const { return at_; }
  [[nodiscard]] const std::string& why() const { return why_; }

 private:
  [[nodiscard]] bool is_done(const PilotStatusData& pilot) const;

  std::vector<Task> tasks_;
  std::size_t at_ = 0;  // the task that is under way, when `begun_`
  bool begun_ = false;
  std::chrono::milliseconds since_{0};
  State state_ = State::kIdle;
  std::string why_;
};

}  // namespace rack::path
