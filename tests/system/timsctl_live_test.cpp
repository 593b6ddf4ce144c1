// timsctl with a component that answers: ping, messages, the effect of Ctrl-C.
#include <csignal>
#include <fstream>

#include "tests/system/timsctl_fixture.h"

namespace tims::test {
namespace timsctl_live_test {

TEST_F(TimsctlTest, PingMeasuresAComponentThatAnswers) {
  auto child = start({"ping", "Ladar/0/0", "-n", "2", "-i", "10ms"});
  ASSERT_TRUE(child);
  for (int i = 0; i < 2; ++i) answer(type::kGetStatus, type::kEnabled);
  const Ran run = finish(*child);
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, HasSubstr("enabled"));
  EXPECT_THAT(run.out, HasSubstr("2 sent, 2 answered, 0% lost"));
}

TEST_F(TimsctlTest, PubShowsTheAnswerOfACommand) {
  auto child = start({"msg", "pub", "Ladar/0/0", "off"});
  ASSERT_TRUE(child);
  answer(type::kOff, type::kError);
  const Ran run = finish(*child);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, HasSubstr(" Ladar(0/0) error\n"));
}

TEST_F(TimsctlTest, PubSendsBodiesPrioritiesAndSeveralTimes) {
  EXPECT_EQ(timsctl({"msg", "pub", "Ladar/0/0", "-6", "--hex", "01 02ff", "--priority", "200",
                     "--rate", "1000", "-n", "3"})
                .code,
            0);
  for (int i = 0; i < 3; ++i) {
    std::vector<std::byte> body;
    const auto header = expect_request(type::kData, &body);
    ASSERT_TRUE(header);
    EXPECT_EQ(header->priority, 200);
    EXPECT_EQ(body, (std::vector{std::byte{1}, std::byte{2}, std::byte{255}}));
  }
}

TEST_F(TimsctlTest, EchoIsInputForPub) {
  const auto target = [&] {
    auto mailbox = session_->open({.address = kTest});
    EXPECT_TRUE(mailbox);
    return std::move(*mailbox);
  };
  Mailbox other = target();
  std::vector<std::byte> body(1000);
  for (std::size_t i = 0; i < body.size(); ++i) body[i] = static_cast<std::byte>(i * 11);
  for (const char* form : {"--raw", "-ojson"}) {
    auto echo = start({"msg", "echo", "Ladar/0/0", "-n", "1", form});
    ASSERT_TRUE(echo);
    const Address data = grant_subscription();
    // Big-endian, as from a big-endian machine.
    ASSERT_TRUE(ladar_->send(
        {.dest = data, .type = type::kData, .priority = 77, .seq_nr = 9, .body_order = 0}, body));
    end_subscription();
    const Ran run = finish(*echo);
    ASSERT_EQ(run.code, 0) << run.err;

    const std::string file = router_.folder() + "/echo";
    std::ofstream(file) << run.out;
    EXPECT_EQ(timsctl({"msg", "pub", kTest.to_hex(), "-f", file}).code, 0);
    auto got = other.peek_for(kPatience);
    ASSERT_TRUE(got) << got.error().message();
    EXPECT_EQ(got->header().type, type::kData);
    EXPECT_EQ(got->header().priority, 77);
    EXPECT_EQ(got->header().seq_nr, 9);
    EXPECT_EQ(got->header().body_order(), std::endian::big);
    EXPECT_TRUE(std::ranges::equal(got->body(), body));
  }
}

TEST_F(TimsctlTest, CtrlCEndsTheSubscriptionOrAnEndlessVerb) {
  auto echo = start({"msg", "echo", "Ladar/0/0", "--json"});
  ASSERT_TRUE(echo);
  const Address data = grant_subscription();
  ASSERT_TRUE(ladar_->send({.dest = data, .type = type::kData}));
  ASSERT_TRUE(echo->wait_for_line("tims/message/1"));
  echo->signal(SIGINT);
  end_subscription();
  EXPECT_EQ(finish(*echo).code, 0);
  // Its mailbox is removed with it.
  EXPECT_EQ(timsctl({"mbx", "show", data.to_hex()}).code, 4);
}

