// Power failure, a full disk and a read-only one at each step of making, joining, renewing,
// revoking and rotating: what is on the disk always works, and the next attempt succeeds.
#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>

#include "security/keys/interrupted_fixture.h"
#include "security/keys/join_desk.h"
#include "security/keys/members_fixture.h"
#include "tests/support/patience.h"
#include "tests/support/temporary_folder.h"

namespace tims::security::interrupted_test {

namespace fs = std::filesystem;
constexpr std::int64_t kNow = 1'800'000'000;
// Of the steps of a work, builds with sanitizers try some: each costs them a process.
constexpr int kStride = test::kSlowdown == 1 ? 1 : 5;

Identity base_identity() {
  return {
      .fleet = "f", .role = MemberRole::kTop, .system = 0, .id = 1, .name = "base", .rights = {}};
}

class InterruptedTest : public testing::TestWithParam<Interruption> {
 protected:
  using Work = std::function<bool()>;

  // Interrupts `work` at each of its steps, from the same state each time; then `check` looks at
  // what is left, and `work` is done again.
  void at_each_step(const Work& work, const std::function<void()>& check) {
    const fs::path kept = folder_.path() / "kept";
    const fs::path used = folder_.path() / "used";
    if (!fs::exists(used)) fs::create_directory(used);
    copy(used, kept);
    int steps = 0;
    for (bool reached = true; reached; steps += kStride) {
      copy(kept, used);
      const Interrupted interrupted = run_interrupted(work, GetParam(), steps);
      reached = interrupted.reached;
      SCOPED_TRACE(testing::Message() << "step " << steps);
      ASSERT_NO_FATAL_FAILURE(check());
      ASSERT_TRUE(interrupted.succeeded || work()) << "the next attempt";
      ASSERT_NO_FATAL_FAILURE(check());
    }
    EXPECT_GT(steps, 3);
  }
  static void copy(const fs::path& from, const fs::path& to) {
    fs::remove_all(to);
    fs::copy(from, to, fs::copy_options::recursive);
  }

  void make_base() {
    auto authority = Authority::init(base_, "f", kNow).value();
    ASSERT_TRUE(authority.issue_own(base_identity(), {}, kNow).ok());
  }
  bool add_token() {
    return Tokens(Authority::open(base_).value())
        .add(
            {.hash = hash_, .identity = robot(3), .made = kNow, .ends = kNow + 3600, .used_by = {}},
            kNow)
        .ok();
  }
  // Both sides in one process.
  bool join(bool renews) {
    JoinDesk desk(base_);
    if (!robot_.make()) return false;
    const auto key = robot_.next_key();
    if (!key) return false;
    Asker asker{.source = "10.9.1.3", .keys = Bytes(32), .proven = {}};
    if (renews) asker.proven = robot_.load()->chain.front();
    const JoinRequest request{.renews = renews,
                              .token = token_id(hash_),
                              .proof = join_proof(hash_, asker.keys),
                              .pem = CertificateRequest::make(*key, {}).value().to_pem()};
    // Interrupted after its last step but one, the first join is complete, and its token used.
    return take_over(robot_, desk.answer(request, asker, kNow), {}).ok() ||
           (!renews && robot_.load().ok());
  }
  static void expect_member(const KeyFolder& keys, const Identity& identity) {
    const auto own = keys.load();
    ASSERT_TRUE(own.ok()) << own.error().message();
    EXPECT_EQ(own->identity, identity);
    const auto root = std::ranges::find_if(
        own->roots, [&](const Certificate& one) { return one.has_signed(own->chain.back()); });
    EXPECT_NE(root, own->roots.end()) << "its root is believed";
  }

