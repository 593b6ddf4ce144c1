// Two handshakers whose bytes are carried by hand, with the keys of a real authority.
#include "router/io/crypto/tls_handshaker.h"

#include <chrono>
#include <future>

#include <gtest/gtest.h>

#include "security/keys/authority.h"
#include "tests/support/temporary_folder.h"

namespace tims::io {
namespace tls_handshaker_test {

using Side = link::Handshaker::Side;
using security::Identity;
using security::MemberRole;

constexpr std::uint64_t kOne = 1;
constexpr std::array<std::byte, 4> kBinding{std::byte{1}};

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// One side: its reports come from another thread.
class End {
 public:
  explicit End(const security::Credentials& credentials)
      : handshaker([this](link::HandshakeProgress&& progress) {
          const std::lock_guard lock(mutex_);
          reports_.push_back(std::move(progress));
          wakes_.notify_one();
        }) {
    EXPECT_TRUE(handshaker.set_credentials(credentials, security::Strictness{}).ok());
  }
  // Takes what has been reported, after at least one report.
  void wait() {
    std::unique_lock lock(mutex_);
    ASSERT_TRUE(
        wakes_.wait_for(lock, std::chrono::seconds(20), [this] { return !reports_.empty(); }));
    for (auto& report : reports_) {
      to_send.insert(to_send.end(), report.to_send.begin(), report.to_send.end());
      if (report.verified.sealer) verified = std::move(report.verified);
      for (auto& message : report.messages) messages.push_back(std::move(message));
      if (!report.failure.empty()) failure = report.failure;
    }
    reports_.clear();
  }

  std::vector<std::byte> to_send;
  link::Verified verified;
  std::vector<std::vector<std::byte>> messages;
  std::string failure;

 private:
  std::mutex mutex_;
  std::condition_variable wakes_;
  std::vector<link::HandshakeProgress> reports_;

 public:
  TlsHandshaker handshaker;  // the last member: its thread uses the others
};

class TlsHandshakerTest : public testing::Test {
 protected:
  static std::int64_t seconds() {
    return std::chrono::duration_cast<std::chrono::seconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
  }
  static Identity identity(MemberRole role, std::uint16_t system, const std::string& name) {
    return {
        .fleet = "harbour", .role = role, .system = system, .id = 1, .name = name, .rights = {}};
  }
  security::Authority authority(const std::string& folder) {
    const security::KeyFolder keys((folder_.path() / folder).string());
    auto made = security::Authority::init(keys, "harbour", seconds()).value();
    EXPECT_TRUE(made.issue_own(identity(MemberRole::kTop, 0, "base"), {}, seconds()).ok());
    return made;
  }
  security::Credentials load(const std::string& folder) {
    return security::KeyFolder((folder_.path() / folder).string()).load().value();
  }
  security::Credentials join(const security::Authority& authority, const Identity& who,
                             const std::string& folder) {
    const security::KeyFolder keys((folder_.path() / folder).string());
    EXPECT_TRUE(keys.make().ok());
    const auto key = keys.next_key().value();
    const auto request = security::CertificateRequest::make(key, who.uris()).value();
    const auto chain = authority.issue(who, {}, request, seconds()).value();
    EXPECT_TRUE(keys.take_over(chain, authority.list()->roots).ok());
    EXPECT_TRUE(keys.take_over_list(authority.list_bytes().value()).ok());
    return keys.load().value();
  }
  // Carries all bytes until both sides have a message, or one has failed.
  static void shake(End& robot, End& base, std::span<const std::byte> base_binding = kBinding) {
    base.handshaker.begin(kOne, Side::kAccepts, base_binding);
    robot.handshaker.begin(kOne, Side::kConnects, kBinding);
    robot.handshaker.send(kOne, bytes_of("who"));
    base.wait();
    for (int step = 0; step < 20; ++step) {
      const bool done = !robot.messages.empty() && !base.messages.empty();
      if (done || !robot.failure.empty() || !base.failure.empty()) return;
      robot.wait();
      if (!robot.to_send.empty()) {
        base.handshaker.receive(kOne, std::exchange(robot.to_send, {}));
        base.wait();
      }
      if (!base.messages.empty() && base.to_send.empty()) {
        base.handshaker.send(kOne, bytes_of("welcome"));
        base.wait();
      }
      if (!base.to_send.empty()) robot.handshaker.receive(kOne, std::exchange(base.to_send, {}));
    }
  }
  static bool opens(link::Sealer& from, link::Sealer& to) {
    std::array<std::byte, 16> header{};
    std::array<std::byte, 3> text{std::byte{7}};
    std::array<std::byte, 16> tag{};
    from.seal(3, header, text, tag);
    return to.open(link::Sealer::Phase::kCurrent, 3, header, text, tag) && text[0] == std::byte{7};
  }

