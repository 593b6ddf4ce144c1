// timsctl up and down: a robot is started, supervised and stopped.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

#include "os/file.h"
#include "tests/support/eventually.h"
#include "tests/system/timsctl_fixture.h"

namespace tims::test {
namespace timsctl_up_test {

namespace fs = std::filesystem;

class TimsctlUpTest : public TimsctlTest {
 protected:
  void SetUp() override {
    TimsctlTest::SetUp();
    // The folder in which running robots are registered.
    options_ = options();
    options_.environment.push_back("XDG_RUNTIME_DIR=" + router_.folder());
  }
  std::string write(const std::string& text) {
    std::string path = router_.folder() + "/robot.toml";
    std::ofstream(path) << text;
    return path;
  }
  ChildProcess begin(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), TIMSCTL_PROGRAM);
    auto child = ChildProcess::start(std::move(arguments), options_);
    EXPECT_TRUE(child) << child.error().message();
    return std::move(child).value();
  }
  Ran run(std::vector<std::string> arguments) {
    ChildProcess child = begin(std::move(arguments));
    return finish(child);
  }
  static std::string expect_line(ChildProcess& child, std::string_view part) {
    const auto line = child.wait_for_line(part);
    EXPECT_TRUE(line) << line.error().message();
    return line ? *line : std::string();
  }
  // The process that owns an address.
  pid_t owner_of(const std::string& address) {
    const Ran ran = timsctl({"mbx", "list", address, "--json"});
    const json::object answer = json_lines(ran.out).at(0);
    const json::object& first = answer.at("items").as_array().at(0).as_object();
    return static_cast<pid_t>(first.at("owner").as_object().at("pid").as_int64());
  }

  ChildOptions options_;
};

constexpr const char* kOneChassis = R"(
[[component]]
program = "ChassisSim"
)";

TEST_F(TimsctlUpTest, ProgramsReportErrorsInTheirCommandLine) {
  const struct {
    const char* program;
    std::vector<std::string> arguments;
    const char* message;
    const char* hint;
  } cases[] = {
      {"-robot", {}, "the verb is missing", "known: up, down, show, save"},
      {"-robot", {"shwo"}, "no verb \"shwo\"", "did you mean show?"},
      {"-sim", {"bogus"}, "no verb \"bogus\"", "timsctl-sim --help"},
      {"-robot", {"up"}, "up: FILE is missing", "timsctl-robot up FILE"},
      {"-sim", {"start", "a", "b"}, "unexpected argument \"b\"", "timsctl-sim start HOST"},
      {"-robot", {"down", "--quite"}, "down has no option --quite", "did you mean --quiet?"},
      {"-robot", {"-j"}, "", ""},
  };
  for (const auto& c : cases) {
    std::vector<std::string> command = c.arguments;
    command.insert(command.begin(), std::string(TIMSCTL_PROGRAM) + c.program);
    auto child = ChildProcess::start(command, options_);
    ASSERT_TRUE(child) << child.error().message();
    const Ran ran = finish(*child);
    EXPECT_EQ(ran.code, 2) << testing::PrintToString(command);
    EXPECT_THAT(ran.err, HasSubstr(c.message));
    EXPECT_THAT(ran.err, HasSubstr(c.hint));
  }
}