  test::TemporaryFolder folder_;
  KeyFolder base_{(folder_.path() / "used" / "base").string()};
  KeyFolder robot_{(folder_.path() / "used" / "robot").string()};
  Digest hash_ = hash_of_secret(view_of("secret"));
};

TEST_P(InterruptedTest, MakingAnAuthority) {
  at_each_step(
      [&] {
        const auto made =
            Authority::exists(base_) ? Authority::open(base_) : Authority::init(base_, "f", kNow);
        return made.ok() && made->issue_own(base_identity(), {}, kNow).ok();
      },
      [] {});
  expect_member(base_, base_identity());
}

TEST_P(InterruptedTest, Joining) {
  fs::create_directory(folder_.path() / "used");
  make_base();
  ASSERT_TRUE(add_token());
  at_each_step([&] { return join(false); },
               [&] {
                 if (robot_.has("identity.pem")) expect_member(robot_, robot(3));
                 const auto issued = Authority::open(base_)->issued();
                 ASSERT_TRUE(issued.ok()) << issued.error().message();
                 EXPECT_LE(issued->size(), 2U) << "one for the base, one for the robot";
               });
  expect_member(robot_, robot(3));
}

TEST_P(InterruptedTest, Renewing) {
  fs::create_directory(folder_.path() / "used");
  make_base();
  ASSERT_TRUE(add_token() && join(false));
  at_each_step([&] { return join(true); }, [&] { expect_member(robot_, robot(3)); });
}

TEST_P(InterruptedTest, Revoking) {
  fs::create_directory(folder_.path() / "used");
  make_base();
  ASSERT_TRUE(add_token() && join(false));
  at_each_step([&] { return Authority::open(base_)->revoke("robot3", kNow + 1).ok(); },
               [&] { expect_member(base_, base_identity()); });
  EXPECT_TRUE(base_.load()->list->revokes(robot_.load()->chain.front()));
  at_each_step([&] { return robot_.take_over_list(base_.load()->list_bytes).ok(); },
               [&] { expect_member(robot_, robot(3)); });
}

TEST_P(InterruptedTest, Rotating) {
  fs::create_directory(folder_.path() / "used");
  make_base();
  ASSERT_TRUE(add_token() && join(false));
  at_each_step(
      [&] {
        auto authority = Authority::open(base_);
        if (!authority) return false;
        // An interrupted rotation that nothing came from is forgotten first, as its message says.
        const bool half = authority->list()->roots.size() > 1;
        const bool used = half && authority->list()->roots.back() == authority->root();
        if (half && !used && !authority->finish_rotation(true, kNow + 1)) return false;
        return used || authority->rotate(kNow + 1).ok();
      },
      [&] {
        expect_member(base_, base_identity());
        expect_member(robot_, robot(3));
        const auto authority = Authority::open(base_);
        ASSERT_TRUE(authority.ok()) << authority.error().message();
        const auto roots = authority->list()->roots;
        EXPECT_NE(std::ranges::find(roots, authority->root()), roots.end())
            << "what it issues is believed";
      });
  // The list reaches the robot; then everybody renews, and the old root goes.
  at_each_step([&] { return robot_.take_over_list(base_.load()->list_bytes).ok(); },
               [&] { expect_member(robot_, robot(3)); });
  ASSERT_TRUE(Authority::open(base_)->issue_own(base_identity(), {}, kNow + 2).ok());
  ASSERT_TRUE(join(true));
  at_each_step([&] { return Authority::open(base_)->finish_rotation(false, kNow + 3).ok(); },
               [&] { expect_member(base_, base_identity()); });
  at_each_step([&] { return robot_.take_over_list(base_.load()->list_bytes).ok(); },
               [&] { expect_member(robot_, robot(3)); });
  EXPECT_EQ(robot_.load()->roots.size(), 1U);
}

INSTANTIATE_TEST_SUITE_P(Each, InterruptedTest,
                         testing::Values(Interruption::kKill, Interruption::kNoSpace,
                                         Interruption::kReadOnly),
                         [](const auto& one) {
                           return one.param == Interruption::kKill      ? "Killed"
                                  : one.param == Interruption::kNoSpace ? "DiskFull"
                                                                        : "ReadOnly";
                         });

}  // namespace tims::security::interrupted_test
