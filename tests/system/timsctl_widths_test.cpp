// timsctl at routers with other address widths, or that do not report their widths.
#include <csignal>
#include <fstream>

#include "tests/support/eventually.h"
#include "tests/support/model_router.h"
#include "tests/system/timsctl_fixture.h"

namespace tims::test {
namespace timsctl_widths_test {

// A fleet with few robots and many components of each class. The ladar is Ladar(3/500):2.
struct WidthsTest : TimsctlTest {
  static constexpr AddressWidths kWidths{6, 8, 10, 8};

  WidthsTest() : TimsctlTest({"address.widths=6/8/10/8", "router.system=3", "router.id=30"}) {}

  void SetUp() override {
    TimsctlTest::SetUp();
    if (!session_) return;
    const Address address = Address::of(
        {.system = 3, .class_id = class_id::kLadar, .instance = 500, .local = 2}, kWidths);
    auto mailbox = session_->open({.address = address, .slots = 64});
    ASSERT_TRUE(mailbox) << mailbox.error().message();
    ladar_.emplace(std::move(*mailbox));
  }

  // The local socket and TCP.
  std::vector<std::string> hosts() const {
    return {"unix:" + router_.socket_path(), router_.tcp()};
  }
};

TEST_F(WidthsTest, ASessionKnowsTheWidths) {
  EXPECT_EQ(session_->address_widths(), kWidths);
  const auto far = Session::connect({.name = "far", .router = router_.tcp()});
  ASSERT_TRUE(far) << far.error().message();
  EXPECT_EQ(far->address_widths(), kWidths);
}

// A chassis on the local socket, its odometry over TCP.
TEST_F(WidthsTest, ComponentsFindOthersBeyond255) {
  const auto start_at = [&](const std::string& router, std::vector<std::string> command) {
    command.front().insert(0, std::string(TIMS_PROGRAMS) + "/");
    return ChildProcess::start(command, {.environment = {"TIMS_ROUTER=" + router}, .folder = {}});
  };
  auto chassis = start_at(router_.socket_path(), {"ChassisSim", "--system=3", "--instance=500"});
  ASSERT_TRUE(chassis);
  EXPECT_TRUE(chassis->wait_for_line("Chassis(3/500) print: Init"));
  auto odometry = start_at(router_.tcp(), {"OdometryChassis", "--system=3", "--instance=700",
                                           "--chassisSys=3", "--chassisInst=500"});
  ASSERT_TRUE(odometry);
  EXPECT_TRUE(odometry->wait_for_line("Odometry(3/700) print: Init"));
  EXPECT_EQ(timsctl({"component", "on", "Odometry/3/700"}).out, "Odometry(3/700) ok\n");
  for (const std::string& host : hosts()) {
    const Ran echo =
        timsctl({"msg", "echo", "Odometry/3/700", "-n", "1", "-o", "json", "-H", host});
    EXPECT_THAT(echo.out, HasSubstr("\"Odometry(3/700)\"")) << echo.err;
  }
  EXPECT_EQ(timsctl({"component", "pilot", "Chassis/3/500", "Pilot/3/300"}).out, "Pilot(3/300)\n");
  EXPECT_THAT(timsctl({"msg", "echo", "Chassis/3/500", "-n", "1", "-o", "json"}).out,
              HasSubstr("\"activePilot\":\"Pilot(3/300)\""));
  const Ran large = timsctl({"component", "param", "set", "Odometry/3/700", "chassisInst", "1024"});
  EXPECT_NE(large.code, 0);
  EXPECT_TRUE(odometry->wait_for_line("chassisInst = 1024: must be a whole number from 0 to 1023"));
}

TEST_F(WidthsTest, AddressesAreParsedAndPrintedWithTheFleetsWidths) {
  EXPECT_THAT(timsctl({"status"}).out, HasSubstr("Tims(3/30)"));
  EXPECT_THAT(timsctl({"route", "show", "Ladar(3/500)"}).out, HasSubstr("Ladar(3/500):2"));
  EXPECT_THAT(timsctl({"route", "show", "Ladar(3/499)"}).out, Not(HasSubstr("Ladar(3/")));
  EXPECT_THAT(timsctl({"mbx", "list"}).out, HasSubstr("Ladar(3/500):2"));
  EXPECT_THAT(timsctl({"mbx", "show", "Ladar/3/500:2"}).out, HasSubstr("Ladar(3/500):2"));
  EXPECT_THAT(timsctl({"mbx", "show", "Ladar/3/501"}).err, HasSubstr("Ladar(3/501)"));
  EXPECT_THAT(timsctl({"route", "get", "Ladar/3/500:2"}).out, HasSubstr("Ladar(3/500):2: deliver"));
  EXPECT_EQ(timsctl({"explain", "Ladar/3/500:2", "Ladar/3/500:2"}).code, 0);
  EXPECT_THAT(timsctl({"explain", "Ladar/3/500:2", "Ladar/3/700"}).out,
              HasSubstr("has Ladar(3/700) registered"));
  EXPECT_THAT(timsctl({"-r", "Tims(3/30)", "status"}).out, HasSubstr("Tims(3/30)"));
  EXPECT_THAT(timsctl({"__complete", "route", "get", "L"}).out, HasSubstr("Ladar/3/500:2"));
  for (const char* verb : {"ping", "trace"}) {
    const Ran unknown = timsctl({verb, "Ladar/80/0"});
    EXPECT_EQ(unknown.code, 2) << "there is no system 80 with six bits";
    EXPECT_THAT(unknown.err, HasSubstr("is not an address"));
  }
}

TEST_F(WidthsTest, Components) {
  const auto at_router =
      ChildOptions{.environment = {"TIMS_ROUTER=" + router_.socket_path()}, .folder = {}};
  const std::string program = std::string(TIMS_PROGRAMS) + "/ChassisSim";
  auto chassis = ChildProcess::start({program, "--system=3", "--instance=500"}, at_router);
  ASSERT_TRUE(chassis);
  EXPECT_TRUE(chassis->wait_for_line("Chassis(3/500) print: Init"));
  EXPECT_EQ(timsctl({"component", "on", "Chassis/3/500"}).out, "Chassis(3/500) ok\n");
  EXPECT_EQ(timsctl({"component", "pilot", "Chassis/3/500", "Pilot/3/300"}).out, "Pilot(3/300)\n");
  const auto line = chassis->wait_for_line("Active pilot is ");
  ASSERT_TRUE(line);
  EXPECT_THAT(*line, HasSubstr("Pilot(3/300)"));
  auto wrong = ChildProcess::start({program, "--system=70"}, at_router);
  ASSERT_TRUE(wrong);
  const auto status = wrong->wait();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->code, 1);
  EXPECT_THAT(wrong->output(), HasSubstr("6 bits for the system and 10 for the instance"));
}

TEST_F(WidthsTest, Ping) {
  for (const std::string& host : hosts()) {
    auto ping = start({"ping", "Ladar/3/500:2", "-n", "1", "-H", host});
    ASSERT_TRUE(ping);
    answer(type::kGetStatus, type::kEnabled);
    EXPECT_THAT(finish(*ping).out, HasSubstr("Ladar(3/500):2: 1 sent, 1 answered"));
    EXPECT_THAT(timsctl({"ping", "Tims/3/30", "-n", "1", "-H", host}).out,
                HasSubstr("router Tims(3/30): 1 sent, 1 answered"));
  }
}

TEST_F(WidthsTest, Trace) {
  auto trace = start({"trace", "Ladar/3/500:2"});
  ASSERT_TRUE(trace);
  answer(type::kGetStatus, type::kEnabled);
  EXPECT_THAT(finish(*trace).out, HasSubstr("Ladar(3/500):2: enabled"));
}

TEST_F(WidthsTest, Pub) {
  for (const std::string& host : hosts()) {
    auto pub = start({"msg", "pub", "Ladar/3/500:2", "off", "-H", host});
    ASSERT_TRUE(pub);
    answer(type::kOff, type::kOk);
    EXPECT_THAT(finish(*pub).out, HasSubstr(" Ladar(3/500):2 ok\n"));
    EXPECT_THAT(timsctl({"msg", "pub", "Ladar/3/501", "off", "-H", host}).err,
                HasSubstr("Ladar(3/501)"));
  }
}

TEST_F(WidthsTest, EchoAndHz) {
  for (const std::string& host : hosts()) {
    auto echo = start({"msg", "echo", "Ladar/3/500:2", "-n", "1", "-H", host});
    ASSERT_TRUE(echo);
    const Address data = grant_subscription();
    EXPECT_EQ(data.fields(kWidths).class_id, class_id::kTool);
    ASSERT_TRUE(ladar_->send({.dest = data, .type = type::kData}));
    end_subscription();
    EXPECT_THAT(finish(*echo).out, HasSubstr(" Ladar(3/500):2 -> Tool("));

    auto hz = start({"msg", "hz", "Ladar/3/500:2", "-n", "1", "-i", "100ms", "-H", host});
    ASSERT_TRUE(hz);
    grant_subscription();
    end_subscription();
    EXPECT_THAT(finish(*hz).out, HasSubstr("Ladar(3/500):2 "));
  }
}

TEST_F(WidthsTest, EchoListens) {
  const Address own =
      Address::of({.system = 3, .class_id = class_id::kTest, .instance = 700}, kWidths);
  for (const std::string& host : hosts()) {
    auto echo = start({"msg", "echo", "--listen", "Test/3/700", "-n", "1", "-H", host});
    ASSERT_TRUE(echo);
    ASSERT_TRUE(echo->wait_for_line("Test(3/700) is registered"));
    ASSERT_TRUE(ladar_->send({.dest = own, .type = type::kData}));
    EXPECT_THAT(finish(*echo).out, HasSubstr("Ladar(3/500):2 -> Test(3/700) "));
  }
}

// A fleet in which 4095 robots have a system each.
struct ManySystemsTest : TimsctlTest {
  static constexpr AddressWidths kWidths{12, 8, 6, 6};

