#include "router/io/http/logins.h"

#include <gtest/gtest.h>

#include "security/crypto/tls_fixture.h"

namespace tims::io {
namespace logins_test {

using namespace std::chrono_literals;

class LoginsTest : public testing::Test {
 protected:
  Person anna_{.name = "anna", .rights = rights_up_to(Right::kDrive)};
  int counter_ = 0;
  Logins logins_{[this](std::span<std::byte> out) {
    ++counter_;
    for (std::byte& byte : out) byte = static_cast<std::byte>(counter_);
    out[0] = static_cast<std::byte>(counter_ / 256);
  }};
  Time now_{1h};
};

TEST_F(LoginsTest, ATokenWorksOnce) {
  const std::string token = logins_.offer(now_, anna_);
  EXPECT_EQ(token.size(), 32U);
  EXPECT_EQ(logins_.use(now_, token), nullptr) << "a token is no session";
  const auto session = logins_.redeem(now_, token);
  ASSERT_TRUE(session);
  EXPECT_NE(*session, token);
  EXPECT_EQ(logins_.use(now_, *session)->name, "anna");
  EXPECT_FALSE(logins_.redeem(now_, token));
  EXPECT_FALSE(logins_.redeem(now_, *session)) << "a session is no token";
}

TEST_F(LoginsTest, ATokenEndsAfterItsTime) {
  const std::string in_time = logins_.offer(now_, anna_);
  const std::string late = logins_.offer(now_, anna_);
  EXPECT_TRUE(logins_.redeem(now_ + Logins::kTokenTime - 1ns, in_time));
  EXPECT_FALSE(logins_.redeem(now_ + Logins::kTokenTime, late));
}

TEST_F(LoginsTest, ASessionEndsWhenItIsIdle) {
  const std::string session = logins_.begin(now_, anna_);
  now_ += Logins::kIdleTime - 1ns;
  EXPECT_NE(logins_.use(now_, session), nullptr);
  now_ += Logins::kIdleTime - 1ns;
  EXPECT_NE(logins_.use(now_, session), nullptr) << "it was used";
  now_ += Logins::kIdleTime;
  EXPECT_EQ(logins_.use(now_, session), nullptr);
}

TEST_F(LoginsTest, GuessesFail) {
  const std::string session = logins_.begin(now_, anna_);
  for (const std::string& guess :
       {std::string(), session.substr(1), session + "0", std::string(32, '0')})
    EXPECT_EQ(logins_.use(now_, guess), nullptr) << guess;
}

TEST_F(LoginsTest, OnesThatHaveLeftOrAreRevokedAreGone) {
  const std::string left = logins_.begin(now_, anna_);
  const std::string stays = logins_.begin(now_, {.name = "uid 1000"});
  const auto certificate = security::test_root("any").certificate;
  anna_.certificate = certificate;
  const std::string revoked = logins_.begin(now_, anna_);
  const std::string token = logins_.offer(now_, anna_);
  logins_.end(left);
  logins_.end_if([&](const Person& person) { return person.certificate == certificate; });
  EXPECT_EQ(logins_.use(now_, left), nullptr);
  EXPECT_EQ(logins_.use(now_, revoked), nullptr);
  EXPECT_FALSE(logins_.redeem(now_, token));
  EXPECT_NE(logins_.use(now_, stays), nullptr);
}

TEST_F(LoginsTest, BeyondTheLimitTheOldestEnds) {
  const std::string first = logins_.begin(now_, anna_);
  for (std::size_t i = 1; i < Logins::kSessionsMax; ++i) logins_.begin(now_ + 1s, anna_);
  EXPECT_EQ(logins_.sessions(), Logins::kSessionsMax);
  EXPECT_NE(logins_.use(now_, first), nullptr);
  const std::string last = logins_.begin(now_ + 1s, anna_);
  EXPECT_EQ(logins_.sessions(), Logins::kSessionsMax);
  EXPECT_EQ(logins_.use(now_, first), nullptr);
  EXPECT_NE(logins_.use(now_, last), nullptr);
}

}  // namespace logins_test
}  // namespace tims::io
