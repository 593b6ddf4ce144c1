#include "tools/timsctl/doctor.h"

#include <algorithm>

#include <boost/json/parse.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/cli/connection.h"
#include "tools/cli/failure.h"

namespace timsctl {
namespace doctor_test {

using testing::HasSubstr;

json::object object(const char* text) { return json::parse(text).as_object(); }

Observations healthy() {
  Observations observed{.where = "/run/tims/router.sock", .version = "0.1.0"};
  observed.status = object(R"({"name": "lab", "version": "0.1.0", "longest_turn_s": 0.001,
      "drops_last_minute": 0, "listen": {"tcp": "127.0.0.1:2000", "http": null}})");
  observed.stats = object(R"({"items": [], "events": {"address_refused": 0}})");
  observed.socket = SocketFile{0770, "root", "tims"};
  observed.files = OpenFiles{65536, 30};
  observed.memory = SharedMemory{true, 1 << 30};
  observed.receive_buffer_max = 4 << 20;
  return observed;
}

Finding finding(const Observations& observed, std::string_view id) {
  for (const Finding& f : judge(observed))
    if (f.id == id) return f;
  return {.id = "none", .level = Level::kOk, .text = "not found", .hint = {}};
}

TEST(Doctor, FindsNothingWrongWithAHealthyRouter) {
  for (const Finding& f : judge(healthy())) EXPECT_LE(f.level, Level::kInfo) << f.id << f.text;
}

TEST(Doctor, EveryFindingIsInTheCatalogue) {
  Observations observed = healthy();
  observed.dead_owners = {"Ladar(3/0) of laser (pid 1)"};
  for (const Finding& f : judge(observed)) EXPECT_NE(find_in_catalogue(f.id), nullptr) << f.id;
}

TEST(Doctor, NoRouterIsAFailureWithItsReason) {
  Observations observed = healthy();
  observed.unreachable = Failure(Exit::kNoRouter, "no_router", "no router at x", "start one");
  observed.tcp_port_owner = "rack_router (pid 7)";
  const Finding f = finding(observed, "router.reachable");
  EXPECT_EQ(f.level, Level::kFailure);
  EXPECT_EQ(f.hint, "start one");
  EXPECT_THAT(finding(observed, "port.tcp").text, HasSubstr("rack_router (pid 7)"));
}

TEST(Doctor, WhatIsAllowedAndDangerousIsSaid) {
  Observations observed = healthy();
  EXPECT_EQ(finding(observed, "security.cautions").id, "none");
  observed.status["security"] = object(R"({"cautions": ["DDS is open"], "keys": null})");
  const Finding f = finding(observed, "security.cautions");
  EXPECT_EQ(f.level, Level::kWarning);
  EXPECT_EQ(f.text, "DDS is open");
  EXPECT_FALSE(f.hint.empty());
}

TEST(Doctor, PortsBeyondTheHostAreGoodWithKeysOnly) {
  Observations observed = healthy();
  observed.status["listen"] = object(R"({"tcp": "0.0.0.0:2000", "http": "0.0.0.0:8080"})");
  for (const char* port : {"port.tcp", "port.http"})
    EXPECT_EQ(finding(observed, port).level, Level::kWarning) << port;
  observed.status["security"] = object(R"({"keys": {"state": "valid"}})");
  for (const char* port : {"port.tcp", "port.http"})
    EXPECT_EQ(finding(observed, port).level, Level::kOk) << port;
}

// Keys say nothing about the users of this host.
TEST(Doctor, PortsWithinTheHostAreMentionedWhereKeysAre) {
  Observations observed = healthy();
  EXPECT_EQ(finding(observed, "port.tcp").level, Level::kOk);
  observed.status["security"] = object(R"({"keys": {"state": "valid"}})");
  const Finding f = finding(observed, "port.tcp");
  EXPECT_EQ(f.level, Level::kInfo);
  EXPECT_THAT(f.text, HasSubstr("every user of this host"));
  EXPECT_THAT(f.hint, HasSubstr("tcp.listen = \"off\""));
}

TEST(Doctor, KeysThatEndAreRevokedOrCannotBeReadAreNamed) {
  Observations observed = healthy();
  EXPECT_EQ(finding(observed, "keys").id, "none");
  observed.status["security"] = object(R"({"exposed": ["udp"], "keys": null})");
  EXPECT_EQ(finding(observed, "keys").level, Level::kWarning);
  const auto with = [&](const char* state, const char* problem) {
    observed.status["security"] = object(
        R"({"keys": {"fleet": "harbour", "identity": "robot3", "ends": "2036-11-26T00:00:00Z",
            "list": 4, "revoked": 1, "problem": null}})");
    json::object& keys = observed.status["security"].as_object()["keys"].as_object();
    keys["state"] = state;
    if (*problem != 0) keys["problem"] = problem;
  };
  with("valid", "");
  EXPECT_EQ(finding(observed, "keys").level, Level::kOk);
  EXPECT_THAT(finding(observed, "keys").text, HasSubstr("robot3 of the fleet harbour"));
  with("valid, but the clock is not synchronised", "");
  EXPECT_EQ(finding(observed, "keys").level, Level::kOk);
  for (const char* state : {"ends soon", "expired", "not valid yet"}) {
    with(state, "");
    EXPECT_EQ(finding(observed, "keys.end").level, Level::kWarning) << state;
    EXPECT_THAT(finding(observed, "keys.end").hint, HasSubstr("timsctl key renew"));
  }
  with("revoked", "");
  EXPECT_EQ(finding(observed, "keys.revoked").level, Level::kFailure);
  with("valid", "identity.key can be read by others: run chmod 600");
  EXPECT_THAT(finding(observed, "keys.folder").text, HasSubstr("chmod 600"));
}