  ManySystemsTest()
      : TimsctlTest({"address.widths=12/8/6/6", "router.system=1000", "router.id=60"}) {}

  ChildProcess start_program(std::vector<std::string> command) {
    command.front().insert(0, std::string(TIMS_PROGRAMS) + "/");
    auto child = ChildProcess::start(std::move(command), options());
    EXPECT_TRUE(child) << child.error().message();
    return std::move(child).value();
  }
};

TEST_F(ManySystemsTest, ComponentsOfRobot1000) {
  EXPECT_THAT(timsctl({"status"}).out, HasSubstr("Tims(1000/60)"));
  // At 0x00010000, where texts go in a fleet with 8 bits a field.
  auto test = session_->open({.address = *Address::parse("Test(0/0)", kWidths), .slots = 16});
  ASSERT_TRUE(test) << test.error().message();
  EXPECT_EQ(test->address(), Address(0x00010000));
  auto follow = start({"log", "follow", "-c", "Chassis(1000/*)"});
  ASSERT_TRUE(follow);
  EXPECT_TRUE(eventually([&] { return timsctl({"route", "get", "GDOS/0/0"}).code == 0; }, "sink"));
  ChildProcess chassis = start_program({"ChassisSim", "--system=1000", "--instance=63"});
  EXPECT_TRUE(chassis.wait_for_line("Chassis(1000/63) print: Init"));
  EXPECT_TRUE(follow->wait_for_line("Chassis(1000/63)"));
  ChildProcess odometry =
      start_program({"OdometryChassis", "--system=1000", "--chassisSys=1000", "--chassisInst=63"});
  EXPECT_TRUE(odometry.wait_for_line("Odometry(1000/0) print: Init"));
  EXPECT_EQ(timsctl({"component", "on", "Odometry/1000/0"}).out, "Odometry(1000/0) ok\n");
  EXPECT_THAT(timsctl({"component", "data", "Chassis/1000/63"}).out, HasSubstr("vx: 0 mm/s"));
  ChildProcess ladar = start_program({"LadarSim", "--system=1000", "--odometrySys=1000",
                                      "--mapFile=" + router_.folder() + "/none.dxf"});
  EXPECT_TRUE(ladar.wait_for_line("Ladar(1000/0) print: Init"));
  EXPECT_FALSE(test->try_peek()) << "texts do not go to this component";
  const Ran large = timsctl({"component", "on", "Chassis/1000/64"});
  EXPECT_EQ(large.code, 2);
  EXPECT_THAT(large.err, HasSubstr("instance 64 is out of range: 0 to 63"));
  EXPECT_THAT(timsctl({"component", "list", "Chassis(4096/*)"}).err,
              HasSubstr("system 4096 is out of range: 0 to 4095"));
}

TEST_F(ManySystemsTest, ARobotFileOfAnySystem) {
  const std::string file = router_.folder() + "/robot.toml";
  std::ofstream(file) << "[[component]]\nprogram = \"ChassisSim\"\ninstance = 62\n";
  ChildOptions with_folder = options();
  with_folder.environment.push_back("XDG_RUNTIME_DIR=" + router_.folder());
  auto up = ChildProcess::start({TIMSCTL_PROGRAM, "up", file, "--system", "1000"}, with_folder);
  ASSERT_TRUE(up);
  EXPECT_TRUE(up->wait_for_line("1 of 1 programs are ready"));
  EXPECT_EQ(timsctl({"component", "status", "Chassis/1000/62"}).out, "Chassis(1000/62) off\n");
  up->signal(SIGTERM);
  finish(*up);
}

// It does not answer the request for the widths, so the default ones are used.
TEST_F(TimsctlTest, PingAtAnOriginalRouter) {
  const ModelRouter original({});
  const Ran ping = timsctl({"ping", "Camera/3/0", "-n", "1", "-H", original.endpoint()});
  EXPECT_EQ(ping.code, 4) << ping.err;
  EXPECT_THAT(ping.out, HasSubstr("Camera(3/0): this address is not registered"));
}

}  // namespace timsctl_widths_test
}  // namespace tims::test
