#include "components/devices/known/udev_rules.h"

#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/known/known_devices.h"

namespace rack::device {
namespace udev_rules_test {

TEST(UdevRulesTest, TheInstalledFileIsThatOfTheList) {
  std::ifstream file(RACK_UDEV_RULES);
  std::ostringstream text;
  text << file.rdbuf();
  const std::string wanted = testing::TempDir() + "60-rack.rules";
  if (text.str() != udev_rules()) std::ofstream(wanted) << udev_rules();
  EXPECT_EQ(text.str(), udev_rules()) << "cp " << wanted << " " << RACK_UDEV_RULES;
}

// udev skips invalid rules and only writes a line to its log.
TEST(UdevRulesTest, EveryLineIsARule) {
  std::istringstream lines(udev_rules());
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    EXPECT_THAT(line, testing::MatchesRegex(".*\"")) << line;
    EXPECT_EQ(std::ranges::count(line, '"') % 2, 0) << line;
    EXPECT_THAT(line, testing::Not(testing::HasSubstr("\" "))) << "a comma is missing: " << line;
  }
}

TEST(UdevRulesTest, EveryJumpHasItsLabel) {
  const std::string rules = udev_rules();
  for (std::size_t at = 0; (at = rules.find("GOTO=\"", at)) != std::string::npos; ++at) {
    const std::size_t begin = at + 6;
    const std::string label = rules.substr(begin, rules.find('"', begin) - begin);
    EXPECT_NE(rules.find("LABEL=\"" + label + "\"", at), std::string::npos) << label;
  }
}

}  // namespace udev_rules_test
}  // namespace rack::device
