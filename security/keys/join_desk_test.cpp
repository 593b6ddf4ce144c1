#include "security/keys/join_desk.h"

#include <gtest/gtest.h>

#include "security/keys/members_fixture.h"
#include "tests/support/temporary_folder.h"

namespace tims::security::join_desk_test {

constexpr std::int64_t kNow = 1'800'000'000;

class JoinDeskTest : public testing::Test {
 protected:
  JoinDeskTest() {
    EXPECT_TRUE(robot_.make().ok());
    EXPECT_TRUE(Tokens(authority_)
                    .add({.hash = hash_,
                          .identity = identity_,
                          .made = kNow,
                          .ends = kNow + Tokens::kLife,
                          .used_by = {}},
                         kNow)
                    .ok());
  }
  JoinRequest request(const KeyFolder& keys, const std::vector<std::string>& uris = {}) {
    const auto key = keys.next_key().value();
    return {.renews = false,
            .token = token_id(hash_),
            .proof = join_proof(hash_, asker_.keys),
            .pem = CertificateRequest::make(key, uris).value().to_pem()};
  }
  std::string refused(const JoinRequest& request, std::int64_t now = kNow) {
    return desk_.answer(request, asker_, now).refused;
  }
  static bool says(const std::string& text, std::string_view part) {
    return text.find(part) != std::string::npos;
  }

