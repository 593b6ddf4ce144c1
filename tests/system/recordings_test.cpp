// Sessions of original programs with the original router, replayed with ours: an original program
// cannot distinguish them.
#include <memory>

#include <gtest/gtest.h>

#include "tests/support/recording.h"
#include "tests/support/replay.h"
#include "tests/support/router_process.h"

namespace tims::test {
namespace recordings_test {

// Settings of the recorded router. Clients that do not answer are closed sooner, to save time.
std::vector<std::string> settings(const std::string& message_max) {
  return {"tcp.compat_delete=true", "message.max=" + message_max, "lifesign.interval=2s"};
}

Recording recording(const std::string& name) {
  auto read = read_recording(TIMS_TEST_DATA_DIR "/recordings/" + name + ".jsonl.gz");
  EXPECT_TRUE(read) << read.error().message();
  return read ? *std::move(read) : Recording();
}

std::string as_text(const ReplayResult& result) {
  std::string text = result.summary() + "\n";
  for (const Difference& d : result.differences) text += d.to_string() + "\n";
  return text;
}

class Recordings : public testing::Test {
 protected:
  void SetUp() override {
    const auto started = router_->start();
    ASSERT_TRUE(started) << started.error().message();
  }

  // Kills the router and starts one that accepts longer messages: mark K1 of the third recording.
  Result<std::string> restart() {
    router_->kill();
    router_ = std::make_unique<RouterProcess>(settings("1MiB"));
    if (auto started = router_->start(); !started) return started.error();
    return router_->tcp();
  }

  ReplayResult replay_all(const std::string& name) {
    const Recording session = recording(name);
    ReplayOptions options{.endpoint = router_->tcp()};
    options.restart = [this] { return restart(); };
    return replay(session, options);
  }

  std::unique_ptr<RouterProcess> router_ = std::make_unique<RouterProcess>(settings("256KiB"));
};

TEST_F(Recordings, OperatorDrivesWithTheGui) {
  const ReplayResult result = replay_all("a-gui-drive");
  EXPECT_TRUE(result.same()) << as_text(result);
  EXPECT_EQ(result.end, ReplayEnd::kComplete);
  EXPECT_EQ(result.received_as_expected, 4291U);
}

TEST_F(Recordings, ClientUsesEveryGenericCommand) {
  const ReplayResult result = replay_all("b-python-client");
  EXPECT_TRUE(result.same()) << as_text(result);
  EXPECT_EQ(result.end, ReplayEnd::kComplete);
  EXPECT_EQ(result.received_as_expected, 1218U);
}

TEST_F(Recordings, Disturbances) {
  const ReplayResult result = replay_all("c-disturbances");
  EXPECT_TRUE(result.same()) << as_text(result);
  EXPECT_EQ(result.end, ReplayEnd::kComplete);
  EXPECT_EQ(result.received_as_expected, 2457U);
}

}  // namespace recordings_test
}  // namespace tims::test
