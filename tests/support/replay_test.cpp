// The replay with a model of the original router: no differences without a fault, and every fault
// is found.
#include "tests/support/replay.h"

#include <gtest/gtest.h>

#include "os/wakeup.h"
#include "tests/support/model_router.h"

namespace tims::test {
namespace replay_test {

constexpr const char* kDrive = TIMS_TEST_DATA_DIR "/recordings/a-gui-drive.jsonl.gz";
constexpr const char* kPython = TIMS_TEST_DATA_DIR "/recordings/b-python-client.jsonl.gz";
constexpr const char* kDisturbances = TIMS_TEST_DATA_DIR "/recordings/c-disturbances.jsonl.gz";

constexpr Duration kBeat = std::chrono::seconds(2);
// For faults that are detected only by a message that does not arrive.
constexpr Duration kShort = std::chrono::seconds(3);
constexpr Duration kLong = std::chrono::seconds(30);

Recording read(const char* path) {
  auto recording = read_recording(path);
  EXPECT_TRUE(recording) << recording.error().message();
  return recording ? *std::move(recording) : Recording();
}

std::string all(const ReplayResult& result) {
  std::string text = result.summary() + "\n";
  for (const Difference& d : result.differences) text += d.to_string() + "\n";
  return text;
}

TEST(Replay, DriveOfTheGui) {
  const ModelRouter router({});
  const ReplayResult result = replay(read(kDrive), {.endpoint = router.endpoint()});
  EXPECT_TRUE(result.same()) << all(result);
  EXPECT_EQ(result.end, ReplayEnd::kComplete);
  EXPECT_EQ(result.received_as_expected, 4291U);
  EXPECT_EQ(result.connections, 18);
}

TEST(Replay, PythonClient) {
  const ModelRouter router({});
  const ReplayResult result = replay(read(kPython), {.endpoint = router.endpoint()});
  EXPECT_TRUE(result.same()) << all(result);
  EXPECT_EQ(result.received_as_expected, 1218U);
}

TEST(Replay, Disturbances) {
  auto router = std::make_unique<ModelRouter>(ModelRouterOptions{.beat = kBeat});
  ReplayOptions options{.endpoint = router->endpoint()};
  options.restart = [&]() -> Result<std::string> {
    router =
        std::make_unique<ModelRouter>(ModelRouterOptions{.message_max = 1 << 20, .beat = kBeat});
    return router->endpoint();
  };
  const ReplayResult result = replay(read(kDisturbances), options);
  EXPECT_TRUE(result.same()) << all(result);
  EXPECT_EQ(result.end, ReplayEnd::kComplete);
  EXPECT_EQ(result.received_as_expected, 2457U);
  EXPECT_EQ(result.connections, 47);
}

TEST(Replay, EndsAtTheRestartWithoutARestartFunction) {
  const ModelRouter router({.message_max = 16 << 20, .beat = kBeat});
  const ReplayResult result =
      replay(read(kDisturbances), {.endpoint = router.endpoint(), .message_max = 16 << 20});
  EXPECT_TRUE(result.same()) << all(result);
  EXPECT_EQ(result.end, ReplayEnd::kNeedsRestart);
  EXPECT_EQ(result.left_out, 2) << "F3 and F4 would pass";
}

struct FaultCase {
  Fault fault;
  const char* path;
  int type;              // type of the messages to which the fault may apply
  const char* expected;  // part of the text of the first difference
  Duration answer_limit = kLong;
};

class ReplayFinds : public testing::TestWithParam<FaultCase> {};

TEST_P(ReplayFinds, Fault) {
  const FaultCase& c = GetParam();
  const ModelRouter router({.beat = kBeat, .fault = c.fault, .befalls = [&](const Header& h) {
                              return h.type == c.type;
                            }});
  ReplayOptions options{.endpoint = router.endpoint()};
  options.answer_limit = c.answer_limit;
  options.silence_limit = 3 * kBeat;
  options.differences_max = 1;
  const ReplayResult result = replay(read(c.path), options);
  ASSERT_FALSE(result.same());
  const std::string text = result.differences.front().to_string();
  EXPECT_NE(text.find(c.expected), std::string::npos) << text;
}

constexpr int kBurst = 40;  // type of the messages of mark E1: 52 sent without a pause

void PrintTo(const FaultCase& c, std::ostream* out) { *out << c.expected << " in " << c.path; }

INSTANTIATE_TEST_SUITE_P(
    All, ReplayFinds,
    testing::Values(FaultCase{Fault::kLosesMessage, kPython, type::kOn, "got nothing", kShort},
                    FaultCase{Fault::kLosesMessage, kDisturbances, kBurst, "got nothing", kShort},
                    FaultCase{Fault::kRepeatsMessage, kPython, type::kOn, "expected nothing"},
                    FaultCase{Fault::kAltersBody, kPython, type::kData, "expected type -6", kShort},
                    FaultCase{Fault::kAltersPriority, kPython, type::kOn, "prio", kShort},
                    FaultCase{Fault::kSwapsMessages, kDisturbances, kBurst, "sent later"},
                    FaultCase{Fault::kHangsUp, kPython, type::kOn, "closed by the router"},
                    FaultCase{Fault::kAnswersReplies, kPython, 0, "expected nothing"},
                    FaultCase{Fault::kRegistersTwice, kPython, 0, "type -1", kShort},
                    FaultCase{Fault::kKeepsMailboxes, kPython, 0, "mailboxes gone", kShort},
                    FaultCase{Fault::kKeepsTooLongMessages, kDisturbances, 0,
                              "expected closed by the router"},
                    FaultCase{Fault::kNeverClosesSilent, kDisturbances, 0,
                              "expected closed by the router", kShort}));

TEST(Replay, StopsOnRequest) {
  const ModelRouter router({});
  auto stop = os::make_event_fd();
  ASSERT_TRUE(stop);
  ReplayOptions options{.endpoint = router.endpoint(), .pace = 1};
  options.stop_fd = stop->get();
  options.on_mark = [&](const recorded::Line& line) {
    if (line.number > 1) os::signal_event_fd(stop->get());
  };
  const ReplayResult result = replay(read(kPython), options);
  EXPECT_EQ(result.end, ReplayEnd::kStopped);
  EXPECT_TRUE(result.same());
}

TEST(Replay, KeepsTheRecordedTimes) {
  const ModelRouter router({});
  const ReplayResult result = replay(read(kPython), {.endpoint = router.endpoint(), .pace = 20});
  EXPECT_TRUE(result.same()) << all(result);
  EXPECT_GE(result.took, std::chrono::milliseconds(31386 / 20));
}

TEST(Replay, NoRouter) {
  const ReplayResult result = replay(read(kPython), {.endpoint = "127.0.0.1:1"});
  EXPECT_EQ(result.end, ReplayEnd::kGaveUp);
  EXPECT_EQ(result.lines, 0);
}

}  // namespace replay_test
}  // namespace tims::test
