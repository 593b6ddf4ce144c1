#include "components/runtime/logic/arguments.h"

#include <array>

#include <gtest/gtest.h>

namespace rack {
namespace arguments_test {

constexpr std::array<ParameterInfo, 3> kOwn = {{
    {"scan2dInst", 0, "instance of the scanner", 0, 255, true},
    {"scan2dSys", 0, "its system", 0, 255},
    {"vxMax", 700, "largest speed, mm/s", 0, 10000},
}};

struct ArgumentsTest : testing::Test {
  tims::Result<Arguments> parse(std::vector<const char*> arguments) {
    return parse_arguments(arguments, parameters);
  }
  std::string error(std::vector<const char*> arguments) {
    const auto result = parse(std::move(arguments));
    return result ? "" : result.error().detail();
  }
  Parameters parameters{"PilotJoystick", kOwn};
};

TEST_F(ArgumentsTest, InEveryForm) {
  const auto result = parse({"--scan2dInst", "1", "-vxMax", "300", "--cmdTaskPrio=30",
                             "-dataTaskPrio=29", "--router", "unix:/tmp/r"});
  ASSERT_TRUE(result) << result.error().message();
  EXPECT_EQ(result->router, "unix:/tmp/r");
  EXPECT_EQ(parameters.integer("scan2dInst"), 1);
  EXPECT_EQ(parameters.integer("vxMax"), 300);
  EXPECT_EQ(parameters.integer("cmdTaskPrio"), 30);
  EXPECT_EQ(parameters.integer("dataTaskPrio"), 29);
}

TEST_F(ArgumentsTest, AsMuchOfANameAsIsUnique) {
  ASSERT_TRUE(parse({"--scan2dI", "1", "--vx=5"}));
  EXPECT_EQ(parameters.integer("vxMax"), 5);
  EXPECT_EQ(error({"--scan2d", "1"}),
            "--scan2d can be --scan2dInst or --scan2dSys (--help lists the options)");
}

TEST_F(ArgumentsTest, TheHolderIsWrittenOut) {
  const auto held = parse({"--scan2dInst=1", "--heldOffBy=0x00020001"});
  ASSERT_TRUE(held);
  EXPECT_EQ(held->held_off_by, tims::Address(0x00020001));
  EXPECT_TRUE(parse({"--he"})->help) << "the beginning of nothing else";
  EXPECT_FALSE(parse({"--scan2dInst=1"})->held_off_by);
}

TEST_F(ArgumentsTest, SayWhatIsWrong) {
  EXPECT_EQ(error({"--vMax", "1"}), "unknown option --vMax (--help lists the options)");
  EXPECT_EQ(error({"vxMax=1"}),
            "vxMax=1 is not an option: options begin with -- (--help lists the options)");
  EXPECT_EQ(error({"--vxMax"}), "--vxMax needs a value (--help lists the options)");
  EXPECT_EQ(error({"--vxMax", "-1"}),
            "--vxMax = -1: must be a whole number from 0 to 10000 (--help lists the options)");
  EXPECT_EQ(error({"--vxMax", "1"}),
            "--scan2dInst is missing: instance of the scanner (--help lists the options)");
}

TEST_F(ArgumentsTest, VersionNeedsNothingElse) {
  const auto result = parse({"--version"});
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->version);
}

TEST_F(ArgumentsTest, DescribeNeedsNothingElseAndIsWrittenOut) {
  const auto result = parse({"--describe"});
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->describe);
  EXPECT_EQ(error({"--describ"}), "unknown option --describ (--help lists the options)");
}

TEST_F(ArgumentsTest, ChoicesAreHelp) {
  EXPECT_NE(usage(parameters, "Drives.")
                .find("level of log texts: 0 print, 1 error, 2 warning, 3 info, 4 detail (2;"),
            std::string::npos);
}

TEST_F(ArgumentsTest, HelpNeedsNothingElse) {
  const auto result = parse({"--help"});
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->help);
  const std::string text = usage(parameters, "Drives.");
  EXPECT_NE(text.find("largest speed, mm/s (700; a whole number from 0 to 10000)"),
            std::string::npos);
  EXPECT_NE(text.find("instance of the scanner (required;"), std::string::npos);
}

}  // namespace arguments_test
}  // namespace rack
