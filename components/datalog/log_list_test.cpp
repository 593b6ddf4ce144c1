#include "components/datalog/log_list.h"

#include <gtest/gtest.h>

namespace rack::datalog {
namespace {

std::string refusal(std::string_view text) {
  const auto list = read_list(text);
  return list ? "it was read" : list.error().detail();
}

TEST(LogList, IsReadToAnEmptyLine) {
  const auto list = read_list("00120000 odo.dat\n0x00190100 scan.dat\r\n\nwhatever\n");
  ASSERT_TRUE(list.ok());
  ASSERT_EQ(list->size(), 2U);
  EXPECT_EQ((*list)[0].moduleMbx, tims::Address(0x00120000));
  EXPECT_EQ((*list)[0].filename, "odo.dat");
  EXPECT_EQ((*list)[0].logEnable, 0) << "until it is told so";
  EXPECT_EQ((*list)[0].maxDataLen, 28);
  EXPECT_EQ((*list)[1].moduleMbx, tims::Address(0x00190100));
  EXPECT_EQ((*list)[1].filename, "scan.dat");
  EXPECT_TRUE(read_list("")->empty());
}

TEST(LogList, RefusesWhatIsNone) {
  EXPECT_EQ(refusal("00120000\n"), "line 1: expected an address, a blank and a file name");
  EXPECT_EQ(refusal("00120000 a\nhello b\n"), "line 2: the address is no hexadecimal number");
  EXPECT_EQ(refusal("00170000 joystick.dat"), "line 1: data of this class are not recorded");
  EXPECT_EQ(refusal("00120000 " + std::string(40, 'a')),
            "line 1: the file name is longer than 39 characters");
  std::string long_list;
  for (int i = 0; i < 101; ++i) long_list += "00120000 a\n";
  EXPECT_EQ(refusal(long_list), "line 101: more than 100 modules");
}

TEST(BaseOf, DotsOfFoldersDoNotCount) {
  EXPECT_EQ(base_of("/tmp/a.b/scan.dat"), "/tmp/a.b/scan");
  EXPECT_EQ(base_of("/tmp/a.b/scan"), "/tmp/a.b/scan");
  EXPECT_EQ(base_of("scan.1.dat"), "scan.1");
}

}  // namespace
}  // namespace rack::datalog
