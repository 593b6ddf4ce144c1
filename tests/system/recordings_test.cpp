// Sessions of original programs with the original router, replayed with ours: an original program
// cannot distinguish them.
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/fleet_keys.h"
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

// All was received as it was recorded, in this number of messages.
void expect_complete(const ReplayResult& result, std::uint64_t messages) {
  EXPECT_TRUE(result.same()) << as_text(result);
  EXPECT_EQ(result.end, ReplayEnd::kComplete);
  EXPECT_EQ(result.received_as_expected, messages);
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

TEST_F(Recordings, OperatorDrivesWithTheGui) { expect_complete(replay_all("a-gui-drive"), 4291); }

TEST_F(Recordings, ClientUsesEveryGenericCommand) {
  expect_complete(replay_all("b-python-client"), 1218);
}

TEST_F(Recordings, Disturbances) { expect_complete(replay_all("c-disturbances"), 2457); }

// The same programs, which know nothing of TLS, by `timsctl tunnel` to a router with keys.
class RecordingsByTunnel : public testing::Test {
 protected:
  // An address of this process alone, so that the port is free.
  RecordingsByTunnel() {
    const unsigned pid = static_cast<unsigned>(::getpid());
    entrance_ = "127." + std::to_string(1 + (pid >> 16) % 254) + "." +
                std::to_string(pid >> 8 & 255) + "." + std::to_string(pid & 255) + ":2000";
  }
  ReplayResult replay_all(const std::string& name) {
    std::vector<std::string> all = settings("256KiB");
    all.insert(all.end(), {keys_.base(), "router.role=top", "router.system=0"});
    RouterProcess router(all);
    const auto started = router.start();
    EXPECT_TRUE(started) << started.error().message();
    auto tunnel = ChildProcess::start({TIMSCTL_PROGRAM, "tunnel", entrance_, router.tcp()},
                                      {.environment = {"TIMS_KEYS=" + operator_}, .folder = {}});
    EXPECT_TRUE(tunnel && tunnel->wait_for_line("leads to"));
    return replay(recording(name), {.endpoint = entrance_});
  }

  FleetKeys keys_;
  const std::string operator_ =
      keys_.user("anna", {.look = true, .drive = true, .configure = true});
  std::string entrance_;
};

TEST_F(RecordingsByTunnel, OperatorDrivesWithTheGui) {
  expect_complete(replay_all("a-gui-drive"), 4291);
}

TEST_F(RecordingsByTunnel, ClientUsesEveryGenericCommand) {
  expect_complete(replay_all("b-python-client"), 1218);
}

}  // namespace recordings_test
}  // namespace tims::test
