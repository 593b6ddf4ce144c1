#include "security/keys/join_server.h"

#include <filesystem>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include "os/clock.h"
#include "os/socket.h"
#include "os/wakeup.h"
#include "security/keys/join_client.h"
#include "security/keys/members_fixture.h"
#include "tests/support/folder_contents.h"
#include "tests/support/temporary_folder.h"

namespace tims::security::join_server_test {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;
constexpr std::int64_t kNow = 1'800'000'000;

// A server in a thread of its own, until the test ends.
class Served {
 public:
  // `after`: called when something has happened.
  explicit Served(
      JoinServer server, std::function<void()> after = [] {})
      : server_(std::move(server)),
        after_(std::move(after)),
        thread_([this](const std::stop_token& stop) { run(stop); }) {}
  ~Served() {
    thread_.request_stop();
    wake_.write.reset();
  }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  [[nodiscard]] std::uint16_t port() const { return server_.port(); }

 private:
  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::array<pollfd, 2> fds{pollfd{.fd = server_.descriptor(), .events = POLLIN, .revents = 0},
                                pollfd{.fd = wake_.read.get(), .events = POLLIN, .revents = 0}};
      ::poll(fds.data(), fds.size(), -1);
      if (!server_.work(os::now(), kNow).empty()) after_();
    }
  }

  JoinServer server_;
  std::function<void()> after_;
  os::Pipe wake_ = os::make_pipe().value();
  std::jthread thread_;
};

class JoinServerTest : public testing::Test {
 protected:
  JoinServerTest() {
    const Identity base{
        .fleet = "f", .role = MemberRole::kTop, .system = 0, .id = 1, .name = "base", .rights = {}};
    EXPECT_TRUE(authority_.issue_own(base, {}, kNow).ok());
  }
  JoinText token(std::uint16_t system, std::uint16_t port) {
    JoinText text{.hosts = {"127.0.0.1"}, .port = port, .root = {}, .secret = {}};
    std::copy_n(authority_.root().fingerprint().begin(), 16, text.root.begin());
    fill_random(text.secret);
    EXPECT_TRUE(Tokens(authority_)
                    .add({.hash = hash_of_secret(text.secret),
                          .identity = robot(system),
                          .made = kNow,
                          .ends = kNow + 3600,
                          .used_by = {}},
                         kNow)
                    .ok());
    return text;
  }
  KeyFolder folder(const std::string& name) const {
    return KeyFolder((folder_.path() / name).string());
  }
  // A stolen robot with an authority of its own in its folder: `timsctl key serve` runs there with
  // the certificate of a member, which lets others of the fleet in, and hands out its own.
  KeyFolder impostor(const Identity& stolen) {
    KeyFolder keys = folder("impostor");
    const Authority forged = Authority::init(keys, "f", kNow).value();
    const KeyFolder member = folder("stolen");
    EXPECT_TRUE(authority_.issue_to(member, stolen, {}, kNow).ok());
    for (const std::string file : {"identity.pem", "identity.key"})
      fs::copy_file(member.file(file), keys.file(file));
    FleetList list = forged.list().value();
    list.number = 99;
    list.roots.push_back(authority_.root());
    const KeyFolder& secrets = forged.folder();
    const auto issuing = Certificate::from_pem(secrets.read_public("issuing.pem").value()).value();
    const auto key = PrivateKey::from_pem(secrets.read_secret("issuing.key").value()).value();
    EXPECT_TRUE(keys.write_list(list.sign(issuing.front(), key).value(), list.roots).ok());
    return keys;
  }
  // A member that renews at this port.
  KeyFolder victim(std::uint16_t port) {
    KeyFolder keys = folder("robot3");
    EXPECT_TRUE(authority_.issue_to(keys, robot(3), {}, kNow).ok());
    JoinText address{.hosts = {"127.0.0.1"}, .port = port, .root = {}, .secret = {}};
    EXPECT_TRUE(keys.write_public("authority.address", address.to_string()).ok());
    EXPECT_TRUE(keys.next_key().ok());  // that of the renewal: it is kept
    return keys;
  }
  static Time soon() { return os::deadline_after(20s); }

  test::TemporaryFolder folder_;
  KeyFolder base_ = folder("base");
  Authority authority_ = Authority::init(base_, "f", kNow).value();
};

TEST_F(JoinServerTest, JoinsAndRenews) {
  const Served server(JoinServer::listen(base_, 0).value());
  const KeyFolder keys = folder("robot3");
  const auto joined = join_fleet(keys, token(3, server.port()), soon());
  ASSERT_TRUE(joined.ok()) << joined.error().message();
  EXPECT_EQ(*joined, robot(3));
  const auto former = keys.load()->chain.front();
  const auto renewed = renew_certificate(keys, {}, soon());
  ASSERT_TRUE(renewed.ok()) << renewed.error().message();
  EXPECT_EQ(*renewed, robot(3));
  EXPECT_NE(keys.load()->chain.front(), former);
  ASSERT_TRUE(authority_.revoke("robot3", kNow).ok());
  EXPECT_FALSE(renew_certificate(keys, {}, soon()).ok());
}