TEST_F(TimsctlUpTest, TheSampleRobotIsStartedAndStopped) {
  ChildProcess up = begin({"up", std::string(TIMS_ROBOTS) + "/sim.toml", "--system", "3"});
  expect_line(up, "sim-3                6 of 6 programs are ready");
  EXPECT_EQ(timsctl({"component", "on", "Chassis/3/0"}).code, 0);
  EXPECT_EQ(timsctl({"component", "pilot", "Chassis/3/0"}).out, "none\n");
  EXPECT_THAT(timsctl({"component", "on", "Pilot/3/1"}).err,
              HasSubstr("Pilot(3/1) is not the active pilot of this chassis, which has none"));
  EXPECT_EQ(timsctl({"component", "pilot", "Chassis/3/0", "Pilot/3/1"}).out, "Pilot(3/1)\n");
  EXPECT_EQ(timsctl({"component", "on", "Pilot/3/1"}).out, "Pilot(3/1) ok\n");
  EXPECT_THAT(timsctl({"component", "param", "get", "Pilot/3/1", "mode"}).out, HasSubstr("0"))
      << "it follows walls";
  EXPECT_TRUE(eventually(
      [&] {
        return timsctl({"component", "pilot", "Chassis/3/0"}).out == "Pilot(3/1)\n";
      },
      "the chassis reports its pilot"));
  up.signal(SIGINT);
  const Ran ran = finish(up);
  EXPECT_EQ(ran.code, 0);
  EXPECT_THAT(ran.out, HasSubstr("Chassis(3/0) print: Terminated"));
  EXPECT_THAT(ran.out.substr(ran.out.find("Terminated")), Not(HasSubstr("error: ")));
  EXPECT_EQ(timsctl({"route", "get", "Chassis/3/0"}).code, 1) << "all components have exited";
}

TEST_F(TimsctlUpTest, ACommandFindsProgramsInTheFolderOfTimsctl) {
  ChildProcess up = begin({"up", write("[[component]]\ncommand = 'nice -n 1 ChassisSim'\n")});
  expect_line(up, "Chassis(0/0) print: Init");
}

TEST_F(TimsctlUpTest, ACrashedComponentIsRestartedInItsState) {
  ChildProcess up = begin({"up", write(kOneChassis)});
  expect_line(up, "1 of 1 programs are ready");
  EXPECT_EQ(timsctl({"component", "on", "Chassis/0/0"}).code, 0);
  expect_line(up, "Module on");
  EXPECT_EQ(timsctl({"component", "param", "set", "Chassis/0/0", "vxMax", "901"}).code, 0);
  EXPECT_EQ(timsctl({"component", "param", "set", "Chassis/0/0", "vxMax", "902"}).code, 0);
  ::kill(owner_of("Chassis(0/0)"), SIGKILL);
  expect_line(up, "killed by signal 9: restart in 0.2 s");
  expect_line(up, "Module on");
  EXPECT_EQ(timsctl({"component", "status", "Chassis/0/0", "--wait"}).code, 0);
  EXPECT_THAT(timsctl({"component", "param", "get", "Chassis/0/0", "vxMax"}).out, HasSubstr("902"));
}

