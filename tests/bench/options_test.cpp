#include "tests/bench/options.h"

#include <gtest/gtest.h>

namespace tims::bench {
namespace options_test {

Result<Options> parse(const std::vector<std::string>& arguments) {
  return parse_options(arguments);
}

TEST(Options, ScenariosAndOptionsInAnyOrder) {
  const auto options = parse({"local_rtt", "--csv", "out.csv", "--quick", "idle", "--reps", "5"});
  ASSERT_TRUE(options) << options.error().message();
  EXPECT_EQ(options->scenarios, (std::vector<std::string>{"local_rtt", "idle"}));
  EXPECT_EQ(options->csv, "out.csv");
  EXPECT_TRUE(options->quick);
  EXPECT_EQ(options->reps, 5);
}

TEST(Options, SecondsMayBeFractions) {
  const auto options = parse({"--seconds", "0.25"});
  ASSERT_TRUE(options);
  EXPECT_EQ(options->seconds, std::chrono::milliseconds(250));
}

TEST(Options, InvalidArgumentsAreRefused) {
  EXPECT_FALSE(parse({"--reps", "none"}));
  EXPECT_FALSE(parse({"--csv"}));
  EXPECT_FALSE(parse({"--fast"}));
}

TEST(Options, AScenarioSelectsItsVariants) {
  Options options;
  EXPECT_TRUE(options.selects("anything"));
  options.scenarios = {"local_rtt"};
  EXPECT_TRUE(options.selects("local_rtt"));
  EXPECT_TRUE(options.selects("local_rtt@1cpu"));
  EXPECT_FALSE(options.selects("router_rtt"));
  options.scenarios = {"local_rtt@1cpu"};
  EXPECT_FALSE(options.selects("local_rtt"));
}

}  // namespace options_test
}  // namespace tims::bench
