// A base and a robot with keys on two hosts, between which a firewall may drop all UDP: the link
// goes over TCP then, sealed like before.
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <gmock/gmock.h>

#include "tests/support/eventually.h"
#include "tests/support/two_networks.h"
#include "tests/system/fleet_keys.h"
#include "tests/system/host.h"
#include "tests/system/traffic.h"

namespace tims::test {
namespace tcp_paths_test {

namespace json = boost::json;
using security::MemberRole;
using testing::HasSubstr;

class TcpPaths : public testing::Test {
 protected:
  void SetUp() override {
    auto made = TwoNetworks::enter();
    if (!made) GTEST_SKIP() << made.error().message();
    networks_.emplace(std::move(*made));
  }
  void TearDown() override {
    if (HasFailure() && robot_)
      std::cerr << "base:\n" << base_->log() << "robot:\n" << robot_->log();
    // The programs must exit before their networks are removed.
    robot_.reset();
    base_.reset();
  }
  void start(const std::string& paths_of_base = "udp+tcp",
             const std::string& paths_of_robot = "udp+tcp") {
    base_ = std::make_unique<Host>(
        "base", "top", 0, 1, std::vector<std::string>{"kind=sub,system=*,paths=" + paths_of_base},
        std::vector<std::string>{keys_.base()});
    base_->listen_at("0.0.0.0:2010");
    base_->start();
    robot_ = std::make_unique<Host>(
        "robot", "system", 1, 1,
        std::vector<std::string>{std::string("kind=super,to=") + TwoNetworks::kLeft +
                                 ":2010,paths=" + paths_of_robot},
        std::vector<std::string>{keys_.join("robot", MemberRole::kSystem, 1, 1)});
    robot_->listen_at("0.0.0.0:2010");
    networks_->on_the_right([this] { robot_->start(); });
  }
  // All UDP on the left host, or what comes to a port by TCP.
  static void drop(const std::string& what) {
    const auto done = TwoNetworks::run(
        "nft add table inet cut\n"
        "nft add chain inet cut input '{ type filter hook input priority 0; }'\n"
        "nft add chain inet cut output '{ type filter hook output priority 0; }'\n"
        "nft add rule inet cut input " +
        what + " drop\nnft add rule inet cut output " + what + " drop\n");
    ASSERT_TRUE(done.ok()) << done.error().message();
  }
  static void drop_udp() { drop("meta l4proto udp"); }
  static void drop_tcp() { drop("meta l4proto tcp"); }
  static void heal() {
    const auto done = TwoNetworks::run("nft flush ruleset");
    ASSERT_TRUE(done.ok()) << done.error().message();
  }

  static json::value link_of(const Host& host) {
    boost::system::error_code error;
    const json::value answer = json::parse(host.timsctl({"link", "show", "--json"}), error);
    if (error || answer.as_object().if_contains("items") == nullptr) return nullptr;
    const auto& items = answer.at("items").as_array();
    return items.empty() ? json::value() : items.front();
  }
  static testing::AssertionResult goes_by(const Host& host, const std::string& path) {
    return eventually([&]() -> std::string {
      const json::value link = link_of(host);
      const bool good = link.is_object() && link.at("state") == "up" &&
                        link.at("path").as_string() == path && link.at("secure").as_bool();
      return good ? "" : json::serialize(link);
    });
  }
  static testing::AssertionResult both_work(const Host& host) {
    return eventually(
        [&] {
          const json::value link = link_of(host);
          if (!link.is_object()) return false;
          for (const auto& path : link.at("paths").as_array())
            if (!path.at("works").as_bool()) return false;
          return true;
        },
        "both paths work");
  }
  void expect_both_go_by(const std::string& path) const {
    EXPECT_TRUE(goes_by(*base_, path));
    EXPECT_TRUE(goes_by(*robot_, path));
  }

  FleetKeys keys_;
  std::optional<TwoNetworks> networks_;
  std::unique_ptr<Host> base_;
  std::unique_ptr<Host> robot_;
};

TEST_F(TcpPaths, UdpFailsAndRecovers) {
  start();
  expect_both_go_by("udp");
  EXPECT_TRUE(both_work(*base_));
  EXPECT_TRUE(both_work(*robot_));
  Traffic traffic(*base_, *robot_);
  EXPECT_TRUE(traffic.goes_on());
  drop_udp();
  expect_both_go_by("tcp");
  EXPECT_TRUE(traffic.goes_on());
  EXPECT_THAT(base_->log(), HasSubstr("changed from udp to tcp: udp has not answered for"));
  heal();
  expect_both_go_by("udp");
  EXPECT_TRUE(traffic.goes_on());
  traffic.expect_all();
  EXPECT_THAT(base_->log(), testing::Not(HasSubstr("is down")));
}

TEST_F(TcpPaths, WithoutUdpFromTheBeginning) {
  drop_udp();
  start();
  expect_both_go_by("tcp");
  Traffic traffic(*base_, *robot_);
  EXPECT_TRUE(traffic.goes_on());
  traffic.expect_all();
}

TEST_F(TcpPaths, TcpAlone) {
  start("tcp", "tcp");
  expect_both_go_by("tcp");
  Traffic traffic(*base_, *robot_);
  EXPECT_TRUE(traffic.goes_on());
  traffic.expect_all();
}

// A cut of all that is longer than TCP's patience, then a restart of the base.
TEST_F(TcpPaths, ConnectionsAreMadeAgain) {
  drop_udp();
  start();
  expect_both_go_by("tcp");
  drop_tcp();
  EXPECT_TRUE(eventually([&] { return base_->log().find("is down") != std::string::npos; },
                         "the link is down"));
  heal();
  drop_udp();
  expect_both_go_by("tcp");
  base_->kill();
  base_->start();
  expect_both_go_by("tcp");
  EXPECT_TRUE(
      eventually([&] { return base_->log().find("links over tcp at") != std::string::npos; },
                 "the base listens again"));
}

// The other path is prepared again while UDP carries the link.
TEST_F(TcpPaths, TcpFailsAndRecoversUnnoticed) {
  start();
  expect_both_go_by("udp");
  EXPECT_TRUE(both_work(*robot_));
  Traffic traffic(*base_, *robot_);
  drop_tcp();
  EXPECT_TRUE(traffic.goes_on());
  heal();
  EXPECT_TRUE(both_work(*base_));
  EXPECT_TRUE(both_work(*robot_));
  traffic.expect_all();
  EXPECT_THAT(base_->log(), testing::Not(HasSubstr("is down")));
}

TEST_F(TcpPaths, ABaseThatDoesNotOfferItIsNotReachedByIt) {
  start("udp", "udp+tcp");
  expect_both_go_by("udp");
  EXPECT_FALSE(TwoNetworks::run("ss -ltn | grep :2010").ok());
}

}  // namespace tcp_paths_test
}  // namespace tims::test
