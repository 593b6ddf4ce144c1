#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "router/config/load.h"
#include "router/config/options.h"

namespace tims::config {
namespace {

// As the shell hands it over.
std::string unquoted(std::string_view setting) {
  std::string text(setting);
  std::erase(text, '\'');
  return text;
}

const Host kRoot{.name = "robot1", .uid = 0, .environment = {}};

TEST(Options, HelpNamesEveryKeyWithLimitsAndDefault) {
  const std::string help = options_help();
  for (const Option& option : options())
    EXPECT_THAT(help, testing::HasSubstr("  " + std::string(option.key) + "  ("));
  for (const List& list : lists())
    for (const Option& option : list.options)
      EXPECT_THAT(help, testing::HasSubstr("  " + std::string(option.key) + "  ("));
  EXPECT_THAT(help, testing::HasSubstr("tcp.queue  (size, 64KiB to 1GiB; default \"4MiB\")"));
  EXPECT_THAT(help, testing::HasSubstr("unix.path  (text, 1 to 107 bytes long; default /run/"));
}

TEST(Options, HelpLinesFitOnAScreen) {
  std::istringstream lines(options_help() + sample_file());
  for (std::string line; std::getline(lines, line);)
    EXPECT_TRUE(line.size() <= 100U || line.ends_with(')')) << line;
}

// The sample without its switches: up to the first example of a list, and from there.
std::pair<std::string, std::string> uncommented() {
  std::istringstream lines(sample_file());
  std::string options;
  std::string items;
  for (std::string line; std::getline(lines, line);) {
    const bool switched_off = line.starts_with('#') && !line.starts_with("# ");
    const bool is_item = !items.empty() || line.starts_with("#[[");
    (is_item ? items : options) += line.substr(switched_off ? 1 : 0) + '\n';
  }
  return {options, items};
}

TEST(SampleFile, UncommentedItGivesTheDefaults) {
  const Loaded loaded = load({{{"router.toml", uncommented().first}}, {}, kRoot});
  EXPECT_TRUE(loaded.ok()) << (loaded.ok() ? "" : loaded.problems.front().to_string());
  EXPECT_EQ(loaded.config, defaults(kRoot));
  EXPECT_EQ(loaded.origins.size(), options().size());
}

TEST(SampleFile, ItsExamplesAreRight) {
  if (!kHasDds) GTEST_SKIP() << "one of them needs DDS";
  const Loaded loaded = load({{{"items.toml", uncommented().second}},
                              {"security.insecure=true", "fleet.name=harbour"},
                              kRoot});
  EXPECT_TRUE(loaded.ok()) << (loaded.ok() ? "" : loaded.problems.front().to_string());
  for (const List& list : lists()) {
    EXPECT_GT(list.size(loaded.config), 0U) << list.name;
    EXPECT_TRUE(load({{}, {"security.insecure=true", unquoted(list.sample_setting)}, kRoot}).ok());
  }
}

TEST(SampleFile, InDeployIsTheGeneratedOne) {
  std::ifstream stream(TIMS_SAMPLE_FILE);
  const std::string deployed{std::istreambuf_iterator<char>(stream), {}};
  if (deployed == sample_file()) return;
  const std::string generated = testing::TempDir() + "tims-router.toml";
  std::ofstream(generated) << sample_file();
  FAIL() << "the option table has changed: cp " << generated << " " << TIMS_SAMPLE_FILE;
}

}  // namespace
}  // namespace tims::config
