#include "router/link/admission.h"

#include <array>
#include <vector>

#include <gtest/gtest.h>

namespace tims::link {
namespace admission_test {

using namespace std::chrono_literals;

constexpr core::SipKey kSecret{1, 2};
const NetAddress kFrom = NetAddress::v4(10, 0, 0, 2, 2010);
const Identity kBase{.epoch = 10, .role = Role::kTop, .system = 0, .id = 1};
const Identity kRobot{.epoch = 11, .role = Role::kSystem, .system = 1, .id = 1};

struct NoSink final : core::RouterHooks {
  void admin(Time, core::ClientId, const core::Message&) override {}
  void traced(core::ClientId, core::ClientId, const core::Message&) override {}
  void event(const core::Event&) override {}
};

class AdmissionTest : public testing::Test {
 protected:
  // Why the base refuses a router that calls it its super router; empty: it does not.
  std::string refusal(const Identity& identity, const std::vector<LinkSettings>& settings) {
    Refuse refuse{};
    const Hello hello{.kind = LinkKind::kSuper, .token = 7, .identity = identity};
    const auto nobody = [](const LinkSettings&) { return false; };
    const bool taken = admission.accepting(settings, kFrom, hello, nobody, refuse) != nullptr;
    return taken ? "" : std::string(refuse.text.view());
  }

  NoSink sink;
  core::Router router{{.address = kBase.address(), .role = kBase.role}, core::HashSeed{1, 2}, sink};
  Admission admission{router, kBase, kSecret};
  const LinkSettings sub{.kind = LinkKind::kSub, .connects = false};
};

// From one address, of one HELLO, and not for long.
TEST_F(AdmissionTest, ACookieProvesAnAddress) {
  const Time now{100s};
  Hello hello{.kind = LinkKind::kSuper, .token = 7, .identity = kRobot};
  const auto proven = [&](Time at, const NetAddress& from) {
    return admission.is_proven(at, from, hello.token, hello.identity.epoch, hello.cookie);
  };
  EXPECT_FALSE(proven(now, kFrom));
  const Retry retry = admission.retry(now, kFrom, hello.token, hello.identity.epoch);
  EXPECT_EQ(retry.echo, hello.token);
  hello.cookie = retry.cookie;
  EXPECT_TRUE(proven(now, kFrom));
  EXPECT_TRUE(proven(now + 5s, kFrom));
  EXPECT_FALSE(proven(now + 10s, kFrom));
  EXPECT_FALSE(proven(now, NetAddress::v4(10, 0, 0, 3, 2010)));
  hello.token = 8;
  EXPECT_FALSE(proven(now, kFrom));
}

TEST_F(AdmissionTest, VersionsMustMeet) {
  Hello hello{.kind = LinkKind::kSuper, .token = 7, .identity = kRobot};
  EXPECT_FALSE(Admission::version_refusal(hello));
  hello.version_min = hello.version_max = kVersionMax + 1;
  const auto refusal = Admission::version_refusal(hello);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->echo, hello.token);
}

TEST_F(AdmissionTest, TheConfigurationDecidesWhichRoutersMayConnect) {
  EXPECT_EQ(refusal(kRobot, {sub}), "");
  EXPECT_EQ(refusal(kRobot, {}), "Tims(0/1)  has no [[link]] with kind = \"sub\"");
  LinkSettings other = sub;
  other.system = 9;
  EXPECT_EQ(refusal(kRobot, {other}), "Tims(0/1)  accepts system 9, not 1");
  Identity twin = kRobot;
  twin.system = kBase.system;
  EXPECT_EQ(refusal(twin, {sub}),
            "Tims(0/1)  already has this system and id: choose another [router] id");
  Identity below = kRobot;
  below.role = Role::kSubsystem;
  EXPECT_EQ(refusal(below, {sub}),
            "Tims(0/1)  is a top router, which cannot be a super router for a subsystem router");
}

// Repeated attempts of one router are not logged each time.
TEST_F(AdmissionTest, RefusalsAreNotedNowAndThen) {
  const Time now{100s};
  const Hello hello{.kind = LinkKind::kSuper, .token = 7, .identity = kRobot};
  for (int i = 0; i < 3; ++i) admission.note_refused(now + i * 1s, kFrom, hello.identity, "full");
  EXPECT_EQ(router.event_counts().of(core::EventKind::kLinkRefused), 1U);
  admission.note_refused(now + 11s, kFrom, hello.identity, "full");
  EXPECT_EQ(router.event_counts().of(core::EventKind::kLinkRefused), 2U);
}

}  // namespace admission_test
}  // namespace tims::link