TEST(Doctor, APortThatOtherHostsReachIsAWarning) {
  Observations observed = healthy();
  for (const char* here : {"127.0.0.1:2000", "[::1]:2000", "127.1.2.3:2000"}) {
    observed.status["listen"].as_object()["tcp"] = here;
    EXPECT_EQ(finding(observed, "port.tcp").level, Level::kOk) << here;
  }
  for (const char* all : {"0.0.0.0:2000", "[::]:2000", "10.0.0.7:2000", "192.168.1.1:2000"}) {
    observed.status["listen"].as_object()["tcp"] = all;
    const Finding f = finding(observed, "port.tcp");
    EXPECT_EQ(f.level, Level::kWarning) << all;
    EXPECT_THAT(f.hint, HasSubstr("tcp.listen = \"127.0.0.1:2000\"")) << all;
  }
}

TEST(Doctor, ComponentsInErrorAreAWarning) {
  Observations observed = healthy();
  EXPECT_EQ(finding(observed, "components.error").id, "none");
  observed.components = 3;
  EXPECT_EQ(finding(observed, "components.error").level, Level::kOk);
  observed.in_error = {"Ladar(3/0)"};
  const Finding f = finding(observed, "components.error");
  EXPECT_EQ(f.level, Level::kWarning);
  EXPECT_THAT(f.text, HasSubstr("Ladar(3/0) is in error"));
  EXPECT_THAT(f.hint, HasSubstr("timsctl log"));
}

TEST(Doctor, OtherVersionIsAWarning) {
  Observations observed = healthy();
  observed.status["version"] = "0.2.0";
  EXPECT_EQ(finding(observed, "router.version").level, Level::kWarning);
}

TEST(Doctor, DeadOwnersAndFullMailboxesAreNamed) {
  Observations observed = healthy();
  observed.dead_owners = {"Ladar(3/0) of laser (pid 811)"};
  observed.mailboxes =
      json::parse(R"x([{"address": {"name": "Pilot(3/0)"}, "owner": {"name": "pilot"},
      "slots": 4, "waiting": 4}])x")
          .as_array();
  EXPECT_EQ(finding(observed, "mailboxes.dead").level, Level::kFailure);
  EXPECT_THAT(finding(observed, "mailboxes.full").text, HasSubstr("Pilot(3/0) of pilot is full"));
}

TEST(Doctor, DropsOfTheLastMinuteWarnWithTheReasonsHint) {
  Observations observed = healthy();
  observed.stats = object(R"({"events": {"address_refused": 2}, "items": [
      {"outcome": "no_route", "dropped": true, "messages": 3},
      {"outcome": "no_route", "dropped": true, "messages": 4},
      {"outcome": "delivered", "dropped": false, "messages": 400}]})");
  Finding f = finding(observed, "drops.no_route");
  EXPECT_EQ(f.level, Level::kInfo) << "long ago";
  EXPECT_THAT(f.text, HasSubstr("7 messages"));
  observed.status["drops_last_minute"] = 1;
  f = finding(observed, "drops.no_route");
  EXPECT_EQ(f.level, Level::kWarning);
  EXPECT_THAT(f.hint, HasSubstr("timsctl route"));
  EXPECT_EQ(finding(observed, "mailboxes.duplicate").level, Level::kWarning);
}

TEST(Doctor, NamesTheReceiversOfLostMessages) {
  Observations observed = healthy();
  EXPECT_EQ(finding(observed, "drops.receivers").id, "none") << "none were";
  observed.clients = {object(R"({"name": "laser", "drops": 0})"),
                      object(R"({"name": "camera", "drops": 12})"),
                      object(R"({"name": "", "peer": "127.0.0.1:50000", "drops": 40})")};
  observed.mailboxes = {
      object(R"x({"address": {"name": "Ladar(3/0)"}, "replaced": 1, "refused": 2})x"),
      object(R"x({"address": {"name": "Pilot(3/0)"}, "replaced": 0})x")};
  EXPECT_EQ(finding(observed, "drops.receivers").text,
            "messages were lost: 40 to 127.0.0.1:50000, 12 to camera, 3 in the mailbox Ladar(3/0)");
  for (int i = 0; i < 4; ++i) observed.clients.push_back(object(R"({"name": "x", "drops": 1})"));
  EXPECT_TRUE(finding(observed, "drops.receivers").text.ends_with("1 to x, and 2 more"));
}

