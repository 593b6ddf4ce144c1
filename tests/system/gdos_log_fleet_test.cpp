// Two robots of a fleet, each with its own log; all logs have the same address.
#include "tests/system/gdos_log_fixture.h"
#include "tests/system/host.h"

namespace tims::test {
namespace gdos_log_fleet_test {

// The base (not the fixture's router) is above robot1 and robot2.
class GdosLogFleetTest : public GdosLogTest {
 protected:
  void SetUp() override {
    base_.start();
    for (const int system : {1, 2}) {
      robots_.emplace_back("robot" + std::to_string(system), "system", system, 1,
                           std::vector<std::string>{"kind=super,to=" + base_.udp()});
      robots_.back().start();
    }
  }
  [[nodiscard]] std::filesystem::path folder_of(const std::string& name) const {
    return folder() / name;
  }
  ChildProcess log_at(const Host& host, int system, const std::string& name) {
    auto log = ChildProcess::start(
        {std::string(TIMS_PROGRAMS) + "/gdos-log", "--system=" + std::to_string(system),
         "--directory=" + folder_of(name).string(), "--syncTime=10"},
        {.environment = {"TIMS_ROUTER=" + host.socket()}, .folder = {}});
    EXPECT_TRUE(log) << log.error().message();
    EXPECT_TRUE(log->wait_for_line("Texts are kept in"));
    return std::move(*log);
  }
  [[nodiscard]] std::string kept_at(const std::string& name) const {
    std::ifstream file(folder_of(name) / rack::gdos::kCurrentFile);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  Host base_{"base", "top", 0, 1, {"kind=sub,system=*"}};
  std::vector<Host> robots_;
};

// A component of a robot that sends texts with the priority of original programs.
class Speaker {
 public:
  Speaker(const Host& host, std::uint32_t address) : session_(host.session("speaker")) {
    auto mailbox = session_.open({.address = Address(address)});
    EXPECT_TRUE(mailbox);
    mailbox_.emplace(std::move(*mailbox));
  }
  void send_text(const std::string& text) {
    EXPECT_TRUE(
        mailbox_->send({.dest = text_sink(), .type = -125, .priority = 99}, bytes_of(text)));
  }

 private:
  Session session_;
  std::optional<Mailbox> mailbox_;
};

TEST_F(GdosLogFleetTest, EachRobotKeepsItsTextsAndARobotWithoutLogSendsThemToTheBase) {
  ChildProcess base_log = log_at(base_, 0, "base");
  std::optional<ChildProcess> first(log_at(robots_[0], 1, "robot1"));
  const ChildProcess second = log_at(robots_[1], 2, "robot2");
  ASSERT_TRUE(eventually(
      [&] {
        return base_.timsctl({"route", "show", "GDOS"}).find("GDOS(2/1)") != std::string::npos &&
               base_.timsctl({"route", "show", "GDOS"}).find("GDOS(1/1)") != std::string::npos;
      },
      "the base knows both logs"));
  Speaker ladar(robots_[0], 0x01140000);
  Speaker chassis(robots_[1], 0x02110000);
  ladar.send_text("from one");
  chassis.send_text("from two");
  const auto has = [&](const std::string& where, const std::string& text) {
    return eventually([&] { return kept_at(where).find(text) != std::string::npos; },
                      text + " at " + where);
  };
  EXPECT_TRUE(has("robot1", "from one"));
  EXPECT_TRUE(has("robot2", "from two"));
  EXPECT_EQ(kept_at("robot1").find("from two"), std::string::npos);
  // A robot without a log.
  first.reset();
  EXPECT_TRUE(eventually(
      [&] {
        ladar.send_text("to the base");
        return kept_at("base").find("to the base") != std::string::npos;
      },
      "the base receives it"));
  EXPECT_EQ(kept_at("base").find("from"), std::string::npos)
      << "the texts of the other robot are kept there";
  EXPECT_EQ(kept_at("robot2").find("to the base"), std::string::npos);
  EXPECT_THAT(base_.timsctl({"status"}), Not(HasSubstr("duplicate")));
}

TEST_F(GdosLogFleetTest, ARobotsTextsAreFollowedFromTheBase) {
  const ChildProcess log = log_at(robots_[0], 1, "robot1");
  ASSERT_TRUE(eventually(
      [&] {
        return base_.timsctl({"route", "show", "GDOS"}).find("GDOS(1/1)") != std::string::npos;
      },
      "the base knows the log"));
  auto follower = ChildProcess::start(
      {TIMSCTL_PROGRAM, "-H", "unix:" + base_.socket(), "log", "follow", "GDOS/1/1"});
  ASSERT_TRUE(follower);
  Speaker ladar(robots_[0], 0x01140000);
  EXPECT_TRUE(eventually(
      [&] {
        ladar.send_text("far away");
        return follower->standard_output().find("error   far away") != std::string::npos;
      },
      "the follower receives it"));
  EXPECT_THAT(follower->standard_output(), HasSubstr("Ladar(1/0)"));
}

}  // namespace gdos_log_fleet_test
}  // namespace tims::test
