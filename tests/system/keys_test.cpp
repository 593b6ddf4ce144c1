// The keys of a fleet with real programs: made, handed out, revoked; what a router says of them.
#include <algorithm>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text.h"
#include "security/keys/authority.h"
#include "tests/support/child_process.h"
#include "tests/support/folder_contents.h"
#include "tests/support/temporary_folder.h"

namespace tims::test::keys_test {

using testing::HasSubstr;
namespace fs = std::filesystem;

struct Said {
  int status = -1;
  std::string out;
  std::string err;
};

class KeysTest : public testing::Test {
 protected:
  // The server that `token new` starts ends with the test.
  void TearDown() override {
    std::error_code ignored;
    for (const auto& process : fs::directory_iterator("/proc", ignored)) {
      const auto command = os::read_file(process.path() / "cmdline");
      const auto pid = base::parse_number<pid_t>(process.path().filename().string());
      if (pid && command && command->find("serve") != std::string::npos &&
          command->find(base_.path()) != std::string::npos)
        ::kill(*pid, SIGKILL);
    }
  }

  static Said timsctl(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), TIMSCTL_PROGRAM);
    auto child = ChildProcess::start(arguments);
    if (!child) return {.status = -1, .out = {}, .err = child.error().message()};
    const auto status = child->wait();
    return {.status = status ? status->code : -1,
            .out = child->standard_output(),
            .err = child->standard_error()};
  }
  std::string token(const std::string& system) {
    const Said said =
        timsctl({"token", "new", "--keys", base_.path(), "--role", "system", "--system", system});
    EXPECT_EQ(said.status, 0) << said.err;
    return std::string(base::trimmed(said.out, "\n"));
  }
  Said join(const std::string& text, const security::KeyFolder& keys) {
    return timsctl({"join", text, "--keys", keys.path()});
  }
  void init() {
    const Said said = timsctl({"key", "init", "--fleet", "harbour", "--keys", base_.path()});
    ASSERT_EQ(said.status, 0) << said.err;
  }
  [[nodiscard]] Result<ChildProcess> router(const security::KeyFolder& keys,
                                            const std::string& role, const std::string& system,
                                            const std::vector<std::string>& settings = {}) const {
    std::vector<std::string> command{std::string(TIMS_PROGRAMS) + "/tims-router"};
    const auto set = [&](const std::string& setting) {
      command.insert(command.end(), {"--set", setting});
    };
    set("security.keys=" + keys.path());
    set("router.role=" + role);
    set("router.system=" + system);
    set("unix.path=" + (folder_.path() / (role + ".sock")).string());
    set("tcp.listen=off");
    set("http.listen=off");
    std::ranges::for_each(settings, set);
    return ChildProcess::start(command);
  }

  TemporaryFolder folder_;
  security::KeyFolder base_{(folder_.path() / "base").string()};
  security::KeyFolder robot_{(folder_.path() / "robot3").string()};
};

TEST_F(KeysTest, OneCommandAndOneTextBringARobotIntoTheFleet) {
  init();
  const std::string text = token("3");
  ASSERT_THAT(text, testing::StartsWith("tims-join:"));
  const Said joined = join(text, robot_);
  ASSERT_EQ(joined.status, 0) << joined.err;
  EXPECT_THAT(joined.err, HasSubstr("system 3, id 1 (robot3) in the fleet harbour"));
  EXPECT_EQ(join(text, robot_).status, 5) << "once";
  const Said own = timsctl({"key", "show", "--keys", robot_.path(), "--json"});
  EXPECT_EQ(own.status, 0);
  EXPECT_THAT(own.out, HasSubstr(R"("name":"robot3","role":"system","system":3,"id":1)"));
  auto router3 = router(robot_, "system", "3").value();
  EXPECT_TRUE(router3.wait_for_line("system 3, id 1 (robot3) of the fleet harbour, list 1").ok());
}

TEST_F(KeysTest, TheRouterOfTheBaseSeesARevocation) {
  init();
  ASSERT_EQ(join(token("3"), robot_).status, 0);
  auto base = router(base_, "top", "0").value();
  ASSERT_TRUE(base.wait_for_line("list 1 with 0 revoked").ok());
  const Said revoked = timsctl({"key", "revoke", "robot3", "--keys", base_.path()});
  EXPECT_EQ(revoked.status, 0) << revoked.err;
  EXPECT_TRUE(base.wait_for_line("list 2 with 1 revoked").ok());
  EXPECT_THAT(timsctl({"key", "list", "--keys", base_.path(), "--output", "plain"}).out,
              HasSubstr("revoked"));
  const Said renewed = timsctl({"key", "renew", "--keys", robot_.path()});
  EXPECT_NE(renewed.status, 0);
  EXPECT_THAT(renewed.err, HasSubstr("revoked"));
}

