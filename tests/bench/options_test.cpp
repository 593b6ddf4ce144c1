#include "tests/bench/options.h"

#include <gtest/gtest.h>

namespace tims::bench {
namespace options_test {

Options parse(const std::vector<std::string>& arguments) {
  Options options;
  timsctl::ArgumentParser parser("tims-bench");
  add_options(parser, options);
  parser.parse(arguments);
  return options;
}

TEST(Options, ScenariosAndOptionsInAnyOrder) {
  const Options options =
      parse({"local_rtt", "--csv", "out.csv", "--quick", "idle", "--reps", "5", "--seconds=0.25"});
  EXPECT_EQ(options.scenarios, (std::vector<std::string>{"local_rtt", "idle"}));
  EXPECT_EQ(options.csv, "out.csv");
  EXPECT_TRUE(options.quick);
  EXPECT_EQ(options.reps, 5U);
  EXPECT_EQ(options.seconds, 0.25);
}

TEST(Options, InvalidArgumentsAreRefused) {
  using timsctl::Failure;
  EXPECT_THROW(parse({"--reps", "none"}), Failure);
  EXPECT_THROW(parse({"--reps", "0"}), Failure);
  EXPECT_THROW(parse({"--seconds", "0"}), Failure);
  EXPECT_THROW(parse({"--csv"}), Failure);
  EXPECT_THROW(parse({"--fast"}), Failure);
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
