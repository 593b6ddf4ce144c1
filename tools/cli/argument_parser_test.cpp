#include "tools/cli/argument_parser.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace timsctl {
namespace argument_parser_test {

using testing::HasSubstr;

// The exit status and the output of a program without verbs.
struct Ended {
  int status;
  std::string output;
};
Ended ended(
    ArgumentParser& line, std::vector<std::string> arguments,
    const std::function<Exit()>& run = [] { return Exit::kDone; }) {
  arguments.insert(arguments.begin(), "x");
  std::vector<char*> argv;
  for (std::string& text : arguments) argv.push_back(text.data());
  argv.push_back(nullptr);
  testing::internal::CaptureStderr();
  const int status = line.run(static_cast<int>(arguments.size()), argv.data(), run);
  return {status, testing::internal::GetCapturedStderr()};
}
Ended ended(const char* argument, const std::function<Exit()>& run) {
  std::uint64_t size = 0;
  ArgumentParser line("x");
  line.option("--size", size, "a size", {0, 100});
  return ended(line, {argument}, run);
}

TEST(RunProgram, ReportsTheErrorAndReturnsItsCode) {
  const auto done = [] { return Exit::kDone; };
  EXPECT_EQ(ended("--size=1", done).status, 0);
  EXPECT_EQ(ended("--other", done).status, 2);
  EXPECT_EQ(ended("--size=101", done).status, 2);
  const auto refused = [] { return throw usage_error("not so"), Exit::kDone; };
  EXPECT_EQ(ended("--size=1", refused).status, 2);
  const auto failed = [] { return throw Failure(Exit::kNoSuch, "x", "a: no", "b"), Exit::kDone; };
  const auto [status, output] = ended("--size=1", failed);
  EXPECT_EQ(status, 4);
  EXPECT_TRUE(output.ends_with(": a: no\n  -> b\n")) << output;
  EXPECT_EQ(ended("--size=1", [] { return throw Interrupted(), Exit::kDone; }).status, 130);
}

class ArgumentParserTest : public testing::Test {
 protected:
  ArgumentParserTest() {
    line_.required_argument("FILE", file_, "a file");
    line_.flag("--quiet", quiet_, "no output");
    line_.option("--name", name_, "a name");
    line_.option("--share", share_, "a share", {0, 1});
    line_.option("--seeds", seeds_, "the seeds", {1, 9});
    line_.option("--set", "NAME=NUMBER", changes_, "another value");
  }

  std::string file_;
  bool quiet_ = false;
  std::string name_ = "usual";
  double share_ = 0.5;
  std::optional<std::uint64_t> seeds_;
  std::vector<std::string> changes_;
  ArgumentParser line_{"x", "What x is for.", "What follows."};
};

TEST_F(ArgumentParserTest, SetsTheVariables) {
  EXPECT_EQ(ended(line_, {"--set", "a=1", "f", "--set=b=2", "--share=0.25", "--quiet"}).status, 0);
  EXPECT_EQ(file_, "f");
  EXPECT_TRUE(quiet_);
  EXPECT_EQ(name_, "usual");
  EXPECT_EQ(share_, 0.25);
  EXPECT_FALSE(seeds_);
  EXPECT_THAT(changes_, testing::ElementsAre("a=1", "b=2"));
  EXPECT_EQ(ended(line_, {"f", "--seeds", "9"}).status, 0);
  EXPECT_EQ(seeds_, 9U);
}

TEST_F(ArgumentParserTest, ErrorsNameWhatIsWrongAndWhereHelpIs) {
  EXPECT_THAT(ended(line_, {"f", "--quite"}).output,
              HasSubstr(": x has no option --quite\n  -> did you mean --quiet?\n"));
  EXPECT_THAT(ended(line_, {}).output, HasSubstr(": FILE is required\n  -> `x --help`\n"));
  EXPECT_THAT(ended(line_, {"f", "g"}).output, HasSubstr(": unexpected argument \"g\"\n"));
  EXPECT_THAT(ended(line_, {"f", "--share=2"}).output, HasSubstr("--share"));
  EXPECT_EQ(ended(line_, {"f", "--seeds=0"}).status, 2);
}

TEST_F(ArgumentParserTest, HelpShowsAllWithTheUsualValues) {
  const auto refused = [] { return Exit::kNo; };
  EXPECT_EQ(ended(line_, {"--help"}, refused).status, 0);
  EXPECT_EQ(ended(line_, {"--version"}, refused).status, 0);
  const std::string help = line_.help();
  for (const char* part : {"What x is for.", "FILE", "a file", "--quiet", "=usual", "=0.5",
                           "--set NAME=NUMBER", "What follows."})
    EXPECT_THAT(help, HasSubstr(part));
}

}  // namespace argument_parser_test
}  // namespace timsctl
