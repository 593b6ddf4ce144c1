#include "security/keys/dialled.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "security/crypto/tls_fixture.h"
#include "security/keys/authority.h"
#include "security/keys/members_fixture.h"
#include "tests/support/temporary_folder.h"

namespace tims::security::dialled_test {

using testing::HasSubstr;
constexpr std::int64_t kNow = 1'800'000'000;

class DialledTest : public testing::Test {
 protected:
  KeyFolder joined(const Identity& who, const std::vector<std::string>& hosts) {
    KeyFolder keys((folder_.path() / who.name).string());
    EXPECT_TRUE(authority_.issue_to(keys, who, hosts, kNow).ok());
    return keys;
  }
  // "" or why whoever dials this refuses the router with these keys.
  static std::string refusal_of(const Dialled& dialled, const KeyFolder& router) {
    const auto refusal = judge_dialled(dialled, router.load()->chain.front());
    return refusal ? refusal->text : "";
  }

  test::TemporaryFolder folder_;
  Authority authority_ =
      Authority::init(KeyFolder((folder_.path() / "base").string()), "f", kNow).value();
  const KeyFolder harbour_ = joined(
      {.fleet = "f", .role = MemberRole::kTop, .system = 0, .id = 1, .name = "base", .rights = {}},
      {"Harbour.local", "10.9.1.1", "fd00::1"});
  const KeyFolder robot3_ = joined(robot(3), {"10.9.1.3"});
  const KeyFolder by_stick_ = joined(robot(4), {});
};

TEST_F(DialledTest, IsTheRouterWhoseCertificateHasTheHost) {
  for (const char* host : {"harbour.local", "HARBOUR.LOCAL", "10.9.1.1", "fd00::1", "fd00:0::0:1"})
    EXPECT_EQ(refusal_of({.host = host}, harbour_), "") << host;
  for (const char* host : {"harbour", "harbour.local.", "10.9.1.11", "10.9.1.3", "fd00::2", "",
                           "base", "*.local", "::ffff:10.9.1.1"})
    EXPECT_NE(refusal_of({.host = host}, harbour_), "") << host;
}

TEST_F(DialledTest, AnotherRouterOfTheFleetDoesNotAnswerForIt) {
  EXPECT_EQ(refusal_of({.host = "10.9.1.1"}, robot3_),
            "the router there is system 3, id 1 (robot3), and its certificate is for 10.9.1.3, not "
            "for 10.9.1.1: if it is the one that you mean, write HOST:PORT/robot3");
  EXPECT_THAT(refusal_of({.host = "10.9.1.1"}, by_stick_),
              HasSubstr("its certificate is for no address, not for 10.9.1.1"));
}

TEST_F(DialledTest, IsTheOneThatIsNamedWhereverItIs) {
  EXPECT_EQ(refusal_of({.host = "198.51.100.7", .name = "robot3"}, robot3_), "");
  EXPECT_EQ(refusal_of({.host = "198.51.100.7", .name = "robot4"}, by_stick_), "");
  for (const char* host : {"10.9.1.3", "127.0.0.1"})
    EXPECT_EQ(refusal_of({.host = host, .name = "base"}, robot3_),
              "the router there is system 3, id 1 (robot3), not \"base\"")
        << "a name counts everywhere";
  EXPECT_NE(refusal_of({.host = "10.9.1.3", .name = "Robot3"}, robot3_), "");
}

TEST_F(DialledTest, AtLoopbackAnyRouterButNoUser) {
  for (const char* host : {"127.0.0.1", "127.3.2.1", "::1", "localhost", "LocalHost"})
    EXPECT_EQ(refusal_of({.host = host}, robot3_), "") << host;
  for (const char* host : {"128.0.0.1", "::2", "localhost.example", "126.0.0.1"})
    EXPECT_NE(refusal_of({.host = host}, robot3_), "") << host;
  const KeyFolder anna = joined(
      {.fleet = "f", .role = MemberRole::kUser, .name = "anna", .rights = {.look = true}}, {});
  EXPECT_EQ(refusal_of({.host = "127.0.0.1"}, anna),
            "the certificate there is that of user anna, not of a router");
}

// The handshake itself fails, so no byte of the program is sent.
TEST_F(DialledTest, NothingPassesToAnother) {
  const auto dialled = [&](const std::string& host) {
    TlsSession server(
        TlsContext::make(member_settings(robot3_.load().value(), TlsSettings::Side::kServer))
            .value());
    TlsSession client(
        TlsContext::make(dialling_settings(harbour_.load().value(), {.host = host})).value());
    converse(client, server);
    EXPECT_EQ(client.write(view_of("password")), client.error().empty());
    return client.error();
  };
  EXPECT_EQ(dialled("10.9.1.3"), "");
  EXPECT_THAT(dialled("10.9.1.4"), HasSubstr("the router there is system 3"));
  // And it must be a member: one of another fleet has no say about its hosts.
  authority_ = Authority::init(KeyFolder((folder_.path() / "other").string()), "f", kNow).value();
  const KeyFolder stranger = joined({.fleet = "f",
                                     .role = MemberRole::kSystem,
                                     .system = 3,
                                     .id = 1,
                                     .name = "stranger",
                                     .rights = {}},
                                    {"10.9.1.3"});
  TlsSession server(
      TlsContext::make(member_settings(stranger.load().value(), TlsSettings::Side::kServer))
          .value());
  TlsSession client(
      TlsContext::make(dialling_settings(harbour_.load().value(), {.host = "10.9.1.3"})).value());
  converse(client, server);
  EXPECT_NE(client.error(), "");
}

}  // namespace tims::security::dialled_test
