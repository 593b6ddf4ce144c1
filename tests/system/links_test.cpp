// A tree of routers of several hosts, as processes connected by real UDP over the loopback.
#include <algorithm>
#include <csignal>
#include <fstream>
#include <memory>
#include <thread>

#include <boost/json/parse.hpp>
#include <gmock/gmock.h>

#include "tests/support/eventually.h"
#include "tests/support/own_network.h"
#include "tests/system/host.h"
#include "tests/system/local_fixture.h"

namespace tims::test {
namespace links_test {

namespace json = boost::json;
using testing::HasSubstr;

constexpr Address kServer(0x01140000);  // Ladar(1/0)
constexpr Address kClient(0x00020000);  // GUI(0/0)

// The router is started first, then the interface gets its address.
TEST(LateInterface, TheLinkComesUpWhenTheAddressDoes) {
  const auto network = OwnNetwork::enter();
  if (!network) GTEST_SKIP() << network.error().message();
  Host base("base", "top", 0, 1, {"kind=sub,system=*"}, {"security.insecure=true"});
  base.listen_at("10.203.0.9:0");
  base.start();
  EXPECT_THAT(base.log(), HasSubstr("this host has no such address yet"));
  Host robot("robot1", "system", 1, 1, {"kind=super,to=" + base.udp()}, {"security.insecure=true"});
  robot.listen_at("10.203.0.10:0");
  robot.start();
  Session session = robot.session("server");
  const auto server = session.open({.address = kServer, .body_max = 100});
  ASSERT_TRUE(server.ok()) << server.error().message();
  EXPECT_FALSE(base.knows(kServer));
  for (const char* address : {"10.203.0.9/32", "10.203.0.10/32"}) {
    auto ip = ChildProcess::start({"ip", "address", "add", address, "dev", "lo"});
    ASSERT_TRUE(ip.ok() && ip->wait().ok());
  }
  EXPECT_TRUE(eventually([&] { return base.knows(kServer); }, "the base knows the server"));
}

TEST(Ipv6, ALinkOverIt) {
  Host base("base", "top", 0, 1, {"kind=sub,system=*"});
  base.listen_at("[::1]:0");
  base.start();
  EXPECT_THAT(base.udp(), HasSubstr("[::1]:"));
  Host robot("robot1", "system", 1, 1, {"kind=super,to=" + base.udp()});
  robot.listen_at("[::1]:0");
  robot.start();
  Session session = robot.session("server");
  const auto server = session.open({.address = kServer, .body_max = 100});
  ASSERT_TRUE(server.ok()) << server.error().message();
  EXPECT_TRUE(eventually([&] { return base.knows(kServer); }, "the base knows the server"));
}

TEST(Ipv6, AnAddressThatTheSocketCannotReachIsReported) {
  Host robot("robot1", "system", 1, 1, {"kind=super,to=[::1]:2010"});
  robot.start();
  EXPECT_TRUE(robot.process().wait_for_line("[::1]:2010, which the socket of udp.listen").ok());
  const std::string doctor = robot.timsctl({"doctor"});
  EXPECT_THAT(doctor, HasSubstr("which the socket of udp.listen = \"127.0.0.1:"));
}

// For how long it has been connecting, not for how long the host has been running.
TEST(Since, ALinkThatWasNeverUp) {
  Host robot("robot1", "system", 1, 1,
             {"kind=super,to=no-such-host.invalid:2010", "kind=super,to=127.0.0.1:9"},
             {"security.insecure=true"});
  robot.start();
  const json::value links = json::parse(robot.timsctl({"link", "show", "--json"}));
  ASSERT_EQ(links.at("items").as_array().size(), 2U);
  for (const json::value& link : links.at("items").as_array())
    EXPECT_LT(link.at("since_s").to_number<double>(), 60) << link;
}

// base (top) - robot1 (system) - arm (subsystem)
struct Tree : testing::Test {
  void SetUp() override {
    base =
        std::make_unique<Host>("base", "top", 0, 1, std::vector<std::string>{"kind=sub,system=*"});
    base->start();
    robot = std::make_unique<Host>(
        "robot1", "system", 1, 1,
        std::vector<std::string>{"kind=super,to=" + base->udp(), "kind=sub,system=1"},
        std::vector<std::string>{"sim.faults=true"});
    robot->start();
    arm = std::make_unique<Host>("arm", "subsystem", 1, 2,
                                 std::vector<std::string>{"kind=super,to=" + robot->udp()});
    arm->start();
  }
  static Mailbox open(Session& session, Address address) {
    auto opened = session.open({.address = address, .body_max = 1U << 20});
    EXPECT_TRUE(opened.ok()) << opened.error().message();
    return std::move(*opened);
  }

