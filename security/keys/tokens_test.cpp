#include "security/keys/tokens.h"

#include <gtest/gtest.h>

#include "security/keys/join_text.h"
#include "security/keys/members_fixture.h"
#include "tests/support/temporary_folder.h"

namespace tims::security::tokens_test {

constexpr std::int64_t kNow = 1'800'000'000;

Token token(std::uint8_t number) {
  return {.hash = hash_of_secret(Bytes{std::byte{number}}),
          .identity = robot(number),
          .made = kNow,
          .ends = kNow + Tokens::kLife,
          .used_by = {}};
}

TEST(Token, IsReadBack) {
  Token one = token(3);
  EXPECT_EQ(Token::parse(one.to_string()).value(), one);
  one.used_by = sha256(view_of("key"));
  EXPECT_EQ(Token::parse(one.to_string()).value(), one);
  EXPECT_TRUE(token(3).is_open(kNow + 3600));
  EXPECT_FALSE(token(3).is_open(kNow + 3601));
  EXPECT_FALSE(one.is_open(kNow));
}

TEST(Token, HalfAFileIsNone) {
  const std::string text = token(3).to_string();
  for (std::size_t size = 0; size < text.size(); ++size)
    EXPECT_FALSE(Token::parse(text.substr(0, size)).ok()) << size;
  EXPECT_FALSE(Token::parse(text + "x").ok());
  EXPECT_FALSE(Token::parse("colour red\n" + text).ok());
}

class TokensTest : public testing::Test {
 protected:
  test::TemporaryFolder folder_;
  KeyFolder keys_{(folder_.path() / "base").string()};
  Authority authority_ = Authority::init(keys_, "f", kNow).value();
  Tokens tokens_{authority_};
};

TEST_F(TokensTest, AreListedFoundAndRevoked) {
  ASSERT_TRUE(tokens_.add(token(3), kNow).ok());
  ASSERT_TRUE(tokens_.add(token(4), kNow).ok());
  EXPECT_EQ(tokens_.all()->size(), 2U);
  EXPECT_EQ(tokens_.find(token(3).id()).value(), token(3));
  EXPECT_TRUE(tokens_.remove(token(3).id()).ok());
  EXPECT_EQ(tokens_.remove(token(3).id()).error(), Errc::kNoMailbox);
  EXPECT_EQ(tokens_.find(token(3).id()).error(), Errc::kNoMailbox);
  EXPECT_EQ(tokens_.find("../root").error(), Errc::kNoMailbox);
  EXPECT_EQ(tokens_.remove("../root.key").error(), Errc::kNoMailbox);
  ASSERT_TRUE(authority_.folder().write_secret("tokens/0123abcd.new", "half").ok());
  EXPECT_EQ(tokens_.all()->size(), 1U);
}

TEST_F(TokensTest, OldOnesAreForgottenADayLater) {
  ASSERT_TRUE(tokens_.add(token(3), kNow).ok());
  ASSERT_TRUE(tokens_.add(token(4), token(3).ends + 86399).ok());
  EXPECT_EQ(tokens_.all()->size(), 2U);
  ASSERT_TRUE(tokens_.add(token(5), token(3).ends + 86400).ok());
  EXPECT_EQ(tokens_.all()->size(), 1U);
}

}  // namespace tims::security::tokens_test
