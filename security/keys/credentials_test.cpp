#include "security/keys/credentials.h"

#include <gtest/gtest.h>

#include "security/keys/authority.h"
#include "security/keys/members_fixture.h"
#include "tests/support/temporary_folder.h"

namespace tims::security::credentials_test {

constexpr std::int64_t kNow = 1'800'000'000;
constexpr std::int64_t kAgeMax = std::int64_t{3} * 86400;
constexpr Strictness kRefuses{.expired = false, .list_age_max = kAgeMax, .old_list = true};

TEST(OldList, IsOneAboveItsAgeByAClockThatCanBeTrusted) {
  FleetList list;
  list.made = kNow;
  const auto old_at = [&](std::int64_t age, bool trusted = true) {
    return is_list_old(&list, {kNow + age, trusted}, kAgeMax);
  };
  EXPECT_FALSE(old_at(kAgeMax - 1));
  EXPECT_FALSE(old_at(kAgeMax));
  EXPECT_TRUE(old_at(kAgeMax + 1));
  EXPECT_FALSE(old_at(kAgeMax + 1, false)) << "no clock stops a robot";
  EXPECT_FALSE(is_list_old(&list, {kNow + 100 * kAgeMax, true}, 0)) << "no limit";
  EXPECT_TRUE(is_list_old(nullptr, {kNow, true}, kAgeMax));
  EXPECT_FALSE(is_list_old(nullptr, {kNow, true}, 0));
}

class OldListTest : public testing::Test {
 protected:
  Certificate certificate_of(const Identity& identity) {
    const auto key = PrivateKey::generate().value();
    const auto request = CertificateRequest::make(key, identity.uris()).value();
    return authority_.issue(identity, {}, request, kNow).value().front();
  }
  // "" or why `own` refuses `other` when its list is as old as this.
  std::string met(const Identity& own, const Identity& other, std::int64_t age,
                  const Strictness& strictness = kRefuses, bool trusted = true) {
    FleetList list;
    list.made = kNow;
    const auto refusal =
        judge(certificate_of(other), 0, own, &list, {kNow + age, trusted}, strictness);
    return refusal ? refusal->text : "";
  }
  static Identity member(MemberRole role, std::uint16_t system, std::uint16_t id) {
    return {.fleet = "f",
            .role = role,
            .system = system,
            .id = id,
            .name = usual_name(role, system, id),
            .rights = {}};
  }

  test::TemporaryFolder folder_;
  Authority authority_ =
      Authority::init(KeyFolder((folder_.path() / "base").string()), "f", kNow).value();
  const Identity base_ = member(MemberRole::kTop, 0, 1);
  const Identity part3_ = member(MemberRole::kSubsystem, 3, 2);
  const Identity user_{
      .fleet = "f", .role = MemberRole::kUser, .name = "anna", .rights = {.look = true}};
};

TEST_F(OldListTest, KeepsUsersAndOtherRobotsOutIfThatIsWanted) {
  EXPECT_EQ(met(robot(3), robot(5), kAgeMax), "");
  EXPECT_NE(met(robot(3), robot(5), kAgeMax + 1).find("security.list_age_max"), std::string::npos);
  EXPECT_NE(met(robot(3), user_, kAgeMax + 1), "");
  EXPECT_NE(met(base_, robot(3), kAgeMax + 1), "") << "a base that has not got the list for long";
  const Strictness reports{.expired = false, .list_age_max = kAgeMax, .old_list = false};
  EXPECT_EQ(met(robot(3), robot(5), kAgeMax + 1, reports), "");
  EXPECT_EQ(met(robot(3), robot(5), kAgeMax + 1, kRefuses, false), "") << "unsynchronised";
}

TEST_F(OldListTest, StopsNoRobot) {
  EXPECT_EQ(met(robot(3), base_, kAgeMax + 1), "") << "it brings the new list";
  EXPECT_EQ(met(part3_, base_, kAgeMax + 1), "");
  EXPECT_EQ(met(part3_, robot(3), kAgeMax + 1), "");
  EXPECT_EQ(met(robot(3), part3_, kAgeMax + 1), "");
  EXPECT_NE(met(part3_, robot(5), kAgeMax + 1), "");
}

TEST_F(OldListTest, IsSignedAnewByTheAuthorityAfterADay) {
  const KeyFolder keys((folder_.path() / "base").string());
  EXPECT_FALSE(authority_.refresh_list(kNow + 86399).value());
  EXPECT_EQ(authority_.list()->number, 1U);
  EXPECT_TRUE(authority_.refresh_list(kNow + 86400).value());
  EXPECT_EQ(authority_.list()->number, 2U);
  EXPECT_EQ(authority_.list()->made, kNow + 86400);
  EXPECT_FALSE(authority_.refresh_list(kNow + 86401).value());
}

class DatesTest : public OldListTest {
 protected:
  using Code = Refusal::Code;

  // Why it is refused at this time.
  std::optional<Code> at(std::int64_t now, bool refuses_expired, bool trusted = true) {
    const Strictness strictness{.expired = refuses_expired};
    const auto refusal = judge(certificate_, depth_, base_, &list_, {now, trusted}, strictness);
    text_ = refusal ? refusal->text : "";
    return refusal ? std::optional(refusal->code) : std::nullopt;
  }
  void expect_limits() {
    const std::int64_t first = certificate_.not_before();
    const std::int64_t last = certificate_.not_after();
    for (const bool refuses : {false, true}) {
      EXPECT_EQ(at(first - 1, refuses), Code::kNotYetValid);
      EXPECT_NE(text_.find("is not valid yet: compare both clocks"), std::string::npos) << text_;
      EXPECT_EQ(at(first, refuses), std::nullopt);
      EXPECT_EQ(at(last, refuses), std::nullopt);
      EXPECT_EQ(at(first - 1, refuses, false), std::nullopt) << "no clock stops a robot";
      EXPECT_EQ(at(last + 1, refuses, false), std::nullopt);
    }
    EXPECT_EQ(at(last + 1, false), std::nullopt) << "nor does an expiry";
    EXPECT_EQ(at(last + 1, true), Code::kExpired);
    EXPECT_NE(text_.find("has expired: run timsctl key renew there (security.refuse_expired)"),
              std::string::npos)
        << text_;
  }

  FleetList list_;
  Certificate certificate_ = certificate_of(robot(3));
  int depth_ = 0;
  std::string text_;
};

TEST_F(DatesTest, CountAtTheirLimitsByAClockThatCanBeTrusted) { expect_limits(); }

TEST_F(DatesTest, OfTheIssuingCertificateCountAsWell) {
  certificate_ = authority_.chain_of(certificate_).back();
  ASSERT_TRUE(certificate_.is_authority());
  depth_ = 1;
  expect_limits();
}

TEST_F(DatesTest, DoNotHelpWhoIsRevoked) {
  list_.revoke(certificate_);
  for (const bool trusted : {false, true})
    EXPECT_EQ(at(certificate_.not_after() + 1, false, trusted), Code::kRevoked);
}

}  // namespace tims::security::credentials_test
