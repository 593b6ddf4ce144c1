// What the policy promises across routers, between real processes: commands that come too late,
// streams for others, and who drives a robot of several hosts.
#include <array>
#include <chrono>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/eventually.h"
#include "tests/support/tcp_client.h"
#include "tests/system/host.h"

namespace tims::test {
namespace policy_links_test {

namespace json = boost::json;
using testing::HasSubstr;

constexpr Address kChassis(0x01110000);
constexpr Address kLadar(0x01140000);
constexpr Address kTool(0x000F0700);
constexpr Address kOtherTool(0x000F0800);
constexpr Address kRobot(0x01000100);
constexpr Address kArm(0x01000200);
constexpr std::int8_t kMove = 21;
constexpr std::uint8_t kSpeedPriority = 20;

// base (top) - robot1 (system) - arm (subsystem), which has the chassis.
class PolicyLinksTest : public testing::Test {
 protected:
  void SetUp() override {
    base.emplace("base", "top", 0, 1, std::vector<std::string>{"kind=sub,system=*,interval=5s"},
                 std::vector<std::string>{"sim.faults=true", lifetimes()});
    base->start();
    robot.emplace(
        "robot1", "system", 1, 1,
        std::vector<std::string>{"kind=super,interval=5s,to=" + base->udp(), "kind=sub,system=1"},
        std::vector<std::string>{lifetimes()});
    robot->start();
    arm.emplace("arm", "subsystem", 1, 2, std::vector<std::string>{"kind=super,to=" + robot->udp()},
                std::vector<std::string>{lifetimes()});
    arm->start();
    session.emplace(arm->session("chassis"));
    chassis.emplace(open(*session, kChassis));
    ladar.emplace(open(*session, kLadar));
    ASSERT_TRUE(eventually([&] { return base->knows(kLadar); }, "the base knows the arm"));
  }
  static Mailbox open(Session& session, Address address) {
    auto opened = session.open({.address = address, .slots = 64});
    EXPECT_TRUE(opened.ok()) << opened.error().message();
    return std::move(*opened);
  }
  // Long enough for a slow machine: what is not late arrives.
  static std::string lifetimes() {
    return fmt::format("message.lifetimes=chassis.move {}s", 2 * kSlowdown);
  }
  static TcpClient original(const Host& host, Address mailbox) {
    auto client = TcpClient::connect(host.tcp());
    EXPECT_TRUE(client.ok()) << client.error().message();
    EXPECT_TRUE(client->register_mailbox(mailbox).ok());
    return std::move(*client);
  }
  // Asks a router from a mailbox of the client.
  static json::object ask(TcpClient& client, Address mailbox, Address router,
                          std::string_view question) {
    const Header header{.type = type::kAdminRequest, .dest = router, .src = mailbox};
    EXPECT_TRUE(client.send(header, bytes_of(question)).ok());
    const auto answer = client.receive();
    EXPECT_TRUE(answer.ok()) << answer.error().message();
    return answer ? json::parse(text_of(answer->body)).as_object() : json::object();
  }
  // What an answer says to a speed; the chassis accepts all that reach it.
  std::int8_t answer_to_move(TcpClient& client, Address from) {
    const std::array<std::int32_t, 3> speed{100, 0, 0};
    const Header header{.type = kMove, .priority = kSpeedPriority, .dest = kChassis, .src = from};
    EXPECT_TRUE(client.send(header, std::as_bytes(std::span(speed))).ok());
    using Clock = std::chrono::steady_clock;
    for (const auto end = Clock::now() + kPatience; Clock::now() < end;) {
      while (const auto request = chassis->try_peek())
        EXPECT_TRUE(chassis->reply(request->header(), type::kOk).ok());
      const auto answer = client.receive(std::chrono::milliseconds(20));
      if (answer) return answer->header.type;
      if (answer.error().code() != Errc::kTimeout) break;
    }
    ADD_FAILURE() << "no answer";
    return 99;
  }

