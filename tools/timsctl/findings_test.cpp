#include "tools/timsctl/findings.h"

#include <algorithm>

#include <boost/json/parse.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/timsctl/catalogue.h"

namespace timsctl {
namespace {

using testing::HasSubstr;

json::object object(const char* text) { return json::parse(text).as_object(); }

Facts healthy() {
  Facts facts{.where = "/run/tims/router.sock", .version = "0.1.0"};
  facts.status = object(R"({"name": "lab", "version": "0.1.0", "longest_turn_s": 0.001,
      "drops_last_minute": 0, "listen": {"tcp": "127.0.0.1:2000", "http": null}})");
  facts.stats = object(R"({"items": [], "events": {"address_refused": 0}})");
  facts.socket = SocketFile{0770, "root", "tims"};
  facts.files = OpenFiles{65536, 30};
  facts.memory = SharedMemory{true, 1 << 30};
  facts.receive_buffer_max = 4 << 20;
  return facts;
}

Finding finding(const Facts& facts, std::string_view id) {
  for (const Finding& f : judge(facts))
    if (f.id == id) return f;
  return {.id = "none", .level = Level::kOk, .text = "not found", .hint = {}};
}

TEST(Doctor, FindsNothingWrongWithAHealthyRouter) {
  for (const Finding& f : judge(healthy())) EXPECT_LE(f.level, Level::kInfo) << f.id << f.text;
}

TEST(Doctor, EveryFindingIsInTheCatalogue) {
  Facts facts = healthy();
  facts.dead_owners = {"Ladar(3/0) of laser (pid 1)"};
  for (const Finding& f : judge(facts)) EXPECT_NE(find_in_catalogue(f.id), nullptr) << f.id;
}

TEST(Doctor, NoRouterIsAFailureWithItsReason) {
  Facts facts = healthy();
  facts.unreachable = Failure(Exit::kNoRouter, "no_router", "no router at x", "start one");
  facts.tcp_port_owner = "rack_router (pid 7)";
  const Finding f = finding(facts, "router.reachable");
  EXPECT_EQ(f.level, Level::kFailure);
  EXPECT_EQ(f.hint, "start one");
  EXPECT_THAT(finding(facts, "port.tcp").text, HasSubstr("rack_router (pid 7)"));
}

TEST(Doctor, OtherVersionIsAWarning) {
  Facts facts = healthy();
  facts.status["version"] = "0.2.0";
  EXPECT_EQ(finding(facts, "router.version").level, Level::kWarning);
}

TEST(Doctor, DeadOwnersAndFullMailboxesAreNamed) {
  Facts facts = healthy();
  facts.dead_owners = {"Ladar(3/0) of laser (pid 811)"};
  facts.mailboxes = json::parse(R"x([{"address": {"name": "Pilot(3/0)"}, "owner": {"name": "pilot"},
      "slots": 4, "waiting": 4}])x")
                        .as_array();
  EXPECT_EQ(finding(facts, "mailboxes.dead").level, Level::kFailure);
  EXPECT_THAT(finding(facts, "mailboxes.full").text, HasSubstr("Pilot(3/0) of pilot is full"));
}

TEST(Doctor, DropsOfTheLastMinuteWarnWithTheReasonsHint) {
  Facts facts = healthy();
  facts.stats = object(R"({"events": {"address_refused": 2}, "items": [
      {"outcome": "no_route", "dropped": true, "messages": 3},
      {"outcome": "no_route", "dropped": true, "messages": 4},
      {"outcome": "delivered", "dropped": false, "messages": 400}]})");
  Finding f = finding(facts, "drops.no_route");
  EXPECT_EQ(f.level, Level::kInfo) << "long ago";
  EXPECT_THAT(f.text, HasSubstr("7 messages"));
  facts.status["drops_last_minute"] = 1;
  f = finding(facts, "drops.no_route");
  EXPECT_EQ(f.level, Level::kWarning);
  EXPECT_THAT(f.hint, HasSubstr("timsctl route"));
  EXPECT_EQ(finding(facts, "mailboxes.duplicate").level, Level::kWarning);
}

TEST(Doctor, SaysToWhomMessagesWereLost) {
  Facts facts = healthy();
  EXPECT_EQ(finding(facts, "drops.receivers").id, "none") << "none were";
  facts.clients = {object(R"({"name": "laser", "drops": 0})"),
                   object(R"({"name": "camera", "drops": 12})"),
                   object(R"({"name": "", "peer": "127.0.0.1:50000", "drops": 40})")};
  facts.mailboxes = {
      object(R"x({"address": {"name": "Ladar(3/0)"}, "replaced": 1, "refused": 2})x"),
      object(R"x({"address": {"name": "Pilot(3/0)"}, "replaced": 0})x")};
  EXPECT_EQ(finding(facts, "drops.receivers").text,
            "messages were lost: 40 to 127.0.0.1:50000, 12 to camera, 3 in the mailbox Ladar(3/0)");
  for (int i = 0; i < 4; ++i) facts.clients.push_back(object(R"({"name": "x", "drops": 1})"));
  EXPECT_TRUE(finding(facts, "drops.receivers").text.ends_with("1 to x, and 2 more"));
}

TEST(Doctor, FilesAndMemory) {
  Facts facts = healthy();
  facts.files = OpenFiles{1024, 30};
  EXPECT_EQ(finding(facts, "limits.files").level, Level::kWarning);
  facts.files = OpenFiles{65536, 65000};
  EXPECT_EQ(finding(facts, "limits.files").level, Level::kFailure);
  facts.memory = SharedMemory{true, 1000};
  EXPECT_EQ(finding(facts, "memory.shared").level, Level::kFailure);
}

TEST(Doctor, ARemoteRouterIsJudgedByItsClockNotByThisHost) {
  Facts facts = healthy();
  facts.local = false;
  facts.clock_difference_s = -3.5;
  EXPECT_EQ(finding(facts, "clock.difference").level, Level::kWarning);
  EXPECT_EQ(finding(facts, "limits.files").id, "none");
}

}  // namespace
}  // namespace timsctl
