#include "security/keys/authority.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "security/crypto/tls_fixture.h"
#include "security/keys/members_fixture.h"
#include "tests/support/temporary_folder.h"

namespace tims::security::authority_test {

namespace fs = std::filesystem;
constexpr std::int64_t kNow = 1'800'000'000;

class AuthorityTest : public testing::Test {
 protected:
  KeyFolder member(const std::string& name) {
    KeyFolder made((folder_.path() / name).string());
    EXPECT_TRUE(made.make().ok());
    return made;
  }
  KeyFolder join(const Authority& authority, const Identity& identity) {
    KeyFolder made((folder_.path() / identity.name).string());
    EXPECT_TRUE(authority.issue_to(made, identity, {}, kNow).ok());
    EXPECT_EQ(made.load()->list_number(), authority.list()->number);
    return made;
  }
  // "" or why the server refuses.
  static std::string meet(const KeyFolder& client, const KeyFolder& server) {
    const auto context = [](const KeyFolder& keys, TlsSettings::Side side) {
      return TlsContext::make(member_settings(keys.load().value(), side)).value();
    };
    TlsSession a(context(client, TlsSettings::Side::kClient));
    TlsSession b(context(server, TlsSettings::Side::kServer));
    converse(a, b);
    return b.state() == TlsSession::State::kOpen ? a.error() : a.error() + b.error();
  }

