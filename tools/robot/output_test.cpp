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

TEST_F(ProgramOutputTest, LinesComeWhenTheyAreComplete) {
  write("Module");
  EXPECT_THAT(read(kOutputStart), IsEmpty());
  write(" on\n\nModule off\nTer");
  EXPECT_THAT(read(kOutputStart), ElementsAre("Module on", "", "Module off"));
}

TEST_F(ProgramOutputTest, NobodyFillsTheMemoryWithOneLine) {
  write(std::string(kLineMax - 1, 'x'));
  EXPECT_THAT(read(kOutputStart), IsEmpty());
  write("yz");
  EXPECT_THAT(read(kOutputStart), ElementsAre(std::string(kLineMax - 1, 'x') + "y"));
  writer_.reset();
  EXPECT_THAT(read(kOutputStart), ElementsAre("z"));
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
