#include "security/keys/join_desk.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "security/keys/members_fixture.h"
#include "tests/support/folder_contents.h"
#include "tests/support/temporary_folder.h"

namespace tims::security::join_desk_test {

using testing::HasSubstr;
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
  EXPECT_EQ(take_over(robot_, read, {.root = root}).value(), identity_);
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
  EXPECT_FALSE(take_over(robot_, answer, {.root = std::array<std::byte, 16>{}}).ok());
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

// A member that answers for the authority of its fleet, with an authority of its own.
class RenewalTest : public JoinDeskTest {
 protected:
  RenewalTest() {
    EXPECT_TRUE(take_over(robot_, desk_.answer(request(robot_), asker_, kNow), {}).ok());
    EXPECT_TRUE(robot_.next_key().ok());
    asker_.proven = robot_.load()->chain.front();
  }
  static JoinAnswer issued_by(const Authority& authority, const Identity& identity,
                              const KeyFolder& member) {
    const auto csr = CertificateRequest::make(member.next_key().value(), {}).value();
    return {.refused = {},
            .chain = to_pem(authority.issue(identity, {}, csr, kNow).value()),
            .roots = to_pem(authority.list()->roots),
            .list = authority.list_bytes().value()};
  }
  JoinAnswer genuine() {
    JoinRequest renewal = request(robot_);
    renewal.renews = true;
    return desk_.answer(renewal, asker_, kNow);
  }
  // Why it is refused; the folder must be as before.
  std::string refusal_of(const JoinAnswer& answer) {
    const auto before = test::contents_of(robot_.path());
    const auto taken = take_over(robot_, answer, {.identity = identity_});
    EXPECT_TRUE(test::contents_of(robot_.path()) == before);
    return taken ? "" : taken.error().detail();
  }

  Authority impostor_ =
      Authority::init(KeyFolder((folder_.path() / "impostor").string()), "f", kNow).value();
};

TEST_F(RenewalTest, NoOtherAuthorityIsBelieved) {
  const JoinAnswer forged = issued_by(impostor_, identity_, robot_);
  EXPECT_THAT(refusal_of(forged),
              HasSubstr("believes another authority of the fleet f: list of the fleet: is not "
                        "signed by this fleet's authority"));
  JoinAnswer mixed = genuine();
  mixed.chain = forged.chain;
  EXPECT_THAT(refusal_of(mixed), HasSubstr("comes from no root that " + robot_.path()));
  mixed.roots = forged.roots;
  EXPECT_THAT(refusal_of(mixed), HasSubstr("comes from no root")) << "its own roots do not count";
  mixed = genuine();
  mixed.list = forged.list;
  EXPECT_THAT(refusal_of(mixed), HasSubstr("is not signed by this fleet's authority"));
  mixed.list.clear();
  EXPECT_THAT(refusal_of(mixed), HasSubstr("list of the fleet: is none"));
  mixed = genuine();
  mixed.roots = forged.roots;
  EXPECT_EQ(take_over(robot_, mixed, {.identity = identity_}).value(), identity_);
  EXPECT_EQ(robot_.load()->roots, std::vector{authority_.root()});
}

TEST_F(RenewalTest, ANewListCountsForTheRootsAlsoInTheSameAnswer) {
  ASSERT_TRUE(authority_.rotate(kNow + 1).ok());
  // The list with the new root is signed by the old one; the certificate is the new one's.
  const JoinAnswer of_new_root = issued_by(authority_, identity_, robot_);
  ASSERT_EQ(take_over(robot_, of_new_root, {.identity = identity_}).value(), identity_);
  EXPECT_TRUE(authority_.root().has_signed(robot_.load()->chain.back()));
  ASSERT_TRUE(authority_.finish_rotation(true, kNow + 2).ok());
  ASSERT_EQ(
      take_over(robot_, issued_by(authority_, identity_, robot_), {.identity = identity_}).value(),
      identity_);
  EXPECT_EQ(robot_.load()->roots, std::vector{authority_.root()});
}

TEST_F(RenewalTest, ARootThatIsBelievedNoLongerDoesNotComeBack) {
  const JoinAnswer of_old_root = genuine();
  ASSERT_TRUE(authority_.rotate(kNow + 1).ok());
  ASSERT_TRUE(robot_.take_over_list(authority_.list_bytes().value()).value());
  ASSERT_TRUE(authority_.finish_rotation(true, kNow + 2).ok());
  JoinAnswer mixed = of_old_root;
  mixed.list = authority_.list_bytes().value();
  EXPECT_THAT(refusal_of(mixed), HasSubstr("comes from no root")) << "not of those of the new list";
  ASSERT_TRUE(robot_.take_over_list(mixed.list).value());
  EXPECT_THAT(refusal_of(of_old_root), HasSubstr("is not signed by this fleet's authority"));
}

TEST_F(RenewalTest, TheListDoesNotGoBack) {
  const JoinAnswer first = genuine();
  ASSERT_TRUE(authority_.revoke("system/3/1", kNow).ok());
  ASSERT_TRUE(robot_.take_over_list(authority_.list_bytes().value()).value());
  ASSERT_EQ(take_over(robot_, first, {.identity = identity_}).value(), identity_);
  EXPECT_EQ(robot_.load()->list_number(), 2U);
  // Neither by files, whatever a person decides: it is the same authority.
  for (const bool another_fleet : {false, true}) {
    JoinAnswer again = issued_by(authority_, identity_, robot_);
    again.list = first.list;
    ASSERT_EQ(take_over(robot_, again, {.another_fleet = another_fleet}).value(), identity_);
    EXPECT_EQ(robot_.load()->list_number(), 2U);
  }
}

TEST_F(RenewalTest, OnlyOfTheSameMember) {
  EXPECT_EQ(refusal_of(issued_by(authority_, robot(4), robot_)),
            "the certificate is that of system 4, id 1 (robot4), not of system 3, id 1 (robot3)");
  // A stick may bring another identity of the same authority.
  EXPECT_EQ(take_over(robot_, issued_by(authority_, robot(4), robot_), {}).value(), robot(4));
}

TEST_F(RenewalTest, AnotherFleetIsEnteredOnlyByAPersonsDecision) {
  const JoinAnswer other = issued_by(impostor_, identity_, robot_);
  const auto before = test::contents_of(robot_.path());
  EXPECT_EQ(take_over(robot_, other, {}).error(), Errc::kRefused);
  EXPECT_TRUE(test::contents_of(robot_.path()) == before);
  ASSERT_TRUE(take_over(robot_, other, {.another_fleet = true}).ok());
  EXPECT_EQ(robot_.load()->roots, std::vector{impostor_.root()});
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
