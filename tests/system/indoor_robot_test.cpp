// The indoor robot of the samples: real drivers in a simulated world. It localises itself on its
// floor plan and is sent to a destination among people. Its arrival is checked against the ground
// truth, not against its own estimate.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/geometry/pose.h"
#include "os/file.h"
#include "rack/proxies/mcl.h"
#include "rack/proxies/obj_recog.h"
#include "tests/support/temporary_folder.h"
#include "tests/system/sample_robot_fixture.h"

namespace tims::test {
namespace indoor_robot_test {

class IndoorRobotTest : public SampleRobotTest {
 protected:
  void SetUp() override {
    if (RACK_WITH_OPENCV == 0) GTEST_SKIP() << "this robot has a camera";
    SampleRobotTest::SetUp();
    start_robot(TIMS_ROBOTS "/emulated.toml", 16);
  }

  // On a very busy machine streams break, and its pilot stops: then it is sent once more. `look` is
  // called repeatedly during the drive.
  testing::AssertionResult arrives(const std::string& x, const std::string& y,
                                   const std::function<void()>& look) {
    const auto drive = [&]() -> std::string {
      constexpr Duration kBetween = std::chrono::milliseconds(20);
      ChildProcess going = begin({"nav", "goto", x, y, "90", "--timeout", "20s", "--for", "150s"});
      auto ended = going.wait(kBetween);
      for (; !ended; ended = going.wait(kBetween)) look();
      return ended->code == 0 ? "" : going.output();
    };
    return eventually(drive, kDrive);
  }