  std::optional<Host> base;
  std::optional<Host> robot;
  std::optional<Host> arm;
  std::optional<Session> session;
  std::optional<Mailbox> chassis;
  std::optional<Mailbox> ladar;
};

TEST_F(PolicyLinksTest, ACommandOlderThanItsLifetimeNeverArrivesWhenALinkHasHealed) {
  Session operators = base->session("operator");
  Mailbox joystick = open(operators, kTool);
  ASSERT_THAT(base->timsctl({"sim", "fault", "--link", "robot1", "blackout"}),
              HasSubstr("blackout"));
  ASSERT_TRUE(joystick.send({.dest = kChassis, .type = kMove, .seq_nr = 1}).ok());
  ASSERT_TRUE(joystick.send({.dest = kChassis, .type = type::kOff, .seq_nr = 2}).ok());
  const auto gone = joystick.peek_for(kPatience);
  ASSERT_TRUE(gone.ok()) << gone.error().message();
  EXPECT_EQ(gone->header().type, type::kNotAvailable) << "its sender learns it while it waits";
  EXPECT_EQ(gone->header().seq_nr, 1);
  EXPECT_FALSE(chassis->try_peek().ok());
  ASSERT_THAT(base->timsctl({"sim", "fault", "--link", "all", "heal"}), HasSubstr("perfect"));
  const auto off = chassis->peek_for(kPatience);
  ASSERT_TRUE(off.ok()) << off.error().message();
  EXPECT_EQ(off->header().type, type::kOff) << "what has no lifetime is delivered";
  ASSERT_TRUE(joystick.send({.dest = kChassis, .type = kMove, .seq_nr = 3}).ok());
  const auto move = chassis->peek_for(kPatience);
  ASSERT_TRUE(move.ok()) << move.error().message();
  EXPECT_EQ(move->header().seq_nr, 3) << "the old one did not arrive before it";
}

// Over two links, whoever it is that asks: rules or not.
TEST_F(PolicyLinksTest, AStreamIsSentToWhoAsksForItAndNotToOthers) {
  Session operators = base->session("operator");
  Mailbox tool = open(operators, kTool);
  const auto subscribe = [&](Address mailbox, std::uint8_t number) {
    const std::array<std::uint32_t, 2> body{100, mailbox.raw()};
    EXPECT_TRUE(tool.send({.dest = kLadar, .type = type::kGetContData, .seq_nr = number},
                          std::as_bytes(std::span(body)))
                    .ok());
  };
  subscribe(kChassis, 1);
  subscribe(kTool, 2);
  const auto asked = ladar->peek_for(kPatience);
  ASSERT_TRUE(asked.ok()) << asked.error().message();
  EXPECT_EQ(asked->header().seq_nr, 2);
  EXPECT_THAT(robot->timsctl({"stats", "--by", "reason"}), HasSubstr("forged"));
}

TEST_F(PolicyLinksTest, ALeaseHoldsForTheHostsBelowARobotToo) {
  TcpClient holder = original(*robot, kTool);
  TcpClient beside = original(*arm, kOtherTool);
  EXPECT_EQ(answer_to_move(beside, kOtherTool), type::kOk) << "nobody drives";
  const auto taken =
      ask(holder, kTool, kRobot, R"({"ask":"lease","robot":1,"do":"take","name":"tablet"})");
  ASSERT_TRUE(taken.contains("done")) << json::serialize(taken);
  EXPECT_TRUE(eventually([&] { return answer_to_move(beside, kOtherTool) == type::kError; },
                         "the arm knows who drives"));
  EXPECT_EQ(answer_to_move(holder, kTool), type::kOk) << "over the link";
  const auto other =
      ask(beside, kOtherTool, kArm, R"({"ask":"lease","robot":1,"do":"take_over","name":"desk"})");
  EXPECT_THAT(json::serialize(other), HasSubstr("lease_elsewhere"));
  holder.close();
  EXPECT_TRUE(eventually([&] { return answer_to_move(beside, kOtherTool) == type::kOk; },
                         "the lease ends with its holder, at the arm too"));
}

}  // namespace policy_links_test
}  // namespace tims::test
