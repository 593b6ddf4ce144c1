// The configuration of two hosts and a robot, changed by `timsctl config` through their agents:
// what is shown, refused, kept, undone, and what goes back by itself.
#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "base/measure.h"
#include "tests/support/child_process.h"
#include "tests/support/eventually.h"
#include "tests/support/patience.h"
#include "tests/support/temporary_folder.h"
#include "tims/session.h"

namespace tims::test {
namespace configuration_test {

namespace fs = std::filesystem;
namespace json = boost::json;
using testing::HasSubstr;

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A loopback address of this process alone: the routers keep their UDP ports over a restart, and no
// port that somebody else was given meanwhile is theirs.
std::string own_address() {
  const unsigned pid = static_cast<unsigned>(::getpid());
  return "127." + std::to_string(1 + (pid >> 16) % 254) + "." + std::to_string(pid >> 8 & 255) +
         "." + std::to_string(pid & 255);
}

struct Ended {
  int code = -1;
  std::string out;
  std::string err;
};

// A host: its configuration folder, its router, which a service manager would start again, and its
// agent.
class Host {
 public:
  explicit Host(const std::string& router) {
    fs::create_directories(folder() / "robots");
    std::ofstream(folder() / "router.toml") << router << "[unix]\npath = \"" << socket() << "\"\n";
  }
  ~Host() {
    if (robot_) (void)robot_->stop(SIGINT, kPatience);
    if (agent_) (void)agent_->stop(SIGTERM, kPatience);
    if (router_) (void)router_->stop(SIGTERM, kPatience);
  }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  [[nodiscard]] fs::path folder() const { return folder_.path() / "etc"; }
  [[nodiscard]] std::string socket() const { return folder_.path() / "router.sock"; }

  void start() {
    const std::string again =
        "trap 'kill $p; wait $p; exit' TERM\n"
        "while :; do " TIMS_PROGRAMS "/tims-router --config " +
        (folder() / "router.toml").string() + " & p=$!; wait $p; done";
    router_ = started({"/bin/bash", "-c", again});
    EXPECT_TRUE(eventually([&] { return timsctl({"status"}).code == 0; }, "the router answers"));
    start_agent();
  }
  void start_agent() {
    agent_ = started({TIMS_PROGRAMS "/tims-agent", "--folder=" + folder().string(),
                      "--state=" + (folder_.path() / "state").string(), "--least-window=8s"});
    EXPECT_TRUE(agent_->wait_for_line("answers as"));
  }
  void kill_agent() {
    agent_->signal(SIGKILL);
    (void)agent_->wait();
  }
  [[nodiscard]] ChildProcess& agent() { return *agent_; }
  [[nodiscard]] ChildProcess& router() { return *router_; }
  void start_robot(const std::string& name) {
    robot_ = started({TIMSCTL_PROGRAM, "up", (folder() / "robots" / name).string()});
    EXPECT_TRUE(robot_->wait_for_line("programs are ready"));
  }

  // `limit`: what a command may take that waits for hosts.
  Ended timsctl(std::vector<std::string> arguments, Duration limit = kPatience) const {
    arguments.insert(arguments.begin(), TIMSCTL_PROGRAM);
    arguments.push_back(limit == kPatience ? "--timeout=" + std::to_string(kPatienceMs) + "ms"
                                           : "--timeout=2s");
    auto child = ChildProcess::start(std::move(arguments), options());
    EXPECT_TRUE(child) << child.error().message();
    const auto status = child->wait(limit);
    return {.code = status ? status->code : -1,
            .out = child->standard_output(),
            .err = child->standard_error()};
  }

  std::unique_ptr<ChildProcess> start_timsctl(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), TIMSCTL_PROGRAM);
    return started(std::move(arguments));
  }

