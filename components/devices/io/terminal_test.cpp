#include "components/devices/io/terminal.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <optional>

#include <gmock/gmock.h>

#include "tests/support/temporary_folder.h"

namespace rack::device {
namespace terminal_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

class TerminalTest : public testing::Test {
 protected:
  tims::test::TemporaryFolder folder_;
  const std::string link_ = folder_.path() / "line";
};

TEST_F(TerminalTest, TheLinkLeadsToTheOtherEndAndGoesWithTheTerminal) {
  std::optional terminal = std::move(*Terminal::make(link_, 9600));
  EXPECT_TRUE(fs::is_character_file(link_));
  terminal.reset();
  EXPECT_FALSE(fs::exists(fs::symlink_status(link_)));
}

TEST_F(TerminalTest, ALinkInUseIsNotTakenOver) {
  const auto first = Terminal::make(link_, 9600);
  ASSERT_TRUE(first);
  const auto target = fs::read_symlink(link_);
  const auto second = Terminal::make(link_, 9600);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message(), HasSubstr(link_ + " is the line of an emulated device"));
  EXPECT_EQ(fs::read_symlink(link_), target);
}

TEST_F(TerminalTest, TheLinkOfAProgramThatWasKilledIsReplaced) {
  fs::create_symlink("/dev/pts/999999", link_);
  EXPECT_TRUE(Terminal::make(link_, 9600));
}

// As when the number of a killed program's terminal was given to a shell.
TEST_F(TerminalTest, ALinkToATerminalOfAnotherKindIsReplaced) {
  const tims::os::File shell(::posix_openpt(O_RDWR | O_NOCTTY));
  ASSERT_EQ(::unlockpt(shell.get()), 0);
  std::array<char, 64> name{};
  ASSERT_EQ(::ptsname_r(shell.get(), name.data(), name.size()), 0);
  fs::create_symlink(name.data(), link_);
  EXPECT_TRUE(Terminal::make(link_, 9600));
}

TEST_F(TerminalTest, AnotherFileIsNeverTouched) {
  std::ofstream(link_) << "precious";
  const auto made = Terminal::make(link_, 9600);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message(), HasSubstr("is no link to a pseudo terminal"));
  EXPECT_EQ(fs::file_size(link_), 8U);
}

TEST_F(TerminalTest, ALinkThatLeadsElsewhereByNowStays) {
  std::optional terminal = std::move(*Terminal::make(link_, 9600));
  fs::remove(link_);
  fs::create_symlink("/dev/pts/999999", link_);
  terminal.reset();
  EXPECT_TRUE(fs::is_symlink(link_));
}

}  // namespace terminal_test
}  // namespace rack::device
