// Components report correctly when a new value of a parameter takes effect: immediately, at the
// next ON, or at the next start of the program.
#include <cmath>
#include <functional>

#include "os/file.h"
#include "rack/proxies/clock.h"
#include "rack/proxies/datalog.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/scan2d.h"
#include "tests/system/robot_fixture.h"

namespace tims::test {
namespace parameters_test {

using rack::TakesEffect;

class ParameterEffectsTest : public RobotTest {
 protected:
  std::optional<TakesEffect> effect_of(const std::string& address, std::string_view name) {
    if (!work_->send({.dest = *Address::parse(address), .type = type::kGetParamEffects})) return {};
    const auto answer = work_->peek_for(kPatience);
    if (!answer || answer->header().type != type::kParamEffects) return {};
    const auto list = rack::decode<rack::ParameterEffects>({answer->header(), answer->body()});
    if (!list) return {};
    for (const rack::ParameterEffect& effect : list->effects)
      if (effect.name == name) return static_cast<TakesEffect>(effect.takesEffect);
    return {};
  }
  void set(const std::string& address, std::string_view name, std::int32_t value) {
    rack::Parameter parameter;
    ASSERT_TRUE(parameter.name.assign(name));
    parameter.valueInt = value;
    const auto done = proxy<rack::Proxy>(address).set_param(parameter);
    ASSERT_TRUE(done) << done.error().message();
  }
  void off_and_on(const std::string& address) {
    auto component = proxy<rack::Proxy>(address);
    ASSERT_TRUE(component.off());
    ASSERT_TRUE(eventually(
        [&] {
          const auto status = component.status();
          return status && *status == rack::Status::kDisabled;
        },
        "off"));
    ASSERT_TRUE(turned_on(address));
  }
  // A value of the next data set; NaN without data.
  template <typename Proxy, typename Read>
  double fresh(const std::string& address, const Read& read) {
    // The longest period, with a margin for a busy machine.
    Proxy component(*work_, *Address::parse(address), {.data = std::chrono::seconds(2)});
    (void)component.get_next_data();
    const auto data = component.get_next_data();
    return data ? static_cast<double>(read(*data)) : std::nan("");
  }