  // One question to the agent of this host, as another program of the host asks.
  json::object ask(const json::object& question, Address agent) const {
    auto session = Session::connect({.name = "editor", .router = socket(), .timeout = kPatience});
    EXPECT_TRUE(session) << session.error().message();
    auto mailbox = session->open({.address = Address(0x01100100), .body_max = 256U << 10});
    EXPECT_TRUE(mailbox) << mailbox.error().message();
    const std::string text = json::serialize(question);
    EXPECT_TRUE(mailbox->send({.dest = agent, .type = type::kAdminRequest},
                              std::as_bytes(std::span(text))));
    auto answer = mailbox->peek_for(kPatience);
    EXPECT_TRUE(answer) << answer.error().message();
    if (!answer) return {};
    const std::string body(reinterpret_cast<const char*>(answer->body().data()),
                           answer->body().size());
    return json::parse(body).as_object();
  }

 private:
  [[nodiscard]] ChildOptions options() const {
    return {.environment = {"TIMS_ROUTER=" + socket(), "TIMS_HOST=", "NO_COLOR=1",
                            "XDG_RUNTIME_DIR=" + folder_.path().string()},
            .folder = {}};
  }
  std::unique_ptr<ChildProcess> started(std::vector<std::string> command) const {
    auto child = ChildProcess::start(std::move(command), options());
    EXPECT_TRUE(child) << child.error().message();
    return std::make_unique<ChildProcess>(std::move(*child));
  }

  TemporaryFolder folder_;
  std::unique_ptr<ChildProcess> router_;
  std::unique_ptr<ChildProcess> agent_;
  std::unique_ptr<ChildProcess> robot_;
};

constexpr Address kBaseAgent(0x00000101);
constexpr Address kRobotAgent(0x01000101);

constexpr std::string_view kScout =
    "# The scout.   Two blanks stay two.\r\n"
    "name = \"scout\"\n"
    "system = 1\n"
    "\n"
    "[[component]]   # its drive\n"
    "program = \"ChassisSim\"\n"
    "parameters = { vxMax = 800, accMax = 500 } # mm/s\n"
    "\n"
    "[[component]]\n"
    "program = \"OdometryChassis\"\n"
    "parameters = { chassisSys = \"{system}\" }\n";

class ConfigurationTest : public testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(robot_.folder() / "robots" / "scout.toml") << kScout;
    base_.start();
    robot_.start();
    EXPECT_TRUE(eventually(
        [&] {
          return base_.timsctl({"config", "history", "-r", "robot1"}).code == 0;
        },
        "the base reaches the agent of the robot"));
  }

  static std::string common(const std::string& name, const std::string& role, int system,
                            const std::string& udp) {
    return "# of " + name + "\n[router]\nname = \"" + name + "\"\nrole = \"" + role +
           "\"\nsystem = " + std::to_string(system) +
           "\nid = 1\n[tcp]\nlisten = \"127.0.0.1:0\"\n[http]\nlisten = \"off\"\n" +
           "[udp]\nlisten = \"" + udp + "\"\n";
  }

  [[nodiscard]] std::string scout() const {
    return text_of(robot_.folder() / "robots" / "scout.toml");
  }
  [[nodiscard]] std::string state_of(const Host& host, Address agent) const {
    return std::string(host.ask({{"ask", "conf_state"}}, agent).at("state").as_string());
  }

  const std::string base_udp_ = own_address() + ":20100";
  Host base_{common("base", "top", 0, base_udp_) + "[[link]]\nkind = \"sub\"\nsystem = \"*\"\n"};
  Host robot_{common("robot1", "system", 1, own_address() + ":20101") +
              "[[link]]\nkind = \"super\"\nto = \"" + base_udp_ + "\"\n"};
  const std::string max_speed_ = "robot1@robots/scout.toml:component[0].parameters.vxMax";
};

