// A short run of `rack-dora`: the whole fleet of the robot Dora starts, all steps run, and nothing
// is left behind. This test does not judge timing; that needs a quiet machine.
#include <csignal>
#include <filesystem>

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/parse.hpp>
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/support/child_process.h"

namespace tims::test {
namespace dora_test {

namespace fs = std::filesystem;
namespace json = boost::json;
using namespace std::chrono_literals;
using testing::Contains;
using testing::IsEmpty;

constexpr int kInterrupted = 130;
constexpr int kNoFleet = 5;

class DoraTest : public testing::Test {
 protected:
  void SetUp() override {
    if (RACK_WITH_OPENCV == 0) GTEST_SKIP() << "this robot has a camera";
    if (::geteuid() != 0) GTEST_SKIP() << "network namespaces need root";
    if (!lines().empty()) GTEST_SKIP() << "another Dora is running: " << lines().front();
  }
  static ChildProcess start(std::vector<std::string> arguments) {
    std::vector<std::string> command = {TIMS_PROGRAMS "/rack-dora", "--fleet-file", DORA_FLEET};
    command.insert(command.end(), arguments.begin(), arguments.end());
    auto child = ChildProcess::start(std::move(command));
    EXPECT_TRUE(child) << child.error().message();
    return std::move(*child);
  }
  // Files and namespaces that a fleet of that process has not removed.
  static std::vector<std::string> left_by(pid_t process) {
    std::vector<std::string> left;
    const std::string name = "dora" + std::to_string(process % 100000);
    for (const char* const folder : {"/run/netns", "/run/tims-sim", "/tmp"}) {
      std::error_code none;
      for (const auto& entry : fs::directory_iterator(folder, none))
        if (entry.path().filename().string().find(name) != std::string::npos)
          left.push_back(entry.path());
    }
    for (std::string& line : lines()) left.push_back(std::move(line));
    return left;
  }
  // The lines of Dora's devices; only one Dora can run at a time.
  static std::vector<std::string> lines() {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator("/tmp"))
      if (entry.path().filename().string().starts_with("rack-dora-1-")) all.push_back(entry.path());
    return all;
  }
};

std::string text(const json::object& row, const char* name) {
  return std::string(row.at(name).as_string());
}

TEST_F(DoraTest, DrivesStopsAndContinuesAutonomously) {
  auto dora = start({"--for", "5s", "--json"});
  const pid_t process = dora.pid();
  const auto ended = dora.wait(90s);
  ASSERT_TRUE(ended) << dora.output();
  if (ended->code == kNoFleet) GTEST_SKIP() << "no network namespaces here: " << dora.output();
  EXPECT_THAT((std::vector{0, 1, 3}), Contains(ended->code)) << dora.output();
  const auto table = json::parse(dora.standard_output()).as_object();
  std::vector<std::string> failed;
  int periods = 0;
  for (const auto& item : table.at("items").as_array()) {
    const auto& row = item.as_object();
    const std::string what = text(row, "what");
    const std::string measured = text(row, "measured");
    const bool held = text(row, "verdict") == "held";
    // All messages must arrive, in time or not. Steps that do not fit in five seconds are no
    // failure.
    if (what.starts_with("period of ")) {
      ++periods;
      if (measured.find("intervals received") != std::string::npos) failed.push_back(what);
    } else if (what.starts_with("posts that appear") ||
               what == "programs that ended unexpectedly") {
      if (!held) failed.push_back(fmt::format("{}: {}", what, measured));
    }
  }
  EXPECT_EQ(periods, 10);
  EXPECT_THAT(failed, IsEmpty());
  EXPECT_THAT(left_by(process), IsEmpty());
}

TEST_F(DoraTest, LeavesNothingWhenItIsInterrupted) {
  auto dora = start({"--for", "1min"});
  const pid_t process = dora.pid();
  if (!dora.wait_for_line("the robot drives", 60s)) {
    const auto ended = dora.wait(1s);
    if (ended && ended->code == kNoFleet) GTEST_SKIP() << "no network namespaces here";
    FAIL() << dora.output();
  }
  const auto ended = dora.stop(SIGINT, 30s);
  ASSERT_TRUE(ended) << dora.output();
  EXPECT_EQ(ended->code, kInterrupted);
  EXPECT_THAT(left_by(process), IsEmpty());
}

}  // namespace dora_test
}  // namespace tims::test