// A new root: its list comes over the link, the router asks the base for a new certificate, and its
// link goes on meanwhile. That the old root can end proves that nobody needs it.
TEST_F(KeysTest, ARouterRenewsItsCertificateByItself) {
  init();
  ASSERT_EQ(join(token("3"), robot_).status, 0);
  const std::string before = robot_.read_public("identity.pem").value();
  (void)token("4");  // while it is open, key serve answers
  auto base =
      router(base_, "top", "0", {"udp.listen=127.0.0.1:0", "link=kind=sub,system=*"}).value();
  const auto listens = base.wait_for_line("listening udp");
  ASSERT_TRUE(listens.ok()) << listens.error().message();
  auto robot = router(robot_, "system", "3",
                      {"link=kind=super,to=" + listens->substr(listens->rfind(' ') + 1),
                       "security.renew_within=0s"})
                   .value();
  ASSERT_TRUE(robot.wait_for_line("is up").ok()) << robot.output();
  ASSERT_EQ(timsctl({"key", "rotate", "--keys", base_.path()}).status, 0);
  EXPECT_TRUE(robot.wait_for_line("list 2").ok()) << robot.output();
  EXPECT_TRUE(robot.wait_for_line("renewed the certificate of").ok()) << robot.output();
  EXPECT_NE(robot_.read_public("identity.pem").value(), before);
  EXPECT_EQ(robot.output().find("is down"), std::string::npos) << robot.output();
  const Said finished = timsctl({"key", "rotate", "--finish", "--keys", base_.path()});
  EXPECT_EQ(finished.status, 0) << finished.err;
  EXPECT_TRUE(robot.wait_for_line("list 3").ok()) << robot.output();
}

TEST_F(KeysTest, ACertificateForBrowsersThatNeverEndsIsRefused) {
  init();
  auto base = router(base_, "top", "0",
                     {"http.certificate=/dev/zero", "http.key=" + base_.file("identity.key")})
                  .value();
  EXPECT_TRUE(base.wait_for_line("http.certificate: /dev/zero: is a device").ok()) << base.output();
  EXPECT_EQ(base.wait()->code, 1);
}

TEST_F(KeysTest, ARouterWithKeysOfAnotherOrOpenOnesDoesNotStartAndSaysWhatHelps) {
  init();
  auto wrong = router(base_, "system", "3").value();
  EXPECT_TRUE(wrong.wait_for_line("run timsctl key init --keys").ok()) << wrong.output();
  EXPECT_EQ(wrong.wait()->code, 1);
  fs::permissions(base_.file("identity.key"), fs::perms(0644));
  auto open = router(base_, "top", "0").value();
  EXPECT_TRUE(open.wait_for_line("run chmod 600 " + base_.file("identity.key")).ok());
  EXPECT_EQ(open.wait()->code, 1);
}

TEST_F(KeysTest, ByFilesWithoutANetwork) {
  init();
  const std::string request = (folder_.path() / "request").string();
  const std::string answer = (folder_.path() / "answer").string();
  ASSERT_EQ(timsctl({"key", "request", request, "--keys", robot_.path()}).status, 0);
  const Said signed_it = timsctl({"key", "sign", request, answer, "--keys", base_.path(), "--role",
                                  "user", "--name", "anna", "--rights", "look,drive"});
  ASSERT_EQ(signed_it.status, 0) << signed_it.err;
  const Said imported = timsctl({"key", "import", answer, "--keys", robot_.path()});
  ASSERT_EQ(imported.status, 0) << imported.err;
  EXPECT_EQ(robot_.load()->identity.rights,
            (security::Rights{.look = true, .drive = true, .configure = false}));
}