TEST_F(ConfigurationTest, ADifferenceIsOneLineAndAChangeRestartsOneComponent) {
  robot_.start_robot("scout.toml");
  const Ended diff = base_.timsctl({"config", "diff", max_speed_ + "=900"});
  EXPECT_EQ(diff.code, 0) << diff.out << diff.err;
  EXPECT_THAT(diff.out, HasSubstr("-parameters = { vxMax = 800, accMax = 500 } # mm/s\n"
                                  "+parameters = { vxMax = 900, accMax = 500 } # mm/s\n"));
  EXPECT_THAT(diff.out, HasSubstr("ChassisSim vxMax 800 -> 900 mm/s; needs restart of ChassisSim"));
  EXPECT_EQ(scout(), kScout) << "nothing is written yet";

  const auto pid_of = [&](const std::string& name) {
    const json::value shown = json::parse(robot_.timsctl({"robot", "--json"}).out);
    for (const json::value& item : shown.at("items").as_array())
      if (item.at("name") == json::value(name)) return item.at("pid").to_number<int>();
    return 0;
  };
  const int chassis = pid_of("ChassisSim");
  const int odometry = pid_of("OdometryChassis");
  const Ended applied =
      base_.timsctl({"config", "apply", max_speed_ + "=900", "--why=faster", "-y"});
  EXPECT_EQ(applied.code, 0) << applied.out << applied.err;
  std::string expected(kScout);
  expected.replace(expected.find("800"), 3, "900");
  EXPECT_EQ(scout(), expected) << "comments and line ends stay byte for byte";
  EXPECT_NE(pid_of("ChassisSim"), chassis);
  EXPECT_EQ(pid_of("OdometryChassis"), odometry);

  const Ended history = base_.timsctl({"config", "history", "-r", "robot1"});
  EXPECT_THAT(history.out, HasSubstr("faster"));
  EXPECT_THAT(history.out, HasSubstr("confirmed"));
  const Ended undone = base_.timsctl({"config", "undo", "-r", "robot1", "--generation=1", "-y"});
  EXPECT_EQ(undone.code, 0) << undone.out << undone.err;
  EXPECT_EQ(scout(), kScout);
}

TEST_F(ConfigurationTest, AWrongValueIsRefusedWithItsPlace) {
  const Ended range = base_.timsctl({"config", "apply", max_speed_ + "=-5", "-y"});
  EXPECT_EQ(range.code, 1);
  EXPECT_THAT(range.out, HasSubstr("robots/scout.toml:7:24: vxMax must be a whole number from 0"));
  const Ended name =
      base_.timsctl({"config", "diff", "robot1@robots/scout.toml:component[0].parameters.vxMux=5"});
  EXPECT_EQ(name.code, 1);
  EXPECT_THAT(name.out, HasSubstr("did you mean vxMax?"));
  const Ended router = base_.timsctl({"config", "diff", "robot1@router.toml:router.role=boss"});
  EXPECT_EQ(router.code, 1);
  EXPECT_THAT(router.out, HasSubstr("router.toml:4:8: router.role"));
  EXPECT_EQ(scout(), kScout);
  for (const std::string file : {"../passwd", "/etc/passwd", "robots/../x.toml", "robots/.toml"}) {
    const json::object answer = robot_.ask({{"ask", "conf_get"}, {"file", file}}, kRobotAgent);
    EXPECT_EQ(answer.at("error").at("code"), json::value("bad_argument")) << file;
  }
}

TEST_F(ConfigurationTest, TwoEditorsConflict) {
  const json::object list =
      robot_.ask({{"ask", "conf_get"}, {"file", "robots/scout.toml"}}, kRobotAgent);
  const auto edit = [&](const std::string& value) {
    return json::object{
        {"ask", "conf_apply"},
        {"change", "00112233445566" + value},
        {"who", "second"},
        {"edits",
         json::array{json::object{
             {"file", "robots/scout.toml"},
             {"base", list.at("hash")},
             {"operations",
              json::array{json::object{
                  {"op", "set"}, {"path", "component[0].parameters.vxMax"}, {"value", 700}}}}}}}};
  };
  EXPECT_EQ(base_.timsctl({"config", "apply", max_speed_ + "=900", "-y"}).code, 0);
  const json::object answer = robot_.ask(edit("01"), kRobotAgent);
  EXPECT_EQ(answer.at("error").at("code"), json::value("conflict"));
  EXPECT_THAT(json::serialize(answer), HasSubstr("was changed by another editor"));
}

