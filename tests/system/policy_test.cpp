// The policy with real programs: programs of another user, original clients, timsctl, a reload.
#include <csignal>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "os/file.h"
#include "tests/support/tcp_client.h"
#include "tests/system/timsctl_fixture.h"

namespace tims::test {
namespace policy_test {

constexpr Address kChassis{0x00110000};
constexpr Address kTool{0x000F0100};
constexpr std::string_view kNobody = "65534";

// Rules of a robot: its own programs do everything, the user nobody looks.
constexpr std::string_view kLooks = R"toml(
[[rule]]
name = "own programs"
from = "own"
then = "allow"

[[rule]]
name = "nobody looks"
from = "uid:65534"
types = "look"
then = "allow"
)toml";

std::int64_t number_of(const json::object& item, std::string_view field) {
  return item.at(field).to_number<std::int64_t>();
}

class PolicyTest : public testing::Test {
 protected:
  void start(std::string_view rules) {
    // Its socket is for everybody.
    ::chmod(folder_.path().c_str(), 0755);
    write(rules);
    auto started = ChildProcess::start({TIMS_ROUTER_PROGRAM, "--config", config_path()});
    ASSERT_TRUE(started) << started.error().message();
    router_.emplace(std::move(*started));
    const auto line = router_->wait_for_line("listening tcp ");
    ASSERT_TRUE(line) << line.error().message();
    tcp_ = line->substr(line->rfind(' ') + 1);
  }
  void write(std::string_view rules) {
    std::ofstream(config_path()) << "[unix]\npath = \"" << socket_path()
                                 << "\"\neverybody = true\n[tcp]\nlisten = \"127.0.0.1:0\"\n"
                                    "[http]\nlisten = \"off\"\n"
                                 << rules;
  }
  void reload(std::string_view rules, std::string_view until) {
    write(rules);
    router_->signal(SIGHUP);
    const auto line = router_->wait_for_line(until);
    EXPECT_TRUE(line) << line.error().message();
  }
  [[nodiscard]] std::string config_path() const { return folder_.path() / "router.toml"; }
  [[nodiscard]] std::string socket_path() const { return folder_.path() / "router.sock"; }

  std::optional<Session> session(const std::string& name) {
    auto session = Session::connect({.name = name,
                                     .router = socket_path(),
                                     .timeout = kPatience,
                                     .on_event = [](const SessionEvent&) {}});
    EXPECT_TRUE(session) << session.error().message();
    return session ? std::optional(std::move(*session)) : std::nullopt;
  }
  static std::optional<Mailbox> open(Session& session, Address address) {
    auto mailbox = session.open({.address = address, .slots = 64});
    EXPECT_TRUE(mailbox) << mailbox.error().message();
    return mailbox ? std::optional(std::move(*mailbox)) : std::nullopt;
  }
  TcpClient original(Address mailbox) {
    auto client = TcpClient::connect(tcp_);
    EXPECT_TRUE(client) << client.error().message();
    EXPECT_TRUE(client->register_mailbox(mailbox));
    return std::move(*client);
  }

  static std::vector<std::string> as_nobody(std::vector<std::string> command) {
    std::vector<std::string> whole{"setpriv", fmt::format("--reuid={}", kNobody),
                                   fmt::format("--regid={}", kNobody), "--clear-groups"};
    whole.insert(whole.end(), command.begin(), command.end());
    return whole;
  }
  [[nodiscard]] std::vector<std::string> timsctl(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), TIMSCTL_PROGRAM);
    arguments.insert(arguments.end(), {"-H", "unix:" + socket_path(), "--timeout",
                                       std::to_string(kPatienceMs) + "ms"});
    return arguments;
  }
  static Ran run(std::vector<std::string> command) {
    return finish(
        ChildProcess::start(std::move(command), {.environment = {"NO_COLOR=1"}, .folder = {}}));
  }
  [[nodiscard]] Ran own(std::vector<std::string> arguments) const {
    return run(timsctl(std::move(arguments)));
  }
  [[nodiscard]] Ran nobody(std::vector<std::string> arguments) const {
    return run(as_nobody(timsctl(std::move(arguments))));
  }
  [[nodiscard]] json::object rule(std::string_view name) const {
    const auto answers = json_lines(own({"acl", "hits", "--json"}).out);
    for (const json::value& item : answers.at(0).at("items").as_array())
      if (item.at("name").as_string() == name) return item.as_object();
    ADD_FAILURE() << "no rule " << name;
    return {};
  }

  TemporaryFolder folder_;
  std::optional<ChildProcess> router_;
  std::string tcp_;
};

