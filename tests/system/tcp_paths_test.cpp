// A base and a robot with keys on two hosts, between which a firewall may drop all UDP: the link
// goes over TCP then, sealed like before.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/fleet_keys.h"
#include "tests/system/traffic.h"
#include "tests/system/two_hosts_fixture.h"

namespace tims::test {
namespace tcp_paths_test {

using security::MemberRole;
using testing::HasSubstr;

class TcpPaths : public TwoHosts {
 protected:
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
  static void drop_udp() { drop({"meta l4proto udp"}); }
  static void drop_tcp() { drop({"meta l4proto tcp"}); }
  void expect_both_go_by(const std::string& path) const {
    for (const auto& [host, peer] :
         {std::pair(base_.get(), "robot"), std::pair(robot_.get(), "base")}) {
      EXPECT_TRUE(goes_by(*host, peer, path));
      EXPECT_TRUE(link_of(*host, peer).at("secure").as_bool());
    }
  }

  FleetKeys keys_;
};

TEST_F(TcpPaths, UdpFailsAndRecovers) {
  start();
  expect_both_go_by("udp");
  EXPECT_TRUE(all_paths_work(*base_, "robot"));
  EXPECT_TRUE(all_paths_work(*robot_, "base"));
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
  EXPECT_TRUE(all_paths_work(*robot_, "base"));
  Traffic traffic(*base_, *robot_);
  drop_tcp();
  EXPECT_TRUE(traffic.goes_on());
  heal();
  EXPECT_TRUE(all_paths_work(*base_, "robot"));
  EXPECT_TRUE(all_paths_work(*robot_, "base"));
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
