// Who has the sink: gdos-log, somebody else, or two of them; and who listens.
#include "tests/system/gdos_log_fixture.h"

namespace tims::test {
namespace {

TEST_F(GdosLogTest, WaitsForTheSinkAndSaysWhoHasIt) {
  std::optional<Mailbox> console(open(*session_, rack::gdos::kSink.raw()));
  auto& log = start("gdos-log", {"--folder=" + folder().string(), "--syncTime=10"});
  const auto waits = log.wait_for_line("Waits for the sink of texts: address in use");
  ASSERT_TRUE(waits) << waits.error().message();
  EXPECT_THAT(*waits, HasSubstr("(test)")) << "the program that has it";
  EXPECT_TRUE(eventually([&] { return proxy<rack::GdosLogProxy>(kLog).on().ok(); },
                         "it does what it is told meanwhile"));
  console.reset();
  EXPECT_TRUE(log.wait_for_line("Texts are kept in"));
  say("now kept");
  EXPECT_TRUE(comes_to_be_kept("now kept"));
}

TEST_F(GdosLogTest, GoesOnWithARestartedRouter) {
  start_log();
  router_.kill();
  ASSERT_TRUE(router_.start());
  EXPECT_TRUE(eventually(
      [&] {
        (void)work_->send({.dest = rack::gdos::kSink, .type = -126}, bytes_of("again"));
        return kept().find("again") != std::string::npos;
      },
      "a text after the restart"));
}

TEST_F(GdosLogTest, ASecondOneWaitsForTheFirst) {
  start_log();
  const TemporaryFolder other;
  auto second = ChildProcess::start({std::string(TIMS_PROGRAMS) + "/gdos-log", "--instance=2",
                                     "--folder=" + other.path().string(), "--syncTime=10"},
                                    at_router());
  ASSERT_TRUE(second);
  const auto waits = second->wait_for_line("Waits for the sink");
  ASSERT_TRUE(waits) << waits.error().message();
  EXPECT_THAT(*waits, HasSubstr("gdos-log"));
  kill("gdos-log");
  EXPECT_TRUE(second->wait_for_line("Texts are kept in"));
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

TEST_F(GdosLogTest, AnyNumberFollows) {
  start_log();
  std::vector<ChildProcess> followers;
  for (const auto& words : {std::vector<std::string>{"log", "follow"},
                            {"log", "follow", "-l", "error"},
                            {"log", "follow", "GDOS/0/1", "-c", "Ladar"},
                            {"log", "follow", "--json"}}) {
    auto follower = timsctl(words);
    ASSERT_TRUE(follower);
    followers.push_back(std::move(*follower));
  }
  Mailbox ladar = open(*session_, 0x00140000);
  const auto all_heard = [&] {
    say("a warning");
    say("an error", rack::gdos::Level::kError);
    (void)ladar.send({.dest = rack::gdos::kSink, .type = -127}, bytes_of("a scan"));
    for (const auto& follower : followers)
      if (follower.standard_output().empty()) return false;
    return true;
  };
  EXPECT_TRUE(eventually(all_heard, "all four hear something"));
  EXPECT_THAT(followers[1].standard_output(), Not(HasSubstr("warning")));
  EXPECT_THAT(followers[1].standard_output(), HasSubstr("GUI(0/0)"));
  EXPECT_THAT(followers[2].standard_output(), HasSubstr("Ladar(0/0)         info    a scan\n"));
  EXPECT_THAT(followers[2].standard_output(), Not(HasSubstr("an error")));
  EXPECT_THAT(followers[3].standard_output(), HasSubstr(R"("schema":"tims/text/1")"));
}

TEST_F(GdosLogTest, AnOwnerThatKnowsNothingOfLogsIsNamed) {
  const Mailbox console = open(*session_, rack::gdos::kSink.raw());
  auto follower = timsctl({"log", "follow", "--timeout=100ms"});
  ASSERT_TRUE(follower);
  const auto status = follower->wait();
  ASSERT_TRUE(status);
  EXPECT_EQ(status->code, 5);
  EXPECT_THAT(follower->output(), HasSubstr("(test)"));
}

}  // namespace
}  // namespace tims::test