  test::TemporaryFolder folder_;
};

TEST_F(TlsHandshakerTest, BothSidesAreVerifiedAndShareKeys) {
  const auto fleet = authority("base");
  End base(load("base"));
  End robot(join(fleet, identity(MemberRole::kSystem, 3, "robot3"), "robot3"));
  shake(robot, base);
  EXPECT_EQ(robot.failure + base.failure, "");
  ASSERT_TRUE(robot.verified.sealer && base.verified.sealer);
  EXPECT_EQ(base.verified.peer.role, core::Role::kSystem);
  EXPECT_EQ(base.verified.peer.system, 3);
  EXPECT_EQ(base.verified.peer.name, "robot3");
  EXPECT_EQ(robot.verified.peer.role, core::Role::kTop);
  ASSERT_EQ(base.messages.size(), 1U);
  EXPECT_EQ(base.messages[0], bytes_of("who"));
  ASSERT_EQ(robot.messages.size(), 1U);
  EXPECT_EQ(robot.messages[0], bytes_of("welcome"));
  EXPECT_TRUE(opens(*robot.verified.sealer, *base.verified.sealer));
  EXPECT_TRUE(opens(*base.verified.sealer, *robot.verified.sealer));
}

// Sides that saw another HELLO or RETRY have other keys.
TEST_F(TlsHandshakerTest, KeysAreBoundToWhatWasSaidBefore) {
  const auto fleet = authority("base");
  End base(load("base"));
  End robot(join(fleet, identity(MemberRole::kSystem, 3, "robot3"), "robot3"));
  constexpr std::array<std::byte, 4> kOther{std::byte{2}};
  shake(robot, base, kOther);
  ASSERT_TRUE(robot.verified.sealer && base.verified.sealer);
  EXPECT_FALSE(opens(*robot.verified.sealer, *base.verified.sealer));
}

TEST_F(TlsHandshakerTest, OthersAreRefusedWithTheReason) {
  const auto fleet = authority("base");
  const auto strange_fleet = authority("elsewhere");
  const auto refusal = [&](const security::Credentials& keys) {
    End base(load("base"));
    End robot(keys);
    shake(robot, base);
    EXPECT_FALSE(base.verified.sealer);
    return base.failure;
  };
  EXPECT_NE(refusal(join(strange_fleet, identity(MemberRole::kSystem, 3, "robot3"), "strange")),
            "");
  Identity user = identity(MemberRole::kUser, 0, "anna");
  user.id = 0;
  EXPECT_NE(refusal(join(fleet, user, "anna")).find("no router's"), std::string::npos);

  const auto robot4 = join(fleet, identity(MemberRole::kSystem, 4, "robot4"), "robot4");
  ASSERT_TRUE(fleet.revoke("robot4", seconds()).ok());
  EXPECT_NE(refusal(robot4).find("revoked"), std::string::npos);
}

TEST_F(TlsHandshakerTest, BytesThatAreNoTlsEndIt) {
  const auto fleet = authority("base");
  End base(load("base"));
  base.handshaker.begin(kOne, Side::kAccepts, kBinding);
  base.wait();
  base.handshaker.receive(kOne, bytes_of("this is not TLS at all"));
  base.wait();
  EXPECT_NE(base.failure, "");
}

}  // namespace tls_handshaker_test
}  // namespace tims::io
