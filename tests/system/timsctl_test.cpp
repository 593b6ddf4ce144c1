// timsctl as used by people and scripts: every verb, output format and exit status.
#include <fstream>

#include "os/file.h"
#include "router/core/statistics.h"
#include "tests/support/eventually.h"
#include "tests/system/timsctl_fixture.h"

namespace tims::test {
namespace timsctl_test {

TEST_F(TimsctlTest, ConfigMigrateRewritesFormerNamesOnlyAndCheckHints) {
  const std::string path = router_.folder() + "/scout.toml";
  const std::string other = router_.folder() + "/other.toml";
  const std::string before =
      "# mine\n[[component]]\nprogram = \"Scan2d\"   # of the ladar\n"
      "parameters = { reflectorFilter = 1,  ladarInst=0 }\n";
  std::ofstream(path) << before;
  std::ofstream(other) << "[tcp]\nlisten = \"off\"\n";
  const Ran hint = timsctl({"config", "check", path});
  EXPECT_EQ(hint.code, 0) << hint.err;
  EXPECT_THAT(hint.out,
              HasSubstr("scout.toml:4:16: reflectorFilter is called reflectorFilterMode"));

  const Ran dry = timsctl({"config", "migrate", path, other, "--dry-run"});
  EXPECT_EQ(dry.code, 0) << dry.err;
  EXPECT_THAT(dry.out, HasSubstr("+parameters = { reflectorFilterMode = 1,  ladarInst=0 }"));
  EXPECT_THAT(dry.err, HasSubstr("other.toml: no key has a former name"));
  EXPECT_EQ(*os::read_file(path), before);

  const Ran done = timsctl({"config", "migrate", path, "--json"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(json_lines(done.out).at(0).at("schema"), "tims/config_migrate/1");
  EXPECT_EQ(*os::read_file(path),
            "# mine\n[[component]]\nprogram = \"Scan2d\"   # of the ladar\n"
            "parameters = { reflectorFilterMode = 1,  ladarInst=0 }\n");
  EXPECT_EQ(timsctl({"config", "check", path}).out, path + ": no errors\n");
  EXPECT_EQ(timsctl({"config", "migrate", router_.folder() + "/none.toml"}).code, 4);
}

TEST_F(TimsctlTest, EveryVerbThatShowsHasTextAndJsonOutput) {
  struct Case {
    std::vector<std::string> arguments;
    const char* shows;   // part of the text output
    const char* schema;  // schema of the JSON output
  };
  const std::string good_config = router_.folder() + "/good.toml";
  std::ofstream(good_config) << "[tcp]\nlisten = \"off\"\n";
  const Case cases[] = {
      {{"status"}, "Address", "tims/status/1"},
      {{"router"}, "Epoch", "tims/status/1"},
      {{"router", "clients"}, "laser", "tims/client/1"},
      {{"route", "show"}, "Ladar(0/0)", "tims/route/1"},
      {{"route", "get", "Ladar/0/0"}, "deliver", "tims/route_get/1"},
      {{"acl", "show"}, "(open)", "tims/rule/1"},
      {{"acl", "hits"}, "MESSAGES", "tims/rule/1"},
      {{"acl", "test", "--from", "user:guest", "--to", "Ladar/0/0"}, "allowed", "tims/acl_test/1"},
      {{"acl", "log"}, "", "tims/event/1"},
      {{"mbx", "list", "Ladar"}, "laser", "tims/mailbox/1"},
      {{"mbx", "show", "0x00140000"}, "Ladar(0/0)", "tims/mailbox/1"},
      {{"ping", "router", "-n", "2", "-i", "10ms"}, "2 answered", "tims/ping_summary/1"},
      {{"top", "--once", "-i", "50ms"}, "laser", "tims/top/1"},
      {{"stats"}, "handled", "tims/stats/1"},
      {{"stats", "--by", "class"}, "1-14", "tims/stats/1"},
      {{"config", "show", "--origin"}, "--set", "tims/config/1"},
      {{"doctor"}, "router.reachable", "tims/doctor/1"},
      {{"config", "check", good_config}, "no errors", "tims/config_check/1"},
      {{"errors", "no_route"}, "not registered", "tims/code/1"},
      {{"completion", "bash"}, "complete -o default -F", "tims/completion/1"},
      {{"msg", "pub", "Ladar/0/0", "-6", "--hex", "01"}, "", "tims/pub/1"},
  };
  for (const Case& c : cases) {
    const Ran person = timsctl(c.arguments);
    EXPECT_EQ(person.code, 0) << c.arguments[0] << person.err;
    EXPECT_THAT(person.out, HasSubstr(c.shows));
    auto arguments = c.arguments;
    arguments.emplace_back("--json");
    const Ran program = timsctl(arguments);
    EXPECT_EQ(program.code, 0) << c.arguments[0] << program.err;
    const auto lines = json_lines(program.out);
    ASSERT_EQ(lines.size(), 1U) << program.out;
    ASSERT_TRUE(lines[0].contains("schema"));
    EXPECT_EQ(lines[0].at("schema").as_string(), c.schema);
  }
}

TEST_F(TimsctlTest, WatchingInJsonIsOneObjectPerLine) {
  const Ran run = timsctl({"mbx", "list", "-j", "--watch=0.01", "-n", "3"});
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(json_lines(run.out).size(), 3U);
}

TEST_F(TimsctlTest, OtherFormats) {
  EXPECT_EQ(timsctl({"mbx", "list", "-o", "name"}).out, "Ladar(0/0)\n");
  EXPECT_THAT(timsctl({"mbx", "list", "-o", "csv"}).out, HasSubstr("address.name,address.raw,"));
  EXPECT_THAT(timsctl({"mbx", "list", "-o", "plain"}).out, Not(HasSubstr("ADDRESS")));
  // A router that was late on a busy machine is a warning.
  EXPECT_THAT(timsctl({"doctor", "--format", "nagios"}).out,
              testing::AnyOf(HasSubstr("TIMS OK"), HasSubstr("TIMS WARNING")));
}

TEST_F(TimsctlTest, TheWholeTableComesInPages) {
  std::vector<MailboxOptions> options;
  for (std::uint32_t i = 0; i < 2500; ++i)
    options.push_back({.address = Address(kTest.raw() + i), .slots = 1, .body_max = 16});
  const auto mailboxes = session_->open(std::span<const MailboxOptions>(options));
  ASSERT_TRUE(mailboxes) << mailboxes.error().message();
  const auto lines = json_lines(timsctl({"mbx", "list", "-j"}).out);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].at("items").as_array().size(), 2501U);
  EXPECT_FALSE(lines[0].contains("next"));
}

TEST_F(TimsctlTest, ExitStatusReportsTheResult) {
  const std::string bad_config = router_.folder() + "/bad.toml";
  std::ofstream(bad_config) << "[tcp]\nlisten = 7\n";
  struct Case {
    std::vector<std::string> arguments;
    int code;
    const char* error;  // error code in the JSON output; null for verbs whose answer is "no"
  };
  const std::string nowhere = "unix:" + router_.folder() + "/none.sock";
  const Case cases[] = {
      {{"route", "get", "Camera/0/0"}, 1, nullptr},
      {{"config", "check", bad_config}, 1, nullptr},
      {{"route", "show", "--rate", "3"}, 2, "usage"},
      {{"mbx", "show"}, 2, "usage"},
      {{"ping", "nonsense"}, 2, "usage"},
      {{"status", "-H", nowhere}, 3, "no_router"},
      {{"mbx", "show", "Camera/0/0"}, 4, "no_such_mailbox"},
      {{"msg", "pub", "Camera/0/0", "-6"}, 4, "no_such_mailbox"},
      {{"msg", "echo", "Camera/0/0"}, 4, "no_such_mailbox"},
      {{"msg", "hz", "Camera/0/0", "-i", "50ms"}, 4, "no_such_mailbox"},
      {{"ping", "Camera/0/0"}, 4, nullptr},
      {{"errors", "nonsense"}, 4, "no_such_code"},
      {{"config", "check", router_.folder() + "/none.toml"}, 4, "no_such_file"},
      {{"msg", "echo", "--listen", "Ladar/0/0"}, 5, "address_in_use"},
      {{"ping", "Ladar/0/0", "-n", "1", "--timeout", "30ms"}, 6, nullptr},
      {{"msg", "pub", "Ladar/0/0", "on", "--timeout", "30ms"}, 6, "timeout"},
      {{"msg", "echo", "Ladar/0/0", "--timeout", "30ms"}, 6, "timeout"},
  };
  for (const Case& c : cases) {
    const std::string all = testing::PrintToString(c.arguments);
    const Ran person = timsctl(c.arguments);
    EXPECT_EQ(person.code, c.code) << all << person.err;
    EXPECT_THAT(person.err, HasSubstr(c.error == nullptr ? "" : "timsctl: ")) << all;
    auto arguments = c.arguments;
    arguments.emplace_back("-j");
    const Ran program = timsctl(arguments);
    EXPECT_EQ(program.code, c.code) << all << program.err;
    const auto lines = json_lines(program.out);
    ASSERT_EQ(lines.size(), 1U) << all << program.out;
    if (c.error == nullptr) continue;
    ASSERT_TRUE(lines[0].contains("error")) << all << program.out;
    EXPECT_EQ(lines[0].at("error").at("code").as_string(), c.error) << all;
    EXPECT_FALSE(lines[0].at("error").at("message").as_string().empty());
  }
}

TEST_F(TimsctlTest, OverTcpAsOverTheSocket) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"status"}, {"mbx", "list"}, {"doctor"}, {"ping", "router"}}) {
    auto all = arguments;
    all.insert(all.end(), {"-H", router_.tcp(), "--json", "-i10ms"});
    if (arguments[0] != "ping") all.pop_back();
    const Ran run = timsctl(all);
    EXPECT_EQ(run.code, 0) << arguments[0] << run.out << run.err;
    EXPECT_EQ(json_lines(run.out).size(), 1U);
  }
  while (ladar_->try_peek()) {
  }  // `doctor` asks components for their status
  auto echo = start({"msg", "echo", "Ladar/0/0", "-n", "1", "-H", router_.tcp()});
  ASSERT_TRUE(echo);
  const Address data = grant_subscription();
  ASSERT_TRUE(ladar_->send({.dest = data, .type = type::kData}, std::vector<std::byte>(3)));
  end_subscription();
  EXPECT_THAT(finish(*echo).out, HasSubstr("bytes=3"));
}

