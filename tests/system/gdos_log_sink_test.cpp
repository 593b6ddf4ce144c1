// Owners of the sink of texts: gdos-log, other programs, or several; and programs that follow.
#include "tests/support/model_router.h"
#include "tests/system/gdos_log_fixture.h"

namespace tims::test {
namespace gdos_log_sink_test {

// A window of the original's graphical interface.
class Window {
 public:
  explicit Window(const RouterProcess& router) : client_(*TcpClient::connect(router.tcp())) {
    const auto registered = client_.register_mailbox(text_sink());
    EXPECT_TRUE(registered) << registered.error().message();
  }
  // The next text sent by the test.
  std::string next(Duration limit = kPatience) {
    for (;;) {
      const auto message = client_.receive(limit);
      if (!message) return message.error().message();
      EXPECT_LT(message->header.type, 0) << "the window understands texts only";
      if (message->header.src == Address(0x00020001)) return text_of(message->body);
    }
  }

 private:
  TcpClient client_;
};

TEST_F(GdosLogTest, WindowsOfTheOriginalAndTheLogReceiveAllTexts) {
  std::optional<Window> first(std::in_place, router_);
  start_log();
  send_text("one");
  EXPECT_TRUE(comes_to_be_kept("one"));
  EXPECT_EQ(first->next(), "one");
  auto follower = timsctl({"log", "follow"});
  ASSERT_TRUE(follower);
  Window second(router_);
  send_text("two");
  EXPECT_TRUE(comes_to_be_kept("two"));
  EXPECT_EQ(first->next(), "two");
  EXPECT_EQ(second.next(), "two");
  first.reset();
  EXPECT_TRUE(eventually(
      [&] {
        send_text("three");
        return follower->standard_output().find("three") != std::string::npos;
      },
      "the log is found in addition to the windows"));
  EXPECT_EQ(second.next(), "three");
  EXPECT_TRUE(comes_to_be_kept("three"));
}

// Until then the component has sent to the log without the router.
TEST_F(GdosLogTest, AWindowThatStartsLaterReceivesTextsOfRunningComponents) {
  start_log();
  send_text("before");
  ASSERT_TRUE(comes_to_be_kept("before"));
  Window window(router_);
  // It takes effect when the component has been notified that it must send through the router.
  EXPECT_TRUE(eventually(
      [&] {
        send_text("after");
        return window.next(std::chrono::milliseconds(100)) == "after";
      },
      "received"));
  EXPECT_TRUE(comes_to_be_kept("after"));
}

TEST_F(GdosLogTest, ContinuesWithARestartedRouter) {
  start_log();
  router_.kill();
  ASSERT_TRUE(router_.start());
  EXPECT_TRUE(eventually(
      [&] {
        (void)work_->send({.dest = text_sink(), .type = -126}, bytes_of("again"));
        return kept().find("again") != std::string::npos;
      },
      "a text after the restart"));
}

TEST_F(GdosLogTest, ASecondLogKeepsTextsAsWell) {
  start_log();
  const TemporaryFolder other;
  auto second = ChildProcess::start({std::string(TIMS_PROGRAMS) + "/gdos-log", "--instance=2",
                                     "--directory=" + other.path().string(), "--syncTime=10"},
                                    at_router());
  ASSERT_TRUE(second);
  ASSERT_TRUE(second->wait_for_line("Texts are kept in"));
  const auto kept_there = [&](const std::string& text) {
    std::ifstream file(other.path() / rack::gdos::kCurrentFile);
    return std::string(std::istreambuf_iterator<char>(file), {}).find(text) != std::string::npos;
  };
  send_text("for both");
  EXPECT_TRUE(comes_to_be_kept("for both"));
  EXPECT_TRUE(eventually([&] { return kept_there("for both"); }, "the second has it"));
  kill("gdos-log");
  EXPECT_TRUE(eventually(
      [&] {
        send_text("for one");
        return kept_there("for one");
      },
      "the second continues"));
}

// The original router accepts one owner of the sink only.
TEST_F(GdosLogTest, WaitsForTheSinkOfAnOriginalRouter) {
  const ModelRouter original({});
  auto console = TcpClient::connect(original.endpoint());
  ASSERT_TRUE(console);
  ASSERT_TRUE(console->register_mailbox(text_sink()));
  auto log = ChildProcess::start({std::string(TIMS_PROGRAMS) + "/gdos-log",
                                  "--directory=" + folder().string(), "--syncTime=10",
                                  "--router=" + original.endpoint()});
  ASSERT_TRUE(log);
  const auto waits = log->wait_for_line("Waits for the sink of texts: address in use");
  ASSERT_TRUE(waits) << waits.error().message();
  console->close();
  EXPECT_TRUE(log->wait_for_line("Texts are kept in"));
}

TEST_F(GdosLogTest, ItsOwnAddressIsNotTheSink) {
  auto log =
      ChildProcess::start({std::string(TIMS_PROGRAMS) + "/gdos-log", "--instance=0"}, at_router());
  ASSERT_TRUE(log);
  const auto status = log->wait();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->code, 1);
  EXPECT_THAT(log->output(), HasSubstr("GDOS(0/0) is the sink itself"));
}

TEST_F(GdosLogTest, AnyNumberOfProgramsCanFollow) {
  start_log();
  std::vector<ChildProcess> followers;
  for (const auto& arguments : {std::vector<std::string>{"log", "follow"},
                                {"log", "follow", "-l", "error"},
                                {"log", "follow", "GDOS/0/1", "-c", "Ladar"},
                                {"log", "follow", "--json"}}) {
    auto follower = timsctl(arguments);
    ASSERT_TRUE(follower);
    followers.push_back(std::move(*follower));
  }
  Mailbox ladar = open(*session_, 0x00140000);
  const auto all_received = [&] {
    send_text("a warning");
    send_text("an error", rack::gdos::Level::kError);
    (void)ladar.send({.dest = text_sink(), .type = -127}, bytes_of("a scan"));
    for (const auto& follower : followers)
      if (follower.standard_output().empty()) return false;
    return true;
  };
  EXPECT_TRUE(eventually(all_received, "all four receive texts"));
  EXPECT_THAT(followers[1].standard_output(), Not(HasSubstr("warning")));
  EXPECT_THAT(followers[1].standard_output(), HasSubstr("GUI(0/0)"));
  EXPECT_THAT(followers[2].standard_output(), HasSubstr("Ladar(0/0)         info    a scan\n"));
  EXPECT_THAT(followers[2].standard_output(), Not(HasSubstr("an error")));
  EXPECT_THAT(followers[3].standard_output(), HasSubstr(R"("schema":"tims/text/1")"));
}

TEST_F(GdosLogTest, AFollowerFirstShowsThePast) {
  start_log();
  ASSERT_TRUE(comes_to_be_kept("Module on")) << "a text of its own";
  for (const char* text : {"first", "second", "third"}) {
    send_text(text);
    ASSERT_TRUE(comes_to_be_kept(text));
  }
  auto follower = timsctl({"log", "follow", "-n", "2", "--directory", folder().string()});
  ASSERT_TRUE(follower);
  EXPECT_TRUE(follower->wait_for_line("third"));
  // Until the sender has been notified that there is a second reader, it sends to the log without
  // the router.
  EXPECT_TRUE(eventually(
      [&] {
        send_text("fourth");
        return follower->standard_output().find("fourth") != std::string::npos;
      },
      "a text of now"));
  const std::string shown = follower->standard_output();
  EXPECT_THAT(shown, Not(HasSubstr("first")));
  EXPECT_EQ(shown.find("third"), shown.rfind("third")) << "once";
  EXPECT_LT(shown.find("second"), shown.find("third")) << shown;
  auto nothing = timsctl({"log", "follow", "-n", "2", "--directory", folder().string() + "/none"});
  ASSERT_TRUE(nothing);
  EXPECT_TRUE(nothing->wait_for_line("no messages of the past: there are no log files in"));
}

TEST_F(GdosLogTest, AnExclusiveOwnerIsNamed) {
  const ModelRouter original({});
  auto console = TcpClient::connect(original.endpoint());
  ASSERT_TRUE(console);
  ASSERT_TRUE(console->register_mailbox(text_sink()));
  auto follower = ChildProcess::start(
      {TIMSCTL_PROGRAM, "-H", original.endpoint(), "log", "follow", "--timeout=100ms"});
  ASSERT_TRUE(follower);
  const auto status = follower->wait();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->code, 5);
  EXPECT_THAT(follower->output(), HasSubstr("GDOS(0/0)"));
}

}  // namespace gdos_log_sink_test
}  // namespace tims::test
