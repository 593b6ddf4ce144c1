#include "security/keys/key_folder.h"

#include <filesystem>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "security/keys/authority.h"
#include "security/keys/members_fixture.h"
#include "tests/support/temporary_folder.h"

namespace tims::security::key_folder_test {

namespace fs = std::filesystem;
constexpr std::int64_t kNow = 1'800'000'000;

class KeyFolderTest : public testing::Test {
 protected:
  KeyFolderTest() {
    authority_.emplace(Authority::init(base_, "f", kNow).value());
    EXPECT_TRUE(robot_.make().ok());
    EXPECT_TRUE(join().ok());
  }
  Result<void> join() {
    const auto key = robot_.next_key().value();
    return robot_.take_over(certificate_for(key), {authority_->root()});
  }
  std::vector<Certificate> certificate_for(const PrivateKey& key) {
    const auto request = CertificateRequest::make(key, identity_.uris()).value();
    return authority_->issue(identity_, {}, request, kNow).value();
  }
  void expect_refused(std::string_view text) {
    const auto loaded = robot_.load();
    ASSERT_FALSE(loaded.ok());
    EXPECT_NE(loaded.error().detail().find(text), std::string::npos) << loaded.error().detail();
  }

  test::TemporaryFolder folder_;
  KeyFolder base_{(folder_.path() / "base").string()};
  KeyFolder robot_{(folder_.path() / "robot").string()};
  Identity identity_ = robot(3);
  std::optional<Authority> authority_;
};

TEST_F(KeyFolderTest, WhatWasTakenOverIsLoaded) {
  const auto own = robot_.load();
  ASSERT_TRUE(own.ok()) << own.error().message();
  EXPECT_EQ(own->identity, identity_);
  EXPECT_EQ(own->chain.size(), 2U);
  EXPECT_EQ(own->list, nullptr);
  EXPECT_FALSE(robot_.has("identity.key.next"));
  EXPECT_EQ(fs::status(robot_.file("identity.key")).permissions(), fs::perms(0600));
  EXPECT_EQ(fs::status(robot_.path()).permissions(), fs::perms(0700));
}

TEST_F(KeyFolderTest, WhatOthersCanReachIsRefusedWithTheRemedy) {
  ASSERT_EQ(::chmod(robot_.path().c_str(), 0750), 0);
  expect_refused("run chmod 700 " + robot_.path());
  ASSERT_EQ(::chmod(robot_.path().c_str(), 0700), 0);
  for (const mode_t mode : {0640U, 0604U, 0620U, 0602U}) {
    ASSERT_EQ(::chmod(robot_.file("identity.key").c_str(), mode), 0);
    expect_refused("run chmod 600 " + robot_.file("identity.key"));
  }
  ASSERT_EQ(::chmod(robot_.file("identity.key").c_str(), 0400), 0);
  EXPECT_TRUE(robot_.load().ok());
  ASSERT_EQ(::chmod(robot_.file("fleet.pem").c_str(), 0664), 0);
  expect_refused("run chmod go-w " + robot_.file("fleet.pem"));
}

TEST_F(KeyFolderTest, LinksPipesAndFoldersAreRefused) {
  for (const std::string file : {"identity.key", "identity.pem", "fleet.pem"}) {
    const std::string path = robot_.file(file);
    fs::rename(path, path + ".moved");
    fs::create_symlink(path + ".moved", path);
    expect_refused("is a symbolic link");
    fs::remove(path);
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    expect_refused("is not an ordinary file");
    fs::remove(path);
    fs::create_directory(path);
    expect_refused(path);
    fs::remove(path);
    expect_refused("does not exist");
    fs::rename(path + ".moved", path);
  }
  EXPECT_TRUE(robot_.load().ok());
}

TEST_F(KeyFolderTest, HalfAFileIsNamed) {
  for (const std::string file : {"identity.key", "identity.pem", "fleet.pem"}) {
    const auto size = fs::file_size(robot_.file(file));
    const std::string kept = robot_.read_public(file).value();
    for (const auto part : {std::uintmax_t{0}, size / 2, size - 30}) {
      fs::resize_file(robot_.file(file), part);
      expect_refused(file);
    }
    ASSERT_TRUE(robot_.write_secret(file, kept).ok() || robot_.write_public(file, kept).ok());
  }
  EXPECT_TRUE(robot_.load().ok());
}

TEST_F(KeyFolderTest, ARenewalInterruptedAtAnyStepLeavesAMemberThatWorks) {
  const auto former = robot_.load()->chain.front();
  const auto key = robot_.next_key().value();
  EXPECT_EQ(robot_.load()->chain.front(), former) << "after the first step";
  EXPECT_EQ(robot_.next_key()->public_key_hash(), key.public_key_hash()) << "the same key again";
  const auto chain = certificate_for(key);
  ASSERT_TRUE(robot_.write_public("identity.pem", to_pem(chain)).ok());
  const auto own = robot_.load();  // after the second step; completes it
  ASSERT_TRUE(own.ok()) << own.error().message();
  EXPECT_EQ(own->chain.front(), chain.front());
  EXPECT_EQ(own->key.public_key_hash(), key.public_key_hash());
  EXPECT_FALSE(robot_.has("identity.key.next"));
}

TEST_F(KeyFolderTest, KeyAndCertificateOfDifferentMembersAreRefused) {
  ASSERT_TRUE(robot_.write_secret("identity.key", PrivateKey::generate()->to_pem()).ok());
  expect_refused("does not belong to identity.key");
}

TEST_F(KeyFolderTest, ListsNeverGoBack) {
  const Bytes first = authority_->list_bytes().value();
  EXPECT_TRUE(robot_.take_over_list(first).value());
  EXPECT_FALSE(robot_.take_over_list(first).value());
  ASSERT_TRUE(authority_->revoke("robot3", kNow).ok());
  const Bytes second = authority_->list_bytes().value();
  EXPECT_TRUE(robot_.take_over_list(second).value());
  EXPECT_FALSE(robot_.take_over_list(first).value());
  EXPECT_EQ(robot_.load()->list_number(), 2U);
  Bytes forged = second;
  forged[10] ^= std::byte{1};
  EXPECT_FALSE(robot_.take_over_list(forged).ok());
}

TEST_F(KeyFolderTest, NewRootsComeWithTheListAlsoWhenInterrupted) {
  const auto old_root = authority_->root();
  ASSERT_TRUE(authority_->rotate(kNow + 1).ok());
  const Bytes both = authority_->list_bytes().value();
  // Interrupted: the list is there, but fleet.pem still is the old one.
  ASSERT_TRUE(robot_.write_public("revoked.list", text_of(both)).ok());
  EXPECT_EQ(robot_.load()->roots, (std::vector{old_root, authority_->root()}));
  ASSERT_TRUE(authority_->finish_rotation(true, kNow + 2).ok());
  const Bytes only_new = authority_->list_bytes().value();
  EXPECT_TRUE(robot_.take_over_list(only_new).value());
  EXPECT_EQ(robot_.load()->roots, std::vector{authority_->root()});
  // Interrupted before fleet.pem got its last form.
  ASSERT_TRUE(robot_.write_public("fleet.pem", to_pem({old_root, authority_->root()})).ok());
  EXPECT_EQ(robot_.load()->roots, std::vector{authority_->root()});
}

}  // namespace tims::security::key_folder_test