  std::unique_ptr<Host> base;
  std::unique_ptr<Host> robot;
  std::unique_ptr<Host> arm;
};

TEST_F(Tree, ARequestGoesDownTwoLinksAndItsAnswerComesUp) {
  Session server_session = arm->session("server");
  Mailbox server = open(server_session, kServer);
  Session client_session = base->session("client");
  Mailbox client = open(client_session, kClient);
  ASSERT_TRUE(eventually([&] { return base->knows(kServer); }, "the top knows the server"));
  const std::string text(100'000, 'x');  // many datagrams
  ASSERT_TRUE(client.send({.dest = kServer, .type = 21}, bytes_of(text)).ok());
  const auto request = server.peek_for(kPatience);
  ASSERT_TRUE(request.ok()) << request.error().message();
  EXPECT_EQ(text_of(request->body()), text);
  ASSERT_TRUE(server.reply(request->header(), type::kOk, bytes_of("well")).ok());
  const auto answer = client.peek_for(kPatience);
  ASSERT_TRUE(answer.ok()) << answer.error().message();
  EXPECT_EQ(answer->header().src, kServer);
  EXPECT_EQ(text_of(answer->body()), "well");
}

TEST_F(Tree, CommandsToUnknownMailboxesAreAnsweredByTheTop) {
  Session session = arm->session("client");
  Mailbox client = open(session, kServer);
  ASSERT_TRUE(eventually([&] { return base->knows(kServer); }, "the top knows the client"));
  ASSERT_TRUE(client.send({.dest = Address(0x07140000), .type = 3}, bytes_of("")).ok());
  const auto answer = client.peek_for(kPatience);
  ASSERT_TRUE(answer.ok()) << answer.error().message();
  EXPECT_EQ(answer->header().type, type::kNotAvailable);
  EXPECT_EQ(answer->header().src, Address(0x07140000));
}

TEST_F(Tree, AKilledRouterIsWithdrawnAndFoundAgain) {
  Session session = arm->session("server");
  Mailbox server = open(session, kServer);
  ASSERT_TRUE(eventually([&] { return base->knows(kServer); }, "the top knows the server"));
  robot->kill();
  EXPECT_TRUE(eventually([&] { return !base->knows(kServer); }, "it is withdrawn at the top"));
  Session client_session = base->session("client");
  Mailbox client = open(client_session, kClient);
  ASSERT_TRUE(client.send({.dest = kServer, .type = 3}, bytes_of("")).ok());
  const auto answer = client.peek_for(kPatience);
  ASSERT_TRUE(answer.ok()) << answer.error().message();
  EXPECT_EQ(answer->header().type, type::kNotAvailable);
  robot->start();
  EXPECT_TRUE(eventually([&] { return base->knows(kServer); }, "it is known at the top again"));
}

TEST_F(Tree, TheRefusalOfASecondRouterWithOneIdNamesTheFirst) {
  Host twin("twin", "system", 1, 1, {"kind=super,to=" + base->udp()});
  ASSERT_TRUE(eventually([&] { return base->knows(Address(0x01000100)); }, "robot1 is known"));
  twin.start();
  EXPECT_TRUE(eventually([&] { return twin.log().find("robot1") != std::string::npos; },
                         "the twin receives the name of the router with its id"));
  EXPECT_TRUE(eventually([&] { return base->log().find("twin") != std::string::npos; },
                         "the base names both"));
  EXPECT_THAT(base->timsctl({"router", "list", "--json"}), HasSubstr("\"robot1\""));
}

TEST_F(Tree, EveryRouterIsSeenFromEveryOther) {
  for (Host* from : {base.get(), robot.get(), arm.get()}) {
    const auto missing = [&]() -> std::string {
      const json::value answer = json::parse(from->timsctl({"router", "list", "--json"}));
      std::string seen;
      for (const json::value& item : answer.at("items").as_array()) {
        if (item.at("state") == "up") seen += std::string(item.at("name").as_string()) + " ";
      }
      return seen == "base robot1 arm " ? "" : "seen: " + seen;
    };
    EXPECT_TRUE(eventually(missing));
  }
  EXPECT_THAT(base->timsctl({"--router", "arm", "status", "--json"}), HasSubstr(R"("name":"arm")"));
}

// A robot's router does not know the other robots.
TEST_F(Tree, ComponentsOfAnotherRobotAreListed) {
  Host other("robot2", "system", 2, 1, {"kind=super,to=" + base->udp()});
  other.start();
  Session session = other.session("server");
  const Mailbox server = open(session, Address(0x02140000));
  ASSERT_TRUE(eventually([&] { return base->knows(Address(0x02140000)); }, "it is known"));
  // The ladar does not report its status; the list waits for it only for a short time.
  const auto lists = [](Host& at, const char* part) {
    return at.timsctl({"component", "list", "Ladar(2/*)", "--json", "--timeout=300ms"})
               .find(part) != std::string::npos;
  };
  EXPECT_TRUE(
      eventually([&] { return lists(*robot, R"("program":"server")"); }, "robot1 finds it"));
  EXPECT_TRUE(eventually([&] { return lists(*base, R"("program":null)"); },
                         "the base knows it, but not its program"));
}

TEST_F(Tree, AListWithoutARouterIsIncomplete) {
  ASSERT_TRUE(eventually([&] { return base->knows(Address(0x01000200)); }, "the arm is known"));
  EXPECT_THAT(base->timsctl({"router", "list", "-j"}), HasSubstr(R"("partial":false)"));
  robot->kill();
  // A request before its link is down would wait for an answer.
  ASSERT_TRUE(eventually([&] { return !base->knows(Address(0x01000100)); }, "its link is down"));
  EXPECT_TRUE(eventually(
      [&] {
        const std::string list = base->timsctl({"router", "list", "-j"});
        return list.find(R"("partial":true)") != std::string::npos &&
               list.find(R"("robot1")") != std::string::npos;
      },
      "robot1 is listed as one that is missing"));
}

// The exit status of `router list`, and each router with its parent and state.
testing::AssertionResult list_becomes(const Host& host, const std::string& wanted) {
  return eventually([&]() -> std::string {
    auto child =
        ChildProcess::start({TIMSCTL_PROGRAM, "-H", "unix:" + host.socket(), "router", "list", "-j",
                             "--timeout=" + std::to_string(kPatienceMs) + "ms"});
    EXPECT_TRUE(child.ok());
    const auto status = child->wait();
    EXPECT_TRUE(status.ok());
    std::string seen = std::to_string(status->code);
    const json::value answer = json::parse(child->standard_output());
    for (const json::value& item : answer.at("items").as_array())
      for (const char* field : {"name", "parent", "state"})
        if (const auto* text = item.at(field).if_string())
          seen.append(*field == 'n' ? "; " : " ").append(*text);
    return seen == wanted ? "" : "seen: " + seen;
  });
}

TEST_F(Tree, ARouteNeedsAnExistingLink) {
  ASSERT_TRUE(eventually([&] { return base->knows(Address(0x01000100)); }, "robot1 is known"));
  // For any client: the refusal is from the router itself.
  Session session = base->session("client");
  Mailbox client = open(session, kClient);
  ASSERT_TRUE(client.send({.dest = session.router(), .type = type::kAdminRequest},
                          bytes_of(R"x({"ask":"route_add","match":"Ladar(3/*)","via":"robt1"})x")));
  const auto answer = client.peek_for(kPatience);
  ASSERT_TRUE(answer.ok()) << answer.error().message();
  EXPECT_THAT(text_of(answer->body()), HasSubstr("no_such_link"));
  EXPECT_THAT(base->timsctl({"route", "add", "Ladar(3/*)", "robt1"}),
              HasSubstr("no link to a router \"robt1\""));
  EXPECT_THAT(base->timsctl({"route", "add", "Ladar(3/*)", "robt1"}),
              HasSubstr("did you mean robot1?"));
  const auto has_route = [&] {
    return base->timsctl({"route", "show", "-j"}).find("Ladar(3/*)") != std::string::npos;
  };
  EXPECT_FALSE(has_route());
  (void)base->timsctl({"route", "add", "Ladar(3/*)", "robot1"});
  EXPECT_TRUE(has_route());
}

TEST_F(Tree, AnAddedRouteIsKeptByAReload) {
  const std::string folder = base->socket().substr(0, base->socket().rfind('/'));
  const std::string path = folder + "/spare.toml";
  const std::string socket = folder + "/spare.sock";
  const std::string start =
      "router = { name = \"spare\", role = \"system\", system = 9, id = 1 }\nunix.path = \"" +
      socket + "\"\ntcp.listen = \"off\"\nhttp.listen = \"off\"\nudp.listen = \"127.0.0.1:0\"\n" +
      "link = [{ kind = \"super\", to = \"" + base->udp() + "\" }]\n";
  std::ofstream(path) << start;
  auto spare = ChildProcess::start({TIMS_ROUTER_PROGRAM, "--config", path});
  ASSERT_TRUE(spare.ok());
  const auto timsctl = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {TIMSCTL_PROGRAM, "-H", "unix:" + socket});
    auto child = ChildProcess::start(std::move(arguments));
    if (!child || !child->wait()) return std::string("not run");
    return child->standard_output() + child->standard_error();
  };
  const auto has_route = [&] {
    return timsctl({"route", "show", "-j"}).find("Ladar(3/*)") != std::string::npos;
  };
  EXPECT_TRUE(eventually(
      [&] {
        return timsctl({"route", "add", "Ladar(3/*)", "base"}).empty();
      },
      "the link exists"));
  EXPECT_TRUE(has_route());
  std::ofstream(path) << start << "log.level = \"debug\"\n";
  spare->signal(SIGHUP);
  EXPECT_TRUE(spare->wait_for_line("reloaded: log.level").ok());
  EXPECT_TRUE(has_route());
}

TEST_F(Tree, ARouterThatSentCloseIsNotListedAsMissing) {
  ASSERT_TRUE(list_becomes(*base, "0; base up; robot1 base up; arm robot1 up"));
  arm->process().signal(SIGTERM);
  ASSERT_TRUE(arm->process().wait());
  EXPECT_TRUE(list_becomes(*robot, "0; base robot1 up; robot1 up"));
  EXPECT_TRUE(list_becomes(*base, "0; base up; robot1 base up"));
  robot->process().signal(SIGTERM);
  ASSERT_TRUE(robot->process().wait());
  EXPECT_TRUE(list_becomes(*base, "0; base up"));
  robot->start();
  EXPECT_TRUE(list_becomes(*base, "0; base up; robot1 base up")) << "it is found again";
}

// Only the base knows of the arm: robot1 cannot be asked, and a restarted one knows nothing.
TEST_F(Tree, RoutersBelowAKilledOneAreListedAsMissing) {
  const auto becomes = [&](const std::string& wanted) { return list_becomes(*base, wanted); };
  const std::string all = "0; base up; robot1 base up; arm robot1 up";
  ASSERT_TRUE(becomes(all));
  ASSERT_TRUE(eventually([&] { return base->knows(Address(0x01000200)); }, "the arm is known"));
  robot->kill();
  ASSERT_TRUE(eventually([&] { return !base->knows(Address(0x01000100)); }, "its link is down"));
  EXPECT_TRUE(becomes("6; base up; robot1 base down; Tims(1/2) robot1 down"));
  EXPECT_THAT(base->timsctl({"router", "list"}), HasSubstr("\n    Tims(1/2)")) << "under robot1";
  EXPECT_THAT(base->timsctl({"explain", "Tims/0/1", "Tims/1/2"}), HasSubstr("robot1"));
  robot->start();
  EXPECT_TRUE(becomes(all));
}

TEST_F(Tree, APermittedRouterInjectsFaults) {
  const auto link_loss = [&](const char* link, const char* fault) {
    return robot->timsctl({"sim", "fault", "--link", link, fault});
  };
  ASSERT_TRUE(eventually([&] { return base->knows(Address(0x01000200)); }, "the arm is known"));
  EXPECT_THAT(link_loss("base", "blackout"), HasSubstr("robot1, datagrams to base: blackout"));
  EXPECT_TRUE(
      eventually([&] { return !base->knows(Address(0x01000200)); }, "the base receives nothing"));
  EXPECT_THAT(robot->timsctl({"link", "show"}),
              HasSubstr("what is sent to base: nothing is sent; `timsctl sim"));
  EXPECT_THAT(robot->timsctl({"link", "show", "arm", "--json"}), HasSubstr(R"("faults":null)"));
  EXPECT_THAT(link_loss("all", "heal"), HasSubstr("perfect"));
  EXPECT_THAT(robot->timsctl({"link", "show"}), Not(HasSubstr("injected")));
  EXPECT_TRUE(eventually([&] { return base->knows(Address(0x01000200)); }, "it is known again"));

  EXPECT_THAT(link_loss("basse", "loss=10%"), HasSubstr("there are links to base, arm"));
  EXPECT_THAT(link_loss("base", "cut"), HasSubstr("cannot cut a line"));
  EXPECT_THAT(link_loss("base", "direction=up"), HasSubstr("at the other end"));
  EXPECT_THAT(base->timsctl({"sim", "fault", "--link", "robot1", "loss=10%"}),
              HasSubstr("set sim.faults = true"));
}

TEST_F(Tree, ATraceShowsEveryRouter) {
  Session session = arm->session("server");
  Mailbox server = open(session, kServer);
  ASSERT_TRUE(eventually([&] { return base->knows(kServer); }, "the top knows the server"));
  std::vector<std::string> command{TIMSCTL_PROGRAM, "-H", "unix:" + base->socket(), "trace",
                                   "Ladar/1/0"};
  auto child = ChildProcess::start(command);
  ASSERT_TRUE(child.ok());
  const auto request = server.peek_for(kPatience);
  ASSERT_TRUE(request.ok()) << request.error().message();
  ASSERT_TRUE(server.reply(request->header(), type::kEnabled).ok());
  ASSERT_TRUE(child->wait().ok());
  for (const char* router : {"base", "robot1", "arm"})
    EXPECT_THAT(child->standard_output(), HasSubstr(router));
}

TEST_F(Tree, TheTimesOfATraceDoNotRunBackwards) {
  Session session = arm->session("server");
  Mailbox server = open(session, kServer);
  ASSERT_TRUE(eventually([&] { return base->knows(kServer); }, "the top knows the server"));
  std::jthread answering([&](const std::stop_token& stop) {
    while (!stop.stop_requested())
      if (const auto request = server.peek_for(10ms))
        (void)server.reply(request->header(), type::kEnabled);
  });
  for (int i = 0; i < 10; ++i) {
    const std::string answer = base->timsctl({"trace", "Ladar/1/0", "--json"});
    std::vector<std::string> times;
    for (std::size_t at = answer.find("\"time\""); at != std::string::npos;
         at = answer.find("\"time\"", at + 1))
      times.push_back(answer.substr(at, 40));
    EXPECT_GE(times.size(), 3U) << answer;
    EXPECT_TRUE(std::ranges::is_sorted(times)) << answer;
  }
}

// What an operator asks first when a robot does not react.
TEST_F(Tree, VerbsNameTheLinkThatIsCut) {
  Session session = arm->session("server");
  Mailbox server = open(session, kServer);
  ASSERT_TRUE(eventually([&] { return base->knows(kServer); }, "the top knows the server"));
  EXPECT_THAT(base->timsctl({"status"}), HasSubstr("1 up"));
  ASSERT_THAT(robot->timsctl({"sim", "fault", "--link", "base", "blackout"}),
              HasSubstr("blackout"));
  ASSERT_TRUE(eventually([&] { return !base->knows(kServer); }, "the link is down"));
  const std::string cut = "the link of base to robot1 is ";
  for (const std::vector<std::string>& verb :
       std::vector<std::vector<std::string>>{{"component", "on", "Ladar/1/0"},
                                             {"component", "data", "Ladar/1/0"},
                                             {"component", "status", "Ladar/1/0"},
                                             {"ping", "Ladar/1/0", "-n", "1"},
                                             {"explain", "Tims/0/1", "Ladar/1/0"}})
    EXPECT_THAT(base->timsctl(verb), HasSubstr(cut)) << verb.front() << " " << verb[1];
  EXPECT_THAT(base->timsctl({"status"}), HasSubstr("robot1 is "));
}

TEST_F(Tree, ExplainNamesTheLastRouterAndTheReason) {
  Session session = arm->session("server");
  Mailbox server = open(session, kServer);
  ASSERT_TRUE(eventually([&] { return base->knows(kServer); }, "the top knows the server"));
  EXPECT_THAT(base->timsctl({"explain", "Tims/0/1", "Ladar/1/0"}), HasSubstr("it arrives: arm"));
  EXPECT_THAT(base->timsctl({"explain", "Tims/0/1", "Ladar/7/0"}),
              HasSubstr("no router of the fleet has Ladar(7/0)"));
}

// An operator's joystick for robot 1 at the base.
TEST_F(Tree, AMailboxOfARobotMayBeAtTheBase) {
  constexpr Address kJoystick(0x01260000);
  Session operators = base->session("operator");
  Mailbox joystick = open(operators, kJoystick);
  Session session = arm->session("pilot");
  Mailbox pilot = open(session, kServer);
  ASSERT_TRUE(eventually([&] { return base->knows(kServer); }, "the top knows the pilot"));
  ASSERT_TRUE(pilot.send({.dest = kJoystick, .type = 3}, bytes_of("")).ok());
  const auto request = joystick.peek_for(kPatience);
  ASSERT_TRUE(request.ok()) << request.error().message();
  EXPECT_EQ(request->header().src, kServer);
  EXPECT_THAT(arm->timsctl({"explain", "Ladar/1/0", kJoystick.to_string()}),
              HasSubstr("it arrives: base"));
}

// The sink of texts is not announced to other routers, so the base has no route to that of a robot.
TEST_F(Tree, ExplainAsksAllRoutersBeforeItReportsThatAMailboxIsUnknown) {
  Session session = arm->session("log");
  Mailbox sink = open(session, text_sink());
  ASSERT_TRUE(eventually([&] { return base->knows(Address(0x01000200)); }, "the arm is known"));
  EXPECT_THAT(
      base->timsctl({"explain", "Tims/0/1", text_sink().to_string()}),
      HasSubstr(text_sink().to_string() + " is registered at arm, to which there is no route"));
  EXPECT_THAT(base->timsctl({"explain", text_sink().to_string(), "Tims/0/1"}),
              HasSubstr("it arrives"));
}

}  // namespace links_test
}  // namespace tims::test