TEST_F(KeysTest, AnAnswerOfAnotherAuthorityIsImportedOnlyWithForce) {
  init();
  ASSERT_EQ(join(token("3"), robot_).status, 0);
  const std::string other = (folder_.path() / "other").string();
  ASSERT_EQ(timsctl({"key", "init", "--fleet", "harbour", "--keys", other}).status, 0);
  const std::string request = (folder_.path() / "request").string();
  const std::string answer = (folder_.path() / "answer").string();
  ASSERT_EQ(timsctl({"key", "request", request, "--keys", robot_.path()}).status, 0);
  ASSERT_EQ(timsctl({"key", "sign", request, answer, "--keys", other, "--system", "3"}).status, 0);
  const auto before = contents_of(robot_.path());
  const Said refused = timsctl({"key", "import", answer, "--keys", robot_.path()});
  EXPECT_EQ(refused.status, 5);
  EXPECT_THAT(refused.err, HasSubstr("believes another authority of the fleet harbour"));
  EXPECT_THAT(refused.err, HasSubstr("if this host shall leave the fleet of its present keys: "
                                     "--force"));
  EXPECT_TRUE(contents_of(robot_.path()) == before);
  EXPECT_EQ(timsctl({"key", "import", answer, "--force", "--keys", robot_.path()}).status, 0);
  EXPECT_EQ(robot_.load()->roots, security::KeyFolder(other).load()->roots);
}

// A disk without room, or one that can only be read: nothing changes, the error says so, and the
// same command works afterwards.
TEST_F(KeysTest, AFullDiskChangesNothing) {
  const auto without_room = [](std::vector<std::string> arguments) {
    arguments.insert(
        arguments.begin(),
        {"/bin/bash", "-c", R"(trap '' XFSZ; ulimit -f 0; exec "$@")", "bash", TIMSCTL_PROGRAM});
    auto child = ChildProcess::start(arguments);
    ASSERT_TRUE(child);
    const auto status = child->wait();
    EXPECT_TRUE(status && status->code > 0) << arguments[5] << arguments[6];
    EXPECT_THAT(child->standard_error(), HasSubstr("File too large"));
  };
  without_room({"key", "init", "--fleet", "harbour", "--keys", base_.path()});
  init();
  const std::string text = token("3");
  without_room({"token", "new", "--keys", base_.path(), "--system", "4"});
  without_room({"join", text, "--keys", robot_.path()});
  ASSERT_EQ(join(text, robot_).status, 0);
  const std::string certificate = robot_.read_public("identity.pem").value();
  without_room({"key", "renew", "--keys", robot_.path()});
  EXPECT_EQ(robot_.read_public("identity.pem").value(), certificate);
  EXPECT_TRUE(robot_.load().ok());
  EXPECT_EQ(timsctl({"key", "renew", "--keys", robot_.path()}).status, 0);
  without_room({"key", "revoke", "robot3", "--keys", base_.path()});
  EXPECT_EQ(base_.load()->list_number(), 1U);
  EXPECT_EQ(timsctl({"key", "revoke", "robot3", "--keys", base_.path()}).status, 0);
  without_room({"key", "rotate", "--keys", base_.path()});
  EXPECT_EQ(timsctl({"key", "rotate", "--keys", base_.path()}).status, 0);
  EXPECT_EQ(base_.load()->list_number(), 3U);
}

TEST_F(KeysTest, BrowsersGetTheRootAndTheNamesOfTheBase) {
  init();
  const Said ca = timsctl({"key", "ca", "--keys", base_.path()});
  EXPECT_EQ(ca.out, base_.read_public("fleet.pem").value());
  const auto names = base_.load()->chain.front().host_names();
  ASSERT_GE(names.size(), 2U) << "its host name and an address";
  ASSERT_EQ(join(token("3"), robot_).status, 0);
  EXPECT_EQ(robot_.load()->chain.front().host_names().size(), 1U) << "where it has asked from";
}

TEST_F(KeysTest, WrongCommandLinesAndTexts) {
  EXPECT_EQ(timsctl({"key", "init", "--keys", base_.path()}).status, 2) << "no fleet";
  EXPECT_EQ(timsctl({"token", "new", "--keys", base_.path(), "--system", "3"}).status, 4);
  init();
  EXPECT_EQ(timsctl({"token", "new", "--keys", base_.path(), "--role", "system"}).status, 2);
  EXPECT_EQ(timsctl({"key", "init", "--fleet", "other", "--keys", base_.path()}).status, 1);
  const Said half = join(token("3").substr(0, 50), robot_);
  EXPECT_EQ(half.status, 1);
  EXPECT_THAT(half.err, HasSubstr("its code is not complete"));
  EXPECT_EQ(timsctl({"key", "revoke", "robot9", "--keys", base_.path()}).status, 4);
}

}  // namespace tims::test::keys_test
