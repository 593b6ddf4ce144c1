#include "router/io/arguments.h"

#include <vector>

#include <fmt/core.h>
#include <gtest/gtest.h>

namespace tims::io {
namespace arguments_test {

Result<Arguments> parse(std::vector<const char*> argv) { return parse_arguments(argv); }

TEST(Arguments, NoneMeanRun) {
  const auto arguments = parse({});
  ASSERT_TRUE(arguments.ok());
  EXPECT_EQ(arguments->action, Arguments::Action::kRun);
  EXPECT_TRUE(arguments->config_path.empty());
}

TEST(Arguments, ValuesStandBehindASpaceOrAnEqualsSign) {
  const auto arguments =
      parse({"--set", "a.b=1", "--config=/etc/r.toml", "--set=c.d=x=y", "check"});
  ASSERT_TRUE(arguments.ok());
  EXPECT_EQ(arguments->action, Arguments::Action::kCheck);
  EXPECT_EQ(arguments->config_path, "/etc/r.toml");
  EXPECT_EQ(arguments->settings, (std::vector<std::string>{"a.b=1", "c.d=x=y"}));
}

TEST(Arguments, TheOriginals) {
  using Settings = std::vector<std::string>;
  EXPECT_EQ(parse({"-P", "10"})->settings, Settings{"router.priority=10"});
  EXPECT_EQ(parse({"-p", "2001"})->settings, Settings{"tcp.listen=127.0.0.1:2001"});
  EXPECT_EQ(parse({"-i", "10.0.0.1"})->settings, Settings{"tcp.listen=10.0.0.1:2000"});
  EXPECT_EQ(parse({"-i", "10.0.0.1", "-m", "1024", "-p", "2001", "-l", "0"})->settings,
            (Settings{"message.max=1024KiB", "tcp.listen=10.0.0.1:2001"}));
  EXPECT_EQ(parse({"-m64"})->settings, Settings{"message.max=64KiB"});
  EXPECT_EQ(parse({"-l", "2"})->settings, Settings{"log.level=debug"});
  for (const char* argument : {"-i", "-p", "-m", "-l", "-P"})
    EXPECT_EQ(parse({argument}).error().detail(), fmt::format("{} needs a value", argument));
}

// Later ones win.
TEST(Arguments, SettingsStayInTheirOrder) {
  EXPECT_EQ(parse({"--set", "a=1", "-m", "64", "--set", "message.max=1MiB", "-P", "3"})->settings,
            (std::vector<std::string>{"a=1", "message.max=64KiB", "message.max=1MiB",
                                      "router.priority=3"}));
  EXPECT_EQ(parse({"check", "--set", "a=1", "--set", "-b"})->settings,
            (std::vector<std::string>{"a=1", "-b"}));
  EXPECT_EQ(parse({"--config", "a", "--config", "b"})->config_path, "b");
}

TEST(Arguments, KnowsItsActions) {
  using Action = Arguments::Action;
  EXPECT_EQ(parse({"--print-config"})->action, Action::kPrintConfig);
  EXPECT_EQ(parse({"--version"})->action, Action::kVersion);
  EXPECT_EQ(parse({"--help"})->action, Action::kHelp);
  EXPECT_EQ(parse({"-h"})->action, Action::kHelp);
}

TEST(Arguments, NamesWhatItDoesNotUnderstand) {
  for (const char* argument : {"--configuration", "start", "-x", ""}) {
    const auto arguments = parse({argument});
    ASSERT_FALSE(arguments.ok()) << argument;
    EXPECT_EQ(arguments.error().detail(), fmt::format("\"{}\" is not known here", argument));
  }
  EXPECT_EQ(parse({"--sets"}).error().detail(),
            "\"--sets\" is not known here (did you mean --set?)");
  EXPECT_EQ(parse({"chek"}).error().detail(), "\"chek\" is not known here (did you mean check?)");
  EXPECT_EQ(parse({"check", "--sett=x"}).error().detail(),
            "\"--sett=x\" is not known here (did you mean --set?)");
  EXPECT_EQ(parse({"--set"}).error().detail(), "--set needs a value");
  EXPECT_EQ(parse({"--config"}).error().detail(), "--config needs a value");
}

}  // namespace arguments_test
}  // namespace tims::io
