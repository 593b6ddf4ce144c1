#include "security/keys/join_text.h"

#include <gtest/gtest.h>

namespace tims::security::join_text_test {

JoinText sample() {
  JoinText text{.hosts = {"10.9.1.1"}, .port = 2011, .root = {}, .secret = {}};
  for (std::size_t i = 0; i < 16; ++i) {
    text.root[i] = static_cast<std::byte>(i * 17);
    text.secret[i] = static_cast<std::byte>(255 - i);
  }
  return text;
}

TEST(JoinText, IsReadBack) {
  JoinText text = sample();
  EXPECT_EQ(text.to_string().size(), 70U) << text.to_string();
  EXPECT_EQ(JoinText::parse(text.to_string()).value(), text);
  EXPECT_EQ(JoinText::parse("  " + text.to_string() + "\r\n").value(), text);
  text.hosts = {"10.9.1.1", "fe80::1%eth0", "base.local", "2001:db8::2"};
  text.port = 65535;
  EXPECT_EQ(JoinText::parse(text.to_string()).value(), text);
}

TEST(JoinText, EveryWrongCharacterIsSeenAndTheSecretIsNotRepeated) {
  const std::string right = sample().to_string();
  const std::size_t code = right.rfind('/') + 1;
  for (std::size_t i = code; i < right.size(); ++i) {
    std::string wrong = right;
    wrong[i] = wrong[i] == 'A' ? 'B' : 'A';
    const auto parsed = JoinText::parse(wrong);
    ASSERT_FALSE(parsed.ok()) << i;
    EXPECT_EQ(parsed.error().detail().find(wrong.substr(code, 10)), std::string::npos);
  }
  for (std::size_t size = 0; size < right.size(); ++size)
    EXPECT_FALSE(JoinText::parse(right.substr(0, size)).ok()) << size;
  EXPECT_FALSE(JoinText::parse(right + "A").ok());
}

TEST(JoinText, ThePlaceIsChecked) {
  const std::string code = sample().to_string().substr(sample().to_string().rfind('/'));
  for (const std::string place : {"", ":2011", "a", "a:0", "a:65536", "a,:1", ",a:1", "a b:1",
                                  "::1:1", "[]:1", "a,b,c,d,e:1"})
    EXPECT_FALSE(JoinText::parse("tims-join:" + place + code).ok()) << place;
  EXPECT_TRUE(JoinText::parse("tims-join:a,b,c,d:1" + code).ok());
  EXPECT_TRUE(JoinText::parse("tims-join:[::1]:1" + code).ok());
  EXPECT_FALSE(JoinText::parse("tims-join:" + std::string(254, 'a') + ":1" + code).ok());
}

TEST(JoinText, AProofIsBoundToItsConnection) {
  const Digest hash = hash_of_secret(sample().secret);
  EXPECT_EQ(token_id(hash).size(), 8U);
  EXPECT_NE(join_proof(hash, view_of("one")), join_proof(hash, view_of("two")));
}

}  // namespace tims::security::join_text_test