TEST(Doctor, FilesAndMemory) {
  Observations observed = healthy();
  observed.files = OpenFiles{1024, 30};
  EXPECT_EQ(finding(observed, "limits.files").level, Level::kWarning);
  observed.files = OpenFiles{65536, 65000};
  EXPECT_EQ(finding(observed, "limits.files").level, Level::kFailure);
  observed.memory = SharedMemory{true, 1000};
  EXPECT_EQ(finding(observed, "memory.shared").level, Level::kFailure);
}

TEST(Doctor, ARemoteRouterIsJudgedByItsClockNotByThisHost) {
  Observations observed = healthy();
  observed.local = false;
  observed.clock_difference_s = -3.5;
  EXPECT_EQ(finding(observed, "clock.difference").level, Level::kWarning);
  EXPECT_EQ(finding(observed, "limits.files").id, "none");
}

using testing::HasSubstr;

json::object healthy_link() {
  return object(R"({"via": "base", "kind": "super", "state": "up", "connects": true,
      "peer_address": "10.0.0.254:2010", "refusal": null, "since_s": 100, "mtu_bytes": 1472,
      "loss_in": 0.001, "loss_out": 0, "clock": {"offset_s": 0.002, "uncertainty_s": 0.001}})");
}

// The only finding about a router with this one link.
Finding finding(json::object link, const char* status = "{}", const char* events = "{}") {
  Observations observed{.where = "here", .version = "0.1.0"};
  observed.status = object(status);
  observed.stats = {{"events", object(events)}};
  observed.links = {std::move(link)};
  const auto found = judge_links(observed);
  EXPECT_FALSE(found.empty());
  if (found.empty()) return {};
  for (const Finding& f : found) {
    EXPECT_NE(find_in_catalogue(f.id), nullptr) << f.id;
    EXPECT_TRUE(f.level < Level::kWarning || !f.hint.empty()) << f.id;
  }
  return found.back();
}

Finding with(const char* key, json::value value) {
  json::object link = healthy_link();
  link[key] = std::move(value);
  return finding(link);
}

TEST(LinkDoctor, AHealthyLinkIsFine) {
  const Finding f = finding(healthy_link());
  EXPECT_EQ(f.level, Level::kOk);
  EXPECT_EQ(f.text, "1 link is up");
}

TEST(LinkDoctor, NoLinksNoFindings) {
  const Observations observed{.where = "here", .version = "0.1.0"};
  EXPECT_TRUE(judge_links(observed).empty());
}

TEST(LinkDoctor, ALinkThatIsNotUp) {
  Finding f = with("state", "connecting");
  EXPECT_EQ(f.id, "links.down");
  EXPECT_EQ(f.level, Level::kFailure);
  EXPECT_EQ(f.text, "the link to base (super) is not up: nothing received for 1m 40s");

  f = with("state", "idle");
  EXPECT_THAT(f.text, HasSubstr("no address"));
  EXPECT_THAT(f.hint, HasSubstr("getent hosts"));

  json::object called = healthy_link();
  called["connects"] = false;
  called["state"] = "silent";
  EXPECT_EQ(finding(called).level, Level::kWarning) << "it may have been switched off";
}

TEST(LinkDoctor, ALinkTakenDownByHandSaysHowItComesUp) {
  const Finding f = with("state", "down");
  EXPECT_EQ(f.level, Level::kWarning);
  EXPECT_EQ(f.hint, "`timsctl link up base`");
}

TEST(LinkDoctor, ARefusalIsReportedWithTheReasonOfThePeer) {
  json::object link = healthy_link();
  link["state"] = "refused";
  link["refusal"] = "base accepts system 2, not 1";
  const Finding f = finding(link);
  EXPECT_EQ(f.id, "links.refused");
  EXPECT_THAT(f.text, HasSubstr("base accepts system 2, not 1"));
}

TEST(LinkDoctor, ANameThatTheSocketCannotReachIsNoRefusal) {
  json::object link = healthy_link();
  link["state"] = "idle";
  link["refusal"] = "its address is [fd00::1]:2010, which the socket cannot reach";
  const Finding f = finding(link);
  EXPECT_EQ(f.id, "links.down");
  EXPECT_THAT(f.text, HasSubstr("is not up: its address is [fd00::1]:2010"));
}

