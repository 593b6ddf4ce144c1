// A robot behind NAT that opens no port to the network: with keys, its own link to the base is
// enough for everything that operators do at the base, by timsctl and by the console; the rules of
// both routers decide about it.
#include <filesystem>
#include <fstream>

#include <boost/json/serialize.hpp>

#include "tests/support/fleet_keys.h"
#include "tests/system/timsctl_fixture.h"
#include "tests/system/two_hosts_fixture.h"
#include "tests/system/websocket_client.h"

namespace tims::test {
namespace behind_nat_test {

namespace fs = std::filesystem;
using security::MemberRole;
using Words = std::vector<std::string>;

constexpr Address kRobotRouter(0x03000100);  // Tims(3/1)
const Address kRobotChassis = *Address::parse("Chassis(3/0)");
constexpr Address kBrowser(0x00020000);  // GUI(0/0)
constexpr Duration kStart = 4 * kPatience;

// Everything that follows is under rules. The last ones let pass what rights let pass.
const Words kRulesOfBase{
    "rule=name=own,from=own,then=allow",
    "rule=name=dora leaves scanners alone,from=user:dora,to=Scan2d(*/*),types=off,then=deny",
    "rule=name=engineers,from=right:configure,then=allow",
    "rule=name=drivers,from=right:drive,then=allow",
    "rule=name=others look,from=right:look,types=look,then=allow",
};
const Words kRulesOfRobot{
    "rule=name=own,from=own,then=allow",
    "rule=name=positions stay,from=router:base,to=Position(3/*),types=off,then=deny",
    "rule=name=routers,from=router:*,then=allow",
};

Words joined(Words settings, const Words& more) {
  settings.insert(settings.end(), more.begin(), more.end());
  return settings;
}

constexpr std::string_view kRobotFile = R"(name = "scout"
system = 3

[[component]]
program = "gdos-log"
parameters = { directory = "FOLDER/logs" }

[[component]]
program = "World"
parameters = { file = "FOLDER/world.toml", targetStatus = 1 }

[[component]]
program = "ChassisSim"
parameters = { targetStatus = 1, vxMax = 1000, accMax = 1000, decMax = 1000, acceleration = 1 }

[[component]]
program = "OdometryChassis"
parameters = { chassisSys = "{system}" }

[[component]]
program = "Scan2dSim"
parameters = { odometrySys = "{system}", mapFile = "PLAN" }

[[component]]
program = "Position"
parameters = { odometrySys = "{system}", startDeviation = 0 }

[[component]]
program = "PathRDDF"
parameters = { chassisSys = "{system}", positionSys = "{system}", scan2dSys = "{system}", mapFile = "PLAN", cellSize = 50 }

[[component]]
program = "PilotPath"
parameters = { chassisSys = "{system}", positionSys = "{system}", scan2dSys = "{system}", scan2dInst = -1, pathSys = "{system}" }
)";

constexpr std::string_view kWorldFile = R"(
[[robot]]
name = "scout"
at = [0, 0, 0]
track = 400
front = 250
back = 250
left = 200
right = 200
device = "pioneer"
line = "pty:FOLDER/pioneer"
)";

class BehindNat : public TwoHosts {
 protected:
  void SetUp() override {
    TwoHosts::SetUp();
    if (IsSkipped()) return;
    const auto hidden = hidden_.hide_behind(*networks_);
    ASSERT_TRUE(hidden.ok()) << hidden.error().message();
    base_ = std::make_unique<Host>(
        "base", "top", 0, 1, Words{"kind=sub,system=*"},
        joined({keys_.base(), "tcp.listen=0.0.0.0:2000", "http.listen=0.0.0.0:8080"},
               kRulesOfBase));
    base_->listen_at("0.0.0.0:2010");
    base_->start();
    agents_.push_back(agent(*base_, folder_.path() / "base"));
    const std::string robot_keys = keys_.join("robot3", MemberRole::kSystem, 3, 1);
    const std::string to_base = std::string("kind=super,to=") + TwoNetworks::kLeft + ":2010";
    robot_ = std::make_unique<Host>("robot3", "system", 3, 1, Words{to_base},
                                    joined({robot_keys}, kRulesOfRobot));
    robot_->listen_at("0.0.0.0:2010");
    hidden_.inside([this] { start_robot(); });
    EXPECT_TRUE(
        eventually([&] { return base_->knows(kRobotChassis); }, "the base knows the robot"));
  }
  void TearDown() override {
    tunnel_.reset();
    if (up_) (void)up_->stop(SIGINT, kStart);
    up_.reset();
    agents_.clear();
    TwoHosts::TearDown();
  }