// Needs the rights to become somebody else.
class OtherUsersTest : public PolicyTest {
 protected:
  void SetUp() override {
    if (::getuid() != 0) GTEST_SKIP() << "only root can become another user";
  }
};

TEST_F(OtherUsersTest, AProgramOfAnotherUserLooksAndDoesNotDrive) {
  start(kLooks);
  auto robot = session("robot");
  auto chassis = open(*robot, kChassis);

  const Ran moved = nobody({"msg", "pub", "Chassis/0/0", "move", "vx=200", "-y"});
  EXPECT_EQ(moved.code, 5) << moved.out;
  EXPECT_THAT(moved.err, HasSubstr("rule \"(none)\" denies it to uid:65534"));
  EXPECT_THAT(moved.err, HasSubstr("timsctl acl show"));
  const Ran on = nobody({"component", "on", "Chassis/0/0"});
  EXPECT_NE(on.code, 0) << on.out;
  EXPECT_FALSE(chassis->try_peek()) << "it did not reach the chassis";
  EXPECT_EQ(number_of(rule("(none)"), "denied"), 1);
  const Ran log = own({"acl", "log"});
  EXPECT_THAT(log.out, HasSubstr("type 1 by rule \"(none)\" for uid:65534"));

  EXPECT_EQ(nobody({"route", "show"}).code, 0) << "questions to the router are looking";
  const Ran changed = nobody({"route", "add", "Ladar(3/*)", "robot3"});
  EXPECT_NE(changed.code, 0);
  EXPECT_THAT(changed.err, HasSubstr("rule \"(none)\" for uid:65534"));
}

TEST_F(OtherUsersTest, ARejectedReloadChangesNothingAndAnAcceptedOneAppliesAtOnce) {
  start(kLooks);
  auto robot = session("robot");
  auto chassis = open(*robot, kChassis);
  auto other = original(kTool);  // connected all the time
  const std::string wanted = std::string(kLooks) + R"toml(
[[rule]]
name = "nobody drives"
from = "uid:65534"
types = "drive"
then = "allow"
)toml";
  const auto test = [](std::string_view expect) {
    return fmt::format(
        "[[test]]\nname = \"drives\"\nfrom = \"uid:65534\"\nto = \"Chassis(0/0)\"\ntype = "
        "\"move\"\nexpect = \"{}\"\n",
        expect);
  };
  reload(wanted + test("deny"), "not reloaded");
  EXPECT_EQ(
      own({"acl", "test", "--from", "uid:65534", "--to", "Chassis/0/0", "--type", "move"}).code, 1);
  reload(wanted + test("allow"), "the rules of the policy were replaced");
  const Ran verdict = own({"acl", "test", "--from", "uid:65534", "--to", "Chassis/0/0", "--type",
                           "move", "--priority", "200"});
  EXPECT_EQ(verdict.code, 0) << verdict.out;
  EXPECT_THAT(verdict.out, HasSubstr("nobody drives"));
  EXPECT_THAT(verdict.out, HasSubstr("router.toml:"));
  auto pub = ChildProcess::start(
      as_nobody(timsctl({"msg", "pub", "Chassis/0/0", "move", "vx=200", "-y"})));
  ASSERT_TRUE(pub) << pub.error().message();
  const auto request = chassis->peek_for(kPatience);
  ASSERT_TRUE(request) << request.error().message();
  EXPECT_TRUE(chassis->reply(request->header(), type::kOk));
  EXPECT_EQ(finish(*pub).code, 0);
  EXPECT_TRUE(other.send({.type = type::kGetStatus, .dest = kChassis, .src = kTool}));
  EXPECT_TRUE(chassis->peek_for(kPatience)) << "the original was not disconnected";
}

