// Rules about persons and routers that have proven by TLS who they are: at the TCP port, in a
// browser, at the other end of a link. Each router and each client is a process.
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/child_process.h"
#include "tests/support/eventually.h"
#include "tests/support/fleet_keys.h"
#include "tests/support/own_network.h"
#include "tests/support/tcp_client.h"
#include "tests/system/host.h"
#include "tests/system/websocket_client.h"

namespace tims::test {
namespace login_policy_test {

using security::MemberRole;
using testing::HasSubstr;
using Words = std::vector<std::string>;

constexpr const char* kAddress = "10.79.0.1";  // not loopback: nothing in the clear
constexpr Address kChassis(0x00110000);        // Chassis(0/0), at the base
constexpr Address kPage(0x00020000);           // GUI(0/0)
constexpr std::int8_t kMove = 21;

// All rules that can decide come after the one that decides, so the order shows, too.
const Words kRules{
    "rule=name=own,from=own,then=allow",
    "rule=name=gast keeps off,from=user:gast,to=Chassis(*/*),then=deny",
    "rule=name=gast stays outside,from=user:gast,types=login,then=deny",
    "rule=name=robot4 is blind,from=router:robot4,to=Chassis(*/*),types=look,then=deny",
    "rule=name=robots do not drive,from=role:system,to=Chassis(*/*),types=drive,then=deny",
    "rule=name=drivers,from=right:drive,then=allow",
    "rule=name=others look,from=right:look,types=look,then=allow",
    "rule=name=and log in,from=right:look,types=login,then=allow",
    "rule=name=routers,from=router:*,then=allow",
};

// A chassis that obeys.
class Chassis {
 public:
  explicit Chassis(const Host& host) : session_(host.session("chassis")) {
    auto opened = session_.open({.address = kChassis, .slots = 64});
    EXPECT_TRUE(opened.ok()) << opened.error().message();
    mailbox_.emplace(std::move(*opened));
    thread_ = std::jthread([this](const std::stop_token& end) {
      while (!end.stop_requested()) {
        const auto request = mailbox_->peek_for(std::chrono::milliseconds(50));
        if (request) (void)mailbox_->reply(request->header(), type::kOk);
      }
    });
  }

 private:
  Session session_;
  std::optional<Mailbox> mailbox_;
  std::jthread thread_;
};

class LoginPolicy : public testing::Test {
 protected:
  void SetUp() override {
    auto entered = OwnNetwork::enter_with(kAddress);
    if (!entered) GTEST_SKIP() << entered.error().message();
    network_.emplace(std::move(*entered));
    Words settings{keys_.base(), std::string("tcp.listen=") + kAddress + ":2000",
                   std::string("http.listen=") + kAddress + ":8080"};
    settings.insert(settings.end(), kRules.begin(), kRules.end());
    base_.emplace("base", "top", 0, 1, Words{"kind=sub,system=*"}, settings);
    base_->start();
    chassis_.emplace(*base_);
  }
  void TearDown() override {
    if (HasFailure() && base_) std::cerr << "base:\n" << base_->log();
    chassis_.reset();
    tunnels_.clear();
    robots_.clear();
    base_.reset();
  }