TEST_F(TimsctlTest, CtrlCBeforeTheEndIs130) {
  auto ping = start({"ping", "Ladar/0/0", "-n", "1000", "-i", "1h"});
  ASSERT_TRUE(ping);
  answer(type::kGetStatus, type::kEnabled);
  ASSERT_TRUE(ping->wait_for_line("enabled"));
  ping->signal(SIGINT);
  const Ran run = finish(*ping);
  EXPECT_EQ(run.code, 130);
  EXPECT_THAT(run.out, HasSubstr("1 sent, 1 answered"));
}

TEST_F(TimsctlTest, AClosedPipeEndsTheSubscriptionToo) {
  auto echo = ChildProcess::start(
      {"sh", "-c", std::string(TIMSCTL_PROGRAM) + " msg echo Ladar/0/0 | head -n 1"}, options());
  ASSERT_TRUE(echo);
  const Address data = grant_subscription();
  std::vector<std::byte> body(64);
  // Several messages, because the closed pipe is detected by the second or third write.
  for (int sent = 0; sent < 1000; ++sent) {
    ASSERT_TRUE(ladar_->send({.dest = data, .type = type::kData}, body));
    auto answer = ladar_->peek_for(10ms);
    if (!answer) continue;
    EXPECT_EQ(answer->header().type, type::kStopContData);
    EXPECT_TRUE(ladar_->reply(answer->header(), type::kOk));
    return;
  }
  ADD_FAILURE() << "the subscription was not ended";
}

TEST_F(TimsctlTest, SilenceIsReported) {
  auto hz = start({"msg", "hz", "Ladar/0/0", "-n", "1", "-i", "100ms"});
  ASSERT_TRUE(hz);
  grant_subscription();
  end_subscription();
  const Ran run = finish(*hz);
  EXPECT_EQ(run.code, 6);
  EXPECT_THAT(run.err, HasSubstr("nothing comes from Ladar/0/0 for "));

  auto echo = start({"msg", "echo", "Ladar/0/0", "--for", "5s"});
  ASSERT_TRUE(echo);
  grant_subscription();
  const auto note = echo->wait_for_line("nothing comes from Ladar/0/0 for ");
  EXPECT_TRUE(note) << note.error().message();
  echo->signal(SIGINT);
  end_subscription();
  finish(*echo);
}

TEST_F(TimsctlTest, EchoWaitsForTheFirstData) {
  auto echo = start({"msg", "echo", "Ladar/0/0", "-n", "1"});
  ASSERT_TRUE(echo);
  auto request = expect_request(type::kGetContData);
  ASSERT_TRUE(request);
  const std::string_view why = "there are no data yet";
  ASSERT_TRUE(ladar_->reply(*request, type::kError, std::as_bytes(std::span(why))));
  const auto note = echo->wait_for_line("has no data yet; waiting");
  EXPECT_TRUE(note) << note.error().message();
  const Address data = grant_subscription();
  ASSERT_TRUE(ladar_->send({.dest = data, .type = type::kData}));
  end_subscription();
  EXPECT_EQ(finish(*echo).code, 0);

  auto off = start({"msg", "echo", "Ladar/0/0", "-n", "1"});
  ASSERT_TRUE(off);
  answer(type::kGetContData, type::kError);
  end_subscription();
  const Ran run = finish(*off);
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("`timsctl component on Ladar/0/0`"));
}

