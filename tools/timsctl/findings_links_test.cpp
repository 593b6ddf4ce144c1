#include <boost/json/parse.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/timsctl/catalogue.h"
#include "tools/timsctl/findings.h"

namespace timsctl {
namespace {

using testing::HasSubstr;

json::object object(const char* text) { return json::parse(text).as_object(); }

json::object healthy_link() {
  return object(R"({"via": "base", "kind": "super", "state": "up", "connects": true,
      "peer_address": "10.0.0.254:2010", "refusal": null, "since_s": 100, "mtu_bytes": 1472,
      "loss_in": 0.001, "loss_out": 0, "clock": {"offset_s": 0.002, "uncertainty_s": 0.001}})");
}

// The only finding about a router with this one link.
Finding finding(json::object link, const char* status = "{}", const char* events = "{}") {
  Facts facts{.where = "here", .version = "0.1.0"};
  facts.status = object(status);
  facts.stats = {{"events", object(events)}};
  facts.links = {std::move(link)};
  const auto found = judge_links(facts);
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
  const Facts facts{.where = "here", .version = "0.1.0"};
  EXPECT_TRUE(judge_links(facts).empty());
}

TEST(LinkDoctor, ALinkThatIsNotUp) {
  Finding f = with("state", "connecting");
  EXPECT_EQ(f.id, "links.down");
  EXPECT_EQ(f.level, Level::kFailure);
  EXPECT_EQ(f.text, "the link to base (super) is not up: nothing is heard for 1m 40s");

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

TEST(LinkDoctor, ARefusalIsToldInTheOthersWords) {
  json::object link = healthy_link();
  link["state"] = "refused";
  link["refusal"] = "base accepts system 2, not 1";
  const Finding f = finding(link);
  EXPECT_EQ(f.id, "links.refused");
  EXPECT_THAT(f.text, HasSubstr("base accepts system 2, not 1"));
}

TEST(LinkDoctor, SmallDatagramsOnly) {
  EXPECT_EQ(with("mtu_bytes", 1200).id, "links.mtu");
  json::object young = healthy_link();
  young["mtu_bytes"] = 1200;
  young["since_s"] = 1;
  EXPECT_EQ(finding(young).level, Level::kOk) << "still being found out";
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

}  // namespace
}  // namespace timsctl
