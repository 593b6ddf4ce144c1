// Programs at devices of a real kernel. Skipped where it has none: `tools/dev vm-test`.
#include <filesystem>

#include "rack/proxies/joystick.h"
#include "tests/support/eventually.h"
#include "tests/support/uinput_stick.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace {

constexpr std::uint32_t kJoystick = 0x00170000;

class StickProgramTest : public ModulesTest {
 protected:
  void SetUp() override {
    if (!stick_->is_plugged_in()) GTEST_SKIP() << "no uinput: tools/dev vm-test";
    ModulesTest::SetUp();
    ASSERT_TRUE(eventually([] { return std::filesystem::exists("/dev/input/js0"); }, "the stick"));
  }
  rack::JoystickProxy joystick() { return {*work_, Address(kJoystick)}; }
  bool has(auto condition, const char* what) {
    return eventually(
        [&] {
          const auto data = joystick().get_data();
          return data && condition(*data);
        },
        what);
  }

  std::optional<UinputStick> stick_{std::in_place, "RACK program's stick"};
};

TEST_F(StickProgramTest, MovesAndButtonsArrive) {
  start("Joystick", {"--periodTime=20", "--deadZone=0"});
  const auto on = joystick().on();
  ASSERT_TRUE(on) << on.error().message();
  ASSERT_TRUE(stick_->move(ABS_X, UinputStick::kEnd));
  EXPECT_TRUE(has([](const auto& data) { return data.position.y.raw() > 90; }, "to the right"));
  ASSERT_TRUE(stick_->press(true));
  EXPECT_TRUE(has([](const auto& data) { return data.buttons != 0; }, "the button"));
  ASSERT_TRUE(stick_->press(false));
  EXPECT_TRUE(has([](const auto& data) { return data.buttons == 0; }, "no button"));
}

TEST_F(StickProgramTest, AStickThatIsPulledOutIsSaid) {
  auto& program = start("Joystick", {"--periodTime=20"});
  ASSERT_TRUE(joystick().on());
  stick_->pull_out();
  EXPECT_TRUE(program.wait_for_line("error:"));
  stick_.emplace("RACK program's stick");
  EXPECT_TRUE(eventually([&] { return joystick().on().ok(); }, "plugged in again"));
}

TEST_F(StickProgramTest, TimsctlTellsOfThem) {
  auto watch = ChildProcess::start(
      {std::string(TIMS_PROGRAMS) + "/timsctl", "device", "watch", "-j", "-n", "2"}, at_router());
  ASSERT_TRUE(watch);
  ASSERT_TRUE(watch->wait_for_line("devices are there"));
  {
    const UinputStick second("RACK second stick");
    const auto plugged = watch->wait_for_line("\"plugged\"");
    ASSERT_TRUE(plugged) << plugged.error().message();
    EXPECT_NE(plugged->find("RACK second stick"), std::string::npos) << *plugged;
    EXPECT_NE(plugged->find("Joystick"), std::string::npos) << *plugged;
  }
  EXPECT_TRUE(watch->wait_for_line("\"unplugged\""));
  const auto status = watch->wait();
  ASSERT_TRUE(status) << status.error().message();
  EXPECT_EQ(status->code, 0);
}

}  // namespace
}  // namespace tims::test