TEST_F(TimsctlTest, MistakesAreRefusedWithASuggestion) {
  RouterProcess pages({"http.listen=127.0.0.1:0"});
  const auto started = pages.start();
  ASSERT_TRUE(started) << started.error().message();
  struct Case {
    std::vector<std::string> arguments;
    int code;
    const char* message;
    const char* hint;
  };
  const Case cases[] = {
      {{"ping", "Ladr/0/0"}, 2, "is not an address", "did you mean Ladar/0/0?"},
      {{"mbx", "list", "Ladr(*/*)"}, 2, "is not an address pattern", "did you mean Ladar(*/*)?"},
      {{"component", "status", "Ladar(*/0)", "--wait"}, 2, "is a pattern", "component list"},
      {{"component", "pilot", "Chassis/0/0", "Ladar/0/0"},
       2,
       "Ladar(0/0) is not a pilot",
       "Pilot/0"},
      {{"component", "pilot", "Ladar/0/0"}, 2, "Ladar(0/0) is not a chassis", "Chassis/0/0"},
      {{"route", "add", "Ladar(3/*)", "robot3"}, 4, "no link to a router \"robot3\"", "no links"},
      {{"status", "-H", pages.http()}, 3, "answers in HTTP", "tcp.listen"},
      {{"status", "-H", "no-such-host.invalid"}, 3, "no router at no-such-host", "getent hosts"},
      {{"route", "get", "Chassis/0/0", "--type", "moove"}, 2, "is not a message", "mean move?"},
      {{"ping", "Ladar/0/0", "-o", "csv"}, 2, "does not support -o csv", "table, wide, json"},
  };
  for (const Case& c : cases) {
    const Ran ran = timsctl(c.arguments);
    const std::string all = testing::PrintToString(c.arguments);
    EXPECT_EQ(ran.code, c.code) << all << ran.err;
    EXPECT_THAT(ran.err, HasSubstr(c.message)) << all;
    EXPECT_THAT(ran.err, HasSubstr(c.hint)) << all;
  }
}

