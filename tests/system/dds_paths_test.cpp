// A base and a robot on two hosts, connected by UDP and DDS: either path or both are cut.
#include <csignal>
#include <fstream>

#include "router/link/datagram.h"
#include "tests/support/fleet_keys.h"
#include "tests/system/dds_fixture.h"
#include "tests/system/rtps_storm.h"
#include "tests/system/traffic.h"

namespace tims::test {
namespace dds_paths_test {

using testing::HasSubstr;
using namespace std::chrono_literals;

class DdsPaths : public TwoHosts {
 protected:
  void start(const std::string& paths = "udp+dds") {
    base_ = fleet_host("base", "top", 0, 1, paths);
    base_->start();
    robot_ = fleet_host("robot", "system", 1, 1, paths);
    networks_->on_the_right([this] { robot_->start(); });
  }
  static void cut_udp(bool in = true, bool out = true) {
    drop({"udp dport 2010", "udp sport 2010"}, in, out);
  }
  static void cut_dds() { drop({"udp dport != 2010 udp sport != 2010"}); }
};

TEST_F(DdsPaths, UdpFailsAndRecovers) {
  start();
  EXPECT_TRUE(goes_by(*base_, "robot", "udp"));
  EXPECT_TRUE(goes_by(*robot_, "base", "udp"));
  EXPECT_TRUE(all_paths_work(*base_, "robot"));
  EXPECT_TRUE(all_paths_work(*robot_, "base"));
  Traffic traffic(*base_, *robot_);
  EXPECT_TRUE(traffic.goes_on());
  cut_udp();
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  EXPECT_TRUE(goes_by(*robot_, "base", "dds"));
  EXPECT_TRUE(traffic.goes_on());
  EXPECT_THAT(base_->log(), HasSubstr("changed from udp to dds: udp has not answered for"));
  heal();
  EXPECT_TRUE(goes_by(*base_, "robot", "udp"));
  EXPECT_TRUE(goes_by(*robot_, "base", "udp"));
  EXPECT_TRUE(traffic.goes_on());
  traffic.expect_all();
  EXPECT_THAT(base_->log(), testing::Not(HasSubstr("is down")));
}

// The process in which a router runs DDS; 0: none.
pid_t helper_of(Host& host) {
  const std::string pid = std::to_string(host.process().pid());
  std::ifstream children("/proc/" + pid + "/task/" + pid + "/children");
  pid_t helper = 0;
  children >> helper;
  return helper;
}

// A fault in the library ends the process that runs it, and nothing else.
TEST_F(DdsPaths, TheProcessOfDdsIsKilled) {
  start("dds+udp");
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  EXPECT_TRUE(goes_by(*robot_, "base", "dds"));
  EXPECT_TRUE(all_paths_work(*base_, "robot"));
  EXPECT_TRUE(all_paths_work(*robot_, "base"));
  Traffic traffic(*base_, *robot_);
  EXPECT_TRUE(traffic.goes_on());
  for (Host* host : {base_.get(), robot_.get()}) {
    const pid_t helper = helper_of(*host);
    ASSERT_GT(helper, 0);
    ASSERT_EQ(::kill(helper, SIGKILL), 0);
    EXPECT_TRUE(eventually([&] { return helper_of(*host) > 0 && helper_of(*host) != helper; },
                           "it is started again"));
    EXPECT_TRUE(traffic.goes_on());
    EXPECT_THAT(host->log(), HasSubstr("has ended (killed by signal 9)"));
  }
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  EXPECT_TRUE(goes_by(*robot_, "base", "dds"));
  EXPECT_TRUE(traffic.goes_on());
  traffic.expect_all();
  EXPECT_THAT(base_->log(), testing::Not(HasSubstr("is down")));
}

// The user data of a router of this fleet that does not exist.
std::vector<std::byte> of_a_ghost() {
  return link::encode(
      link::Announcement{.fleet = std::string_view("test" + std::to_string(::getpid())),
                         .identity = {.epoch = 99,
                                      .role = core::Role::kTop,
                                      .id = 9,
                                      .name = std::string_view("ghost"),
                                      .message_max = 1U << 20},
                         .udp = {link::NetAddress::v4(10, 78, 0, 9, 2010)}});
}

// The number of a router in DDS, as another one knows it: 24 hexadecimal digits.
std::string dds_number_of(const Host& host, const std::string& name) {
  const auto routers = boost::json::parse(host.timsctl({"fleet", "show", "--json"}));
  for (const auto& router : routers.at("items").as_array())
    if (router.at("name").as_string() == name)
      return std::string(router.at("dds").as_string()).substr(std::string("dds:").size());
  ADD_FAILURE() << name << " is not announced";
  return {};
}

// Whatever the library makes of it, also if its process ends: the link, which DDS carries, goes on,
// by whichever path.
TEST_F(DdsPaths, AStormOfForgedDatagramsEndsNothing) {
  start("dds+udp");
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  EXPECT_TRUE(goes_by(*robot_, "base", "dds"));
  EXPECT_TRUE(all_paths_work(*base_, "robot"));
  EXPECT_TRUE(all_paths_work(*robot_, "base"));
  RtpsStorm to_base(of_a_ghost(), dds_number_of(*base_, "robot"));
  RtpsStorm to_robot(of_a_ghost(), dds_number_of(*robot_, "base"));
  EXPECT_TRUE(eventually(
      [&] {
        to_base.announce(TwoNetworks::kLeft);
        return base_->timsctl({"fleet", "show"}).find("ghost") != std::string::npos;
      },
      "a forged announcement gets past the filter"));
  Traffic traffic(*base_, *robot_);
  EXPECT_TRUE(traffic.goes_on());
  for (int round = 0; round < 5; ++round) {
    to_base.send(TwoNetworks::kLeft, 200);
    to_robot.send(TwoNetworks::kRight, 200);
    EXPECT_TRUE(traffic.goes_on());
  }
  traffic.expect_all();
  EXPECT_THAT(base_->log(), testing::Not(HasSubstr("is down")));
}

// With keys, DDS leaves the host where that is wished, and its links are sealed as over UDP.
TEST_F(DdsPaths, ALinkWithKeysIsSealedOverDdsToo) {
  FleetKeys keys;
  const auto host = [](const std::string& name, const std::string& role, int system,
                       const std::string& link, const std::string& its_keys) {
    auto made = std::make_unique<Host>(
        name, role, system, 1, std::vector{link + ",paths=dds"},
        std::vector<std::string>{"fleet.name=test" + std::to_string(::getpid()),
                                 "dds.beyond_host=true", its_keys});
    made->listen_at("0.0.0.0:2010");
    return made;
  };
  base_ = host("base", "top", 0, "kind=sub", keys.base());
  base_->start();
  robot_ = host("robot", "system", 1, "kind=super,to=auto",
                keys.join("robot", security::MemberRole::kSystem, 1, 1));
  networks_->on_the_right([this] { robot_->start(); });
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  EXPECT_TRUE(goes_by(*robot_, "base", "dds"));
  for (const auto& link : {link_of(*base_, "robot"), link_of(*robot_, "base")}) {
    ASSERT_FALSE(link.is_null());
    EXPECT_TRUE(link.at("secure").as_bool()) << link;
  }
  Traffic traffic(*base_, *robot_);
  EXPECT_TRUE(traffic.goes_on());
  traffic.expect_all();
  EXPECT_THAT(base_->timsctl({"doctor"}), HasSubstr("DDS is open to the network"));
}

// What a fault in the library could reach.
TEST_F(DdsPaths, TheProcessOfDdsHasNoRights) {
  start("dds");
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  const std::string folder = "/proc/" + std::to_string(helper_of(*base_));
  std::ifstream status(folder + "/status");
  const std::string text{std::istreambuf_iterator<char>(status), {}};
  EXPECT_THAT(text, HasSubstr("NoNewPrivs:\t1"));
  EXPECT_THAT(text, HasSubstr("Seccomp:\t2"));
  EXPECT_THAT(base_->log(), testing::Not(HasSubstr("keeps rights")));
}

TEST_F(DdsPaths, AFilterInOneDirection) {
  start();
  EXPECT_TRUE(goes_by(*base_, "robot", "udp"));
  EXPECT_TRUE(all_paths_work(*base_, "robot"));
  EXPECT_TRUE(all_paths_work(*robot_, "base"));
  Traffic traffic(*base_, *robot_);
  cut_udp(false, true);  // datagrams from the base
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  EXPECT_TRUE(goes_by(*robot_, "base", "udp"));
  EXPECT_TRUE(traffic.goes_on());
  heal();
  EXPECT_TRUE(goes_by(*base_, "robot", "udp"));
  traffic.expect_all();
}

TEST_F(DdsPaths, DdsFailsThenBothThenBothRecover) {
  start();
  EXPECT_TRUE(goes_by(*base_, "robot", "udp"));
  Traffic traffic(*base_, *robot_);
  cut_dds();
  EXPECT_TRUE(traffic.goes_on());
  cut_udp();
  EXPECT_TRUE(eventually([&] { return base_->log().find("is down") != std::string::npos; },
                         "the link is down"));
  heal();
  EXPECT_TRUE(goes_by(*base_, "robot", "udp"));
  EXPECT_TRUE(eventually([&] { return base_->knows(kServer); }, "the base knows the server"));
}

TEST_F(DdsPaths, DdsAlone) {
  start("dds");
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  cut_udp();
  Traffic traffic(*base_, *robot_);
  EXPECT_TRUE(traffic.goes_on());
  traffic.expect_all();
}

// The base accepts links over DDS only; the robot would prefer UDP.
TEST_F(DdsPaths, WhatOneSidePrefersAndTheOtherRefuses) {
  base_ = fleet_host("base", "top", 0, 1, "dds");
  base_->start();
  robot_ = fleet_host("robot", "system", 1, 1, "udp+dds");
  networks_->on_the_right([this] { robot_->start(); });
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  EXPECT_TRUE(goes_by(*robot_, "base", "dds"));
}

TEST_F(DdsPaths, WhatOneSideHasOnlyAndTheOtherHasSecond) {
  base_ = fleet_host("base", "top", 0, 1, "udp+dds");
  base_->start();
  robot_ = fleet_host("robot", "system", 1, 1, "dds");
  networks_->on_the_right([this] { robot_->start(); });
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  EXPECT_TRUE(goes_by(*robot_, "base", "dds"));
}

// A robot that is switched on without a network, joins one, and then another.
TEST_F(DdsPaths, ARouterThatStartedBeforeItsNetworkFollowsItsAddress) {
  networks_->on_the_right([] {
    EXPECT_TRUE(TwoNetworks::run("ip address flush dev cable\nip link set cable down").ok());
  });
  start("dds");
  networks_->on_the_right([] {
    EXPECT_TRUE(
        TwoNetworks::run("ip link set cable up\nip address add 10.78.0.2/24 dev cable").ok());
  });
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  EXPECT_TRUE(goes_by(*robot_, "base", "dds"));
  for (const char* address : {"10.78.0.9", "10.78.0.7"}) {
    networks_->on_the_right([&] {
      EXPECT_TRUE(TwoNetworks::run("ip address flush dev cable").ok());
      EXPECT_TRUE(
          TwoNetworks::run(std::string("ip address add ") + address + "/24 dev cable").ok());
    });
    const std::string there = std::string("\"") + address + ":2010\"";
    EXPECT_TRUE(eventually(
        [&] {
          return base_->timsctl({"fleet", "show", "--json"}).find(there) != std::string::npos;
        },
        "the base knows the new address"));
    EXPECT_TRUE(goes_by(*base_, "robot", "dds")) << address;
    EXPECT_TRUE(goes_by(*robot_, "base", "dds")) << address;
  }
}

// Like a robot whose Wi-Fi comes up after its router.
TEST_F(DdsPaths, ACableThatIsPluggedInLater) {
  ASSERT_TRUE(TwoNetworks::run("ip link set cable down").ok());
  start();
  ASSERT_TRUE(TwoNetworks::run("ip link set cable up").ok());
  EXPECT_TRUE(goes_by(*base_, "robot", "udp"));
  EXPECT_TRUE(goes_by(*robot_, "base", "udp"));
}

TEST_F(DdsPaths, LargeMessagesGoByDds) {
  start("dds");
  Session client_session = base_->session("client");
  Session server_session = robot_->session("server");
  const auto open = [](Session& session, Address address) {
    auto opened = session.open({.address = address, .slots = 2, .body_max = 4U << 20});
    EXPECT_TRUE(opened.ok()) << opened.error().message();
    return std::move(*opened);
  };
  Mailbox client = open(client_session, kClient);
  Mailbox server = open(server_session, kServer);
  EXPECT_TRUE(eventually([&] { return base_->knows(kServer); }, "the base knows the server"));
  for (const std::size_t size : {0U, 1U, 1024U, 65536U, 1U << 20, 4U << 20}) {
    std::vector<std::byte> body(size);
    for (std::size_t i = 0; i < size; ++i) body[i] = static_cast<std::byte>(i * 31 % 251);
    ASSERT_TRUE(client.send({.dest = kServer, .type = 21}, body).ok()) << size;
    const auto message = server.peek_for(kPatience);
    ASSERT_TRUE(message.ok()) << size << " " << message.error().message();
    EXPECT_TRUE(std::ranges::equal(message->body(), body)) << size;
  }
}

TEST_F(DdsPaths, ARobotThatIsKilledAndStartedAgain) {
  start("dds");
  EXPECT_TRUE(goes_by(*robot_, "base", "dds"));
  robot_->kill();
  EXPECT_TRUE(eventually(
      [&] {
        return base_->timsctl({"fleet", "show", "--json"}).find("\"robot\"") == std::string::npos;
      },
      "the old entry is removed from the fleet"));
  networks_->on_the_right([this] { robot_->start(); });
  EXPECT_TRUE(goes_by(*base_, "robot", "dds"));
  EXPECT_TRUE(goes_by(*robot_, "base", "dds"));
}

TEST_F(DdsPaths, ARobotThatGetsAnotherAddress) {
  start();
  EXPECT_TRUE(goes_by(*base_, "robot", "udp"));
  networks_->on_the_right([] {
    const auto done = TwoNetworks::run(
        "ip address del 10.78.0.2/24 dev cable\n"
        "ip address add 10.78.0.9/24 dev cable");
    EXPECT_TRUE(done.ok()) << done.error().message();
  });
  EXPECT_TRUE(eventually(
      [&] {
        return base_->timsctl({"link", "show", "--json"}).find("10.78.0.9") != std::string::npos;
      },
      "the base knows the new address"));
  EXPECT_TRUE(goes_by(*base_, "robot", "udp"));
  EXPECT_TRUE(all_paths_work(*base_, "robot"));
}

}  // namespace dds_paths_test
}  // namespace tims::test
