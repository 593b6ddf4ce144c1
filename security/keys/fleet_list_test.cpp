#include "security/keys/fleet_list.h"

#include <gtest/gtest.h>

#include "security/crypto/tls_fixture.h"

namespace tims::security::fleet_list_test {

class FleetListTest : public testing::Test {
 protected:
  TestPair root_ = test_root("root");
  TestPair issuing_ = test_issued(root_, issuing());
  TestPair thief_ = test_member(issuing_, {"tims://f/system/3/1"});
  TestPair other_ = test_member(issuing_, {"tims://f/system/4/1"});

  static Issue issuing() {
    return {.kind = Issue::Kind::kIssuing,
            .subject = "issuing",
            .uris = {},
            .host_names = {},
            .not_before = 1000,
            .not_after = 4000000000};
  }
  FleetList list(std::uint64_t number) {
    FleetList made;
    made.number = number;
    made.made = 1234;
    made.fleet = "f";
    made.roots = {root_.certificate};
    made.revoke(thief_.certificate);
    return made;
  }
  Bytes bytes(std::uint64_t number) {
    return list(number).sign(issuing_.certificate, issuing_.key).value();
  }
  Result<FleetList> open(View bytes) { return FleetList::open(bytes, {root_.certificate}, "f"); }
};

TEST_F(FleetListTest, WhatIsSignedIsReadBack) {
  const Bytes encoded = bytes(7);
  const auto read = open(encoded).value();
  EXPECT_EQ(read.number, 7U);
  EXPECT_EQ(FleetList::number_of(encoded), 7U);
  EXPECT_EQ(read.made, 1234);
  EXPECT_EQ(read.roots, std::vector{root_.certificate});
  EXPECT_EQ(read.size(), 1U);
  EXPECT_TRUE(read.revokes(thief_.certificate));
  EXPECT_FALSE(read.revokes(other_.certificate));
}

TEST_F(FleetListTest, AnotherCertificateForARevokedKeyIsRevoked) {
  const auto again = Issue{.kind = Issue::Kind::kMember,
                           .subject = "new",
                           .uris = {"tims://f/system/9/1"},
                           .host_names = {},
                           .not_before = 1,
                           .not_after = 2}
                         .sign(thief_.key, issuing_.certificate, issuing_.key)
                         .value();
  EXPECT_TRUE(open(bytes(1)).value().revokes(again));
}

TEST_F(FleetListTest, EveryFlippedBitAndEveryCutIsSeen) {
  const Bytes right = bytes(1);
  for (std::size_t i = 0; i < right.size(); ++i) {
    Bytes wrong = right;
    wrong[i] ^= static_cast<std::byte>(1U << i % 8);
    EXPECT_FALSE(open(wrong).ok()) << i;
    EXPECT_FALSE(open(View(right).first(i)).ok()) << i;
  }
  Bytes longer = right;
  longer.push_back({});
  EXPECT_FALSE(open(longer).ok());
}

TEST_F(FleetListTest, OnlyTheAuthorityOfThisFleetSigns) {
  EXPECT_FALSE(open(list(1).sign(other_.certificate, other_.key).value()).ok()) << "a member";
  EXPECT_FALSE(open(list(1).sign(issuing_.certificate, other_.key).value()).ok()) << "other key";
  const TestPair foreign = test_root("root");
  EXPECT_FALSE(open(list(1).sign(foreign.certificate, foreign.key).value()).ok());
  EXPECT_TRUE(open(list(1).sign(root_.certificate, root_.key).value()).ok());
  const auto other_fleet = FleetList::open(bytes(1), {root_.certificate}, "g");
  ASSERT_FALSE(other_fleet.ok());
  EXPECT_NE(other_fleet.error().detail().find("fleet \"f\""), std::string::npos);
}

TEST_F(FleetListTest, Limits) {
  FleetList full = list(1);
  full.roots.assign(8, root_.certificate);
  EXPECT_TRUE(open(full.sign(issuing_.certificate, issuing_.key).value()).ok());
  full.roots.push_back(root_.certificate);
  EXPECT_FALSE(full.sign(issuing_.certificate, issuing_.key).ok());
  full.roots.clear();
  EXPECT_FALSE(full.sign(issuing_.certificate, issuing_.key).ok());
  EXPECT_FALSE(open(Bytes(FleetList::kBytesMax + 1)).ok());
  EXPECT_EQ(FleetList::number_of(view_of("TIMSLST1")), 0U);
}

}  // namespace tims::security::fleet_list_test
