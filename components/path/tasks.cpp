#include "components/path/tasks.h"

#include <array>
#include <charconv>
#include <cmath>

#include "components/geometry/pose.h"

namespace rack::path {

namespace {

constexpr double kFarthest = 1e9;                        // mm
constexpr std::chrono::milliseconds kTakesNotice{1000};  // until a pilot reports a new path

tims::Error not_a_task(std::string_view text) {
  return {tims::Errc::kMalformed,
          "\"" + std::string(text) +
              "\" is not a task; tasks are: goto X Y [HEADING [SPEED]] (mm, "
              "degrees, mm/s), route, wait SECONDS, stop"};
}

struct Fields {
  std::array<std::string_view, 5> field;
  std::size_t count = 0;
  bool too_many = false;
};

// The first field also ends before a number.
Fields split(std::string_view text) {
  Fields fields;
  while (!text.empty()) {
    const auto begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) break;
    text.remove_prefix(begin);
    const char* const ends = fields.count == 0 ? " \t\r\n-.0123456789" : " \t\r\n";
    const auto end = std::min(std::max<std::size_t>(text.find_first_of(ends), 1), text.size());
    fields.too_many = fields.count == fields.field.size();
    if (fields.too_many) break;
    fields.field[fields.count++] = text.substr(0, end);
    text.remove_prefix(end);
  }
  return fields;
}

bool read(std::string_view field, double least, double most, double& value) {
  const auto end = field.data() + field.size();
  const auto parsed = std::from_chars(field.data(), end, value);
  return parsed.ec == std::errc() && parsed.ptr == end && value >= least && value <= most;
}

}  // namespace

tims::Result<Task> read_task(std::string_view text) {
  const Fields fields = split(text);
  Task task;
  for (std::size_t i = 0; i < fields.count; ++i)
    task.text += (i == 0 ? "" : " ") + std::string(fields.field[i]);
  if (fields.too_many || fields.count == 0) return not_a_task(text);
  if ((fields.field[0] == "route" || fields.field[0] == "stop") && fields.count == 1) {
    task.kind = fields.field[0] == "stop" ? Task::Kind::kStop : Task::Kind::kRoute;
    return task;
  }
  double seconds = 0;
  if (fields.field[0] == "wait" && fields.count == 2 && read(fields.field[1], 0, 86400, seconds)) {
    task.time = std::chrono::milliseconds(std::lround(seconds * 1000));
    return task;
  }
  std::array<double, 4> values{};  // x, y, heading, speed
  if (fields.field[0] != "goto" || fields.count < 3) return not_a_task(text);
  for (std::size_t i = 1; i < fields.count; ++i) {
    const double least = i == 4 ? 0 : -kFarthest;
    if (!read(fields.field[i], least, kFarthest, values[i - 1])) return not_a_task(text);
  }
  task.kind = Task::Kind::kGoto;
  task.destination.pos.x = whole_millimetres(values[0]);
  task.destination.pos.y = whole_millimetres(values[1]);
  task.destination.pos.rho = static_cast<f32>(heading(radians(values[2])));
  task.destination.speed = static_cast<i32>(values[3]);
  return task;
}

void TaskList::begin(std::vector<Task> tasks) {
  tasks_ = std::move(tasks);
  at_ = 0;
  begun_ = false;
  why_.clear();
  state_ = tasks_.empty() ? State::kIdle : State::kAtWork;
}

void TaskList::fail(std::string why) {
  why_ = std::move(why);
  state_ = State::kFailed;
}

bool TaskList::is_done(const PilotStatusData& pilot) const {
  const Task& task = tasks_[at_];
  if (task.kind == Task::Kind::kStop) return true;
  if (task.kind == Task::Kind::kWait) return since_ >= task.time;
  return since_ >= kTakesNotice && pilot.pilotState == pilot_state::kIdle &&
         pilot.distanceToDest == 0;
}

const Task* TaskList::next(const PilotStatusData& pilot, std::chrono::milliseconds passed) {
  if (state_ != State::kAtWork) return nullptr;
  if (begun_) {
    since_ += passed;
    const auto kind = tasks_[at_].kind;
    const bool drives = kind == Task::Kind::kGoto || kind == Task::Kind::kRoute;
    if (drives && since_ >= kTakesNotice && pilot.pilotState == pilot_state::kPathError) {
      fail(tasks_[at_].text + ": the pilot has no path to the destination, or has lost it");
      return nullptr;
    }
    if (!is_done(pilot)) return nullptr;
    ++at_;
    begun_ = false;
  }
  if (at_ == tasks_.size()) {
    state_ = State::kIdle;
    return nullptr;
  }
  begun_ = true;
  since_ = std::chrono::milliseconds(0);
  return &tasks_[at_];
}

}  // namespace rack::path