  test::TemporaryFolder folder_;
  KeyFolder base_{(folder_.path() / "base").string()};
  KeyFolder robot_{(folder_.path() / "robot").string()};
  Authority authority_ = Authority::init(base_, "f", kNow).value();
  JoinDesk desk_{base_};
  Digest hash_ = hash_of_secret(view_of("secret"));
  Identity identity_ = robot(3);
  Asker asker_{.source = "10.9.1.3", .keys = Bytes(32), .proven = {}};
};

TEST_F(JoinDeskTest, WhoHasTheSecretJoins) {
  const JoinAnswer answer = desk_.answer(request(robot_), asker_, kNow + 5);
  ASSERT_EQ(answer.refused, "");
  const auto read = JoinAnswer::parse(answer.encode()).value();
  std::array<std::byte, 16> root{};
  std::copy_n(authority_.root().fingerprint().begin(), 16, root.begin());
  EXPECT_EQ(take_over(robot_, read, root).value(), identity_);
  EXPECT_EQ(robot_.load()->identity, identity_);
  EXPECT_EQ(robot_.load()->list_number(), 1U);
  EXPECT_EQ(authority_.issued()->size(), 1U);
}

TEST_F(JoinDeskTest, ALostAnswerIsAskedForAgainAndNothingIsIssuedTwice) {
  const JoinAnswer first = desk_.answer(request(robot_), asker_, kNow);
  const JoinAnswer second = desk_.answer(request(robot_), asker_, kNow + 10);
  EXPECT_EQ(second.refused, "");
  EXPECT_EQ(first.chain, second.chain);
  EXPECT_EQ(authority_.issued()->size(), 1U);
  const KeyFolder other((folder_.path() / "other").string());
  ASSERT_TRUE(other.make().ok());
  EXPECT_TRUE(says(refused(request(other)),
                   "was used already: make a new one on the base: timsctl token new --role system "
                   "--system 3 --id 1"));
}

TEST_F(JoinDeskTest, AKilledBaseHasMarkedTheTokenOnlyAndTheRetryWorks) {
  auto token = Tokens(authority_).find(token_id(hash_)).value();
  token.used_by = robot_.next_key()->public_key_hash();
  ASSERT_TRUE(Tokens(authority_).store(token).ok());
  EXPECT_EQ(refused(request(robot_)), "");
}

TEST_F(JoinDeskTest, LateWrongOrForAnother) {
  EXPECT_EQ(refused(request(robot_), kNow + 3600), "") << "the last second";
  EXPECT_TRUE(says(refused(request(robot_), kNow + 3601), "is 60 min old and has ended"));
  JoinRequest wrong = request(robot_, {"tims://f/system/4/1"});
  EXPECT_TRUE(says(refused(wrong), "is for system 3, id 1 (robot3), not for tims://f/system/4/1"));
  wrong = request(robot_);
  wrong.pem = "x";
  EXPECT_TRUE(says(refused(wrong), "no request for a certificate"));
  wrong = request(robot_);
  wrong.token = "../root";
  EXPECT_TRUE(says(refused(wrong), "no token"));
}

TEST_F(JoinDeskTest, AProofOfAnotherConnectionIsWrong) {
  JoinRequest forwarded = request(robot_);
  asker_.keys[5] = std::byte{1};
  EXPECT_TRUE(says(refused(forwarded), "no token " + token_id(hash_)));
  ASSERT_TRUE(Tokens(authority_).remove(token_id(hash_)).ok());
  EXPECT_TRUE(says(refused(request(robot_)), "it was revoked"));
}

TEST_F(JoinDeskTest, GuessesAreLimitedForEachAddress) {
  JoinRequest guess = request(robot_);
  guess.proof[0] ^= std::byte{1};
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(says(refused(guess), "no token"));
  EXPECT_TRUE(says(refused(guess), "wait a minute"));
  EXPECT_TRUE(says(refused(request(robot_)), "wait a minute")) << "also with the right one";
  asker_.source = "10.9.1.4";
  EXPECT_TRUE(says(refused(guess), "no token"));
  asker_.source = "10.9.1.3";
  EXPECT_EQ(refused(request(robot_), kNow + 61), "");
}

TEST_F(JoinDeskTest, GuessesFromManyAddressesTakeLittleMemory) {
  GuessLimit limit;
  for (int i = 0; i < 3000; ++i) limit.count(std::to_string(i), kNow);
  EXPECT_FALSE(limit.allows("new", kNow)) << "those beyond the limit count as one";
  EXPECT_TRUE(limit.allows("0", kNow));
  EXPECT_TRUE(limit.allows("new", kNow + 61));
}

TEST_F(JoinDeskTest, WhoRenewsShowsACertificateThatIsNotRevoked) {
  ASSERT_TRUE(take_over(robot_, desk_.answer(request(robot_), asker_, kNow), {}).ok());
  const auto former = robot_.load()->chain.front();
  JoinRequest renewal = request(robot_);
  renewal.renews = true;
  EXPECT_TRUE(says(refused(renewal), "must show its present certificate"));
  asker_.proven = former;
  const JoinAnswer answer = desk_.answer(renewal, asker_, kNow + 9);
  ASSERT_EQ(answer.refused, "");
  ASSERT_TRUE(take_over(robot_, answer, {}).ok());
  EXPECT_NE(robot_.load()->chain.front(), former);
  EXPECT_EQ(robot_.load()->identity, identity_);
  JoinRequest other = request(robot_, {"tims://f/system/4/1"});
  other.renews = true;
  EXPECT_TRUE(says(refused(other), "has the names of the present one"));
  ASSERT_TRUE(authority_.revoke("robot3", kNow).ok());
  EXPECT_TRUE(says(refused(renewal), "is revoked"));
}

TEST_F(JoinDeskTest, AnswersOfAnotherAuthorityAreNotTakenOver) {
  const JoinAnswer answer = desk_.answer(request(robot_), asker_, kNow);
  EXPECT_FALSE(take_over(robot_, answer, std::array<std::byte, 16>{}).ok());
  const KeyFolder other_base((folder_.path() / "other").string());
  const auto other = Authority::init(other_base, "f", kNow).value();
  JoinAnswer mixed = answer;
  mixed.roots = other.root().to_pem();
  EXPECT_FALSE(take_over(robot_, mixed, {}).ok());
  mixed.list = other.list_bytes().value();
  EXPECT_FALSE(take_over(robot_, mixed, {}).ok());
  EXPECT_FALSE(robot_.has("identity.pem"));
  EXPECT_EQ(
      take_over(robot_, {.refused = "because", .chain = {}, .roots = {}, .list = {}}, {}).error(),
      Errc::kRefused);
}

TEST_F(JoinDeskTest, RequestsAndAnswersAreReadBackAndCutOnesRefused) {
  const JoinRequest asked = request(robot_);
  const Bytes bytes = asked.encode();
  EXPECT_EQ(JoinRequest::parse(bytes)->encode(), bytes);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(JoinRequest::parse(View(bytes).first(size)).ok());
  EXPECT_FALSE(JoinAnswer::parse({}).ok());
  EXPECT_EQ(
      JoinAnswer::parse(JoinAnswer{.refused = "why", .chain = {}, .roots = {}, .list = {}}.encode())
          ->refused,
      "why");
}

}  // namespace tims::security::join_desk_test