  // As the operator with these keys, at another host: through the base's port with TLS.
  Ran as(const std::string& keys, Words arguments, Duration limit = 2 * kPatience) const {
    arguments.insert(arguments.begin(), {TIMSCTL_PROGRAM, "-H", "tls:10.78.0.1:2000"});
    arguments.push_back("--timeout=" + std::to_string(kPatienceMs) + "ms");
    auto child = ChildProcess::start(
        std::move(arguments),
        {.environment = {"TIMS_KEYS=" + keys, "TIMS_HOST=", "TERM=xterm", "NO_COLOR="},
         .folder = {}});
    EXPECT_TRUE(child) << child.error().message();
    const auto status = child->wait(limit);
    return {.code = status ? status->code : -1,
            .out = child->standard_output(),
            .err = child->standard_error()};
  }

  // The command of an operator with all rights succeeds and prints this.
  void prints(const Words& command, const std::string& text) const {
    const Ran ran = as(configure_, command);
    std::string words;
    for (const std::string& word : command) words += word + " ";
    EXPECT_EQ(ran.code, 0) << words << "\n" << ran.out << ran.err;
    EXPECT_THAT(ran.out + ran.err, HasSubstr(text)) << words;
  }

  // It fails while the odometry is not on yet, or late on a loaded machine.
  void turn_on_the_scanner() const {
    prints({"component", "on", "Scan2d/3/0"}, "Scan2d(3/0)");
    const Words status{"component", "status", "Scan2d/3/0"};
    EXPECT_TRUE(eventually([&] { return as(configure_, status).code == 0; }, "it is on"));
  }

  // A page that has logged in with this right, by HTTPS at the base.
  WebSocketClient page(const std::string& right) {
    if (!tunnel_) {
      auto started = ChildProcess::start(
          {TIMSCTL_PROGRAM, "tunnel", "127.0.0.1:9000", std::string(TwoNetworks::kLeft) + ":8080"},
          {.environment = {"TIMS_KEYS=" + look_}, .folder = {}});
      EXPECT_TRUE(started && started->wait_for_line("leads to"));
      tunnel_ = std::make_unique<ChildProcess>(std::move(*started));
    }
    std::string bearer = base_->timsctl({"web", "--bearer", "--rights", right});
    WebSocketClient client("127.0.0.1:9000", bearer.substr(0, bearer.find('\n')) + "\r\n");
    EXPECT_TRUE(client.is_open()) << client.answer() << bearer;
    EXPECT_TRUE(client.register_mailbox(kBrowser).ok());
    return client;
  }
  // The type of the answer.
  static int answer_of(WebSocketClient& page, std::int8_t type, Address dest,
                       const std::string& body = {}) {
    page.send_message({.type = type, .dest = dest, .src = kBrowser}, body);
    const auto answer = page.receive();
    EXPECT_TRUE(answer.ok()) << answer.error().message();
    return answer ? answer->header.type : 0;
  }

  FleetKeys keys_{{TwoNetworks::kLeft}};
  const std::string look_ = keys_.user("lena", {.look = true});
  const std::string drive_ = keys_.user("dora", {.look = true, .drive = true});
  const std::string configure_ =
      keys_.user("anna", {.look = true, .drive = true, .configure = true});
  HiddenNetwork hidden_;