TEST(LinkDoctor, SmallDatagramsOnly) {
  EXPECT_EQ(with("mtu_bytes", 1200).id, "links.mtu");
  EXPECT_THAT(with("mtu_bytes", 1064).text, HasSubstr("above 1064 bytes"));
  json::object lossy = healthy_link();
  lossy["mtu_bytes"] = 1064;
  lossy["loss_out"] = 0.2;
  const Finding loss = finding(lossy);
  EXPECT_EQ(loss.id, "links.loss");
  EXPECT_THAT(loss.hint, HasSubstr("links.mtu")) << "it is not the radio";
  json::object young = healthy_link();
  young["mtu_bytes"] = 1200;
  young["since_s"] = 1;
  EXPECT_EQ(finding(young).level, Level::kOk) << "still being found out";
}

TEST(LinkDoctor, FaultsThatSomebodyHasInjected) {
  EXPECT_EQ(with("faults", nullptr).level, Level::kOk);
  const json::object faults = object(R"({"loss": 0.105, "duplicate": 0, "reorder": 0.01,
      "delay_s": 0.02, "jitter_s": 0.005, "rate": 125000, "blackout": false})");
  Finding f = with("faults", faults);
  EXPECT_EQ(f.id, "links.faults");
  EXPECT_EQ(f.level, Level::kWarning);
  EXPECT_EQ(f.text,
            "faults are injected into what is sent to base (super): 10.5% lost, 1% out of order, "
            "20.00ms late, up to 5.00ms later, at most 122.1 KiB/s");
  json::object silent = healthy_link();
  silent["state"] = "silent";
  silent["faults"] = {{"loss", 0.1}, {"blackout", true}};
  f = finding(silent);
  EXPECT_EQ(f.id, "links.faults");
  EXPECT_THAT(f.text, HasSubstr("nothing is sent"));
}

TEST(LinkDoctor, LossAndClock) {
  Finding f = with("loss_out", 0.2);
  EXPECT_EQ(f.id, "links.loss");
  EXPECT_THAT(f.text, HasSubstr("0% in and 20% out"));
  f = with("clock", object(R"({"offset_s": -2, "uncertainty_s": 0.001})"));
  EXPECT_EQ(f.id, "links.clock");
  EXPECT_THAT(f.text, HasSubstr("2.00s behind"));
  EXPECT_EQ(with("clock", nullptr).level, Level::kOk);
}

TEST(LinkDoctor, ASmallSocketBufferWarnsWhenItHasCostSomething) {
  const char* status = R"({"udp": {"asked_buffer_bytes": 8388608, "receive_buffer_bytes": 212992,
      "send_buffer_bytes": 212992, "dropped_by_kernel": 0}})";
  EXPECT_EQ(finding(healthy_link(), status).level, Level::kInfo);
  status = R"({"udp": {"asked_buffer_bytes": 8388608, "receive_buffer_bytes": 212992,
      "send_buffer_bytes": 8388608, "dropped_by_kernel": 5}})";
  const Finding f = finding(healthy_link(), status);
  EXPECT_EQ(f.level, Level::kWarning);
  EXPECT_THAT(f.hint, HasSubstr("sysctl -w net.core.rmem_max"));
}

TEST(LinkDoctor, WhatTheRouterHasSeen) {
  EXPECT_EQ(finding(healthy_link(), "{}", R"({"duplicate_router": 1})").id, "routers.duplicate");
  EXPECT_EQ(finding(healthy_link(), "{}", R"({"duplicate_address": 2})").id, "addresses.duplicate");
  const Finding f = finding(healthy_link(), "{}", R"({"loop": 3})");
  EXPECT_EQ(f.id, "routes.loop");
  EXPECT_EQ(f.level, Level::kFailure);
  EXPECT_THAT(f.text, HasSubstr("(3 times)"));
}

TEST(Host, AsAnEndpointIsWritten) {
  EXPECT_EQ(parse_host("robot:2001"), Host(TcpHost{"robot", 2001}));
  EXPECT_EQ(parse_host("/run/x.sock"), Host(UnixHost{"/run/x.sock"}));
  EXPECT_THROW(parse_host("robot:0"), Failure);
}

TEST(HostFacts, OfThisProcess) {
  const auto files = open_files(static_cast<std::uint32_t>(::getpid()));
  ASSERT_TRUE(files);
  EXPECT_GT(files->limit, 0U);
  EXPECT_GE(files->open.value_or(0), 3U);
  EXPECT_TRUE(is_running(static_cast<std::uint32_t>(::getpid())));
  EXPECT_FALSE(is_running(0x3FFFFFFF));
  EXPECT_TRUE(shared_memory().memfd);
  EXPECT_FALSE(socket_file("/no/such/file"));
}

}  // namespace doctor_test
}  // namespace timsctl
