#include "tools/timsctl/robot/line_buffer.h"

#include <gmock/gmock.h>

namespace timsctl::robot {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

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

}  // namespace
}  // namespace timsctl::robot
