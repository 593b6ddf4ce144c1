// What a router knows of streams and of who drives, with real programs and browsers: newest values
// whose source has gone, and driving leases.
#include <algorithm>
#include <array>
#include <bit>
#include <optional>
#include <string>

#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <gtest/gtest.h>

#include "rack/proxies/chassis.h"
#include "rack/proxies/path.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/vehicle.h"
#include "router/core/driving_leases.h"
#include "tests/system/websocket_fixture.h"
#include "tims/session.h"

namespace tims::test {
namespace streams_and_leases_test {

namespace json = boost::json;

constexpr Address kChassis{0x03110000};
constexpr Address kPosition{0x03130000};
constexpr Address kOtherPage{0x00020001};
constexpr Address kTool{0x000F0000};
constexpr std::int8_t kMove = rack::ChassisType::kMove;

class StreamsAndLeasesTest : public WebSocketTest {
 protected:
  void SetUp() override {
    start();
    robot_ = local("robot");
  }
  std::optional<Session> local(const std::string& name) {
    auto session = Session::connect({.name = name,
                                     .router = router_->socket_path(),
                                     .timeout = kPatience,
                                     .on_event = [](const SessionEvent&) {}});
    EXPECT_TRUE(session.ok()) << session.error().message();
    return session ? std::optional(std::move(*session)) : std::nullopt;
  }
  std::optional<Mailbox> open(Address address) {
    auto mailbox = robot_->open({.address = address, .slots = 16});
    EXPECT_TRUE(mailbox.ok()) << mailbox.error().message();
    return mailbox ? std::optional(std::move(*mailbox)) : std::nullopt;
  }
  static json::object ask(WebSocketClient& page, const std::string& question) {
    page.send_message({.type = type::kAdminRequest, .seq_nr = 7}, question);
    for (;;) {
      const auto answer = page.receive();
      EXPECT_TRUE(answer.ok()) << answer.error().message();
      if (!answer) return {};
      if (answer->header.type == type::kAdminReply)
        return json::parse(text_of(answer->body)).as_object();
    }
  }
  static std::string error_of(const json::object& answer) {
    return answer.contains("error") ? std::string(answer.at("error").at("code").as_string()) : "";
  }
  // The answer to a command to drive. The chassis, if the command reaches it, accepts it.
  template <typename Client>
  std::int8_t answer_to_move(Client& client, Address from, Mailbox& chassis, bool reaches) {
    const std::array<std::int32_t, 3> speed{100, 0, 0};
    const Header header{.type = kMove, .seq_nr = 3, .dest = kChassis, .src = from};
    send(client, header, std::as_bytes(std::span(speed)));
    if (reaches) {
      const auto request = chassis.peek_for(kPatience);
      EXPECT_TRUE(request.ok()) << request.error().message();
      if (request) {
        EXPECT_TRUE(chassis.reply(request->header(), type::kOk).ok());
      }
    }
    const auto answer = client.receive();
    EXPECT_TRUE(answer.ok()) << answer.error().message();
    EXPECT_FALSE(chassis.try_peek().ok());
    return answer ? answer->header.type : std::int8_t{99};
  }
  template <typename Client>
  bool drives(Client& client, Address from, Mailbox& chassis) {
    return answer_to_move(client, from, chassis, true) == type::kOk;
  }
  template <typename Client>
  bool is_refused(Client& client, Address from, Mailbox& chassis) {
    return answer_to_move(client, from, chassis, false) == type::kError;
  }
  static void send(TcpClient& client, const Header& header, std::span<const std::byte> body) {
    EXPECT_TRUE(client.send(header, body).ok());
  }
  static void send(WebSocketClient& client, const Header& header, std::span<const std::byte> body) {
    EXPECT_TRUE(client.send_message(header, text_of(body)));
  }

