// The runtime of components as seen by other components: commands, parameters, data, texts, exit.
#include <csignal>

#include <gtest/gtest.h>

#include "rack/proxies/chassis.h"
#include "rack/proxies/gdos.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/scan2d.h"
#include "tests/support/eventually.h"
#include "tests/system/modules_fixture.h"

namespace tims::test {
namespace modules_test {

using rack::ChassisData;
using rack::ChassisProxy;

constexpr std::uint32_t kChassis = 0x00110000;
constexpr std::uint32_t kData = 0x00180002;

class ModulesProgramsTest : public ModulesTest {
 protected:
  ChassisProxy chassis() { return proxy<ChassisProxy>(kChassis); }
  void start_chassis() { start("ChassisSim", {"--periodTime=20", "--moveDeadline=0"}); }

  // The next message of a stream.
  static Header next_header(Mailbox& data) {
    const auto message = data.peek_for(kPatience);
    EXPECT_TRUE(message) << message.error().message();
    return message ? message->header() : Header{};
  }
  std::string status() {
    const auto status = chassis().status();
    return status ? std::string(name(*status)) : status.error().message();
  }
};

TEST_F(ModulesProgramsTest, AreTurnedOnAndOff) {
  start_chassis();
  EXPECT_EQ(status(), "disabled");
  EXPECT_TRUE(chassis().on());
  EXPECT_EQ(status(), "enabled");
  EXPECT_TRUE(chassis().get_data()) << "a component that is on has data";
  EXPECT_TRUE(chassis().on()) << "it is on already";
  EXPECT_TRUE(chassis().off());
  EXPECT_TRUE(eventually([&] { return status() == "disabled"; }, "off"));
  EXPECT_FALSE(chassis().get_data());
}

// A window of the graphical interface sends these requests twice per second.
TEST_F(ModulesProgramsTest, DoNotLogCommandsWhileTheyAreOff) {
  auto& program = start("ChassisSim", {"--periodTime=20"});
  EXPECT_FALSE(chassis().get_data());
  EXPECT_FALSE(chassis().move(100, 0, 0));
  ASSERT_TRUE(chassis().on());
  const auto moved = chassis().move(100, 0, 0);
  ASSERT_FALSE(moved);
  EXPECT_EQ(moved.error().detail(),
            "Chassis(0/0), MOVE: GUI(0/0) is not the active pilot of this chassis, which has none");
  const auto line = program.wait_for_line("is not the active pilot of this chassis");
  ASSERT_TRUE(line) << line.error().message();
  EXPECT_NE(line->find("warning: MOVE from GUI(0/0):1: "), std::string::npos) << *line;
  EXPECT_EQ(program.output().find("GET_DATA"), std::string::npos);
  EXPECT_EQ(program.output().find("is off"), std::string::npos);
}

TEST_F(ModulesProgramsTest, StayOffWhenTheyWereTurnedOffByAUser) {
  start("ChassisSim", {"--periodTime=20"});
  auto& odometry = start("OdometryChassis", {"--errorTimeout=50"});
  auto odometry_proxy = proxy<rack::OdometryProxy>(0x00120000);
  ASSERT_TRUE(odometry_proxy.on());
  EXPECT_EQ(status(), "enabled") << "turned on by the component that needs it";
  ASSERT_TRUE(chassis().off());
  const auto line = odometry.wait_for_line("GUI(0/0):1 has turned it off");
  ASSERT_TRUE(line) << line.error().message();
  EXPECT_NE(line->find("error: Chassis(0/0), ON: "), std::string::npos) << *line;
  for (int i = 0; i < 3; ++i) {
    const auto tried = odometry_proxy.on();
    ASSERT_FALSE(tried) << "tried at once, and refused with a reason";
    EXPECT_NE(tried.error().message().find("Odometry(0/0), ON: the component answered"),
              std::string::npos);
    EXPECT_NE(tried.error().message().find("only an operator can turn it on again"),
              std::string::npos)
        << tried.error().message();
  }
  EXPECT_EQ(status(), "disabled");
  const std::string all = odometry.output();
  EXPECT_EQ(all.find("has turned it off"), all.rfind("has turned it off")) << "once: " << all;
  ASSERT_TRUE(chassis().on());
  EXPECT_TRUE(eventually([&] { return odometry_proxy.on().ok(); }, "it can be turned on again"));
}

// Programs of the original would close the connection when they receive an unexpected body.
TEST_F(ModulesProgramsTest, SendReasonsOnlyOnRequest) {
  start("OdometryChassis");
  for (const bool asks : {false, true}) {
    std::vector<std::byte> body(asks ? 4 : 0);
    ASSERT_TRUE(work_->send({.dest = Address(0x00120000), .type = type::kOn, .seq_nr = 9}, body));
    const auto answer = work_->peek_for(kPatience);
    ASSERT_TRUE(answer) << answer.error().message();
    EXPECT_EQ(answer->header().type, type::kError);
    EXPECT_EQ(text_of(answer->body()).empty(), !asks) << text_of(answer->body());
  }
}

TEST_F(ModulesProgramsTest, ExecuteCommands) {
  start_chassis();
  auto chassis_proxy = chassis();
  ASSERT_TRUE(chassis_proxy.on());
  EXPECT_FALSE(chassis_proxy.move(100, 0, 0)) << "not the active pilot";
  ASSERT_TRUE(chassis_proxy.set_active_pilot(Address(kWork)));
  ASSERT_TRUE(chassis_proxy.move(100, 0, 0.1F));
  const auto data = chassis_proxy.get_next_data(kPatience);
  ASSERT_TRUE(data) << data.error().message();
  EXPECT_EQ(data->vx.raw(), 100.0F);
  EXPECT_EQ(data->activePilot, Address(kWork & ~0xFFU));
}

// As every chassis: a MOVE is valid for three periods of the pilot. moveDeadline=0 is the original.
TEST_F(ModulesProgramsTest, AChassisStopsWhenItsPilotIsSilent) {
  constexpr float kSpeed = 300;
  auto& program = start("ChassisSim", {"--periodTime=20"});
  auto chassis_proxy = chassis();
  ASSERT_TRUE(chassis_proxy.on());
  ASSERT_TRUE(chassis_proxy.set_active_pilot(Address(kWork)));
  const auto speed = [&] {
    const auto data = chassis_proxy.get_next_data(kPatience);
    return data ? data->vx.raw() : -1;
  };
  ASSERT_TRUE(eventually([&] { return chassis_proxy.move(300, 0, 0).ok() && speed() == kSpeed; },
                         "it drives"));
  EXPECT_TRUE(eventually([&] { return speed() == 0; }, "it stands"));
  EXPECT_TRUE(program.wait_for_line("No MOVE from GUI(0/0) in time, stopped"));
  ASSERT_TRUE(eventually([&] { return chassis_proxy.move(300, 0, 0).ok() && speed() == kSpeed; },
                         "it drives again"));
  rack::Parameter endless;
  ASSERT_TRUE(endless.name.assign("moveDeadline"));
  endless.valueInt = 0;
  ASSERT_TRUE(chassis_proxy.set_param(endless));
  ASSERT_TRUE(chassis_proxy.off());
  ASSERT_TRUE(eventually([&] { return status() == "disabled"; }, "off"));
  ASSERT_TRUE(chassis_proxy.on());
  ASSERT_TRUE(chassis_proxy.set_active_pilot(Address(kWork)));
  ASSERT_TRUE(chassis_proxy.move(300, 0, 0));
  ASSERT_TRUE(eventually([&] { return speed() == kSpeed; }, "it drives"));
  for (int i = 0; i < 30; ++i) ASSERT_EQ(speed(), kSpeed) << "for ever: " << i;
}

TEST_F(ModulesProgramsTest, ReportTheActivePilotAndTheParametersInForce) {
  auto& program = start("ChassisSim", {"--periodTime=20"});
  auto chassis_proxy = chassis();
  ASSERT_TRUE(chassis_proxy.on());
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(chassis_proxy.set_active_pilot(Address(0x00180100)));
  ASSERT_TRUE(chassis_proxy.set_active_pilot(rack::kNoPilot));
  ASSERT_TRUE(program.wait_for_line("No active pilot, set by GUI(0/0)"));
  const std::string all = program.output();
  EXPECT_NE(all.find("print: Active pilot is Pilot(0/1), set by GUI(0/0)"), std::string::npos);
  EXPECT_EQ(all.find("Active pilot is"), all.rfind("Active pilot is"))
      << "reported only when it changes";
  rack::Parameter speed;
  ASSERT_TRUE(speed.name.assign("vxMax"));
  speed.valueInt = 900;
  ASSERT_TRUE(chassis_proxy.set_param(speed));
  EXPECT_EQ(chassis_proxy.get_parameter()->vxMax.raw(), 700) << "until the next ON";
  ASSERT_TRUE(chassis_proxy.off());
  EXPECT_TRUE(
      eventually([&] { return chassis_proxy.get_parameter()->vxMax.raw() == 900; }, "the next ON"));
}

TEST_F(ModulesProgramsTest, RefuseOnWithoutAMap) {
  start("ChassisSim");
  start("OdometryChassis");
  const std::string path = "/nowhere/" + std::string(200, 'x') + ".dxf";
  start("LadarSim", {"--mapFile=" + path});
  const auto on = proxy<rack::OdometryProxy>(0x00140000).on();
  ASSERT_FALSE(on);
  EXPECT_NE(on.error().message().find("map /nowhere/xxx"), std::string::npos)
      << on.error().message();
}

TEST_F(ModulesProgramsTest, AKilledChassisDoesNotMoveTheRobot) {
  start("ChassisSim", {"--periodTime=20", "--moveDeadline=0"});
  start("OdometryChassis", {"--errorTimeout=50"});
  auto odometry = proxy<rack::OdometryProxy>(0x00120000);
  const auto x = [&] {
    const auto data = odometry.get_data();
    return data ? data->pos.x.raw() : -1;
  };
  ASSERT_TRUE(odometry.on());
  ASSERT_TRUE(chassis().set_active_pilot(Address(kWork)));
  ASSERT_TRUE(chassis().move(600, 0, 0));
  ASSERT_TRUE(eventually([&] { return x() > 100; }, "it drives"));
  const auto before = x();
  kill("ChassisSim");
  start("ChassisSim", {"--periodTime=20"});
  EXPECT_TRUE(
      eventually([&] { return status() == "enabled"; }, "the component that needs it turns it on"));
  EXPECT_TRUE(eventually([&] { return x() >= before; }, "where it was"));
  ASSERT_TRUE(odometry.off());
  ASSERT_TRUE(eventually([&] { return *odometry.status() == rack::Status::kDisabled; }, "off"));
  ASSERT_TRUE(odometry.on());
  EXPECT_EQ(x(), 0) << "like the original";
}

TEST_F(ModulesProgramsTest, SendStreams) {
  start_chassis();
  auto producer = chassis();
  Mailbox data = open(*session_, kData);
  EXPECT_FALSE(producer.get_cont_data(0, data.address())) << "it is off";
  ASSERT_TRUE(producer.on());
  const auto period = producer.get_cont_data(50, data.address());
  ASSERT_TRUE(period) << period.error().message();
  EXPECT_EQ(period->raw(), 40U);
  ChassisData first;
  ChassisData second;
  ASSERT_TRUE(producer.decode_stream(*data.peek_for(kPatience), first));
  ASSERT_TRUE(producer.decode_stream(*data.peek_for(kPatience), second));
  EXPECT_GT(second.recordingTime, first.recordingTime);
  ASSERT_TRUE(producer.stop_cont_data(data.address()));
}

TEST_F(ModulesProgramsTest, NotifyTheirListenersWhenTheyAreTurnedOff) {
  start_chassis();
  Mailbox data = open(*session_, kData);
  ASSERT_TRUE(chassis().on());
  ASSERT_TRUE(chassis().get_cont_data(0, data.address()));
  ASSERT_TRUE(chassis().off());
  EXPECT_TRUE(eventually([&] { return next_header(data).type == type::kError; }, "ERROR"));
}

TEST_F(ModulesProgramsTest, RemoveListenersThatHaveExited) {
  auto& program = start("ChassisSim", {"--periodTime=20", "--gdosLevel=3"});
  ASSERT_TRUE(chassis().on());
  {
    Mailbox data = open(*session_, kData);
    ASSERT_TRUE(chassis().get_cont_data(0, data.address()));
    EXPECT_EQ(next_header(data).type, type::kData);
  }
  const auto gone = program.wait_for_line("Listener Pilot(0/0):2 is gone");
  EXPECT_TRUE(gone) << gone.error().message();
}

TEST_F(ModulesProgramsTest, LimitTheNumberOfListeners) {
  auto& program = start("ChassisSim", {"--periodTime=20"});
  auto producer = chassis();
  ASSERT_TRUE(producer.on());
  constexpr int kMax = 64;
  std::vector<Mailbox> listeners;
  int taken = 0;
  for (int i = 0; i < 200; ++i) {
    listeners.push_back(
        open(*session_, 0x00190000U + static_cast<std::uint32_t>(i), {.slots = 2, .body_max = 64}));
    if (producer.get_cont_data(0, listeners.back().address())) ++taken;
  }
  EXPECT_EQ(taken, kMax);
  EXPECT_TRUE(program.wait_for_line("the maximum of 64 listeners is reached"));
  EXPECT_EQ(status(), "enabled") << "listeners that never read do not stop it";
}

// The longest period is 24 days: until then nothing is sent that would show that they are absent.
TEST_F(ModulesProgramsTest, GiveThePlacesOfAbsentListenersToThoseThatExist) {
  auto& program = start("ChassisSim", {"--periodTime=20", "--gdosLevel=3"});
  auto producer = chassis();
  ASSERT_TRUE(producer.on());
  for (std::uint32_t i = 0; i < 64; ++i)
    ASSERT_TRUE(producer.get_cont_data(0x7FFFFFFF, Address(0x00190000U + i)));
  Mailbox data = open(*session_, kData);
  // A report that a mailbox does not exist counts only when its request is a second old.
  ASSERT_TRUE(eventually([&]() -> std::string {
    const auto granted = producer.get_cont_data(0, data.address());
    return granted ? "" : granted.error().message();
  }));
  EXPECT_EQ(next_header(data).type, type::kData);
  EXPECT_TRUE(program.wait_for_line("is gone"));
}

TEST_F(ModulesProgramsTest, GiveEachComponentItsShareOfTheListenersPlaces) {
  auto& program = start("ChassisSim", {"--periodTime=20"});
  auto producer = chassis();
  ASSERT_TRUE(producer.on());
  std::vector<Mailbox> greedy;
  for (std::uint32_t i = 0; i < 64; ++i) {
    greedy.push_back(open(*session_, 0x00190000U + i, {.slots = 2, .body_max = 64}));
    ASSERT_TRUE(producer.get_cont_data(0x7FFFFFFF, greedy.back().address()));
  }
  Mailbox other = open(*session_, kData, {.body_max = 1 << 12});
  rack::ChassisProxy modest(other, Address(kChassis), {.data = kPatience});
  const auto granted = modest.get_cont_data(0, other.address());
  ASSERT_TRUE(granted) << granted.error().message();
  EXPECT_EQ(next_header(other).type, type::kData);
  EXPECT_TRUE(program.wait_for_line("which has most of the 64 places, is ended for Pilot(0/0)"));
  EXPECT_TRUE(eventually([&] { return next_header(greedy.back()).type == type::kError; }, "ERROR"));
}

TEST_F(ModulesProgramsTest, AcceptParameters) {
  start_chassis();
  auto chassis_proxy = chassis();
  const auto list = chassis_proxy.get_param();
  ASSERT_TRUE(list) << list.error().message();
  EXPECT_EQ(list->parameters.at(0).valueString, "ChassisSim");
  rack::Parameter speed;
  ASSERT_TRUE(speed.name.assign("vxMax"));
  speed.valueInt = 900;
  EXPECT_TRUE(chassis_proxy.set_param(speed));
  EXPECT_EQ(chassis_proxy.get_parameter()->vxMax.raw(), 900);
  speed.valueInt = -1;
  EXPECT_FALSE(chassis_proxy.set_param(speed));
  EXPECT_EQ(chassis_proxy.get_parameter()->vxMax.raw(), 900) << "the old value is kept";
}

TEST_F(ModulesProgramsTest, AcceptManyParametersInOneMessage) {
  start_chassis();
  rack::ParameterList list;
  for (const char* name : {"vxMax", "vxMin", "nobodyKnowsThis"}) {
    auto& record = list.parameters.emplace_back();
    ASSERT_TRUE(record.name.assign(name));
    record.valueInt = 77;
  }
  std::vector<std::byte> body(rack::encoded_size(list));
  ASSERT_TRUE(rack::encode(list, body));
  ASSERT_TRUE(work_->send({.dest = Address(kChassis), .type = type::kSetParam}, body));
  EXPECT_EQ(next_header(*work_).type, type::kOk);
  EXPECT_EQ(chassis().get_parameter()->vxMax.raw(), 77);
  EXPECT_EQ(chassis().get_parameter()->vxMin.raw(), 77);
}

TEST_F(ModulesProgramsTest, AnswerBodiesOfAnyLength) {
  start_chassis();
  ASSERT_TRUE(chassis().on());
  for (const std::int8_t command : {type::kGetData, type::kGetContData, type::kStopContData,
                                    type::kSetParam, std::int8_t{21}, std::int8_t{23}}) {
    for (const std::size_t size : {0U, 1U, 3U, 5U, 239U, 240U, 8192U}) {
      const std::vector<std::byte> body(size, std::byte{0xFF});
      ASSERT_TRUE(work_->send({.dest = Address(kChassis), .type = command}, body));
      EXPECT_EQ(next_header(*work_).type, type::kError) << int{command} << ", " << size << " bytes";
    }
  }
  ASSERT_TRUE(work_->send({.dest = Address(kChassis), .type = 99}));
  EXPECT_EQ(next_header(*work_).type, type::kError);
  EXPECT_EQ(status(), "enabled");
}

TEST_F(ModulesProgramsTest, SendTextsToTheSink) {
  Mailbox sink = open(*session_, text_sink().raw());
  start_chassis();
  const auto text = sink.peek_for(kPatience);
  ASSERT_TRUE(text);
  EXPECT_EQ(text->header().src, Address(kChassis));
  EXPECT_EQ(text->header().priority, 0);
  EXPECT_EQ(rack::gdos::level_of(text->header().type), rack::gdos::Level::kPrint);
  EXPECT_EQ(*rack::gdos::decode(text->body(), text->header().body_order()), "Init");
}

TEST_F(ModulesProgramsTest, ExitOnSignals) {
  for (const int signal : {SIGTERM, SIGINT}) {
    auto& program = start("ChassisSim", {"--targetStatus=1"});
    ASSERT_TRUE(program.wait_for_line("Module on"));
    const auto status = program.stop(signal);
    ASSERT_TRUE(status) << status.error().message();
    EXPECT_TRUE(status->success()) << status->to_string();
    EXPECT_NE(program.output().find("Module off"), std::string::npos);
    EXPECT_TRUE(program.output().ends_with("Terminated\n")) << program.output();
  }
}

TEST_F(ModulesProgramsTest, ReportWhyTheyCannotStart) {
  start_chassis();
  const std::string program = std::string(TIMS_PROGRAMS) + "/ChassisSim";
  auto second = ChildProcess::start({program}, at_router());
  ASSERT_TRUE(second);
  EXPECT_EQ(second->wait()->code, 1);
  EXPECT_NE(second->output().find("address in use: Chassis(0/0)"), std::string::npos)
      << second->output();
  auto wrong = ChildProcess::start({program, "--vxMax=fast"}, at_router());
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->wait()->code, 2);
  EXPECT_NE(wrong->output().find("--vxMax = fast: must be"), std::string::npos) << wrong->output();
}

// The components that are printed in the RACK paper.
TEST_F(ModulesProgramsTest, ExamplesRun) {
  auto& simple = start("SimpleModule");
  rack::Proxy module(*work_, Address(0x00100000));
  ASSERT_TRUE(module.on());
  EXPECT_TRUE(simple.wait_for_line("init something"));

  start_chassis();
  start("OdometryChassis");
  start("LadarSim", {"--mapFile", TIMS_SOURCES "/deploy/robots/floor.dxf"});
  start("Scan2dModule");
  auto scan2d = proxy<rack::Scan2dProxy>(0x00190000);
  const auto on = scan2d.on();
  ASSERT_TRUE(on) << on.error().message();
  const auto scan = scan2d.get_data();
  ASSERT_TRUE(scan) << scan.error().message();
  EXPECT_EQ(scan->points.size(), 361U);
}

}  // namespace modules_test
}  // namespace tims::test