  // The process that owns its mailbox.
  pid_t owner_of(const Address& component) {
    ChildProcess asking = begin({"mbx", "list", component.to_string(), "--json"});
    const auto ended = asking.wait();
    EXPECT_TRUE(ended && ended->code == 0) << asking.output();
    const std::string output = asking.standard_output();
    const auto at = output.find("\"pid\":");
    EXPECT_NE(at, std::string::npos) << output;
    return at == std::string::npos ? 0 : static_cast<pid_t>(std::stol(output.substr(at + 6)));
  }
};

// The position of a person relative to the robot: ahead, to the right.
rack::Pose seen_by(const rack::WorldThing& robot, const rack::WorldThing& person) {
  const auto pose = [](const rack::Position2d& pos) {
    return rack::Pose{.x = 1.0 * pos.x.raw(), .y = 1.0 * pos.y.raw(), .rho = 1.0 * pos.rho.raw()};
  };
  return pose(person.pos) - pose(robot.pos);
}

TEST_F(IndoorRobotTest, LocalisesAndReachesADestinationAmongPeople) {
  ASSERT_TRUE(arrives("3.5", "3", [] {})) << up_->output();

  const rack::WorldData truth_then = truth();
  const auto* const is = truth_then.find(rack::world_thing::kRobot, "scout");
  ASSERT_NE(is, nullptr);
  EXPECT_LT(std::hypot(is->pos.x.raw() - 3500, is->pos.y.raw() - 3000), 300);
  EXPECT_EQ(is->contacts(), 0U) << "contacts caused by people do not count";
  EXPECT_GT(is->travelled.raw(), 4000);
  EXPECT_EQ(truth_then.peopleMove, 1);

  const auto believed = of_robot<rack::MclProxy>("Mcl").get_data();
  ASSERT_TRUE(believed) << believed.error().message();
  EXPECT_LT(
      std::hypot(believed->pos.x.raw() - is->pos.x.raw(), believed->pos.y.raw() - is->pos.y.raw()),
      200);
}

// A person stands in the middle of the corridor, directly ahead: the robot stops, waits for the
// person to move on, and then drives around.
TEST_F(IndoorRobotTest, PassesAPersonOnItsPathWithoutContact) {
  constexpr double kTouches = 200 + 250;  // half of its width, and of a person
  const auto stands_in_the_corridor = [&] {
    const rack::WorldData now = truth();
    const auto* const walker = now.find(rack::world_thing::kPerson, "");
    return walker != nullptr && walker->vx == 0 && walker->vy == 0 &&
           std::hypot(walker->pos.x.raw() - 3500, walker->pos.y.raw()) < 100;
  };
  ASSERT_TRUE(eventually(stands_in_the_corridor, "a person stands in the corridor", kDrive));
  ASSERT_TRUE(world().let_people_move(false).ok());

  ASSERT_TRUE(turned_on(of_system("ObjRecog")));
  auto recogniser = of_robot<rack::ObjRecogProxy>("ObjRecog");
  const rack::Pose there{.x = 3500, .y = 0};
  ASSERT_TRUE(eventually(
      [&] {
        const auto seen = recogniser.get_data();
        return seen && std::ranges::any_of(seen->objects, [&](const rack::ObjRecogObject& object) {
                 const rack::Pose at = rack::Pose::of(seen->refPos) + rack::Pose::of(object.pos);
                 return std::hypot(at.x - there.x, at.y - there.y) < 400;
               });
      },
      "an object at the position of the person", kDrive));

  bool was_ahead = false;
  double nearest = 1e9;
  const auto look = [&] {
    const rack::WorldData now = truth();
    const auto* const robot = now.find(rack::world_thing::kRobot, "scout");
    const auto* const walker = now.find(rack::world_thing::kPerson, "");
    if (robot == nullptr || walker == nullptr) return;
    const rack::Pose seen = seen_by(*robot, *walker);
    was_ahead = was_ahead || (seen.x > 0 && std::abs(seen.y) < kTouches);
    nearest = std::min(nearest, std::hypot(seen.x, seen.y));
  };
  ASSERT_TRUE(arrives("6.3", "0", look)) << up_->output();

  const rack::WorldData now = truth();
  const auto* const robot = now.find(rack::world_thing::kRobot, "scout");
  ASSERT_NE(robot, nullptr);
  EXPECT_TRUE(was_ahead);
  EXPECT_GT(nearest, kTouches);
  EXPECT_LT(nearest, 1500) << "it did not meet the person";
  EXPECT_EQ(robot->contacts(), 0U);
  EXPECT_LT(std::hypot(robot->pos.x.raw() - 6300, robot->pos.y.raw()), 300);
}

// Its localisation is killed during the drive; the supervisor restarts it.
TEST_F(IndoorRobotTest, StopsWithoutItsLocalisationAndContinues) {
  ASSERT_TRUE(world().let_people_move(false).ok());
  const auto position = of_robot<rack::PositionProxy>("Position").component();
  bool is_killed = false;
  bool stood = false;
  const auto look = [&] {
    const rack::WorldData now = truth();
    const auto* const robot = now.find(rack::world_thing::kRobot, "scout");
    if (robot == nullptr || stood) return;
    if (!is_killed && robot->travelled > 800) {
      is_killed = ::kill(owner_of(position), SIGKILL) == 0;
      return;
    }
    stood = is_killed && robot->vx == 0;
  };
  ChildProcess going = begin({"nav", "goto", "0", "5", "--timeout", "20s"});
  auto ended = going.wait(std::chrono::milliseconds(20));
  for (; !ended; ended = going.wait(std::chrono::milliseconds(20))) look();
  EXPECT_EQ(ended->code, 0) << going.output() << up_->output();
  EXPECT_TRUE(is_killed);
  EXPECT_TRUE(stood);
  const rack::WorldData now = truth();
  const auto* const robot = now.find(rack::world_thing::kRobot, "scout");
  ASSERT_NE(robot, nullptr);
  EXPECT_LT(std::hypot(robot->pos.x.raw(), robot->pos.y.raw() - 5000), 300);
  EXPECT_EQ(robot->contacts(), 0U);
}

// The two corridors look alike for its scanner: after it was carried from one to the other, only a
// marker on the wall tells them apart.
TEST_F(IndoorRobotTest, AMarkerBringsItBackAfterItWasCarriedAway) {
  ASSERT_TRUE(world().let_people_move(false).ok());
  ASSERT_TRUE(turned_on(of_system("Mcl")));
  const auto off_by = [&](const rack::Position3d& believed) {
    const rack::WorldData now = truth();
    const auto* const robot = now.find(rack::world_thing::kRobot, "scout");
    if (robot == nullptr) return 1e9;
    return std::hypot(believed.x.raw() - robot->pos.x.raw(), believed.y.raw() - robot->pos.y.raw());
  };
  const auto mcl_is_right = [&] {
    const auto believed = of_robot<rack::MclProxy>("Mcl").get_data();
    return believed && off_by(believed->pos) < 200;
  };
  ASSERT_TRUE(eventually(mcl_is_right, "it knows where it is", kDrive)) << up_->output();

  rack::Position2d elsewhere;
  elsewhere.x = 5500;
  elsewhere.y = 9000;
  ASSERT_TRUE(world().place("scout", elsewhere).ok());
  const auto is_wrong = [&] {
    const auto believed = of_robot<rack::MclProxy>("Mcl").get_data();
    return believed && off_by(believed->pos) > 1000;
  };
  ASSERT_TRUE(eventually(is_wrong, "it does not know where it is", kDrive));
  ASSERT_TRUE(turned_on(of_system("ObjRecog", 1))) << up_->output();
  auto markers = of_robot<rack::ObjRecogProxy>("ObjRecog", 1);
  ASSERT_TRUE(eventually(
      [&] {
        const auto seen = markers.get_data();
        return seen && std::ranges::any_of(seen->objects, [](const rack::ObjRecogObject& object) {
                 return object.objectId == 4 && std::abs(object.pos.x.raw() - 3000) < 150;
               });
      },
      "the marker at the end of the corridor", kDrive))
      << up_->output();
  EXPECT_TRUE(eventually(
      [&] {
        const auto believed = of_robot<rack::PositionProxy>("Position").get_data();
        return believed && off_by(believed->pos) < 300 && mcl_is_right();
      },
      "it knows where it is again", kDrive))
      << up_->output();
  EXPECT_THAT(up_->output(), testing::HasSubstr("by markers"));
}

TEST_F(IndoorRobotTest, ASavedPictureShowsWhatIsRecognisedInIt) {
  const TemporaryFolder folder;
  const auto save = [&](const std::string& name, std::vector<std::string> more = {}) {
    std::vector<std::string> line = {"camera", "save", of_system("Camera"), folder.path() / name,
                                     "--json"};
    line.insert(line.end(), more.begin(), more.end());
    ChildProcess saving = begin(line);
    const auto ended = saving.wait();
    return std::pair(ended ? ended->code : -1, saving.output());
  };
  const std::vector<std::string> boxes = {"--objects", of_system("ObjRecog", 1)};
  EXPECT_EQ(save("off.png").first, 1);
  EXPECT_EQ(save("objects.jpg", boxes).first, 2) << "it would have to be compressed again";
  EXPECT_EQ(save("picture.bmp").first, 2);

  ASSERT_TRUE(turned_on(of_system("ObjRecog", 1)));
  const auto [code, output] = save("objects.png", boxes);
  EXPECT_EQ(code, 0) << output;
  EXPECT_THAT(output, testing::ContainsRegex("\"objects\": *[1-9]"));
  EXPECT_THAT(os::read_file(folder.path() / "objects.png").value(), testing::StartsWith("\x89PNG"));
  EXPECT_EQ(save("plain.png").first, 0);
  EXPECT_EQ(save("plain.jpg").first, 0);
  EXPECT_THAT(os::read_file(folder.path() / "plain.jpg").value(), testing::StartsWith("\xFF\xD8"));
  EXPECT_LT(std::filesystem::file_size(folder.path() / "plain.jpg"),
            std::filesystem::file_size(folder.path() / "plain.png"));
}

}  // namespace indoor_robot_test
}  // namespace tims::test