  test::TemporaryFolder folder_;
  KeyFolder keys_{(folder_.path() / "base").string()};
};

TEST_F(AuthorityTest, MembersOfAFleetMeetAndStrangersDoNot) {
  const auto authority = Authority::init(keys_, "f", kNow).value();
  const Identity base{
      .fleet = "f", .role = MemberRole::kTop, .system = 0, .id = 1, .name = "base", .rights = {}};
  ASSERT_TRUE(authority.issue_own(base, {"base.local"}, kNow).ok());
  EXPECT_EQ(keys_.load()->identity, base);
  const KeyFolder robot3 = join(authority, robot(3));
  EXPECT_EQ(meet(robot3, keys_), "");

  const KeyFolder other_base((folder_.path() / "other").string());
  const auto other = Authority::init(other_base, "f", kNow).value();
  const KeyFolder stranger = join(other, {.fleet = "f",
                                          .role = MemberRole::kSystem,
                                          .system = 3,
                                          .id = 1,
                                          .name = "stranger",
                                          .rights = {}});
  EXPECT_NE(meet(stranger, keys_), "");
}

TEST_F(AuthorityTest, ARevokedMemberIsRefusedByItsReason) {
  const auto authority = Authority::init(keys_, "f", kNow).value();
  ASSERT_TRUE(authority
                  .issue_own({.fleet = "f",
                              .role = MemberRole::kTop,
                              .system = 0,
                              .id = 1,
                              .name = "base",
                              .rights = {}},
                             {}, kNow)
                  .ok());
  const KeyFolder robot3 = join(authority, robot(3));
  const KeyFolder robot4 = join(authority, robot(4));
  const auto revoked = authority.revoke("robot3", kNow + 5).value();
  ASSERT_EQ(revoked.size(), 1U);
  EXPECT_EQ(authority.list()->number, 2U);
  EXPECT_NE(meet(robot3, keys_).find("robot3) is revoked by list 2"), std::string::npos);
  EXPECT_EQ(meet(robot4, keys_), "");
  ASSERT_TRUE(authority.revoke("robot3", kNow + 6).ok());
  EXPECT_EQ(authority.list()->number, 2U) << "nothing new";
  EXPECT_EQ(authority.revoke("robot5", kNow).error(), Errc::kNoMailbox);
  EXPECT_TRUE(authority.revoke("system/4/1", kNow).ok());
  EXPECT_TRUE(authority.issued()->at(1).revoked);
}

TEST_F(AuthorityTest, ANameThatTwoMembersHaveIsNotRevoked) {
  const auto authority = Authority::init(keys_, "f", kNow).value();
  Identity second = robot(4);
  second.name = "robot3";
  (void)join(authority, robot(3));
  (void)join(authority, second);
  const auto unclear = authority.revoke("robot3", kNow);
  EXPECT_EQ(unclear.error(), Errc::kInvalidArgument);
  EXPECT_NE(unclear.error().detail().find("system/3/1, system/4/1 have the name"),
            std::string::npos)
      << unclear.error().detail();
  EXPECT_EQ(authority.list()->number, 1U);
  const auto serial = authority.issued()->front().certificate.serial();
  EXPECT_EQ(authority.revoke(serial.substr(0, 10), kNow)->size(), 1U);
  EXPECT_EQ(authority.revoke("robot3", kNow)->size(), 2U) << "one of them is left";
}

TEST_F(AuthorityTest, IsMadeOnceAndOpenedAgain) {
  ASSERT_TRUE(Authority::init(keys_, "f", kNow).ok());
  EXPECT_EQ(Authority::init(keys_, "f", kNow).error(), Errc::kAddressInUse);
  EXPECT_EQ(Authority::open(keys_)->fleet(), "f");
  EXPECT_EQ(Authority::open(KeyFolder((folder_.path() / "none").string())).error(),
            Errc::kNoMailbox);
  EXPECT_EQ(Authority::init(KeyFolder((folder_.path() / "x").string()), "a b", kNow).error(),
            Errc::kInvalidArgument);
  for (const std::string file : {"root.key", "issuing.key"})
    EXPECT_EQ(fs::status(keys_.file("authority/" + file)).permissions(), fs::perms(0600));
}

TEST_F(AuthorityTest, DoesNotIssueForAnotherFleet) {
  const auto authority = Authority::init(keys_, "f", kNow).value();
  const auto request = CertificateRequest::make(PrivateKey::generate().value(), {}).value();
  Identity other = robot(3);
  other.fleet = "g";
  EXPECT_FALSE(authority.issue(other, {}, request, kNow).ok());
  other = robot(3);
  other.name = "a/b";
  EXPECT_FALSE(authority.issue(other, {}, request, kNow).ok());
}

TEST_F(AuthorityTest, RotationKeepsOldMembersUntilAllAreRenewed) {
  auto authority = Authority::init(keys_, "f", kNow).value();
  const Identity base{
      .fleet = "f", .role = MemberRole::kTop, .system = 0, .id = 1, .name = "base", .rights = {}};
  ASSERT_TRUE(authority.issue_own(base, {}, kNow).ok());
  const KeyFolder robot3 = join(authority, robot(3));
  const KeyFolder away = join(authority, robot(4));
  ASSERT_TRUE(authority.rotate(kNow + 1).ok());
  EXPECT_EQ(authority.rotate(kNow + 2).error(), Errc::kRefused) << "one at a time";
  EXPECT_EQ(meet(away, keys_), "") << "who has not got the list finds the base as it was";
  EXPECT_TRUE(away.take_over_list(authority.list_bytes().value()).value());
  EXPECT_EQ(meet(away, keys_), "");
  EXPECT_FALSE(has_old_root(robot3.load().value())) << "it does not know of another one";
  EXPECT_TRUE(robot3.take_over_list(authority.list_bytes().value()).value());
  EXPECT_TRUE(has_old_root(robot3.load().value()));

  EXPECT_EQ(authority.of_old_roots()->size(), 3U);
  EXPECT_EQ(authority.finish_rotation(false, kNow + 3).error(), Errc::kRefused);
  const KeyFolder again = join(authority, robot(3));
  EXPECT_FALSE(has_old_root(again.load().value()));
  ASSERT_EQ(authority.of_old_roots()->size(), 2U);
  EXPECT_EQ(authority.of_old_roots()->front().identity.name, "robot4");
  EXPECT_EQ(meet(again, keys_), "") << "half of the fleet is on new keys";
  EXPECT_EQ(meet(away, keys_), "");
  EXPECT_EQ(meet(again, away), "");
  const auto refused = authority.finish_rotation(false, kNow + 3);
  EXPECT_TRUE(refused.error().detail().starts_with("robot4 still")) << refused.error().detail();
  EXPECT_EQ(meet(away, keys_), "") << "the base has not gone ahead";
  ASSERT_TRUE(authority.finish_rotation(true, kNow + 3).ok());
  EXPECT_EQ(keys_.load()->roots, std::vector{authority.root()});
  EXPECT_TRUE(again.take_over_list(authority.list_bytes().value()).value());
  EXPECT_EQ(meet(again, keys_), "");
  EXPECT_NE(meet(away, keys_), "");
}

TEST_F(AuthorityTest, AnInterruptedRotationIsCompletedOrForgotten) {
  {
    auto authority = Authority::init(keys_, "f", kNow).value();
    const KeyFolder& folder = authority.folder();
    const auto& old_root = authority.root();
    // As if it had been killed after the first of its files.
    ASSERT_TRUE(folder.write_secret("root.key.next", PrivateKey::generate()->to_pem()).ok());
    EXPECT_EQ(Authority::open(keys_)->root(), old_root);
  }
  auto authority = Authority::open(keys_).value();
  ASSERT_TRUE(authority.rotate(kNow + 1).ok());
  const KeyFolder folder = authority.folder();
  EXPECT_FALSE(folder.has("root.key.next"));
  // As if it had been killed between two of the last renames.
  ASSERT_TRUE(folder.rename("issuing.key", "issuing.key.next").ok());
  ASSERT_TRUE(folder.rename("issuing.pem", "issuing.pem.next").ok());
  ASSERT_TRUE(folder.write_secret("rotation.complete", "").ok());
  const auto opened = Authority::open(keys_);
  ASSERT_TRUE(opened.ok()) << opened.error().message();
  EXPECT_EQ(opened->root(), authority.root());
  EXPECT_FALSE(folder.has("rotation.complete"));
}

}  // namespace tims::security::authority_test