 private:
  void write(const fs::path& path, std::string_view content) const {
    std::string text(content);
    for (const auto& [what, with] : {std::pair<std::string, std::string>{"PLAN", FLOOR_PLAN},
                                     {"FOLDER", folder_.path().string()}})
      for (auto at = text.find(what); at != std::string::npos; at = text.find(what))
        text.replace(at, what.size(), with);
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  std::unique_ptr<ChildProcess> started(const Host& host, Words command,
                                        std::string_view ready) const {
    auto child = ChildProcess::start(
        std::move(command),
        {.environment = {"TIMS_ROUTER=" + host.socket(), "TIMS_HOST=", "NO_COLOR=1",
                         "XDG_RUNTIME_DIR=" + folder_.path().string()},
         .folder = {}});
    EXPECT_TRUE(child) << child.error().message();
    const auto line = child->wait_for_line(ready, kStart);
    EXPECT_TRUE(line) << line.error().message();
    return std::make_unique<ChildProcess>(std::move(*child));
  }
  // The keeper of the configuration in this folder.
  std::unique_ptr<ChildProcess> agent(const Host& host, const fs::path& etc) const {
    write(etc / "router.toml", "[router]\n");
    return started(host,
                   {TIMS_PROGRAMS "/tims-agent", "--folder=" + etc.string(),
                    "--state=" + (etc / "state").string()},
                   "answers as");
  }
  void start_robot() {
    robot_->start();
    const fs::path etc = folder_.path() / "robot";
    write(folder_.path() / "world.toml", kWorldFile);
    write(etc / "robots" / "scout.toml", kRobotFile);
    agents_.push_back(agent(*robot_, etc));
    up_ = started(*robot_, {TIMSCTL_PROGRAM, "up", (etc / "robots" / "scout.toml").string()},
                  "8 of 8 programs are ready");
  }

  TemporaryFolder folder_;
  std::vector<std::unique_ptr<ChildProcess>> agents_;
  std::unique_ptr<ChildProcess> up_;
  std::unique_ptr<ChildProcess> tunnel_;
};

// Its parts, each of which leaves the robot as the next ones need it: hosts and robot are started
// once for several.
struct BehindNatParts : BehindNat {
  // The host that hides the robot answers for it, and lets nothing in.
  void nothing_reaches_the_robot_from_outside() {
    EXPECT_FALSE(TwoNetworks::run("ip route get 192.168.78.2").ok());
    for (const char* port : {"2000", "2010", "2011", "8080"}) {
      EXPECT_TRUE(ByteSocket(std::string(TwoNetworks::kRight) + ":" + port).closed()) << port;
    }
    // Nor is anything of it open to its own neighbours: all of it listens on loopback, but for the
    // socket of its outgoing link.
    networks_->on_the_right([] {
      for (const char* port : {"2000", "2011", "8080"})
        EXPECT_TRUE(ByteSocket(std::string(HiddenNetwork::kAddress) + ":" + port).closed()) << port;
    });
  }

  void routers_and_their_links() {
    prints({"router", "list"}, "robot3");
    prints({"status", "-r", "robot3"}, "robot3");
    prints({"router", "show", "-r", "robot3"}, "Tims(3/1)");
    prints({"router", "clients", "-r", "robot3"}, "ChassisSim");
    prints({"link", "show", "-r", "robot3"}, "base");
    prints({"link", "show", "-r", "robot3", "--json"}, "\"secure\":true");
    prints({"fleet", "show", "-r", "robot3"}, "");
    prints({"route", "show", "Chassis(3/*)", "-r", "robot3"}, "Chassis(3/0)");
    prints({"route", "get", "Chassis/3/0"}, "robot3");
    prints({"route", "add", "Ladar(9/*)", "base", "-r", "robot3"}, "");
    prints({"route", "show", "-r", "robot3", "--json"}, "Ladar(9/*)");
    prints({"route", "del", "Ladar(9/*)", "-r", "robot3"}, "");
    prints({"route", "watch", "-r", "robot3", "--for", "200ms"}, "");
    prints({"mbx", "list", "Chassis(3/*)", "-r", "robot3"}, "Chassis(3/0)");
    prints({"mbx", "show", "Chassis/3/0", "-r", "robot3"}, "ChassisSim");
    prints({"stats", "-r", "robot3"}, "local");
    prints({"top", "-r", "robot3", "-n", "1"}, "ChassisSim");
    prints({"clock"}, "robot3");
    prints({"explain", "Odometry/3/0", "Chassis/3/0"}, "it arrives");
    EXPECT_THAT(base_->timsctl({"trace", "Chassis/3/0"}), HasSubstr("robot3"));
    prints({"ping", "router", "-r", "robot3", "-n", "1"}, "1 answered");
    prints({"ping", "Chassis/3/0", "-n", "1"}, "1 answered");
    prints({"config", "show", "-r", "robot3"}, "security.keys");
    prints({"doctor", "-r", "robot3"}, "robot3");
  }

