// Links with keys between real routers: TLS, its thread, the certificates on the disk.
#include <boost/json/parse.hpp>
#include <gmock/gmock.h>

#include "os/clock.h"
#include "tests/support/eventually.h"
#include "tests/support/fleet_keys.h"
#include "tests/support/router_process.h"
#include "tests/system/host.h"

namespace tims::test {
namespace sealed_links_test {

namespace json = boost::json;
using security::MemberRole;
using testing::HasSubstr;

constexpr Address kServer(0x03140000);  // Ladar(3/0)

json::value link_of(Host& host) {
  const json::value links = json::parse(host.timsctl({"link", "show", "--json"}));
  const auto& items = links.at("items").as_array();
  return items.empty() ? json::value() : items.front();
}

class SealedLinksTest : public testing::Test {
 protected:
  SealedLinksTest() : robot_keys(keys.join("robot3", MemberRole::kSystem, 3, 1)) {}

  void start(const std::vector<std::string>& of_base, const std::vector<std::string>& of_robot,
             const std::string& link = "") {
    base.emplace("base", "top", 0, 1, std::vector<std::string>{"kind=sub,system=*" + link},
                 of_base);
    base->start();
    robot.emplace("robot3", "system", 3, 1,
                  std::vector<std::string>{"kind=super,to=" + base->udp() + link}, of_robot);
    robot->start();
    session.emplace(robot->session("server"));
    auto opened = session->open({.address = kServer, .body_max = 1U << 20});
    ASSERT_TRUE(opened.ok()) << opened.error().message();
    server.emplace(std::move(*opened));
  }
  static std::size_t ups(Host& host) {
    const json::value links = json::parse(host.timsctl({"link", "show", "--json"}));
    return static_cast<std::size_t>(std::ranges::count_if(
        links.at("items").as_array(),
        [](const json::value& link) { return link.at("state").as_string() == "up"; }));
  }
  void expect_link() {
    EXPECT_TRUE(eventually([&] { return base->knows(kServer); }, "the base knows the server"));
  }

