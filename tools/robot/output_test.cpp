#include "tools/robot/output.h"

#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace timsctl::robot {
namespace output_test {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr tims::Time kOutputStart{1000s};

TEST(LineBuffer, LinesComeWhenTheyAreComplete) {
  LineBuffer buffer;
  EXPECT_THAT(buffer.add("Module"), IsEmpty());
  EXPECT_THAT(buffer.add(" on\n\nModule off\nTer"), ElementsAre("Module on", "", "Module off"));
  EXPECT_EQ(buffer.take_rest(), "Ter");
  EXPECT_EQ(buffer.take_rest(), "");
}

TEST(LineBuffer, NobodyFillsTheMemoryWithOneLine) {
  LineBuffer buffer;
  EXPECT_THAT(buffer.add(std::string(kLineMax - 1, 'x')), IsEmpty());
  EXPECT_THAT(buffer.add("yz"), ElementsAre(std::string(kLineMax - 1, 'x') + "y"));
  EXPECT_EQ(buffer.take_rest(), "z");
}

// --- FloodGate

TEST(FloodGate, ManyLinesAtOncePassAndNoMore) {
  FloodGate gate;
  EXPECT_EQ(gate.pass(kOutputStart, kLinesAtOnce - 1), kLinesAtOnce - 1);
  EXPECT_TRUE(gate.pass(kOutputStart));
  EXPECT_FALSE(gate.is_cut());
  EXPECT_EQ(gate.report_at(), tims::kNever);
  EXPECT_FALSE(gate.pass(kOutputStart));
  EXPECT_TRUE(gate.is_cut());
}

TEST(FloodGate, ANormalRatePassesForEver) {
  FloodGate gate;
  for (int second = 0; second < 100; ++second)
    ASSERT_EQ(gate.pass(kOutputStart + second * 1s, kLinesPerSecond), kLinesPerSecond) << second;
}

TEST(FloodGate, AFloodIsCountedAndReportedNowAndThen) {
  FloodGate gate;
  std::uint64_t passed = 0;
  std::uint64_t reported = 0;
  int reports = 0;
  constexpr int kSeconds = 60;
  constexpr std::uint64_t kEach = 1000;  // every 10 ms
  for (int i = 0; i < kSeconds * 100; ++i) {
    const tims::Time now = kOutputStart + i * 10ms;
    passed += gate.pass(now, kEach);
    if (const auto held_back = gate.take_report(now)) {
      reported += *held_back;
      ++reports;
    }
  }
  EXPECT_LE(passed, kLinesAtOnce + kLinesPerSecond);
  EXPECT_GE(reports, kSeconds / 10 - 1);
  EXPECT_LE(reports, kSeconds / 10 + 1);
  const auto rest = gate.take_report(kOutputStart + 100s);
  EXPECT_EQ(passed + reported + rest.value_or(0), kEach * kSeconds * 100);
}

TEST(FloodGate, OpensWhenTheFloodIsOver) {
  FloodGate gate;
  EXPECT_EQ(gate.pass(kOutputStart, 2 * kLinesAtOnce), kLinesAtOnce);
  EXPECT_FALSE(gate.take_report(kOutputStart + 999ms));
  EXPECT_EQ(gate.take_report(kOutputStart + 1s), kLinesAtOnce);
  EXPECT_EQ(gate.report_at(), tims::kNever);
  EXPECT_TRUE(gate.pass(kOutputStart + 3s)) << "a quiet second has passed";
}

TEST(FloodGate, StaysClosedForARateAboveTheLimit) {
  FloodGate gate;
  (void)gate.pass(kOutputStart, kLinesAtOnce + 1);
  EXPECT_EQ(gate.pass(kOutputStart + 500ms, kLinesPerSecond + 1), 0U);
  EXPECT_EQ(gate.pass(kOutputStart + 1s, kLinesPerSecond), 0U) << "too many in the last second";
  EXPECT_TRUE(gate.pass(kOutputStart + 2s)) << "not more than allowed in the last second";
}

// --- ProgramOutput

class ProgramOutputTest : public testing::Test {
 protected:
  void SetUp() override {
    auto pipe = tims::os::make_pipe();
    ASSERT_TRUE(pipe.ok());
    output_ = ProgramOutput(std::move(pipe->read));
    writer_ = std::move(pipe->write);
  }
  void write(const std::string& text) const {
    ASSERT_EQ(::write(writer_.get(), text.data(), text.size()), std::ssize(text));
  }
  std::vector<std::string> read(tims::Time now) {
    std::vector<std::string> lines;
    output_.read(now, gate_, lines);
    return lines;
  }

  ProgramOutput output_;
  tims::os::File writer_;
  FloodGate gate_;
};

TEST_F(ProgramOutputTest, ReadsUntilAllWritersHaveClosedIt) {
  write("one\ntwo");
  EXPECT_THAT(read(kOutputStart), ElementsAre("one"));
  EXPECT_THAT(read(kOutputStart), IsEmpty());
  EXPECT_GE(output_.descriptor(kOutputStart), 0);
  writer_.reset();
  EXPECT_THAT(read(kOutputStart), ElementsAre("two"));
  EXPECT_EQ(output_.descriptor(kOutputStart), -1);
  EXPECT_EQ(output_.rests_until(), tims::kNever);
}

TEST_F(ProgramOutputTest, OneTurnIsBounded) {
  const std::string line = std::string(1023, 'x') + "\n";
  for (int i = 0; i < 40; ++i) write(line);  // 40 KiB
  EXPECT_EQ(read(kOutputStart).size(), kReadPerTurn / line.size());
  EXPECT_EQ(output_.descriptor(kOutputStart), -1) << "it rests";
  EXPECT_EQ(output_.rests_until(), kOutputStart + kReadPause);
  EXPECT_THAT(read(kOutputStart), IsEmpty());
  EXPECT_EQ(read(kOutputStart + kReadPause).size(), kReadPerTurn / line.size());
  EXPECT_EQ(read(kOutputStart + 2 * kReadPause).size(), 40 - 2 * kReadPerTurn / line.size());
  EXPECT_GE(output_.descriptor(kOutputStart + 2 * kReadPause), 0) << "nothing more: no rest";
}

TEST_F(ProgramOutputTest, LinesOfAFloodAreCounted) {
  write(std::string(kReadPerTurn, '\n'));
  EXPECT_EQ(read(kOutputStart).size(), kLinesAtOnce);
  write(std::string(3000, '\n'));
  EXPECT_THAT(read(kOutputStart + kReadPause), IsEmpty());
  EXPECT_EQ(gate_.take_report(kOutputStart + 1s), kReadPerTurn - kLinesAtOnce + 3000);
}

}  // namespace output_test
}  // namespace timsctl::robot