  // The link comes back by itself: the robot connects again.
  void links_are_taken_down_and_up_and_reset_from_afar() {
    prints({"link", "reset", "base", "-r", "robot3"}, "");
    EXPECT_TRUE(eventually([&] { return base_->knows(kRobotChassis); }, "after the reset"));
    prints({"link", "down", "robot3", "--yes"}, "");
    EXPECT_TRUE(eventually([&] { return !base_->knows(kRobotChassis); }, "it is down"));
    prints({"link", "up", "robot3"}, "");
    EXPECT_TRUE(eventually([&] { return base_->knows(kRobotChassis); }, "it is up"));
  }

  void components_messages_and_logs() {
    prints({"component", "list"}, "Chassis(3/0)");
    turn_on_the_scanner();
    prints({"component", "show", "Chassis/3/0"}, "vxMax");
    prints({"component", "describe", "Chassis/3/0"}, "vxMax");
    prints({"component", "param", "get", "Chassis/3/0", "vxMax"}, "1000");
    prints({"component", "param", "set", "Chassis/3/0", "vxMax", "900"}, "900");
    prints({"component", "data", "Chassis/3/0"}, "vx");
    prints({"component", "pilot", "Chassis/3/0"}, "");
    prints({"component", "pilot", "Chassis/3/0", "none"}, "");
    prints({"msg", "pub", "Chassis/3/0", "get_status"}, "enabled");
    prints({"msg", "echo", "Scan2d/3/0", "-n", "1"}, "Scan2d(3/0)");
    prints({"msg", "hz", "Chassis/3/0", "--for", "1s"}, "Chassis(3/0)");
    prints({"msg", "bw", "Chassis/3/0", "--for", "1s"}, "Chassis(3/0)");
    prints({"log", "follow", "GDOS/3/0", "--for", "500ms"}, "");
    prints({"component", "off", "Scan2d/3/0"}, "");
  }

  void navigation_and_the_world() {
    prints({"nav", "goto", "0.8", "0", "--robot", "3", "--for", "60s"}, "arrived");
    prints({"nav", "where", "3"}, "heading");
    prints({"nav", "path", "3"}, "");
    prints({"nav", "map", "show", "--robot", "3"}, "floor.dxf");
    prints({"world", "show"}, "scout");
    prints({"world", "place", "scout", "500", "0"}, "");
    prints({"world", "put", "3000", "3000", "200"}, "");
    prints({"world", "people", "off"}, "");
  }

  void the_configuration_of_its_host() {
    const std::string speed = "robot3@robots/scout.toml:component[2].parameters.vxMax=";
    prints({"config", "diff", speed + "900"}, "1000 -> 900");
    prints({"config", "apply", speed + "900", "-y", "--why=slower"}, "");
    prints({"config", "history", "-r", "robot3"}, "slower");
    prints({"config", "apply", speed + "800"}, "");
    prints({"config", "confirm", "-r", "robot3"}, "");
    prints({"config", "apply", speed + "700"}, "");
    prints({"config", "undo", "-r", "robot3"}, "");
    prints({"config", "budget"}, "WORST");
    EXPECT_THAT(as(configure_, {"component", "param", "get", "Chassis/3/0", "vxMax"}).out,
                HasSubstr("800"));
  }

  void rights_hold_all_the_way_to_the_robot() {
    const Words status{"component", "status", "Chassis/3/0"};
    const Words off{"component", "off", "Chassis/3/0"};
    const Words on{"component", "on", "Chassis/3/0"};
    const Words set{"component", "param", "set", "Chassis/3/0", "vxMax", "900"};
    const Words reset{"link", "reset", "base", "-r", "robot3"};
    const Words apply{"config", "apply",
                      "robot3@robots/scout.toml:component[2].parameters.vxMax=900", "-y"};
    EXPECT_TRUE(eventually([&] { return as(look_, status).code == 0; }, "it is on"));
    for (const Words& denied : {off, set, reset, apply}) {
      const Ran ran = as(look_, denied);
      EXPECT_NE(ran.code, 0) << denied[1] << ran.out;
    }
    EXPECT_EQ(as(drive_, off).code, 0);
    EXPECT_EQ(as(drive_, on).code, 0);
    for (const Words& denied : {set, reset, apply}) {
      const Ran ran = as(drive_, denied);
      EXPECT_NE(ran.code, 0) << denied[1] << ran.out;
    }
  }

