#include "components/path/tasks.h"

#include <gtest/gtest.h>

namespace rack::path {
namespace tasks_test {

using namespace std::chrono_literals;
using State = TaskList::State;

PilotStatusData pilot(u32 state, i32 left) {
  PilotStatusData status;
  status.pilotState = state;
  status.distanceToDest = left;
  return status;
}

TEST(Tasks, AreReadAsPeopleTypeThem) {
  const auto there = read_task("  goto 1000 -2000.5 90 300 ");
  ASSERT_TRUE(there.ok());
  EXPECT_EQ(there->destination.pos.x, 1000);
  EXPECT_EQ(there->destination.pos.y, -2001);
  EXPECT_NEAR(there->destination.pos.rho, 1.5708, 1e-4);
  EXPECT_EQ(there->destination.speed, 300);
  EXPECT_EQ(there->text, "goto 1000 -2000.5 90 300");
  EXPECT_EQ(read_task("wait 1.5")->time, 1500ms);
  EXPECT_EQ(read_task("route")->kind, Task::Kind::kRoute);
  EXPECT_EQ(read_task(" stop ")->kind, Task::Kind::kStop);
}

TEST(Tasks, AreReadAsTheOriginalsInterfaceSendsThem) {
  const auto there = read_task("goto-1000 .5 90");
  ASSERT_TRUE(there.ok()) << there.error().message();
  EXPECT_EQ(there->destination.pos.x, -1000);
  EXPECT_EQ(there->text, "goto -1000 .5 90");
  EXPECT_EQ(read_task("wait1.5")->time, 1500ms);
}

TEST(Tasks, SayWhatIsNone) {
  for (const char* text :
       {"", " ", "go", "goto", "goto 1", "goto x 2", "goto 1 2 3 4 5", "goto nan 1", "goto 1e99 1",
        "goto 1 2 3 -4", "wait", "wait -1", "route 1", "stop now", "1", "-", ".", "goto-"}) {
    const auto task = read_task(text);
    ASSERT_FALSE(task.ok()) << text;
    EXPECT_NE(task.error().detail().find("wait SECONDS"), std::string::npos);
  }
}

TEST(TaskList, DoesOneAfterTheOther) {
  TaskList list;
  EXPECT_EQ(list.next(pilot(pilot_state::kIdle, 0), 100ms), nullptr);
  list.begin({*read_task("goto 1 2"), *read_task("wait 1"), *read_task("route")});
  const Task* task = list.next(pilot(pilot_state::kIdle, 0), 100ms);
  ASSERT_NE(task, nullptr);
  EXPECT_EQ(task->kind, Task::Kind::kGoto);
  EXPECT_EQ(list.next(pilot(pilot_state::kIdle, 0), 100ms), nullptr) << "the pilot's old state";
  EXPECT_EQ(list.next(pilot(pilot_state::kRunning, 500), 2s), nullptr);
  task = list.next(pilot(pilot_state::kIdle, 0), 100ms);
  ASSERT_NE(task, nullptr);
  EXPECT_EQ(task->kind, Task::Kind::kWait);
  EXPECT_EQ(list.next(pilot(pilot_state::kIdle, 0), 900ms), nullptr);
  task = list.next(pilot(pilot_state::kIdle, 0), 100ms);
  ASSERT_NE(task, nullptr);
  EXPECT_EQ(task->kind, Task::Kind::kRoute);
  EXPECT_EQ(list.state(), State::kAtWork);
  EXPECT_EQ(list.next(pilot(pilot_state::kIdle, 0), 1s), nullptr);
  EXPECT_EQ(list.state(), State::kIdle);
}

TEST(TaskList, GoesOnAfterAStop) {
  TaskList list;
  list.begin({*read_task("stop"), *read_task("wait 1")});
  const Task* task = list.next(pilot(pilot_state::kPathError, -1), 100ms);
  ASSERT_NE(task, nullptr);
  EXPECT_EQ(task->kind, Task::Kind::kStop);
  task = list.next(pilot(pilot_state::kPathError, -1), 100ms);
  ASSERT_NE(task, nullptr) << "the state of the pilot's path does not matter";
  EXPECT_EQ(task->kind, Task::Kind::kWait);
}

TEST(TaskList, EndsWithThePilotsError) {
  TaskList list;
  list.begin({*read_task("goto 1 2"), *read_task("route")});
  ASSERT_NE(list.next(pilot(pilot_state::kIdle, -1), 100ms), nullptr);
  EXPECT_EQ(list.next(pilot(pilot_state::kPathError, -1), 2s), nullptr);
  EXPECT_EQ(list.state(), State::kFailed);
  EXPECT_NE(list.why().find("goto 1 2"), std::string::npos);
}

}  // namespace tasks_test
}  // namespace rack::path