TEST_F(ConfigurationTest, AnAgentThatIsKilledGoesBack) {
  const Ended applied = base_.timsctl({"config", "apply", max_speed_ + "=900"});
  EXPECT_EQ(applied.code, 0) << applied.err;
  EXPECT_THAT(applied.err, HasSubstr("timsctl config confirm"));
  EXPECT_THAT(scout(), HasSubstr("900"));
  EXPECT_EQ(state_of(robot_, kRobotAgent), "waiting");
  robot_.kill_agent();
  EXPECT_THAT(scout(), HasSubstr("900"));
  robot_.start_agent();
  EXPECT_EQ(scout(), kScout);
  EXPECT_EQ(state_of(robot_, kRobotAgent), "idle");
  EXPECT_THAT(robot_.agent().output(), HasSubstr("WARNING: change 2"));
  EXPECT_EQ(base_.timsctl({"config", "confirm", "-r", "robot1"}).code, 4);
}

TEST_F(ConfigurationTest, IsConfirmedOrUndoneByHand) {
  EXPECT_EQ(base_.timsctl({"config", "apply", max_speed_ + "=900"}).code, 0);
  EXPECT_EQ(base_.timsctl({"config", "apply", max_speed_ + "=950", "-y"}).code, 1)
      << "one at a time";
  EXPECT_EQ(base_.timsctl({"config", "confirm", "-r", "robot1"}).code, 0);
  EXPECT_THAT(scout(), HasSubstr("900"));
  EXPECT_EQ(base_.timsctl({"config", "apply", max_speed_ + "=1000"}).code, 0);
  EXPECT_EQ(base_.timsctl({"config", "undo", "-r", "robot1"}).code, 0);
  EXPECT_TRUE(eventually([&] { return state_of(robot_, kRobotAgent) == "idle"; }, "it went back"));
  EXPECT_THAT(scout(), HasSubstr("900"));
}

TEST_F(ConfigurationTest, WithoutEditsWhatIsDeployedIsChecked) {
  const json::object question{{"ask", "conf_check"}};
  EXPECT_TRUE(robot_.ask(question, kRobotAgent).at("ok").as_bool());
  std::ofstream(robot_.folder() / "robots" / "scout.toml", std::ios::app)
      << "[[component]]\nprogram = \"Position\"\nparameters = { startDeviatio = 1 }\n";
  const json::object answer = robot_.ask(question, kRobotAgent);
  EXPECT_FALSE(answer.at("ok").as_bool());
  EXPECT_TRUE(answer.at("files").as_array().empty()) << "nothing is changed";
  const json::object& problem = answer.at("problems").at(0).as_object();
  EXPECT_EQ(problem.at("file").as_string(), "robots/scout.toml");
  EXPECT_THAT(std::string(problem.at("text").as_string()), HasSubstr("startDeviation"));
}

TEST_F(ConfigurationTest, TheHolderOfALockIsNamedWithItsChange) {
  (void)robot_.ask({{"ask", "conf_lock"}, {"change", "0123456789abcdef"}, {"who", "ada"}},
                   kRobotAgent);
  const json::object state = robot_.ask({{"ask", "conf_state"}}, kRobotAgent);
  EXPECT_EQ(state.at("state").as_string(), "locked");
  EXPECT_EQ(state.at("who").as_string(), "ada");
  EXPECT_EQ(state.at("change").as_string(), "0123456789abcdef");
  (void)robot_.ask({{"ask", "conf_unlock"}, {"change", "0123456789abcdef"}}, kRobotAgent);
}