  void the_console_reaches_the_robot_with_its_login() {
    const std::string links = R"({"ask":"links"})";
    const std::string reset = R"({"ask":"link","link":"base","do":"reset"})";
    {
      WebSocketClient lena = page("look");
      EXPECT_TRUE(eventually(
          [&] { return answer_of(lena, type::kGetStatus, kRobotChassis) == type::kEnabled; },
          "it is on"));
      EXPECT_EQ(answer_of(lena, type::kGetData, kRobotChassis, std::string(4, '\0')), type::kData);
      EXPECT_EQ(answer_of(lena, type::kAdminRequest, kRobotRouter, links), type::kAdminReply);
      EXPECT_EQ(answer_of(lena, type::kOff, kRobotChassis), type::kNotAvailable);
    }
    {
      WebSocketClient dora = page("drive");
      EXPECT_EQ(answer_of(dora, type::kOff, kRobotChassis), type::kOk);
      EXPECT_EQ(answer_of(dora, type::kOn, kRobotChassis), type::kOk);
      EXPECT_EQ(answer_of(dora, type::kSetParam, kRobotChassis), type::kNotAvailable);
      EXPECT_EQ(answer_of(dora, type::kAdminRequest, kRobotRouter, reset), type::kNotAvailable);
    }
    WebSocketClient anna = page("configure");
    EXPECT_NE(answer_of(anna, type::kSetParam, kRobotChassis), type::kNotAvailable);
    EXPECT_EQ(answer_of(anna, type::kAdminRequest, kRobotRouter, reset), type::kAdminReply);
  }

  // One of the base denies a person one thing, one of the robot what comes from the base.
  void rules_on_the_way_deny_one_thing_and_allow_another() {
    EXPECT_EQ(as(drive_, {"component", "describe", "Scan2d/3/0"}).code, 0);
    const Ran denied = as(drive_, {"component", "off", "Scan2d/3/0"});
    EXPECT_NE(denied.code, 0) << denied.out;
    EXPECT_EQ(as(drive_, {"component", "off", "Chassis/3/0"}).code, 0);
    EXPECT_NE(as(drive_, {"component", "off", "Position/3/0"}).code, 0);
    EXPECT_NE(as(configure_, {"component", "off", "Position/3/0"}).code, 0);
    EXPECT_EQ(as(configure_, {"component", "off", "Scan2d/3/0"}).code, 0);
    const auto verdict = [&](const std::string& from, const std::string& to) {
      return as(configure_, {"acl", "test", "--from", from, "--to", to, "--type", "off"}).out;
    };
    const std::string dora = "user:dora, right:look, right:drive";
    EXPECT_THAT(verdict(dora, "Scan2d(3/0)"), HasSubstr("dora leaves scanners alone"));
    EXPECT_THAT(verdict(dora, "Position(3/0)"), HasSubstr("positions stay"));
    EXPECT_THAT(verdict(dora, "Chassis(3/0)"), testing::Not(HasSubstr("denied")));
    prints({"acl", "hits", "-r", "robot3"}, "positions stay");
    prints({"acl", "log"}, "dora leaves scanners alone");
    WebSocketClient page_that_drives = page("drive");
    EXPECT_EQ(answer_of(page_that_drives, type::kOff, *Address::parse("Position(3/0)")),
              type::kNotAvailable);
    EXPECT_EQ(answer_of(page_that_drives, type::kOn, kRobotChassis), type::kOk);
  }
};

TEST_F(BehindNatParts, TimsctlReachesAllOfTheRobot) {
  nothing_reaches_the_robot_from_outside();
  routers_and_their_links();
  links_are_taken_down_and_up_and_reset_from_afar();
  components_messages_and_logs();
  navigation_and_the_world();
  the_configuration_of_its_host();
}

TEST_F(BehindNatParts, RightsAndRulesHoldAllTheWay) {
  rights_hold_all_the_way_to_the_robot();
  the_console_reaches_the_robot_with_its_login();
  rules_on_the_way_deny_one_thing_and_allow_another();
}

}  // namespace behind_nat_test
}  // namespace tims::test