TEST_F(TimsctlTest, ExplainNamesAClientWithoutAName) {
  auto listener = start({"msg", "echo", "--listen", "Test/0/1", "-n", "1", "-H", router_.tcp()});
  ASSERT_TRUE(listener);
  ASSERT_TRUE(listener->wait_for_line("is registered"));
  const Ran ran = timsctl({"explain", "Ladar/0/0", "Test/0/1"});
  EXPECT_EQ(ran.code, 0);
  EXPECT_THAT(ran.out, HasSubstr("delivers it to the client at 127.0.0.1"));
  ASSERT_TRUE(ladar_->send({.dest = kTest, .type = -42}));
  EXPECT_EQ(finish(*listener).code, 0);
}

TEST_F(TimsctlTest, CompletionKnowsVerbsAndRunningAddresses) {
  for (const char* shell : {"bash", "zsh", "fish"})
    EXPECT_THAT(timsctl({"completion", shell}).out, HasSubstr("timsctl __complete"));
  EXPECT_EQ(timsctl({"completion", "tcsh"}).code, 2);
  EXPECT_EQ(timsctl({"__complete", "rou"}).out, "route\nrouter\n");
  EXPECT_EQ(timsctl({"__complete", "msg", ""}).out, "bw\necho\nhz\npub\nshow\ntypes\n");
  // Completion waits for the router for half a second only, because the user is waiting.
  EXPECT_TRUE(eventually(
      [&] {
        return timsctl({"__complete", "ping", "La"}).out == "Ladar/0/0\n";
      },
      "the living address"));
  EXPECT_EQ(timsctl({"__complete", "completion", "f"}).out, "fish\n");
  EXPECT_THAT(timsctl({"__complete", "msg", "pub", "--pr"}).out, HasSubstr("--priority\n"));
  EXPECT_EQ(timsctl({"__complete", "ping", "Ladar/0/0", "-o", ""}).out, "json\ntable\nwide\n");
  EXPECT_EQ(timsctl({"__complete", "stats", "--by=r"}).out, "--by=reason\n");
  EXPECT_EQ(timsctl({"__complete", "stats", "-n", "5", "--by", "p"}).out, "port\n");
  EXPECT_EQ(timsctl({"__complete", "msg", "pub", "Chassis/0/0", "mo"}).out, "move\n");
  EXPECT_EQ(timsctl({"__complete", "msg", "pub", "Chassis/0/0", "move", "vx=1", "o"}).out,
            "omega=\n");
  EXPECT_EQ(timsctl({"__complete", "msg", "show", "Cha"}).out, "Chassis\n");
  EXPECT_EQ(timsctl({"__complete", "config", "check", ""}).out, "")
      << "the shell completes file names";
  EXPECT_TRUE(eventually(
      [&] {
        const std::string tcp = router_.tcp();
        return timsctl({"__complete", "-H", tcp, "explain", "Pilot/0/0", "La"}).out ==
               "Ladar/0/0\n";
      },
      "what lives at another router"));
}

TEST_F(TimsctlTest, EveryReasonTheRouterCountsIsInTheCatalogue) {
  for (const auto& outcome : core::kOutcomes) {
    if (core::taken(outcome.value) && outcome.value != core::Outcome::kMailboxReplaced) continue;
    EXPECT_EQ(timsctl({"errors", std::string(outcome.name)}).code, 0) << outcome.name;
  }
}

// The default would be five seconds.
TEST_F(TimsctlTest, TurningOnWaitsForTheGivenTimeout) {
  const auto began = std::chrono::steady_clock::now();
  const Ran ran = timsctl({"component", "on", "Ladar/0/0", "--timeout", "500ms"});
  EXPECT_EQ(ran.code, 6) << ran.err;
  EXPECT_THAT(ran.err, HasSubstr("Ladar(0/0) did not answer"));
  EXPECT_LT(std::chrono::steady_clock::now() - began, kSlowdown * 4s);
}

}  // namespace timsctl_test
}  // namespace tims::test
