#include "tools/timsctl/command_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/cli/failure.h"
#include "tools/cli/options.h"

namespace timsctl {
namespace command_line_test {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using Words = std::vector<std::string>;

std::variant<Command, Text> parse(const Words& words) {
  return parse_line(timsctl_program(), split_line(timsctl_program(), words));
}
Command command(const Words& words) { return std::get<Command>(parse(words)); }
std::string text(const Words& words) { return std::get<Text>(parse(words)).text; }
std::string refusal(const Words& words) {
  try {
    (void)parse(words);
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.exit, Exit::kUsage);
    return failure.message + "; " + failure.hint;
  }
  return "accepted";
}

TEST(SplitLine, OptionsInOneForm) {
  const Options options = command({"-jn5", "route", "--count", "3", "show", "-n", "4", "-w",
                                   "Ladar", "-w0.5", "--watch=3", "-H", "robot", "--sort=", "-jw"})
                              .options;
  EXPECT_THAT(options.arguments, ElementsAre("Ladar"));
  EXPECT_THAT(options.given, ElementsAre("--json", "--count=5", "--count=3", "--count=4",
                                         "--watch=2", "--watch=0.5", "--watch=3", "--host=robot",
                                         "--sort=", "--json", "--watch=2"));
  EXPECT_EQ(options.count, 4U);
}

TEST(SplitLine, NegativeNumbersAndDashesAreArguments) {
  EXPECT_THAT(command({"msg", "pub", "A", "-6", "-", "[a,b]", "", "--", "-x", "--", "--count="})
                  .options.arguments,
              ElementsAre("A", "-6", "-", "[a,b]", "", "-x", "--", "--count="));
  EXPECT_EQ(command({"route", "get", "A", "--type", "-6"}).options.type, "-6");
}

TEST(SplitLine, WhatFollowsACommandIsItsOwn) {
  const Options options =
      command({"sim", "exec", "--fleet", "demo", "base", "-j", "ls", "-j", "--", "--x="}).options;
  EXPECT_THAT(options.arguments, ElementsAre("base", "ls", "-j", "--", "--x="));
  EXPECT_THAT(options.given, ElementsAre("--fleet=demo", "--json"));
  EXPECT_THAT(command({"sim", "fault", "robot1-base", "cut", "-j"}).options.given,
              ElementsAre("--json"));
  EXPECT_THAT(command({"__complete", "status", "-"}).options.arguments, ElementsAre("status", "-"));
}

TEST(Verbs, PrefixesThatAreUniqueAreEnough) {
  EXPECT_EQ(command({"mb", "li"}).verb->name(), "mbx list");
  EXPECT_EQ(command({"route", "g", "Ladar/0/0"}).verb->name(), "route get");
}

TEST(Verbs, ShowIsTheDefault) {
  EXPECT_EQ(command({}).verb->name(), "status");
  EXPECT_EQ(command({"route"}).verb->name(), "route show");
  EXPECT_EQ(command({"mbx"}).verb->name(), "mbx list");
  const Command glob = command({"mbx", "Ladar(*/*)"});
  EXPECT_EQ(glob.verb->name(), "mbx list");
  EXPECT_THAT(glob.options.arguments, ElementsAre("Ladar(*/*)"));
}

TEST(CommandLine, OptionsMayStandAnywhere) {
  const Command c = command({"-H", "robot:2001", "msg", "--period", "100ms", "echo", "Ladar/0/0",
                             "-n", "3", "--json", "--priority", "7"});
  EXPECT_EQ(c.verb->name(), "msg echo");
  EXPECT_EQ(c.options.host, "robot:2001");
  EXPECT_EQ(c.options.period, 100ms);
  EXPECT_EQ(c.options.count, 3U);
  EXPECT_EQ(c.options.priority, 7);
  EXPECT_TRUE(c.options.json());
  EXPECT_EQ(command({"ping", "Test/0/0", "--once"}).options.count, 1U);
  EXPECT_THAT(command({"msg", "pub", "Test/0/0", "-6"}).options.arguments,
              ElementsAre("Test/0/0", "-6"));
}

TEST(CommandLine, RefusalsSayWhatAndWhatToDo) {
  EXPECT_THAT(refusal({"statsu"}), HasSubstr("did you mean status"));
  EXPECT_THAT(refusal({"rou"}), HasSubstr("router, route"));
  EXPECT_THAT(refusal({"route", "shwo"}), HasSubstr("did you mean show"));
  EXPECT_THAT(refusal({"msg"}), HasSubstr("the verb is missing"));
  EXPECT_THAT(refusal({"mbx", "show"}), HasSubstr("ADDR is missing"));
  EXPECT_THAT(refusal({"status", "x"}), HasSubstr("unexpected argument"));
  EXPECT_THAT(refusal({"status", "--cuont", "3"}),
              HasSubstr("status has no option --cuont; did you mean --count?"));
  EXPECT_THAT(refusal({"status", "--rate", "3"}), HasSubstr("status has no option --rate"));
  EXPECT_THAT(refusal({"status", "--count"}), HasSubstr("--count needs a value"));
  EXPECT_THAT(refusal({"status", "--count="}), HasSubstr("--count: \"\" is not a count"));
  EXPECT_THAT(refusal({"status", "-wj"}), HasSubstr("--watch: \"j\" is not a duration"));
  EXPECT_THAT(refusal({"status", "--json=yes"}), HasSubstr("does not take a value"));
  EXPECT_THAT(refusal({"status", "-Z"}), HasSubstr("status has no option -Z"));
  EXPECT_THAT(refusal({"nav", "goto", "-.5", "1"}), HasSubstr("must follow --"));
}

TEST(CommandLine, ValuesAreChecked) {
  EXPECT_THAT(refusal({"status", "--timeout", "fast"}), HasSubstr("--timeout: \"fast\" is not"));
  EXPECT_THAT(refusal({"status", "--router", "unix:/tmp/a"}), HasSubstr("use -H for HOST:PORT"));
  EXPECT_THAT(refusal({"status", "-w0"}), HasSubstr("at least 10ms"));
  EXPECT_THAT(refusal({"status", "-n", "0"}), HasSubstr("at least 1"));
  EXPECT_THAT(refusal({"status", "-o", "yaml"}), HasSubstr("one of table"));
  EXPECT_THAT(refusal({"msg", "pub", "Test/0/0", "3", "--priority", "256"}), HasSubstr("0 to 255"));
  EXPECT_THAT(refusal({"msg", "pub", "Test/0/0", "3", "--rate", "0"}), HasSubstr("a rate in Hz"));
  EXPECT_THAT(refusal({"stats", "--by", "moon"}), HasSubstr("reason, port, class"));
}

TEST(Help, EveryVerbHasOneWithAnExample) {
  for (const Verb& verb : verbs()) {
    if (verb.example.empty()) continue;
    Words line{std::string(verb.noun)};
    if (!verb.verb.empty()) line.emplace_back(verb.verb);
    line.emplace_back("--help");
    const std::string help = text(line);
    EXPECT_THAT(help, HasSubstr("timsctl " + verb.name()));
    EXPECT_THAT(help, HasSubstr(std::string(verb.example)));
    EXPECT_THAT(text({"--help"}), HasSubstr("  " + verb.name()));
  }
  EXPECT_THAT(text({"route", "--help"}), HasSubstr("route watch"));
  EXPECT_THAT(text({"--version"}), HasSubstr("timsctl "));
}

// The table of verbs names options by their long names: each must be one.
TEST(Verbs, NameOnlyOptionsThatExist) {
  const auto check = [](std::string_view names) {
    while (!names.empty()) {
      const std::size_t end = std::min(names.find(' '), names.size());
      EXPECT_NE(find_option(names.substr(0, end)), nullptr) << names.substr(0, end);
      names.remove_prefix(std::min(end + 1, names.size()));
    }
  };
  check(kGeneralOptions);
  for (const Verb& verb : verbs()) check(verb.options);
}

TEST(CommandLine, FormsOfOutputAreThereOrRefused) {
  EXPECT_EQ(command({"route", "show", "-ocsv"}).options.format, Format::kCsv);
  EXPECT_EQ(command({"msg", "echo", "Ladar/0/0", "-ocsv"}).options.format, Format::kCsv);
  EXPECT_EQ(refusal({"ping", "Ladar/0/0", "-o", "csv"}),
            "ping does not support -o csv; available forms: table, wide, json");
  for (const Verb& verb : verbs())
    for (const char* form : {"table", "json"})
      EXPECT_NE(verb.forms.find(form), std::string_view::npos) << verb.name();
}

}  // namespace command_line_test
}  // namespace timsctl