  // The keys of a robot.
  std::string robot_keys(std::uint16_t system) {
    const std::string name = "robot" + std::to_string(system);
    return keys_.join(name, MemberRole::kSystem, system, 1);
  }
  // From this port of 127.0.0.1 to one of the base, with the keys of a folder.
  std::string tunnel(const std::string& keys, const std::string& from, const std::string& to) {
    auto child = ChildProcess::start(
        {TIMSCTL_PROGRAM, "tunnel", "127.0.0.1:" + from, std::string(kAddress) + ":" + to},
        {.environment = {"TIMS_KEYS=" + keys}, .folder = {}});
    EXPECT_TRUE(child && child->wait_for_line("leads to"));
    tunnels_.push_back(std::move(*child));
    return "127.0.0.1:" + from;
  }
  // Through TLS to the TCP port of the base.
  TcpClient client(const std::string& keys, Address mailbox) {
    auto client = TcpClient::connect(tunnel(keys, std::to_string(2100 + tunnels_.size()), "2000"));
    EXPECT_TRUE(client.ok()) << client.error().message();
    EXPECT_TRUE(client->register_mailbox(mailbox).ok());
    return std::move(*client);
  }
  // What `timsctl web` prints for whoever has these keys.
  static std::string login(const std::string& keys, const std::string& port = "2000") {
    auto child = ChildProcess::start(
        {TIMSCTL_PROGRAM, "-H", std::string("tls:") + kAddress + ":" + port, "web", "--bearer"},
        {.environment = {"TIMS_KEYS=" + keys, "NO_COLOR=1"}, .folder = {}});
    EXPECT_TRUE(child && child->wait());
    return child->standard_output() + child->standard_error();
  }
  // A page of whoever has these keys.
  WebSocketClient page(const std::string& keys) {
    const std::string said = login(keys);
    EXPECT_THAT(said, HasSubstr("Bearer"));
    const std::string port = std::to_string(2100 + tunnels_.size());
    WebSocketClient page(tunnel(keys, port, "8080"), said.substr(0, said.find('\n')) + "\r\n");
    EXPECT_TRUE(page.is_open()) << page.answer();
    EXPECT_TRUE(page.register_mailbox(kPage).ok());
    return page;
  }
  const Host& linked_robot(std::uint16_t system) {
    const std::string name = "robot" + std::to_string(system);
    // It may call itself what it likes: rules know it by its certificate.
    const Host& robot = *robots_.emplace_back(
        std::make_unique<Host>("not-" + name, "system", system, 1,
                               Words{"kind=super,to=" + base_->udp()}, Words{robot_keys(system)}));
    robots_.back()->start();
    return robot;
  }

  // How the chassis, or a router instead of it, answers.
  static int answer_to(TcpClient& client, Address from, std::int8_t type) {
    EXPECT_TRUE(client.send({.type = type, .dest = kChassis, .src = from}).ok());
    const auto answer = client.receive();
    EXPECT_TRUE(answer.ok()) << answer.error().message();
    return answer ? answer->header.type : 0;
  }
  static int answer_to(WebSocketClient& page, std::int8_t type) {
    page.send_message({.type = type, .dest = kChassis, .src = kPage});
    const auto answer = page.receive();
    EXPECT_TRUE(answer.ok()) << answer.error().message();
    return answer ? answer->header.type : 0;
  }
  static int answer_to(Mailbox& mailbox, std::int8_t type) {
    EXPECT_TRUE(mailbox.send({.dest = kChassis, .type = type}).ok());
    const auto answer = mailbox.peek_for(kPatience);
    EXPECT_TRUE(answer.ok()) << answer.error().message();
    return answer ? answer->header().type : 0;
  }
  [[nodiscard]] std::string acl_log() const { return base_->timsctl({"acl", "log", "--json"}); }

