#include "router/io/member_keys.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "security/keys/authority.h"
#include "tests/support/temporary_folder.h"

namespace tims::io::member_keys_test {

constexpr std::int64_t kNow = 1'800'000'000;

class MemberKeysTest : public testing::Test {
 protected:
  MemberKeysTest() {
    config_.security.keys = keys_.path();
    config_.router.role = core::Role::kTop;
    EXPECT_TRUE(authority_.issue_own(base_, {}, kNow).ok());
  }

  test::TemporaryFolder folder_;
  security::KeyFolder keys_{(folder_.path() / "base").string()};
  security::Authority authority_ = security::Authority::init(keys_, "f", kNow).value();
  security::Identity base_{.fleet = "f",
                           .role = security::MemberRole::kTop,
                           .system = 0,
                           .id = 1,
                           .name = "base",
                           .rights = {}};
  config::Config config_;
};

TEST_F(MemberKeysTest, ANewListAndANewCertificateAreSeen) {
  auto keys = MemberKeys::load(config_).value();
  Time now{};
  EXPECT_FALSE(keys.on_timeout(now).value());
  const auto first = keys.credentials().chain.front();
  ASSERT_TRUE(authority_.revoke("base", kNow).ok());
  EXPECT_FALSE(keys.on_timeout(now).value()) << "looks again after the interval only";
  now += MemberKeys::kInterval;
  EXPECT_EQ(keys.next_timeout(), now);
  EXPECT_TRUE(keys.on_timeout(now).value());
  EXPECT_EQ(keys.credentials().list_number(), 2U);
  ASSERT_TRUE(authority_.issue_own(base_, {}, kNow).ok());
  EXPECT_TRUE(keys.on_timeout(now += MemberKeys::kInterval).value());
  EXPECT_NE(keys.credentials().chain.front(), first);
  EXPECT_FALSE(keys.on_timeout(now += MemberKeys::kInterval).value());
}

TEST_F(MemberKeysTest, AListFromALinkCountsAtOnceAndNeverGoesBack) {
  auto keys = MemberKeys::load(config_).value();
  const auto old = keys_.read_public("revoked.list").value();
  ASSERT_TRUE(authority_.revoke("base", kNow).ok());
  const auto bytes = authority_.list_bytes().value();
  const auto list = std::make_shared<const security::FleetList>(authority_.list().value());
  ASSERT_TRUE(keys_.write_public("revoked.list", old).ok());  // the disk could not be written
  EXPECT_TRUE(keys.use_list(list, bytes));
  EXPECT_FALSE(keys.use_list(list, bytes)) << "not newer";
  EXPECT_EQ(keys.credentials().list_number(), 2U);
  EXPECT_EQ(keys.credentials().list_bytes, bytes);
  Time now{};
  EXPECT_FALSE(keys.on_timeout(now).value());
  EXPECT_EQ(keys.credentials().list_number(), 2U) << "the older file does not count";
  ASSERT_TRUE(keys_.take_over_list(bytes).value());
  EXPECT_FALSE(keys.on_timeout(now += MemberKeys::kInterval).value()) << "known already";
}

TEST_F(MemberKeysTest, WhatCannotBeUsedLeavesTheFormerKeysInForce) {
  auto keys = MemberKeys::load(config_).value();
  ASSERT_TRUE(keys_.write_public("revoked.list", "damaged").ok());
  EXPECT_FALSE(keys.on_timeout(Time{}).ok());
  EXPECT_EQ(keys.credentials().list_number(), 1U);
  EXPECT_TRUE(keys.on_timeout(Time{} + MemberKeys::kInterval).ok()) << "reported once";
  EXPECT_FALSE(keys.problem().empty()) << "and still so";
}

TEST_F(MemberKeysTest, TheCertificateOfAnotherRouterIsNamed) {
  config_.router.role = core::Role::kSystem;
  config_.router.system = 3;
  const auto loaded = MemberKeys::load(config_);
  ASSERT_FALSE(loaded.ok());
  EXPECT_NE(loaded.error().detail().find(
                "is that of top 0, id 1 (base), but this router is system 3, id 1"),
            std::string::npos)
      << loaded.error().detail();
  config_.security.keys = (folder_.path() / "none").string();
  EXPECT_NE(MemberKeys::load(config_).error().detail().find("timsctl join"), std::string::npos);
}

}  // namespace tims::io::member_keys_test
