// A robot that was broken into, with keys and without rules: from its own host somebody tries to
// change the routers and files of the base and of another robot. From the base it goes on as
// before, also where the agents of several hosts have to agree about a change.
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/eventually.h"
#include "tests/support/fleet_keys.h"
#include "tests/system/host.h"

namespace tims::test {
namespace stolen_robot_test {

namespace fs = std::filesystem;
using security::MemberRole;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr Address kOfThief(0x03180000);
constexpr Address kOfOther(0x05180000);

// The agent of a host, and its folder with the file of a router.
class HostAgent {
 public:
  explicit HostAgent(const Host& host) {
    fs::create_directories(folder());
    std::ofstream(file()) << "[log]\nlevel = \"info\"\n";
    auto started =
        ChildProcess::start({TIMS_PROGRAMS "/tims-agent", "--folder=" + folder().string(),
                             "--state=" + (folder_.path() / "state").string(), "--least-window=8s"},
                            {.environment = {"TIMS_ROUTER=" + host.socket()}, .folder = {}});
    EXPECT_TRUE(started.ok()) << started.error().message();
    if (!started) return;
    agent_.emplace(std::move(*started));
    EXPECT_TRUE(agent_->wait_for_line("answers as").ok());
  }
  [[nodiscard]] std::string text() const {
    std::ifstream text(file());
    return {std::istreambuf_iterator<char>(text), {}};
  }

 private:
  [[nodiscard]] fs::path folder() const { return folder_.path() / "etc"; }
  [[nodiscard]] fs::path file() const { return folder() / "router.toml"; }

  TemporaryFolder folder_;
  std::optional<ChildProcess> agent_;
};

class StolenRobotTest : public testing::Test {
 protected:
  void start(const std::vector<std::string>& rules_of_base = {}) {
    std::vector<std::string> of_base{keys.base()};
    of_base.insert(of_base.end(), rules_of_base.begin(), rules_of_base.end());
    base.emplace("base", "top", 0, 1, std::vector<std::string>{"kind=sub,system=*"}, of_base);
    base->start();
    const auto robot = [&](const std::string& name, std::uint16_t system) {
      return Host(name, "system", system, 1, {"kind=super,to=" + base->udp()},
                  {keys.join(name, MemberRole::kSystem, system, 1)});
    };
    thief.emplace(robot("robot3", 3));
    other.emplace(robot("robot5", 5));
    for (auto& [host, session, mailbox, address] :
         {std::tie(thief, of_thief, of_thief_mailbox, kOfThief),
          std::tie(other, of_other, of_other_mailbox, kOfOther)}) {
      host->start();
      session.emplace(host->session("component"));
      auto opened = session->open({.address = address});
      ASSERT_TRUE(opened.ok()) << opened.error().message();
      mailbox.emplace(std::move(*opened));
    }
    ASSERT_TRUE(eventually([&] { return thief->knows(kOfThief) && base->knows(kOfThief); },
                           "the base knows the thief"));
    ASSERT_TRUE(eventually([&] { return base->knows(kOfOther); }, "the base knows the other"));
  }

  FleetKeys keys;
  std::optional<Host> base;
  std::optional<Host> thief;
  std::optional<Host> other;
  std::optional<Session> of_thief;
  std::optional<Session> of_other;
  std::optional<Mailbox> of_thief_mailbox;
  std::optional<Mailbox> of_other_mailbox;
};

TEST_F(StolenRobotTest, ChangesNoRouterButItsOwn) {
  start();
  const auto route_to_thief = [](const std::string& router) -> std::vector<std::string> {
    return {"-r", router, "route", "add", "*(5/*)", router == "base" ? "robot3" : "base"};
  };
  for (const std::string router : {"base", "robot5"}) {
    EXPECT_THAT(thief->timsctl(route_to_thief(router)),
                AllOf(HasSubstr("the policy does not permit it"), HasSubstr("(other robots)")))
        << router;
    EXPECT_THAT(thief->timsctl({"-r", router, "status"}), HasSubstr(router)) << "it may look";
  }
  EXPECT_THAT(base->timsctl({"acl", "log"}), HasSubstr("(other robots)"));
  EXPECT_THAT(
      thief->timsctl({"explain", kOfThief.to_hex(), "Tims/5/1", "--type=change"}),
      AllOf(HasSubstr("the policy of base does not permit it"), HasSubstr("(other robots)")));
  EXPECT_THAT(
      thief->timsctl({"acl", "test", "--from", "own", "--to", "Tims(5/1)", "--type", "change"}),
      HasSubstr("denied"));
  EXPECT_THAT(
      thief->timsctl({"acl", "test", "--from", "own", "--to", "Tims(5/1)", "--type", "look"}),
      HasSubstr("allowed"));
  // Operators are at the base, or at the robot itself.
  EXPECT_THAT(base->timsctl(route_to_thief("robot5")), Not(HasSubstr("does not permit")));
  EXPECT_THAT(base->timsctl({"-r", "robot5", "route", "show", "--json"}), HasSubstr("*(5/*)"));
  EXPECT_THAT(other->timsctl({"route", "del", "*(5/*)"}), Not(HasSubstr("does not permit")));
}

TEST_F(StolenRobotTest, ARuleAtTheBaseLetsItChangeRouters) {
  start({"rule=name=own,from=own,then=allow",
         "rule=name=mother ship,from=router:robot3,types=change,then=allow"});
  EXPECT_THAT(thief->timsctl({"-r", "base", "route", "add", "*(7/*)", "robot3"}),
              Not(HasSubstr("does not permit")));
  EXPECT_THAT(other->timsctl({"-r", "base", "route", "add", "*(8/*)", "robot3"}),
              HasSubstr("(other robots)"));
}

// A change of several hosts is kept where all of their agents have told each other so, and the one
// of the robot tells that of the base.
TEST_F(StolenRobotTest, FilesAreChangedFromTheBaseOnly) {
  start();
  const HostAgent agent_of_base(*base);
  const HostAgent agent_of_thief(*thief);
  const HostAgent agent_of_other(*other);
  const auto change = [](const std::string& to, const std::vector<std::string>& hosts) {
    std::vector<std::string> command{"config", "apply", "-y", "--window=30s"};
    for (const std::string& host : hosts)
      command.push_back(fmt::format("{}@router.toml:log.level={}", host, to));
    return command;
  };
  for (const std::string host : {"base", "robot5"})
    EXPECT_THAT(thief->timsctl(change("error", {host})), HasSubstr("(other robots)")) << host;
  EXPECT_THAT(agent_of_base.text() + agent_of_other.text(), Not(HasSubstr("error")));
  const std::string changed = base->timsctl(change("debug", {"base", "robot3", "robot5"}));
  for (const HostAgent* agent : {&agent_of_base, &agent_of_thief, &agent_of_other})
    EXPECT_THAT(agent->text(), HasSubstr("debug")) << changed;
  for (const std::string host : {"base", "robot3", "robot5"})
    EXPECT_TRUE(eventually(
        [&] {
          return base->timsctl({"config", "history", "-r", host}).find("confirmed") !=
                 std::string::npos;
        },
        host + " has confirmed"));
}

}  // namespace stolen_robot_test
}  // namespace tims::test