TEST_F(ConfigurationTest, AllInstalledProgramsAreOffered) {
  json::object answer;
  EXPECT_TRUE(eventually(
      [&] {
        answer = robot_.ask({{"ask", "conf_programs"}}, kRobotAgent);
        return answer.at("complete").as_bool();
      },
      "all programs have described themselves"));
  const json::array& items = answer.at("items").as_array();
  const auto has = [&](const std::string& program, const std::string& class_name) {
    return std::ranges::any_of(items, [&](const json::value& item) {
      return item.at("program").as_string() == program &&
             item.at("class").as_string() == class_name && !item.at("purpose").as_string().empty();
    });
  };
  EXPECT_TRUE(has("ChassisSim", "Chassis"));
  EXPECT_TRUE(has("Position", "Position")) << "which no file of the robot starts";
  EXPECT_FALSE(std::ranges::any_of(items, [](const json::value& item) {
    return item.at("program").as_string() == "tims-router" ||
           item.at("program").as_string() == "timsctl";
  }));
}

TEST_F(ConfigurationTest, ARouterIsReloadedOrRestartedAsItsOptionsNeed) {
  const std::string before = robot_.timsctl({"status", "--json"}).out;
  EXPECT_EQ(base_.timsctl({"config", "apply", "robot1@router.toml:log.level=debug", "-y"}).code, 0);
  EXPECT_TRUE(eventually(
      [&] {
        return robot_.timsctl({"config", "show"}).out.find("debug") != std::string::npos;
      },
      "the router uses the new level"));
  const auto epoch = [](const std::string& text) { return json::parse(text).at("epoch"); };
  EXPECT_EQ(epoch(robot_.timsctl({"status", "--json"}).out), epoch(before));
  const Ended restarted = base_.timsctl(
      {"config", "apply", "robot1@router.toml:message.max=\"8MiB\"", "-y"}, kPatience * 2);
  EXPECT_EQ(restarted.code, 0) << restarted.out << restarted.err;
  EXPECT_NE(epoch(robot_.timsctl({"status", "--json"}).out), epoch(before));
  EXPECT_THAT(robot_.router().output(), HasSubstr("stopping for a restart"))
      << "so that links go on where the service manager keeps them";
}

TEST_F(ConfigurationTest, AChangeHasTheTimeThatTheHostAllows) {
  const Ended applied =
      base_.timsctl({"config", "apply", "base@router.toml:log.level=debug", "--window=7s", "-y"});
  EXPECT_EQ(applied.code, 1) << applied.out << applied.err;
  EXPECT_THAT(applied.out + applied.err, HasSubstr("must be from 8 to 600 seconds"));
}

TEST(AgentProgram, TakesALeastWindowOf3To90Seconds) {
  for (const auto& [text, is_allowed] : {std::pair("2999ms", false),
                                         {"3s", true},
                                         {"90s", true},
                                         {"90001ms", false},
                                         {"soon", false}}) {
    auto agent = ChildProcess::start(
        {TIMS_PROGRAMS "/tims-agent", std::string("--least-window=") + text, "--no-such-option"});
    ASSERT_TRUE(agent) << agent.error().message();
    const auto ended = agent->wait(kPatience);
    ASSERT_TRUE(ended);
    EXPECT_EQ(ended->code, 2);
    EXPECT_THAT(agent->output(), HasSubstr(is_allowed ? "unknown argument" : "must be from 3"))
        << text;
  }
}