// Rules that forget their owner: the hint of each refusal leads to verbs that work.
TEST_F(PolicyTest, WhoWritesTheRulesMayReadThemWhateverTheySay) {
  start(R"toml(
[[rule]]
name = "nobody"
then = "deny"
)toml");
  const Ran shown = own({"acl", "show"});
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("nobody"));
  EXPECT_EQ(own({"status"}).code, 0);
  EXPECT_EQ(own({"acl", "log"}).code, 0);
  const Ran changed = own({"route", "add", "Ladar(3/*)", "robot3"});
  EXPECT_EQ(changed.code, 5) << changed.out;
  EXPECT_THAT(changed.err, HasSubstr("rule \"nobody\" at "));
}

// Whatever it sends to: messages of a program under a policy go through the router.
TEST_F(OtherUsersTest, AProgramUnderAPolicyHasNoMemoryOfOthers) {
  start(std::string(kLooks) + R"toml(
[[rule]]
name = "nobody sends data"
from = "uid:65534"
types = "replies"
then = "allow"
)toml");
  auto robot = session("victim");
  auto victim = open(*robot, Address(2));  // to which the actors send
  // Neither mapped nor held as a descriptor.
  const auto has_memory_of_victim = [](const ChildProcess& process) {
    const std::string folder = fmt::format("/proc/{}/", process.pid());
    std::string all = os::read_file(folder + "maps").value_or("");
    for (const auto& file : std::filesystem::directory_iterator(folder + "fd"))
      all += std::filesystem::read_symlink(file).string();
    EXPECT_THAT(all, HasSubstr("memfd:tims-send-and-close")) << "its own";
    return all.find("memfd:tims-victim") != std::string::npos;
  };
  const auto actor = [&](Address own) {
    return std::vector<std::string>{TIMS_ACTOR_PROGRAM, "send-and-close", socket_path(),
                                    own.to_string({})};
  };
  for (const bool is_judged : {false, true}) {
    const Address own(kTool.raw() + (is_judged ? 1U : 0U));
    auto sender = ChildProcess::start(is_judged ? as_nobody(actor(own)) : actor(own));
    ASSERT_TRUE(sender) << sender.error().message();
    ASSERT_TRUE(sender->wait_for_line("ready"));
    const auto sent = victim->peek_for(kPatience);
    ASSERT_TRUE(sent) << sent.error().message();
    EXPECT_EQ(sent->header().src, own);
    EXPECT_EQ(has_memory_of_victim(*sender), !is_judged);
  }
}

TEST_F(OtherUsersTest, ExplainAndTraceNameTheRule) {
  start(kLooks);
  auto robot = session("robot");
  auto chassis = open(*robot, kChassis);
  auto echo = ChildProcess::start(
      as_nobody({TIMS_ACTOR_PROGRAM, "echo", socket_path(), kTool.to_string({})}));
  ASSERT_TRUE(echo) << echo.error().message();
  ASSERT_TRUE(echo->wait_for_line("ready"));
  const Ran explained = own({"explain", "Tool/0/1", "Chassis/0/0", "--type", "move"});
  EXPECT_EQ(explained.code, 1) << explained.out;
  EXPECT_THAT(explained.out, HasSubstr("rule \"(none)\" denies it to uid:65534"));
  EXPECT_EQ(own({"explain", "Tool/0/1", "Chassis/0/0"}).code, 0);

  const std::string deny = R"toml(
[[rule]]
name = "no status"
from = "uid:65534"
to = "Chassis(*/*)"
then = "deny"
)toml";
  reload(deny + std::string(kLooks), "the rules of the policy were replaced");
  const Ran traced = nobody({"trace", "Chassis/0/0"});
  EXPECT_THAT(traced.out, HasSubstr("denied by rule \"no status\" at "));
  EXPECT_THAT(traced.out, HasSubstr("router.toml:9"));
}