  std::optional<Session> robot_;
};

TEST_F(StreamsAndLeasesTest, WhoComesLateGetsTheLastSampleOfAComponentThatHasGone) {
  WebSocketClient early = page(kPage);
  auto position = open(kPosition);
  for (const char* where : {"here", "there"}) {
    const std::string text(where);
    ASSERT_TRUE(position->send({.dest = kPage, .type = type::kData, .stream = true},
                               std::as_bytes(std::span(text))));
    ASSERT_TRUE(early.receive().ok());
  }
  position.reset();
  robot_.reset();
  early.socket().close();
  WebSocketClient late = page();
  const auto value = ask(late, R"x({"ask":"newest","of":"Position(3/0)"})x");
  EXPECT_EQ(value.at("body").as_string(), "7468657265");
  EXPECT_EQ(value.at("samples"), 2);
  EXPECT_GE(value.at("age_s").as_double(), 0);
  const auto list = ask(late, R"({"ask":"newest"})");
  EXPECT_EQ(list.at("values"), 1);
  EXPECT_EQ(list.at("replaced"), 1);
}

TEST_F(StreamsAndLeasesTest, OneDrivesARobotUntilItsSocketEnds) {
  auto chassis = open(kChassis);
  WebSocketClient holder = page(kPage);
  WebSocketClient other = page(kOtherPage);
  TcpClient tool = tcp(kTool);
  EXPECT_TRUE(drives(tool, kTool, *chassis)) << "nobody drives";
  const auto taken = ask(holder, R"({"ask":"lease","robot":3,"do":"take","name":"tablet 2"})");
  EXPECT_TRUE(taken.contains("done")) << json::serialize(taken);
  EXPECT_TRUE(drives(holder, kPage, *chassis));
  EXPECT_TRUE(is_refused(tool, kTool, *chassis));
  EXPECT_TRUE(is_refused(other, kOtherPage, *chassis));
  EXPECT_EQ(error_of(ask(other, R"({"ask":"lease","robot":3,"do":"take","name":"desk"})")),
            "lease_taken");
  EXPECT_EQ(ask(other, R"({"ask":"leases"})").at("items").at(0).at("holder").as_string(),
            "tablet 2");
  EXPECT_EQ(
      metric(R"(tims_router_messages_total{port="tcp",class="1",outcome="no_lease"})") +
          metric(R"(tims_router_messages_total{port="websocket",class="1",outcome="no_lease"})"),
      2U);
  holder.socket().close();
  EXPECT_TRUE(
      eventually([&] { return ask(other, R"({"ask":"leases"})").at("items").as_array().empty(); },
                 "the lease ends with the socket"));
  EXPECT_TRUE(drives(tool, kTool, *chassis));
}

TEST_F(StreamsAndLeasesTest, ALeaseIsTakenOverExplicitly) {
  auto chassis = open(kChassis);
  WebSocketClient first = page(kPage);
  WebSocketClient second = page(kOtherPage);
  ask(first, R"({"ask":"lease","robot":3,"do":"take","name":"tablet 2"})");
  ask(second, R"({"ask":"lease","robot":3,"do":"take_over","name":"desk 1"})");
  EXPECT_TRUE(is_refused(first, kPage, *chassis));
  EXPECT_TRUE(drives(second, kOtherPage, *chassis));
  const auto renewed = ask(first, R"({"ask":"lease","robot":3,"do":"renew"})");
  EXPECT_EQ(error_of(renewed), "lease_not_held");
  EXPECT_EQ(renewed.at("error").at("message").as_string(), "desk 1 drives robot 3");
}

// The router knows the numbers of these commands without linking the proxies.
TEST(DrivingCommands, AreThoseOfTheProxies) {
  const auto drives = [](std::uint32_t class_id, int type) {
    std::array<std::byte, kHeaderSize + 12> bytes{};
    bytes.fill(std::byte{1});
    const core::Message message{
        .header = {.type = static_cast<std::int8_t>(type),
                   .dest = Address::of({.system = 3, .class_id = class_id})},
        .bytes = bytes};
    return core::driven_robot(message, {}).has_value();
  };
  EXPECT_TRUE(drives(class_id::kChassis, rack::ChassisType::kMove));
  EXPECT_TRUE(drives(class_id::kChassis, rack::ChassisType::kSetActivePilot));
  EXPECT_FALSE(drives(class_id::kChassis, rack::ChassisType::kGetParameter));
  EXPECT_TRUE(drives(class_id::kPilot, rack::PilotType::kSetDestination));
  EXPECT_TRUE(drives(class_id::kPilot, rack::PilotType::kSetMultiDestination));
  EXPECT_FALSE(drives(class_id::kPilot, rack::PilotType::kHoldCommand));
  EXPECT_TRUE(drives(class_id::kPath, rack::PathType::kMake));
  EXPECT_TRUE(drives(class_id::kPath, rack::PathType::kSetDestination));
  EXPECT_TRUE(drives(class_id::kPath, rack::PathType::kSetRddf));
  EXPECT_FALSE(drives(class_id::kPath, rack::PathType::kGetLayer));
  EXPECT_TRUE(drives(class_id::kVehicle, rack::VehicleType::kSetValue));
  std::array<std::byte, kHeaderSize + 4> none{};
  const auto no_pilot = std::bit_cast<std::array<std::byte, 4>>(rack::kNoPilot.raw());
  std::ranges::copy(no_pilot, none.begin() + kHeaderSize);
  EXPECT_FALSE(core::driven_robot(
      {.header = {.type = rack::ChassisType::kSetActivePilot, .dest = kChassis}, .bytes = none},
      {}))
      << "it stops";
}

}  // namespace streams_and_leases_test
}  // namespace tims::test