  FleetKeys keys;
  const std::string robot_keys;
  std::optional<Host> base;
  std::optional<Host> robot;
  std::optional<Session> session;
  std::optional<Mailbox> server;
};

TEST_F(SealedLinksTest, RoutersWithKeysAreLinkedAndSealed) {
  start({keys.base()}, {robot_keys});
  expect_link();
  for (Host* host : {&*base, &*robot}) {
    const json::value link = link_of(*host);
    EXPECT_EQ(link.at("secure"), json::value(true)) << link;
    EXPECT_THAT(std::string(link.at("suite").as_string()),
                testing::AnyOf("AES-128-GCM", "ChaCha20-Poly1305"));
    EXPECT_EQ(link.at("packets_forged").to_number<int>(), 0) << link;
  }
  EXPECT_EQ(link_of(*base).at("certificate").as_string(), "robot3");
}

TEST_F(SealedLinksTest, TheyLinkAgainWhenOneHasRestarted) {
  start({keys.base()}, {robot_keys});
  expect_link();
  base->kill();
  base->start();
  expect_link();
  EXPECT_EQ(link_of(*base).at("secure"), json::value(true));
}

TEST_F(SealedLinksTest, ARouterWithoutKeysIsRefusedAndBothSidesSayWhy) {
  start({keys.base()}, {});
  EXPECT_TRUE(base->process().wait_for_line("links only with routers that have keys").ok());
  EXPECT_TRUE(robot->process().wait_for_line("links only with routers that have keys").ok());
  EXPECT_FALSE(base->knows(kServer));
  EXPECT_THAT(std::string(link_of(*robot).at("refusal").as_string()), HasSubstr("timsctl join"));
}

TEST_F(SealedLinksTest, ABaseWithoutKeysIsRefusedAndBothSidesSayWhy) {
  start({}, {robot_keys});
  EXPECT_TRUE(base->process().wait_for_line("this router has no keys").ok());
  EXPECT_TRUE(robot->process().wait_for_line("this router has no keys").ok());
  EXPECT_FALSE(base->knows(kServer));
}

TEST_F(SealedLinksTest, AnotherFleetIsRefusedAndBothSidesSayWhy) {
  FleetKeys other;
  start({keys.base()}, {other.join("robot3", MemberRole::kSystem, 3, 1)});
  EXPECT_TRUE(base->process().wait_for_line(" refused: ").ok());
  EXPECT_TRUE(robot->process().wait_for_line(" refused: ").ok());
  EXPECT_FALSE(base->knows(kServer));
}

// The list of a revoked one arrives at the base, which ends the link within a second.
TEST_F(SealedLinksTest, ARevokedRouterIsCutOff) {
  start({keys.base()}, {robot_keys});
  expect_link();
  keys.revoke("robot3");
  EXPECT_TRUE(eventually([&] { return !base->knows(kServer); }, "the base has cut it off"));
  EXPECT_TRUE(base->process().wait_for_line("its certificate is revoked").ok()) << base->log();
  EXPECT_TRUE(robot->process().wait_for_line("revoked").ok());
}

// base - robot3 - robot5 - robot6: the list goes from router to router, and lies on each disk.
TEST_F(SealedLinksTest, ARevocationReachesARobotTwoHopsAway) {
  start({keys.base()}, {robot_keys, "link=kind=peer,system=5"});
  const std::string keys5 = keys.join("robot5", MemberRole::kSystem, 5, 1);
  Host robot6("robot6", "system", 6, 1, {"kind=peer,system=5"},
              {keys.join("robot6", MemberRole::kSystem, 6, 1)});
  robot6.start();
  Host robot5("robot5", "system", 5, 1,
              {"kind=peer,to=" + robot->udp(), "kind=peer,to=" + robot6.udp()}, {keys5});
  robot5.start();
  expect_link();
  ASSERT_TRUE(eventually([&] { return ups(robot5) == 2; }, "robot5 is linked with both"));
  keys.revoke("robot6");
  EXPECT_TRUE(robot5.process().wait_for_line("its certificate is revoked").ok()) << robot5.log();
  EXPECT_EQ(ups(robot5), 1U) << "robot3 stays";
  EXPECT_EQ(keys.list_number("robot5"), 2U);
  // Who was away learns it from its neighbour.
  robot5.kill();
  (void)keys.join("robot7", MemberRole::kSystem, 7, 1);
  keys.revoke("robot7");
  ASSERT_TRUE(eventually([&] { return keys.list_number("robot3") == 3; }, "robot3 has the list"));
  robot5.start();
  EXPECT_TRUE(eventually([&] { return keys.list_number("robot5") == 3; }, "robot5 has the list"));
}

TEST_F(SealedLinksTest, AListThatCannotBeStoredCountsAllTheSame) {
  start({keys.base()}, {robot_keys});
  expect_link();
  (void)keys.join("robot7", MemberRole::kSystem, 7, 1);
  keys.make_unwritable("robot3");
  keys.revoke("robot7");
  EXPECT_TRUE(robot->process().wait_for_line("only until this router ends").ok()) << robot->log();
  EXPECT_TRUE(robot->process().wait_for_line("list 2 with 1 revoked").ok());
  expect_link();
}

// The root is replaced while a robot is away, and another one is renewed only later.
TEST_F(SealedLinksTest, AFleetThatIsHalfOnOldKeysStaysTogether) {
  start({keys.base()}, {robot_keys});
  expect_link();
  Host away("robot5", "system", 5, 1, {"kind=super,to=" + base->udp()},
            {keys.join("robot5", MemberRole::kSystem, 5, 1)});
  keys.rotate();
  ASSERT_TRUE(eventually([&] { return keys.list_number("robot3") == 2; }, "robot3 knows the root"));
  away.start();
  ASSERT_TRUE(eventually([&] { return keys.list_number("robot5") == 2; }, "robot5 knows it, too"));
  (void)keys.join("robot3", MemberRole::kSystem, 3, 1);
  for (Host* host : {&*robot, &*base}) {
    host->kill();
    host->start();
  }
  ASSERT_TRUE(eventually([&] { return ups(*base) == 2; }, "one with old keys, one with new ones"));
  (void)keys.join("robot5", MemberRole::kSystem, 5, 1);
  keys.finish_rotation();
  ASSERT_TRUE(eventually([&] { return keys.list_number("robot5") == 3; }, "the old root has gone"));
  base->kill();
  base->start();
  EXPECT_TRUE(eventually([&] { return ups(*base) == 2; }, "all with new keys"));
}

// All have renewed while their links were up, and the base renews when it completes the rotation.
TEST_F(SealedLinksTest, AFinishedRotationCutsNobodyWhoHasRenewed) {
  start({keys.base()}, {robot_keys});
  expect_link();
  keys.rotate();
  ASSERT_TRUE(eventually([&] { return keys.list_number("robot3") == 2; }, "robot3 knows the root"));
  // When they last shook hands, in seconds of this program's clock.
  const auto handshake = [&] {
    const double now = std::chrono::duration<double>(os::now().time_since_epoch()).count();
    return now - link_of(*robot).at("keys_since_s").to_number<double>();
  };
  const auto again_after = [&](double former) {
    return eventually([&] { return handshake() > former + 0.05; }, "they shake hands again");
  };
  const double joined = handshake();
  (void)keys.join("robot3", MemberRole::kSystem, 3, 1);
  ASSERT_TRUE(again_after(joined));
  const double former = handshake();
  keys.finish_rotation();
  ASSERT_TRUE(eventually([&] { return keys.list_number("robot3") == 3; }, "the old root has gone"));
  EXPECT_TRUE(again_after(former)) << "the base shows its new certificate";
  EXPECT_THAT(robot->log(), testing::Not(HasSubstr("is down"))) << robot->log();
  EXPECT_THAT(base->log(), testing::Not(HasSubstr("is down"))) << base->log();
}

// Whoever has stolen the authority's keys loses its links with the old root.
TEST_F(SealedLinksTest, TheEndOfARootEndsLinksWithItsCertificates) {
  start({keys.base()}, {robot_keys});
  expect_link();
  keys.rotate();
  ASSERT_TRUE(eventually([&] { return keys.list_number("robot3") == 2; }, "robot3 knows the root"));
  keys.finish_rotation(true);
  EXPECT_TRUE(base->process().wait_for_line("from a root that the fleet believes no longer").ok())
      << base->log();
  EXPECT_FALSE(base->knows(kServer));
}

TEST_F(SealedLinksTest, ALinkWithoutKeysMustBeWantedByBothSides) {
  start({keys.base()}, {robot_keys}, ",secure=false");
  expect_link();
  EXPECT_EQ(link_of(*base).at("secure"), json::value(false));
}

TEST_F(SealedLinksTest, ACertificateForAnotherRouterDoesNotStart) {
  RouterProcess wrong({"router.role=system", "router.system=4", "router.id=1", robot_keys});
  const auto started = wrong.start();
  EXPECT_FALSE(started.ok());
  EXPECT_THAT(started.error().message(), HasSubstr("is that of system 3"));
}

}  // namespace sealed_links_test
}  // namespace tims::test