TEST_F(PolicyTest, RatesOfBytesHoldForAllConnectionsOfAUserTogether) {
  start(R"toml(
[[rule]]
name = "slow originals"
from = "port:tcp"
types = "commands"
rate = "1000B"
then = "allow"

[[rule]]
name = "rest"
then = "allow"
)toml");
  auto robot = session("robot");
  auto chassis = open(*robot, kChassis);
  constexpr int kClients = 4;
  int denied = 0;
  for (int i = 0; i < kClients; ++i) {
    const Address mailbox(kTool.raw() + (static_cast<std::uint32_t>(i) << 8));
    auto client = original(mailbox);
    const std::vector<std::byte> body(484);
    for (int j = 0; j < 5; ++j)
      ASSERT_TRUE(client.send({.type = 21, .dest = kChassis, .src = mailbox}, body));
    // Answered in order: after all of them.
    ASSERT_TRUE(client.send({.type = -1, .dest = mailbox, .src = mailbox}));
    for (;;) {
      const auto answer = client.receive();
      ASSERT_TRUE(answer) << answer.error().message();
      if (answer->header.type != type::kNotAvailable) break;
      ++denied;
    }
  }
  // 10 kB within far less than a second: three messages of 500 B at once, and what a second brings.
  EXPECT_GE(denied, 4 * 5 - 3 - 2 * kSlowdown * 4);
  EXPECT_GE(denied, 5);
  EXPECT_EQ(number_of(rule("slow originals"), "over_rate"), denied);
}

TEST_F(PolicyTest, StreamsAreThinned) {
  start(R"toml(
[[rule]]
name = "every third"
to = "Tool(0/1)"
types = "-6"
priority_max = 3
every = 3
then = "thin"

[[rule]]
name = "short"
to = "Tool(0/2)"
types = "-6"
bytes_max = "100B"
then = "thin"

[[rule]]
name = "one a second"
to = "Tool(0/3)"
types = "-6"
per_second = 1
then = "thin"

[[rule]]
name = "rest"
then = "allow"
)toml");
  auto robot = session("robot");
  auto chassis = open(*robot, kChassis);
  const auto samples = [&](std::uint32_t tool, std::size_t length) {
    const Address to(0x000F0000 + (tool << 8));
    auto client = original(to);
    const std::vector<std::byte> body(length);
    for (int i = 0; i < 30; ++i)
      EXPECT_TRUE(chassis->send({.dest = to, .type = -6, .priority = 9, .stream = true}, body));
    EXPECT_TRUE(chassis->send({.dest = to, .type = 0}));
    std::vector<Header> got;
    for (;;) {
      const auto message = client.receive();
      EXPECT_TRUE(message) << message.error().message();
      if (!message || message->header.type == 0) return got;
      got.push_back(message->header);
    }
  };
  const auto third = samples(1, 8);
  EXPECT_EQ(third.size(), 10U);
  for (const Header& header : third) EXPECT_EQ(header.priority, 3);
  EXPECT_EQ(samples(2, 8).size(), 30U);
  EXPECT_EQ(samples(2, 100).size(), 0U) << "with its header it is longer";
  const auto slow = samples(3, 8);
  EXPECT_GE(slow.size(), 1U);
  EXPECT_LE(slow.size(), static_cast<std::size_t>(1 + 2 * kSlowdown));
  EXPECT_EQ(number_of(rule("every third"), "thinned"), 20);
  EXPECT_EQ(number_of(rule("short"), "thinned"), 30);
}

TEST_F(PolicyTest, DrivingLeasesAndLoginsAreSubjectToTheRules) {
  start(R"toml(
[[rule]]
name = "originals do not drive"
from = "port:tcp"
types = ["drive", "login"]
then = "deny"

[[rule]]
name = "rest"
then = "allow"
)toml");
  auto client = original(kTool);
  for (const char* question :
       {R"({"ask":"lease","robot":0,"do":"take","name":"tablet"})", R"({"ask":"login"})"}) {
    ASSERT_TRUE(client.send({.type = type::kAdminRequest}, bytes_of(question)));
    const auto answer = client.receive();
    ASSERT_TRUE(answer) << answer.error().message();
    EXPECT_THAT(text_of(answer->body), HasSubstr("originals do not drive"));
    EXPECT_THAT(text_of(answer->body), HasSubstr("router.toml:9"));
  }
  ASSERT_TRUE(client.send({.type = type::kAdminRequest}, bytes_of(R"({"ask":"leases"})")));
  const auto answer = client.receive();
  ASSERT_TRUE(answer) << answer.error().message();
  EXPECT_THAT(text_of(answer->body), HasSubstr(R"("items":[])"));
}

}  // namespace policy_test
}  // namespace tims::test
