#include "tools/sim/fleet_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/cli/failure.h"
#include "tools/sim/plan.h"

namespace timsctl::sim {
namespace fleet_file_test {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

Fleet fleet_of(const std::string& text) {
  FleetFile file = read_fleet({"fleet.toml", text});
  for (const auto& problem : file.problems) ADD_FAILURE() << problem.to_string();
  return std::move(file.fleet);
}

std::vector<std::string> problems_of(const std::string& text) {
  std::vector<std::string> all;
  for (const auto& problem : read_fleet({"f", text}).problems) all.push_back(problem.to_string());
  return all;
}

TEST(FleetFile, OneRobotIsEnough) {
  const Fleet fleet = fleet_of("[[robot]]\n");
  EXPECT_EQ(fleet.name, "fleet");
  ASSERT_EQ(fleet.robots.size(), 1U);
  EXPECT_EQ(fleet.robots[0].name, "robot1");
  EXPECT_THAT(fleet.robots[0].hosts, ElementsAre("main"));
  EXPECT_THAT(line_names(fleet), ElementsAre("robot1-base"));
}

TEST(FleetFile, RobotsAreCounted) {
  const Fleet fleet = fleet_of(R"toml(
[[robot]]
count = 2
hosts = ["main", "arm"]
[[robot]]
name = "rover"
system = 7
)toml");
  EXPECT_THAT(host_names_of(fleet), ElementsAre("base", "robot1-main", "robot1-arm", "robot2-main",
                                                "robot2-arm", "rover7-main"));
  EXPECT_THAT(line_names(fleet),
              ElementsAre("robot1-base", "robot1-arm", "robot2-base", "robot2-arm", "rover7-base"));
}

TEST(FleetFile, ComponentsComeFromTheHostAndTheRobot) {
  const Fleet fleet = fleet_of(R"toml(
[[robot]]
hosts = ["main", "arm"]
components.main = ["mine 'two words'"]
[host.main]
components = ["everybodys --at Ladar({system}/0)"]
settings = ["log.level=debug"]
)toml");
  const HostPrograms& programs = fleet.robots.at(0).programs.at("main");
  EXPECT_THAT(programs.components,
              ElementsAre(ElementsAre("everybodys", "--at", "Ladar({system}/0)"),
                          ElementsAre("mine", "two words")));
  EXPECT_THAT(programs.settings, ElementsAre("log.level=debug"));
  EXPECT_TRUE(fleet.robots[0].programs.at("arm").components.empty());
}

TEST(FleetFile, ProfilesAreAddedAndChanged) {
  const Fleet fleet = fleet_of(R"toml(
[profile.wifi]
loss = "2%"
[profile.mine]
delay = "50ms"
rate = "1Mbit"
[[robot]]
link = "mine"
)toml");
  EXPECT_DOUBLE_EQ(fleet.profiles.at("wifi").loss, 0.02);
  EXPECT_EQ(fleet.profiles.at("wifi").delay, 2ms) << "omitted keys are unchanged";
  EXPECT_EQ(fleet.profiles.at("mine").rate_bits, 1'000'000U);
  EXPECT_EQ(fleet.robots[0].link, "mine");
}

TEST(FleetFile, FaultsHaveATimeAndAnEnd) {
  const Fleet fleet = fleet_of(R"toml(
[[robot]]
[[fault]]
at = "5s"
line = "robot1-base"
do = "loss=10% delay=5ms"
direction = "up"
for = "3s"
every = "10s"
[[fault]]
at = "0"
host = "robot1-main"
do = "kill"
)toml");
  ASSERT_EQ(fleet.steps.size(), 2U);
  EXPECT_THAT(fleet.steps[0].arguments, ElementsAre("loss=10%", "delay=5ms", "direction=up"));
  EXPECT_EQ(fleet.steps[0].at, 5s);
  EXPECT_EQ(fleet.steps[0].duration, 3s);
  EXPECT_EQ(fleet.steps[0].every, 10s);
  EXPECT_EQ(fleet.steps[1].host, "robot1-main");
}

struct Bad {
  const char* text;
  const char* problem;
};

TEST(FleetFile, ReportsWhatIsWrongAndWhere) {
  for (const Bad& bad : {
           Bad{"", "f:1:1: a fleet needs at least one robot: add [[robot]]"},
           Bad{"robots = 1\n", "f:1:1: unknown key of a fleet \"robots\"; did you mean robot?"},
           Bad{"[robot]\n", "robot must be [[robot]] above the keys of each, not a table"},
           Bad{"[[robot]]\nhost = [\"a\"]\n",
               "f:2:1: unknown key of [[robot]] \"host\"; did you mean hosts?"},
           Bad{"[[robot]]\nhosts = \"a\"\n", "f:2:9: hosts must be a list such as"},
           Bad{"[[robot]]\nhosts = [\"Arm\"]\n", "f:2:10: a host name has at most"},
           Bad{"[[robot]]\nhosts = [\"a\", \"a\"]\n", "f:2:15: duplicate host \"a\""},
           Bad{"[[robot]]\nhosts = [\"base\"]\n", "f:2:10: a host name"},
           Bad{"[[robot]]\ncount = 0\n", "f:2:9: count must be a number from 1 to 250, not 0"},
           Bad{"[[robot]]\ncount = \"2\"\n", "count must be a number from 1 to 250, not \"2\""},
           Bad{"[[robot]]\nsystem = 250\ncount = 2\n",
               "too many robots: the largest system number is 250"},
           Bad{"[[robot]]\n[[robot]]\nsystem = 1\n", "f:2:1: system 1 is already used by robot1"},
           Bad{"[[robot]]\nname = \"r2\"\n", "f:2:8: a robot name has"},
           Bad{"[[robot]]\nlink = \"wify\"\n",
               "f:2:8: unknown profile \"wify\"; did you mean wifi?"},
           Bad{"[[robot]]\n[host.arm]\n", "unknown host \"arm\"; there are main"},
           Bad{"[[robot]]\ncomponents.arm = [\"x\"]\n", "unknown host in components"},
           Bad{"[[robot]]\ncomponents = [\"x\"]\n", "require a host"},
           Bad{"[[robot]]\n[base]\ncomponents = [\"a 'b\"]\n", "f:3:15: a quote is not closed"},
           Bad{"[[robot]]\n[base]\ncomponents = [\"a {sytem}\"]\n",
               "unknown placeholder \"sytem\"; did you mean system?"},
           Bad{"[[robot]]\n[base]\nsettings = [\"debug\"]\n", "settings requires key=value"},
           Bad{"[[robot]]\n[profile.x]\nlos = \"1%\"\n",
               "f:3:1: unknown key of a profile \"los\"; did you mean loss?"},
           Bad{"[[robot]]\n[profile.x]\nloss = \"101%\"\n", "f:3:8: loss requires a share"},
           Bad{"[[robot]]\n[profile.x]\nrate = \"5\"\n",
               "f:3:8: rate requires a rate per second such as"},
           Bad{"[[robot]]\n[profile.cut]\nloss = \"1%\"\n",
               "cut is reserved for changes of a line"},
           Bad{"name = \"A b\"\n[[robot]]\n", "f:1:8: name requires at most 15 small letters"},
           Bad{"[[robot]]\n[[fault]]\nat = \"1s\"\nline = \"robot1-bas\"\ndo = \"cut\"\n",
               "f:4:8: unknown line \"robot1-bas\"; did you mean robot1-base?"},
           Bad{"[[robot]]\n[[fault]]\nat = \"1s\"\nline = \"robot1-base\"\ndo = \"cutt\"\n",
               "f:5:6: do: \"cutt\" is not a fault; did you mean cut?"},
           Bad{"[[robot]]\n[[fault]]\nat = \"1s\"\nhost = \"base\"\ndo = \"cut\"\n",
               "f:5:6: do requires kill or start"},
           Bad{"[[robot]]\n[[fault]]\nat = \"soon\"\nhost = \"base\"\ndo = \"kill\"\n",
               R"(f:3:6: at must be a duration such as "5s", not "soon")"},
           Bad{"[[robot]]\n[[fault]]\nat = \"1s\"\n", "either line or host"},
           Bad{"a = \n", "f:1:5: "},
       }) {
    const auto problems = problems_of(bad.text);
    ASSERT_FALSE(problems.empty()) << bad.text;
    EXPECT_THAT(problems, testing::Contains(HasSubstr(bad.problem))) << bad.text;
  }
}

TEST(SplitCommand, AsAShellWould) {
  EXPECT_THAT(*base::split_words("  a 'b c'  \"d\"e ''"), ElementsAre("a", "b c", "de", ""));
  EXPECT_THAT(*base::split_words(""), ElementsAre());
  EXPECT_FALSE(base::split_words("a \"b"));
}

}  // namespace fleet_file_test
}  // namespace timsctl::sim