TEST_F(TimsctlUpTest, AComponentTurnedOffByAUserStaysOff) {
  ChildProcess up = begin({"up", write(R"(
[[component]]
program = "ChassisSim"
parameters = { targetStatus = 1 }

[[component]]
program = "OdometryChassis"
parameters = { targetStatus = 1, errorTimeout = 100, gdosLevel = 3 }
)")});
  expect_line(up, "2 of 2 programs are ready");
  EXPECT_EQ(timsctl({"component", "status", "Odometry/0/0", "--wait"}).code, 0);
  EXPECT_EQ(timsctl({"component", "off", "Chassis/0/0"}).code, 0);
  expect_line(up, "has turned it off");
  ::kill(owner_of("Chassis(0/0)"), SIGKILL);
  expect_line(up, "killed by signal 9: restart in 0.2 s");
  expect_line(up, "has turned it off; only an operator can turn it on again");
  EXPECT_EQ(timsctl({"component", "status", "Chassis/0/0"}).out, "Chassis(0/0) off\n");
  EXPECT_EQ(timsctl({"component", "on", "Chassis/0/0"}).code, 0);
  ::kill(owner_of("Chassis(0/0)"), SIGKILL);
  expect_line(up, "restart in");
  EXPECT_EQ(timsctl({"component", "status", "Chassis/0/0", "--wait"}).code, 0) << "on again";
}

// In the simulation the robot is at the position of the odometry.
TEST_F(TimsctlUpTest, ACrashDoesNotMoveTheRobot) {
  ChildProcess up = begin({"up", std::string(TIMS_ROBOTS) + "/sim.toml", "--system", "3"});
  expect_line(up, "6 of 6 programs are ready");
  const auto x_of = [&](const std::string& component) {
    const Ran ran = timsctl({"component", "data", component, "--json"});
    if (ran.code != 0) return -1.0;
    const json::object answer = json_lines(ran.out).at(0);
    return answer.at("data").at("pos").at("x").to_number<double>();
  };
  const auto x = [&] { return x_of("Odometry/3/0"); };
  // The first value after a restart.
  const auto next_x_of = [&](const std::string& component) {
    double value = -1;
    EXPECT_TRUE(eventually([&] { return (value = x_of(component)) >= 0; }, component + " data"));
    return value;
  };
  ASSERT_EQ(timsctl({"component", "on", "Chassis/3/0"}).code, 0);
  ASSERT_EQ(timsctl({"component", "pilot", "Chassis/3/0", "Pilot/3/1"}).code, 0);
  const Ran on = timsctl({"component", "on", "Pilot/3/1"});
  ASSERT_EQ(on.code, 0) << on.err;
  const double start = x();
  ASSERT_TRUE(eventually([&] { return x() > start + 100; }, "it drives"));
  ASSERT_EQ(timsctl({"component", "off", "Pilot/3/1"}).code, 0);
  ASSERT_EQ(timsctl({"component", "on", "Position/3/0"}).code, 0);
  double before = 0;
  ASSERT_TRUE(eventually([&] { return std::exchange(before, x()) == before; }, "it stands"));
  const double position = next_x_of("Position/3/0");
  for (const std::string name : {"Chassis", "Odometry"}) {
    ::kill(owner_of(name + "(3/0)"), SIGKILL);
    expect_line(up, "restart in");
    for (const char* component : {"Chassis/3/0", "Odometry/3/0", "Position/3/0"})
      EXPECT_TRUE(eventually(
          [&] {
            return timsctl({"component", "status", component}).code == 0;
          },
          component));
    EXPECT_NEAR(next_x_of("Odometry/3/0"), before, 2) << name;
    EXPECT_NEAR(next_x_of("Position/3/0"), position, 2) << name;
  }
}

// As the back-trace of a component: another process writes it after the crash, perhaps after the
// restart.
TEST_F(TimsctlUpTest, OutputAfterTheEndIsShown) {
  std::ofstream(router_.folder() + "/late.sh")
      << "(while [ -d " << router_.folder()
      << "/wait ]; do sleep 0.05; done; echo late) & kill -9 $$\n";
  fs::create_directory(router_.folder() + "/wait");
  ChildProcess up = begin({"up", write("[[component]]\ncommand = \"sh late.sh\"\n")});
  expect_line(up, "killed by signal 9: restart in");
  expect_line(up, "restarted");
  fs::remove(router_.folder() + "/wait");
  expect_line(up, "late");
}

// What they report while the supervisor does not run is more than the queue of a datagram socket
// has room for.
TEST_F(TimsctlUpTest, NothingIsLostOfWhatManyProgramsReportAtOnce) {
  constexpr int kMany = 12;
  std::string text;
  for (int i = 0; i < kMany; ++i)
    text += fmt::format(
        "[[component]]\nprogram = 'ChassisSim'\ninstance = {}\nparameters = {{ targetStatus = 1 "
        "}}\n",
        i);
  ChildProcess up = begin({"up", write(text)});
  expect_line(up, fmt::format("{0} of {0} programs are ready", kMany));
  const auto name = [](int i) { return fmt::format("Chassis/0/{}", i); };
  std::vector<pid_t> owners;
  for (int i = 0; i < kMany; ++i) {
    EXPECT_EQ(timsctl({"component", "status", name(i), "--wait"}).code, 0);
    owners.push_back(owner_of(fmt::format("Chassis(0/{})", i)));
  }
  up.signal(SIGSTOP);
  for (int i = 0; i < kMany; ++i) EXPECT_EQ(timsctl({"component", "off", name(i)}).code, 0);
  for (const pid_t owner : owners) ::kill(owner, SIGKILL);
  up.signal(SIGCONT);
  for (int i = 0; i < kMany; ++i) {
    EXPECT_TRUE(eventually(
        [&] {
          const Ran ran = timsctl({"component", "status", name(i)});
          return ran.out == fmt::format("Chassis(0/{}) off\n", i);
        },
        name(i) + " is off"));
    EXPECT_NE(owner_of(fmt::format("Chassis(0/{})", i)), owners[static_cast<std::size_t>(i)]);
  }
}

// Eight writers at one pipe, as fast as they can.
TEST_F(TimsctlUpTest, AFloodIsCutAndStopsNothing) {
  std::ofstream(router_.folder() + "/flood.sh")
      << "for i in 1 2 3 4 5 6 7 8; do yes \"flood $i\" & done; wait\n";
  ChildProcess up =
      begin({"up", write(std::string("[[component]]\ncommand = \"sh flood.sh\"\n") + kOneChassis)});
  expect_line(up, "lines are not shown: it prints more than 50 lines a second");
  ASSERT_TRUE(eventually(
      [&] {
        return timsctl({"route", "get", "Chassis/0/0"}).code == 0;
      },
      "the component runs"));
  EXPECT_THAT(run({"robot"}).out, HasSubstr("ChassisSim"));
  ::kill(owner_of("Chassis(0/0)"), SIGKILL);
  expect_line(up, "killed by signal 9: restart in 0.2 s");
  expect_line(up, "Chassis(0/0) print: Init");
  EXPECT_EQ(run({"down"}).code, 0);
  EXPECT_EQ(finish(up).code, 0);
}

// As a terminal after Ctrl-S.
TEST_F(TimsctlUpTest, AReaderThatHasStoppedStopsNothing) {
  const std::string fifo = router_.folder() + "/fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const os::File reader(::open(fifo.c_str(), O_RDWR | O_CLOEXEC));
  std::ofstream(router_.folder() + "/flood.sh")
      << "yes \"" << std::string(1000, 'x') << "\" | head -n 1000; exec sleep 1000\n";
  const std::string file =
      write(std::string("[[component]]\ncommand = \"sh flood.sh\"\n") + kOneChassis);
  auto up = ChildProcess::start({"sh", "-c", "exec " TIMSCTL_PROGRAM " up " + file + " > " + fifo},
                                options_);
  ASSERT_TRUE(up) << up.error().message();
  ASSERT_TRUE(eventually(
      [&] {
        return timsctl({"route", "get", "Chassis/0/0"}).code == 0;
      },
      "the component runs"));
  const pid_t owner = owner_of("Chassis(0/0)");
  int before = 0;
  ASSERT_TRUE(eventually(
      [&] {
        int waiting = 0;
        if (::ioctl(reader.get(), FIONREAD, &waiting) != 0) return false;
        return std::exchange(before, waiting) == waiting && waiting > 10'000;
      },
      "the pipe is full"));
  ::kill(owner, SIGKILL);
  EXPECT_TRUE(eventually(
      [&] {
        return timsctl({"route", "get", "Chassis/0/0"}).code == 0 &&
               owner_of("Chassis(0/0)") != owner;
      },
      "it is restarted"));
  EXPECT_EQ(run({"down"}).code, 0);
  EXPECT_TRUE(up->wait().ok());
}

TEST_F(TimsctlUpTest, DependentsStartQuietlyInAnyOrder) {
  std::ofstream(router_.folder() + "/late.sh")
      << "sleep 1; exec " << TIMS_PROGRAMS << "/ChassisSim --system=0\n";
  ChildProcess up = begin({"up", write(R"(
[[component]]
program = "Position"
parameters = { targetStatus = 1 }

[[component]]
program = "OdometryChassis"
parameters = { targetStatus = 1 }

[[component]]
command = "sh late.sh"
)")});
  EXPECT_EQ(timsctl({"component", "status", "Position/0/0", "--wait"}).code, 0);
  EXPECT_EQ(timsctl({"component", "status", "Odometry/0/0", "--wait"}).code, 0);
  up.signal(SIGINT);
  const Ran ran = finish(up);
  EXPECT_THAT(ran.out, Not(HasSubstr("rror")));
  EXPECT_THAT(ran.out, Not(HasSubstr("warning")));
}

// It may drive as soon as it is the active pilot; until then it fails again and again.
TEST_F(TimsctlUpTest, ARefusedPilotIsReportedOnce) {
  std::ifstream stream(std::string(TIMS_ROBOTS) + "/sim.toml");
  std::string text(std::istreambuf_iterator<char>(stream), {});
  const std::string pilot = "program = \"PilotWallFollowing\"";
  const std::size_t at = text.find("parameters = {", text.find(pilot));
  ASSERT_NE(at, std::string::npos);
  text.insert(at + std::string_view("parameters = {").size(), " errorTimeout = 50, gdosLevel = 3,");
  fs::copy_file(FLOOR_PLAN, router_.folder() + "/floor.dxf");
  ChildProcess up = begin({"up", write(text), "--system", "3"});
  expect_line(up, "programs are ready");
  ASSERT_EQ(timsctl({"component", "on", "Chassis/3/0"}).code, 0);
  ASSERT_EQ(timsctl({"component", "pilot", "Chassis/3/0", "Pilot/3/1"}).code, 0);
  const Ran on = timsctl({"component", "on", "Pilot/3/1"});
  ASSERT_EQ(on.code, 0) << on.err;
  ASSERT_EQ(timsctl({"component", "pilot", "Chassis/3/0", "none"}).code, 0);
  // At its level of information it repeats each failure.
  for (int i = 0; i < 10; ++i) expect_line(up, "is not the active pilot");
  up.signal(SIGINT);
  std::istringstream lines(finish(up).out);
  int warnings = 0;
  for (std::string line; std::getline(lines, line);)
    warnings += line.find("not the active pilot") != std::string::npos &&
                        line.find(" info") == std::string::npos
                    ? 1
                    : 0;
  EXPECT_LE(warnings, 4) << lines.str();
}

TEST_F(TimsctlUpTest, ACopyOfARunningRobotIsRefused) {
  const std::string file = write(kOneChassis);
  const std::string copy = router_.folder() + "/copy.toml";
  fs::copy_file(file, copy);
  ChildProcess up = begin({"up", file});
  expect_line(up, "1 of 1 programs are ready");
  const Ran ran = run({"up", copy});
  EXPECT_EQ(ran.code, 5);
  EXPECT_THAT(ran.err, HasSubstr("robot robot (" + file + ") already runs ChassisSim, system 0"));
  EXPECT_THAT(ran.err, HasSubstr("`timsctl down robot` stops it"));
  ChildProcess second = begin({"up", copy, "--system", "1"});
  expect_line(second, "1 of 1 programs are ready");
}

TEST_F(TimsctlUpTest, ChangedParametersAreSavedInItsFile) {
  const std::string before =
      "# mine\n[[component]]\nprogram = \"ChassisSim\"\nparameters = { vxMax = 700 } # slow\n";
  const std::string after =
      "# mine\n[[component]]\nprogram = \"ChassisSim\"\n"
      "parameters = { vxMax = 901, accMax = 50 } # slow\n";
  const std::string file = write(before);
  fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write | fs::perms::others_read);
  const auto text = [&] {
    std::ifstream stream(file);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  const auto set = [&](const char* name, const char* value) {
    EXPECT_EQ(timsctl({"component", "param", "set", "Chassis/0/0", name, value}).code, 0);
  };
  ChildProcess up = begin({"up", file});
  expect_line(up, "1 of 1 programs are ready");
  EXPECT_THAT(run({"component", "param", "save", "Chassis/0/0"}).err,
              HasSubstr("no parameters differ"));
  set("vxMax", "901");
  const Ran dry = run({"component", "param", "save", "Chassis/0/0", "--dry-run"});
  EXPECT_EQ(dry.out, "vxMax = 901 (was 700)\n");
  EXPECT_THAT(dry.err, HasSubstr("Chassis(0/0): would be written to " + file));
  EXPECT_EQ(text(), before);
  EXPECT_EQ(run({"component", "param", "save", "Chassis/0/0"}).code, 0);
  set("accMax", "50");
  const Ran again = run({"component", "param", "save", "Chassis/0/0", "accMax", "-j"});
  const json::object saved = json_lines(again.out).at(0);
  EXPECT_TRUE(saved.at("written").as_bool());
  EXPECT_EQ(saved.at("file").as_string(), file);
  EXPECT_EQ(text(), after);
  EXPECT_EQ(fs::status(file).permissions(),
            fs::perms::owner_read | fs::perms::owner_write | fs::perms::others_read);
  EXPECT_FALSE(fs::exists(file + ".new"));

  write(after + "# changed\n");
  set("vxMax", "902");
  const Ran changed = run({"component", "param", "save", "Chassis/0/0"});
  EXPECT_EQ(changed.code, 1);
  EXPECT_THAT(changed.err,
              HasSubstr("robot.toml has changed since this robot was started from it"));
  EXPECT_EQ(text(), after + "# changed\n");
  const Ran none = run({"component", "param", "save", "Ladar/0/0"});
  EXPECT_EQ(none.code, 4);
  EXPECT_THAT(none.err, HasSubstr("no robot started by `timsctl up` on this host"));
  EXPECT_EQ(run({"component", "param", "save", "Chassis/0/0", "vxMax", "1"}).code, 2);
}

TEST_F(TimsctlUpTest, AComponentWithWrongArgumentsIsNotRestarted) {
  const Ran ran =
      run({"up", write("[[component]]\nprogram = \"ChassisSim\"\nparameters = { vxMx = 1 }"),
           "--for", "1ms"});
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.out, HasSubstr("vxMx"));
  EXPECT_THAT(ran.out, HasSubstr("exit status 2: not restarted"));
  EXPECT_THAT(ran.out, HasSubstr("0 of 1 programs are ready, 1 ended"));
}

TEST_F(TimsctlUpTest, AFileWithMistakesStartsNothing) {
  const Ran ran = run({"up", write("[[component]]\nprogramm = \"ChassisSim\"")});
  EXPECT_EQ(ran.code, 1);
  EXPECT_THAT(ran.err, HasSubstr("robot.toml:2:1: unknown key of [[component]] \"programm\""));
  EXPECT_EQ(run({"up", "/nowhere.toml"}).code, 4);
}

TEST_F(TimsctlUpTest, AMissingProgram) {
  const Ran ran = run({"up", write("[[component]]\nprogram = \"ChasisSim\"")});
  EXPECT_EQ(ran.code, 4);
  EXPECT_THAT(ran.err, HasSubstr("cannot run ChasisSim"));
}

TEST_F(TimsctlUpTest, InTheBackgroundUntilDown) {
  const std::string file = write(kOneChassis);
  EXPECT_EQ(run({"up", file, "--detach"}).code, 0);
  EXPECT_EQ(timsctl({"component", "status", "Chassis/0/0"}).out, "Chassis(0/0) off\n");
  EXPECT_THAT(run({"robot"}).out, HasSubstr("robot  ChassisSim"));
  const Ran again = run({"up", file});
  EXPECT_EQ(again.code, 5);
  EXPECT_THAT(again.err, HasSubstr("robot robot is already running"));
  EXPECT_EQ(run({"down", "other"}).code, 4);
  EXPECT_EQ(run({"down"}).code, 0);
  EXPECT_EQ(timsctl({"route", "get", "Chassis/0/0"}).code, 1);
  EXPECT_EQ(run({"down"}).code, 4);
}

TEST_F(TimsctlUpTest, RobotTellsDeadFromOff) {
  const std::string file = write("restart = \"never\"" + std::string(kOneChassis));
  EXPECT_EQ(run({"up", file, "--detach"}).code, 0);
  const auto shows = [&](std::string_view part) {
    return eventually([&] { return run({"robot"}).out.find(part) != std::string::npos; },
                      std::string(part));
  };
  EXPECT_TRUE(shows("  off  "));
  ::kill(owner_of("Chassis/0/0"), SIGKILL);
  EXPECT_TRUE(shows("dead: killed by signal 9, not restarted"));
  EXPECT_EQ(run({"down"}).code, 0);
}

TEST_F(TimsctlUpTest, TwoOfOneNameAtTwoRouters) {
  RouterProcess other;
  const auto started = other.start();
  ASSERT_TRUE(started) << started.error().message();
  const std::string there = "unix:" + other.socket_path();
  const std::string file = write(kOneChassis);
  ChildProcess here_up = begin({"up", file});
  expect_line(here_up, "1 of 1 programs are ready");
  ChildProcess there_up = begin({"up", file, "-H", there});
  expect_line(there_up, "1 of 1 programs are ready");
  EXPECT_THAT(run({"robot", "-o", "plain"}).out, HasSubstr(other.socket_path()));
  EXPECT_EQ(run({"up", file, "-H", there}).code, 5) << "but not twice at one router";
  EXPECT_EQ(run({"__complete", "down", ""}).out, "robot\n");
  EXPECT_EQ(run({"down", "robot", "-H", there}).code, 0);
  EXPECT_EQ(finish(there_up).code, 0);
  EXPECT_EQ(timsctl({"route", "get", "Chassis/0/0"}).code, 0) << "this one keeps running";
  EXPECT_EQ(run({"down"}).code, 0);
  EXPECT_EQ(finish(here_up).code, 0);
}

TEST_F(TimsctlUpTest, AnUnknownHost) {
  const Ran ran = run({"up",
                       write("[host.arm]\nssh = \"pi@arm\"\n"
                             "[[component]]\nprogram = \"ChassisSim\"\nhost = \"arm\""),
                       "--on", "amr"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("did you mean arm?"));
}

TEST_F(TimsctlUpTest, BeforeItsRouterRuns) {
  router_.kill();
  ChildProcess up = begin({"up", write(kOneChassis)});
  expect_line(up, "ChassisSim: waiting for a router");
  up.signal(SIGTERM);
  const auto status = up.wait();
  ASSERT_TRUE(status) << status.error().message();
  EXPECT_TRUE(status->success());
  EXPECT_THAT(up.output(), HasSubstr("exit status 0")) << "it did not have to be killed";
}

// ssh is replaced by a script that runs the command on this host until its stdin ends.
TEST_F(TimsctlUpTest, OnAnotherHost) {
  const std::string ssh = router_.folder() + "/ssh";
  std::ofstream(ssh) << "#!/bin/sh\nshift 3\nPATH=" TIMS_PROGRAMS ":$PATH exec \"$@\"\n";
  fs::permissions(ssh, fs::perms::owner_all);
  options_.environment.push_back("PATH=" + router_.folder() + ":/usr/bin:/bin");
  ChildProcess up = begin({"up", write(R"(
[host.arm]
ssh = "pi@arm"
[[component]]
program = "ChassisSim"
host = "arm"
)")});
  expect_line(up, "1 of 1 programs are ready");
  expect_line(up, "robot-arm            1 of 1 programs are ready");
  EXPECT_EQ(timsctl({"component", "status", "Chassis/0/0"}).out, "Chassis(0/0) off\n");
  up.signal(SIGINT);
  EXPECT_EQ(finish(up).code, 0);
  EXPECT_EQ(timsctl({"route", "get", "Chassis/0/0"}).code, 1);
}

}  // namespace timsctl_up_test
}  // namespace tims::test