  // `now` returns the present behaviour, which must correspond to the new value after the next ON.
  void takes_effect_at_on(const std::string& address, const char* name, std::int32_t value,
                          const std::function<double()>& now) {
    SCOPED_TRACE(address + " " + name);
    ASSERT_TRUE(turned_on(address));
    EXPECT_EQ(effect_of(address, name), TakesEffect::kAtOn);
    double before = std::nan("");
    ASSERT_TRUE(eventually([&] { return !std::isnan(before = now()); }, "data"));
    ASSERT_NE(before, value);
    set(address, name, value);
    EXPECT_EQ(now(), before) << "not yet";
    off_and_on(address);
    EXPECT_TRUE(eventually([&] { return now() == value; }, "the new value"));
  }
};

constexpr auto kRange = [](const auto& data) { return data.maxRange.raw(); };

TEST_F(ParameterEffectsTest, OfTheSimulatedRobotAtTheNextOn) {
  start("ChassisSim", {"--periodTime=20"});
  start("OdometryChassis");
  start("LadarSim", {"--mapFile", FLOOR_PLAN});
  start("Scan2dSim", {"--mapFile", FLOOR_PLAN});
  start("Scan2d", {"--instance=1", "--ladarInst=0"});
  start("Position");
  takes_effect_at_on("Chassis(0/0)", "vxMax", 555, [&] {
    const auto limits = proxy<rack::ChassisProxy>("Chassis(0/0)").get_parameter();
    return limits ? limits->vxMax.raw() : std::nan("");
  });
  takes_effect_at_on("Odometry(0/0)", "initPosX", 5000, [&] {
    return fresh<rack::OdometryProxy>("Odometry(0/0)", [](auto& d) { return d.pos.x.raw(); });
  });
  takes_effect_at_on("Ladar(0/0)", "maxRange", 7000,
                     [&] { return fresh<rack::LadarProxy>("Ladar(0/0)", kRange); });
  takes_effect_at_on("Scan2d(0/0)", "maxRange", 6000,
                     [&] { return fresh<rack::Scan2dProxy>("Scan2d(0/0)", kRange); });
  takes_effect_at_on("Scan2d(0/1)", "maxRange", 5000,
                     [&] { return fresh<rack::Scan2dProxy>("Scan2d(0/1)", kRange); });
  set("Position(0/0)", "positionReference", 2);
  takes_effect_at_on("Position(0/0)", "offsetNorthing", 77, [&] {
    const auto utm = proxy<rack::PositionProxy>("Position(0/0)").pos_to_utm({});
    return utm ? static_cast<double>(utm->northing.raw()) / 1000 : std::nan("");
  });
}

TEST_F(ParameterEffectsTest, OfAPilotAtTheNextOn) {
  start("ChassisSim");
  start("OdometryChassis");
  start("Scan2dSim", {"--mapFile", FLOOR_PLAN});
  start("Position");
  start("PilotWallFollowing", {"--instance=1", "--scan2dInst=0", "--maxSpeed=700", "--mode=0"});
  ASSERT_TRUE(turned_on("Chassis(0/0)"));
  auto chassis = proxy<rack::ChassisProxy>("Chassis(0/0)");
  ASSERT_TRUE(chassis.set_active_pilot(*Address::parse("Pilot(0/1)")));
  ASSERT_TRUE(turned_on("Pilot(0/1)"));
  EXPECT_EQ(effect_of("Pilot(0/1)", "maxSpeed"), TakesEffect::kAtOn);
  const auto speed = [&] {
    return fresh<rack::ChassisProxy>("Chassis(0/0)", [](auto& d) { return d.vx.raw(); });
  };
  // On a busy machine it may miss data and be turned on again, but only before it drives.
  ASSERT_TRUE(eventually([&] { return speed() > 100; }, "drives fast"));
  set("Pilot(0/1)", "maxSpeed", 60);
  EXPECT_GT(speed(), 100) << "not yet";
  off_and_on("Pilot(0/1)");
  EXPECT_TRUE(eventually([&] { return speed() > 5; }, "drives"));
  for (int i = 0; i < 5; ++i) EXPECT_LE(speed(), 61);
}

// The test is the other clock.
TEST_F(ParameterEffectsTest, OfAClockNow) {
  Session other = session();
  Mailbox clock = open(other, Address::parse("Clock(0/1)")->raw());
  start("ClockSystem", {"--clockInst=1", "--systemClockUpdate=0"});
  EXPECT_EQ(effect_of("Clock(0/0)", "systemClockUpdate"), TakesEffect::kNow);
  ASSERT_TRUE(work_->send({.dest = *Address::parse("Clock(0/0)"), .type = type::kOn}));
  const auto on = clock.peek_for(kPatience);
  ASSERT_TRUE(on && on->header().type == type::kOn);
  ASSERT_TRUE(clock.reply(on->header(), type::kOk));
  const auto answer = work_->peek_for(kPatience);
  ASSERT_TRUE(answer && answer->header().type == type::kOk);
  EXPECT_EQ(clock.try_peek().error().code(), Errc::kEmpty)
      << "it has data without a request to the other clock";
  set("Clock(0/0)", "systemClockUpdate", 1);
  const auto asked = clock.peek_for(kPatience);
  ASSERT_TRUE(asked) << asked.error().message();
  EXPECT_EQ(asked->header().type, type::kGetData);
  ASSERT_TRUE(clock.reply(asked->header(), type::kError));
}

TEST_F(ParameterEffectsTest, OfARecorderAtItsStart) {
  start("DatalogRec");
  EXPECT_EQ(effect_of("Datalog(0/0)", "logPathName"), TakesEffect::kAtStart);
  EXPECT_EQ(effect_of("Datalog(0/0)", "binaryIo"), TakesEffect::kAtOn);
  rack::Parameter parameter{.type = rack::Parameter::kString};
  parameter.name = "logPathName";
  ASSERT_TRUE(parameter.valueString.assign(router_.folder() + "/"));
  auto recorder = proxy<rack::DatalogProxy>("Datalog(0/0)");
  ASSERT_TRUE(recorder.set_param(parameter));
  ASSERT_TRUE(recorder.on());
  const auto list = recorder.get_log_status();
  ASSERT_TRUE(list) << list.error().message();
  EXPECT_EQ(list->logPathName.view(), "");
}

// Parameters of the runtime, the same in all components.
TEST_F(ParameterEffectsTest, OfTheRuntime) {
  start("SimpleModule");
  const auto address = std::string("Test(0/0)");
  EXPECT_EQ(effect_of(address, "gdosLevel"), TakesEffect::kNow);
  EXPECT_EQ(effect_of(address, "instance"), TakesEffect::kAtStart);
  ASSERT_TRUE(turned_on(address));
  set(address, "instance", 3);
  off_and_on(address);
  EXPECT_TRUE(proxy<rack::Proxy>(address).status().ok()) << "at its old address";
  EXPECT_FALSE(proxy<rack::Proxy>("Test(0/3)").status().ok());
}

}  // namespace parameters_test
}  // namespace tims::test