TEST_F(JoinServerTest, TheNextAddressIsTriedAndTheTokenIsNotUsedUp) {
  const Served server(JoinServer::listen(base_, 0).value());
  JoinText text = token(3, server.port());
  text.hosts = {"127.0.0.2.invalid", "::1", "127.0.0.1"};
  EXPECT_TRUE(join_fleet(folder("robot3"), text, soon()).ok());
}

TEST_F(JoinServerTest, ABaseWithAnotherRootGetsNothing) {
  const KeyFolder other = folder("other");
  const auto forged = Authority::init(other, "f", kNow).value();
  ASSERT_TRUE(forged.issue_own(robot(9), {}, kNow).ok());
  const Served middle(JoinServer::listen(other, 0).value());
  const auto joined = join_fleet(folder("robot3"), token(3, middle.port()), soon());
  ASSERT_FALSE(joined.ok());
  EXPECT_FALSE(folder("robot3").has("identity.pem"));
  // The right base still takes the token.
  const Served server(JoinServer::listen(base_, 0).value());
  EXPECT_TRUE(join_fleet(folder("robot3"), token(3, server.port()), soon()).ok());
}

TEST_F(JoinServerTest, AStolenRobotThatAnswersForTheBaseChangesNothing) {
  const Served server(JoinServer::listen(impostor(robot(9)), 0).value());
  const KeyFolder keys = victim(server.port());
  const auto before = test::contents_of(keys.path());
  const auto renewed = renew_certificate(keys, {}, soon());
  ASSERT_FALSE(renewed.ok());
  EXPECT_EQ(renewed.error(), Errc::kRefused);
  EXPECT_THAT(renewed.error().detail(),
              HasSubstr("robot3 believes another authority of the fleet f: list of the fleet: is "
                        "not signed by this fleet's authority"));
  EXPECT_TRUE(test::contents_of(keys.path()) == before);
}

TEST_F(JoinServerTest, AUserIsNotEvenAsked) {
  const Identity user{
      .fleet = "f", .role = MemberRole::kUser, .name = "anna", .rights = {.look = true}};
  const Served server(JoinServer::listen(impostor(user), 0).value());
  const KeyFolder keys = victim(server.port());
  const auto before = test::contents_of(keys.path());
  EXPECT_THAT(renew_certificate(keys, {}, soon()).error().detail(),
              HasSubstr("the other side is a user, not the base"));
  EXPECT_TRUE(test::contents_of(keys.path()) == before);
}

TEST_F(JoinServerTest, BehindAnImpostorTheNextAddressIsTried) {
  // One address that leads to the impostor first, then to the base.
  const std::string place = folder("place").path();
  fs::create_directory_symlink(impostor(robot(9)).path(), place);
  const Served server(JoinServer::listen(folder("place"), 0).value(), [&] {
    fs::remove(place);
    fs::create_directory_symlink(base_.path(), place);
  });
  const KeyFolder keys = victim(server.port());
  const auto former = keys.load()->chain.front();
  const auto renewed = renew_certificate(keys, {"127.0.0.1"}, soon());
  ASSERT_TRUE(renewed.ok()) << renewed.error().message();
  EXPECT_NE(keys.load()->chain.front(), former);
  EXPECT_EQ(keys.load()->roots, std::vector{authority_.root()});
}

TEST_F(JoinServerTest, ManySilentConnectionsKeepNobodyOut) {
  const Served server(JoinServer::listen(base_, 0).value());
  std::vector<os::File> silent;
  for (std::size_t i = 0; i < 3 * JoinServer::kConnectionsMax; ++i)
    silent.push_back(os::connect_tcp("127.0.0.1", server.port(), soon()).value());
  const auto joined = join_fleet(folder("robot3"), token(3, server.port()), soon());
  EXPECT_TRUE(joined.ok()) << joined.error().message();
}

TEST_F(JoinServerTest, OneServerForAFolder) {
  EXPECT_EQ(JoinServer::running(base_), std::nullopt);
  {
    const auto server = JoinServer::listen(base_, 0).value();
    EXPECT_EQ(JoinServer::running(base_), server.port());
    EXPECT_EQ(JoinServer::listen(base_, 0).error(), Errc::kAddressInUse);
  }
  EXPECT_EQ(JoinServer::running(base_), std::nullopt);
  EXPECT_EQ(JoinServer::listen(folder("none"), 0).error(), Errc::kNoMailbox);
}

}  // namespace tims::security::join_server_test
