// Planner: carries out tasks, given as text, one after the other.
#include "rack/proxies/planner.h"

#include <array>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "components/path/tasks.h"
#include "rack/clock.h"
#include "rack/data_module.h"
#include "rack/partner.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/path.h"

namespace rack::path {
namespace {

constexpr std::array<ParameterInfo, 4> kParameters = {{
    partner("pilot", "the pilot", "the pilot, a PilotPath"),
    partner("path", "the path"),
    partner("chassis", "the chassis"),
    {"periodTime", 200, "period of the data [ms]", 10, 10000},
}};

constexpr ModuleInfo kInfo{
    .program = "Planner",
    .purpose =
        "Sends a robot from task to task: goto X Y [HEADING [SPEED]], route, wait SECONDS, stop.",
    .class_id = tims::class_id::kPlanner,
    .parameters = kParameters,
    .command_body_max = PlannerCommand::kWholeSize,
};

class Planner : public DataModule<PlannerData> {
 public:
  Planner() : DataModule(kInfo, {.history = 5}) {}

 private:
  Result<void> module_on() override {
    set_period(std::chrono::milliseconds(integer("periodTime")));
    pilot_.connect();
    path_.connect();
    if (auto on = chassis_.turn_on(); !on) return on;
    if (auto active = chassis_->set_active_pilot(pilot_->component()); !active) return active;
    if (auto on = pilot_->on(); !on) return on;
    {
      const std::lock_guard lock(tasks_mutex_);
      tasks_.begin({});
      stops_ = false;
    }
    return DataModule::module_on();
  }

  void module_off() override {
    if (pilot_) (void)pilot_->hold_command({1, 0, {}});
  }

  Result<void> module_loop() override {
    sleep_until_next(period());
    const auto pilot = pilot_->get_status();
    if (!pilot) return pilot.error();
    std::optional<Task> task;
    bool stops = false;
    {
      const std::lock_guard lock(tasks_mutex_);
      if (const Task* next = tasks_.next(*pilot, period())) task = *next;
      stops = std::exchange(stops_, false);
    }
    if (stops) {
      if (auto held = pilot_->hold_command({1, 0, {}}); !held) return held;
    }
    if (task) begin(*task);
    return publish_state();
  }

  void begin(const Task& task) {
    auto good = pilot_->hold_command({task.kind == Task::Kind::kStop ? 1 : 0, 0, {}});
    if (good && task.kind == Task::Kind::kGoto) good = pilot_->set_destination(task.destination);
    if (good && task.kind == Task::Kind::kRoute) good = path_->make({-1, -1, -1, -1.0F});
    if (good) return;
    log().warning("{}: {}", task.text, good.error().message());
    const std::lock_guard lock(tasks_mutex_);
    tasks_.fail(task.text + ": " + good.error().message());
  }

  Result<void> publish_state() {
    const std::lock_guard lock(tasks_mutex_);
    PlannerData& data = get_local_buffer();
    data.recordingTime = time_stamp();
    data.state = static_cast<i32>(tasks_.state());
    data.messages.clear();
    data.messages.push_back(PlannerString::of(headline()));
    for (std::size_t i = 0; i < tasks_.tasks().size() && i < kTasksShown; ++i) {
      const char* what = i < tasks_.at() ? "done: " : i == tasks_.at() ? "now: " : "then: ";
      data.messages.push_back(PlannerString::of(what + tasks_.tasks()[i].text));
    }
    return put_local_buffer();
  }

  // The original's graphical interface shows the first message, and adds a line when the message or
  // the state changes; without any message, it cannot send commands.
  [[nodiscard]] std::string headline() const {
    switch (tasks_.state()) {
      case TaskList::State::kFailed:
        return tasks_.why();
      case TaskList::State::kAtWork:
        return "now: " +
               (tasks_.at() < tasks_.tasks().size() ? tasks_.tasks()[tasks_.at()].text : "");
      case TaskList::State::kIdle:
        break;
    }
    return tasks_.tasks().empty() ? "no task" : "all done";
  }

  Result<void> module_command(const tims::MessageView& message) override {
    switch (message.header.type) {
      case PlannerType::kCommand:
        return command(message);
      case PlannerType::kGetCommand: {
        PlannerCommand names;  // offered by user interfaces
        for (const auto name : kTaskNames) names.commands.push_back(PlannerString::of(name));
        reply(message.header, PlannerType::kCommand, names);
        return {};
      }
      default:
        return DataModule::module_command(message);
    }
  }

  // Replaces the task list; an empty one stops the robot.
  Result<void> command(const tims::MessageView& message) {
    const auto command = decode<PlannerCommand>(message);
    if (!command) return command.error();
    if (!is_on()) return refused("the planner is off; turn it on first");
    std::vector<Task> tasks;
    for (const PlannerString& text : command->commands) {
      auto task = read_task(text.text.view());
      if (!task) return task.error();
      tasks.push_back(std::move(*task));
    }
    {
      const std::lock_guard lock(tasks_mutex_);
      stops_ = tasks.empty();
      tasks_.begin(std::move(tasks));
    }
    reply(message.header, tims::type::kOk);
    return {};
  }

  static constexpr std::size_t kTasksShown = 49;  // plus the headline

  OwnMailbox work_{*this, 4, 256};
  Partner<PilotProxy> pilot_{*this, "pilot", work_, kPlanningTimeouts};
  Partner<PathProxy> path_{*this, "path", work_, kPlanningTimeouts};
  Partner<ChassisProxy> chassis_{*this, "chassis", work_};

  PriorityMutex tasks_mutex_;  // protects the members below
  TaskList tasks_;
  bool stops_ = false;
};

}  // namespace
}  // namespace rack::path

int main(int argc, char** argv) {
  rack::path::Planner planner;
  return planner.run(argc, argv);
}