TEST_F(TimsctlTest, HzMeasures) {
  auto hz = start({"msg", "hz", "Ladar/0/0", "-n", "1", "-i", "1s", "-j"});
  ASSERT_TRUE(hz);
  const Address data = grant_subscription();
  for (int i = 0; i < 5; ++i)
    ASSERT_TRUE(ladar_->send({.dest = data, .type = type::kData, .seq_nr = 3},
                             std::vector<std::byte>(100)));
  end_subscription();
  const Ran run = finish(*hz);
  EXPECT_EQ(run.code, 0) << run.err;
  const auto lines = json_lines(run.out);
  ASSERT_EQ(lines.size(), 1U);
  const json::object& item = lines[0].at("items").at(0).as_object();
  EXPECT_EQ(item.at("messages").to_number<int>(), 5);
  EXPECT_EQ(item.at("state").as_string(), "on");
  EXPECT_EQ(item.at("body_max_bytes").to_number<int>(), 100);
  EXPECT_GT(item.at("rate_hz").to_number<double>(), 0);
}

TEST_F(TimsctlTest, ListenRegistersAndAnswersCommandsWithError) {
  auto listener = start({"msg", "echo", "--listen", "Test/0/1", "-n", "2"});
  ASSERT_TRUE(listener);
  ASSERT_TRUE(listener->wait_for_line("is registered"));
  ASSERT_TRUE(ladar_->send({.dest = kTest, .type = -42}));
  ASSERT_TRUE(ladar_->send({.dest = kTest, .type = 42, .seq_nr = 5}));
  const auto answer = expect_request(type::kError);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->seq_nr, 5);
  const Ran run = finish(*listener);
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, HasSubstr("Ladar(0/0) -> Test(0/1) type=-42 "));
}

TEST_F(TimsctlTest, StatsIncludeRemovedMailboxes) {
  const auto replaced = [this] {
    const auto lines = json_lines(timsctl({"stats", "-j"}).out);
    return lines.empty() ? 0 : lines[0].at("mailboxes").at("replaced").to_number<int>();
  };
  {
    auto mailbox = session_->open({.address = kTest, .slots = 1});
    ASSERT_TRUE(mailbox) << mailbox.error().message();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(ladar_->send({.dest = kTest, .type = type::kData}));
    EXPECT_EQ(replaced(), 2);
  }
  EXPECT_EQ(replaced(), 2);
  EXPECT_THAT(timsctl({"stats"}).out, HasSubstr(" 2 replaced, "));
}

TEST_F(TimsctlTest, RouteWatchInJsonIsOneEventPerLine) {
  auto watch = start({"route", "watch", "-j", "-n", "2"});
  ASSERT_TRUE(watch);
  ASSERT_TRUE(watch->wait_for_line("watching"));
  ASSERT_TRUE(session_->open({.address = kTest}));
  const Ran run = finish(*watch);
  EXPECT_EQ(run.code, 0);
  const auto lines = json_lines(run.out);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].at("schema").as_string(), "tims/event/1");
  EXPECT_EQ(lines[0].at("kind").as_string(), "registered");
  EXPECT_EQ(lines[1].at("kind").as_string(), "withdrawn");
  EXPECT_EQ(lines[1].at("address").at("raw").as_string(), kTest.to_hex());
}

TEST_F(TimsctlTest, RouteWatchShowsChangesAlsoAfterARestart) {
  auto watch = start({"route", "watch", "Test"});
  ASSERT_TRUE(watch);
  ASSERT_TRUE(watch->wait_for_line("watching"));
  {
    auto mailbox = session_->open({.address = kTest});
    ASSERT_TRUE(mailbox);
    EXPECT_TRUE(watch->wait_for_line("Test(0/1) registered by laser"));
    EXPECT_FALSE(session_->open({.address = kTest}));
    EXPECT_TRUE(watch->wait_for_line("Test(0/1) refused to laser"));
  }
  EXPECT_TRUE(watch->wait_for_line("Test(0/1) withdrawn by laser"));
  router_.kill();
  ASSERT_TRUE(router_.start());
  EXPECT_TRUE(watch->wait_for_line("has restarted"));
  auto again = session_->open({.address = kTest});
  ASSERT_TRUE(again);
  EXPECT_TRUE(watch->wait_for_line("Test(0/1) registered by laser"));
  watch->signal(SIGINT);
  const Ran run = finish(*watch);
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, Not(HasSubstr("Ladar"))) << "the pattern selects";
}

}  // namespace timsctl_live_test
}  // namespace tims::test