TEST_F(ConfigurationTest, AChangeThatCutsItsOwnLinkIsUndoneEverywhere) {
  const std::string base_before = text_of(base_.folder() / "router.toml");
  const std::string robot_before = text_of(robot_.folder() / "router.toml");
  const Ended applied =
      base_.timsctl({"config", "apply", "robot1@router.toml:link[0].to=\"127.0.0.1:9\"",
                     "base@router.toml:log.level=debug", "--window=8s", "-y"},
                    kPatience * 6);
  EXPECT_EQ(applied.code, 1) << applied.out << applied.err;
  EXPECT_TRUE(eventually(
      [&] {
        return text_of(robot_.folder() / "router.toml") == robot_before &&
               text_of(base_.folder() / "router.toml") == base_before;
      },
      "both hosts went back", kPatience * 6));
  EXPECT_TRUE(eventually(
      [&] {
        return base_.timsctl({"config", "history", "-r", "robot1"}).code == 0;
      },
      "the robot can be reached again"));
}

TEST_F(ConfigurationTest, CtrlCTakesAChangeBack) {
  const std::string before = text_of(base_.folder() / "router.toml");
  auto apply = base_.start_timsctl({"config", "apply", "base@router.toml:log.level=debug",
                                    "robot1@router.toml:link[0].to=\"127.0.0.1:9\"", "-y"});
  // It waits for the robot, which can answer no longer, or only once more.
  ASSERT_TRUE(apply->wait_for_line("robot1: restarting what changed")) << apply->output();
  apply->signal(SIGINT);
  const auto ended = apply->wait(kPatience * 3);
  ASSERT_TRUE(ended) << apply->output();
  EXPECT_EQ(ended->code, 130) << apply->output();
  EXPECT_EQ(state_of(base_, kBaseAgent), "idle");
  EXPECT_EQ(text_of(base_.folder() / "router.toml"), before);
}

// Over TCP, as windows and consoles come, without tcp.admin.
TEST_F(ConfigurationTest, GuestsReadAndChangeNothing) {
  const json::value status = json::parse(base_.timsctl({"status", "--json"}).out);
  const std::string tcp(status.at("listen").at("tcp").as_string());
  const std::string guest = "--host=" + tcp;
  EXPECT_EQ(base_.timsctl({"config", "history", "-r", "robot1", guest}).code, 0);
  EXPECT_EQ(base_.timsctl({"config", "diff", max_speed_ + "=900", guest}).code, 0);
  const Ended applied = base_.timsctl({"config", "apply", max_speed_ + "=900", "-y", guest});
  EXPECT_EQ(applied.code, 1) << applied.out << applied.err;
  EXPECT_THAT(applied.err, HasSubstr("read-only access"));
  EXPECT_EQ(scout(), kScout);
  EXPECT_EQ(state_of(robot_, kRobotAgent), "idle");
}

// As much as `link show` counts meanwhile.
TEST_F(ConfigurationTest, BudgetsMeasureWhatGoesOverLinks) {
  const auto load =
      base_.start_timsctl({"ping", "router", "-r", "robot1", "-i", "10ms", "--for", "120s"});
  struct Sent {
    base::WallTime at{};
    double bytes = 0;
  };
  const auto sent = [&]() -> Sent {
    const json::value links = json::parse(base_.timsctl({"link", "show", "--json"}).out);
    const auto at = base::parse_rfc3339(std::string(links.at("time").as_string()));
    return {*at, links.at("items").at(0).at("wire_bytes_out").to_number<double>()};
  };
  EXPECT_TRUE(eventually([&]() -> std::string {
    const Sent before = sent();
    const Ended budget = base_.timsctl({"config", "budget", "--json"});
    const Sent after = sent();
    const std::chrono::duration<double> time = after.at - before.at;
    const double counted = (after.bytes - before.bytes) / time.count();
    const json::value made = json::parse(budget.out);
    for (const json::value& link : made.at("links").as_array()) {
      const json::value& measured = link.at("measured_bytes_per_s");
      if (link.at("host") == json::value("base") && measured.is_number() && counted > 5000 &&
          std::abs(measured.to_number<double>() / counted - 1) < 0.1)
        return "";
    }
    return "the link counted " + std::to_string(counted) + " bytes/s; " + budget.out +
           load->output();
  }));
}

}  // namespace configuration_test
}  // namespace tims::test