  FleetKeys keys_{{kAddress}};
  const std::string gast_ = keys_.user("gast", {.look = true, .drive = true, .configure = true});
  const std::string dora_ = keys_.user("dora", {.look = true, .drive = true});
  const std::string lena_ = keys_.user("lena", {.look = true});
  std::optional<OwnNetwork> network_;
  std::optional<Host> base_;
  std::optional<Chassis> chassis_;
  std::vector<ChildProcess> tunnels_;
  std::vector<std::unique_ptr<Host>> robots_;
};

// A stolen robot on the path to the base gets neither commands nor logins of operators.
TEST_F(LoginPolicy, ARobotDoesNotAnswerForTheBase) {
  Host robot("robot3", "system", 3, 1, {"kind=sub"},
             {robot_keys(3), std::string("tcp.listen=") + kAddress + ":2001"});
  robot.start();
  EXPECT_THAT(login(dora_, "2001"),
              HasSubstr("the router there is system 3, id 1 (robot3), and its certificate is for "
                        "no address, not for 10.79.0.1: if it is the one that you mean, write "
                        "HOST:PORT/robot3"));
  EXPECT_EQ(robot.log().find("login"), std::string::npos) << robot.log();
  EXPECT_THAT(login(dora_, "2000/robot3"),
              HasSubstr("the router there is top 0, id 1 (base), not \"robot3\""));
  EXPECT_THAT(login(dora_, "2000/base"), HasSubstr("Bearer"));
  EXPECT_THAT(login(dora_, "2001/robot3"), HasSubstr("Bearer")) << "if it is the one that is meant";
}

TEST_F(LoginPolicy, PersonsAtTheTcpPort) {
  const Address one(0x000F0100);
  const Address two(0x000F0200);
  const Address three(0x000F0300);
  TcpClient dora = client(dora_, one);
  EXPECT_EQ(answer_to(dora, one, kMove), type::kOk);
  EXPECT_EQ(answer_to(dora, one, type::kGetStatus), type::kOk);
  TcpClient lena = client(lena_, two);
  EXPECT_EQ(answer_to(lena, two, kMove), type::kNotAvailable);
  EXPECT_EQ(answer_to(lena, two, type::kGetStatus), type::kOk);
  // His certificate has all rights, his name has not.
  TcpClient gast = client(gast_, three);
  EXPECT_EQ(answer_to(gast, three, kMove), type::kNotAvailable);
  EXPECT_EQ(answer_to(gast, three, type::kGetStatus), type::kNotAvailable);
  EXPECT_THAT(acl_log(), testing::AllOf(HasSubstr("gast keeps off"), HasSubstr("user:gast")));
}

TEST_F(LoginPolicy, PersonsInTheirBrowsers) {
  {
    WebSocketClient dora = page(dora_);
    EXPECT_EQ(answer_to(dora, kMove), type::kOk);
  }
  {
    WebSocketClient lena = page(lena_);
    EXPECT_EQ(answer_to(lena, kMove), type::kNotAvailable);
    EXPECT_EQ(answer_to(lena, type::kGetStatus), type::kOk);
  }
  EXPECT_THAT(login(gast_), HasSubstr("gast stays outside"));
}

// A robot's certificate also opens the TCP port, and rules that name the robot hold there.
TEST_F(LoginPolicy, RoutersAtTheTcpPort) {
  const std::size_t key = std::string("security.keys=").size();
  const Address one(0x000F0100);
  const Address two(0x000F0200);
  TcpClient third = client(robot_keys(3).substr(key), one);
  EXPECT_EQ(answer_to(third, one, type::kGetStatus), type::kOk);
  EXPECT_EQ(answer_to(third, one, kMove), type::kNotAvailable);
  TcpClient fourth = client(robot_keys(4).substr(key), two);
  EXPECT_EQ(answer_to(fourth, two, type::kGetStatus), type::kNotAvailable);
  EXPECT_THAT(acl_log(), testing::AllOf(HasSubstr("robot4 is blind"), HasSubstr("router:robot4")));
}

TEST_F(LoginPolicy, RoutersOverTheirLinks) {
  for (const std::uint16_t system : {std::uint16_t{3}, std::uint16_t{4}}) {
    Session session = linked_robot(system).session("pilot");
    auto pilot =
        session.open({.address = Address(std::uint32_t{system} << 24U | 0x00180000U), .slots = 64});
    ASSERT_TRUE(pilot.ok()) << pilot.error().message();
    EXPECT_TRUE(eventually([&] { return base_->knows(pilot->address()); }, "they are linked"));
    EXPECT_EQ(answer_to(*pilot, kMove), type::kNotAvailable);
    EXPECT_EQ(answer_to(*pilot, type::kGetStatus), system == 3 ? type::kOk : type::kNotAvailable);
  }
  EXPECT_THAT(acl_log(), testing::AllOf(HasSubstr("robots do not drive"), HasSubstr("robot3")));
}

}  // namespace login_policy_test
}  // namespace tims::test
