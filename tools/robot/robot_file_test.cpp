#include "tools/robot/robot_file.h"

#include <fstream>

#include <gmock/gmock.h>

namespace timsctl::robot {
namespace robot_file_test {

using testing::ElementsAre;
using testing::HasSubstr;

RobotFile read(std::string text, std::optional<std::int64_t> system = {}) {
  return read_robot({"r.toml", std::move(text)}, "robot", system);
}

// All problems, one per line.
std::string problems(std::string text) {
  std::string all;
  for (const auto& problem : read(std::move(text)).problems) all += problem.to_string() + "\n";
  return all;
}

TEST(RobotFile, ProgramsGetTheirPlaceAndParameters) {
  const RobotFile file = read(R"(
name = "scout"
system = 3
[[component]]
program = "Scan2dSim"
parameters = { mapFile = "floor.dxf", maxRange = 10_000, odometrySys = "{system}", scale = 0.5, loud = true }
[[component]]
program = "PilotWallFollowing"
instance = 1
restart = "never"
)");
  EXPECT_EQ(problems(""), "r.toml:1:1: a robot needs at least one component: add [[component]]\n");
  ASSERT_TRUE(file.problems.empty()) << file.problems.front().to_string();
  EXPECT_EQ(file.robot.name, "scout");
  ASSERT_EQ(file.robot.components.size(), 2U);
  EXPECT_EQ(file.robot.components[0].name, "Scan2dSim");
  EXPECT_EQ(file.robot.components[0].restart, Restart::kOnFailure);
  EXPECT_THAT(file.robot.components[0].command,
              ElementsAre("Scan2dSim", "--system=3", "--instance=0", "--mapFile=floor.dxf",
                          "--maxRange=10000", "--odometrySys=3", "--scale=0.5", "--loud=1"));
  EXPECT_EQ(file.robot.components[1].name, "PilotWallFollowing-1");
  EXPECT_EQ(file.robot.components[1].restart, Restart::kNever);
}

TEST(RobotFile, WhatIsDeployed) {
  const RobotFile file = read(R"(
[deploy]
ssh = "root@scout.local"
repository = "packages"
packages = ["tims-router", "timsctl"]
files = "scout/main"
[host.arm]
ssh = "pi@arm.local"
files = "scout/arm"
[host.eye]
ssh = "eye"
packages = ["rack-devices"]
[[component]]
program = "ChassisSim"
)");
  ASSERT_TRUE(file.problems.empty()) << file.problems.front().to_string();
  EXPECT_EQ(file.robot.deploy.host.name, "main");
  EXPECT_EQ(file.robot.deploy.host.ssh, "root@scout.local");
  EXPECT_EQ(file.robot.deploy.host.files, "scout/main");
  EXPECT_EQ(file.robot.deploy.repository, "packages");
  EXPECT_THAT(file.robot.hosts.at(0).packages, ElementsAre("tims-router", "timsctl"));
  EXPECT_EQ(file.robot.hosts.at(0).files, "scout/arm");
  EXPECT_THAT(file.robot.hosts.at(1).packages, ElementsAre("rack-devices"));

  const std::string component = "[[component]]\nprogram = \"ChassisSim\"\n";
  EXPECT_THAT(problems("[deploy]\nssh = \"-oProxyCommand=x\"\n" + component),
              HasSubstr("not a destination"));
  for (const char* name : {"a", "Tims", "a b", "-tims", "tims;reboot", "$(x)", "a/b"})
    EXPECT_THAT(problems(std::string("[deploy]\npackages = [\"") + name + "\"]\n" + component),
                HasSubstr("not the name of a Debian package"))
        << name;
  EXPECT_THAT(problems("[deploy]\nrepository = \"deb x\\ndeb y\"\n" + component),
              HasSubstr("one line"));
  EXPECT_THAT(problems("[deploy]\nssh = \"a\"\n[host.main]\nssh = \"b\"\n" + component),
              HasSubstr("another name"));
}

TEST(RobotFile, AnotherSystemThanThatOfTheFile) {
  const RobotFile file = read(R"(
system = 3
[[component]]
command = "tims-demo ladar --at 'Ladar({system}/0)'"
)",
                              7);
  ASSERT_TRUE(file.problems.empty());
  EXPECT_EQ(file.robot.name, "robot");
  EXPECT_EQ(file.robot.system, 7);
  EXPECT_THAT(file.robot.components.at(0).command,
              ElementsAre("tims-demo", "ladar", "--at", "Ladar(7/0)"));
}

TEST(RobotFile, OtherHosts) {
  const RobotFile file = read(R"(
restart = "always"
[[component]]
program = "ChassisSim"
host = "arm"
[host.arm]
ssh = "pi@arm.local"
router = "unix:/run/tims/arm.sock"
)");
  ASSERT_TRUE(file.problems.empty()) << file.problems.front().to_string();
  EXPECT_EQ(file.robot.hosts.at(0).ssh, "pi@arm.local");
  EXPECT_EQ(file.robot.components.at(0).host, "arm");
  EXPECT_EQ(file.robot.components.at(0).restart, Restart::kAlways);
}

TEST(RobotFile, TheFolderOfFilesThatMessagesName) {
  const std::string component = "[[component]]\nprogram = \"A\"\n";
  EXPECT_EQ(read(component).robot.files, "");
  EXPECT_EQ(read("files = \"maps\"\n" + component).robot.files, "maps");
  EXPECT_EQ(read("files = \"/srv/{system}\"\nsystem = 3\n" + component).robot.files, "/srv/3");
  EXPECT_THAT(problems("files = \"\"\n" + component), HasSubstr("files requires the path"));
  EXPECT_THAT(problems("files = \"{sytem}\"\n" + component), HasSubstr("unknown placeholder"));
}

TEST(RobotFile, EveryProblemHasItsPlaceAndSaysWhatToDo) {
  EXPECT_THAT(problems("[[component]]\nprogramm = \"A\""),
              HasSubstr("r.toml:2:1: unknown key of [[component]] \"programm\"; did you mean "
                        "program?"));
  EXPECT_THAT(problems("[[component]]\nprogram = \"A\"\n[[component]]\nprogram = \"A\""),
              HasSubstr("duplicate component A: give one of them another instance or name"));
  EXPECT_THAT(problems("[[component]]\nprogram = \"A\"\ncommand = \"B\""),
              HasSubstr("a component requires program, instance and parameters, or a command"));
  EXPECT_THAT(problems("[[component]]\nprogram = \"A\"\nhost = \"arm\""),
              HasSubstr("unknown host arm: add [host.arm]"));
  EXPECT_THAT(problems("[[component]]\nprogram = \"A\"\ninstance = 65536"),
              HasSubstr("instance must be a number from 0 to 65535, not 65536"));
  EXPECT_THAT(problems("[[component]]\nprogram = \"A\"\nparameters = { system = 1 }"),
              HasSubstr("system must be outside of parameters"));
  EXPECT_THAT(problems("[[component]]\nprogram = \"A\"\nparameters = { a = \"{sytem}\" }"),
              HasSubstr("unknown placeholder \"sytem\"; did you mean system?"));
  EXPECT_THAT(problems("restart = \"on-falure\"\n[[component]]\nprogram = \"A\""),
              HasSubstr("unknown restart \"on-falure\"; did you mean on-failure?"));
  EXPECT_THAT(problems("[host.arm]\nssh = \"-oProxyCommand=x\"\n[[component]]\nprogram = \"A\""),
              HasSubstr("[host.arm] requires ssh"));
  EXPECT_THAT(problems("name = \"a/b\"\n[[component]]\nprogram = \"A\""),
              HasSubstr("\"a/b\" is not a name"));
}

TEST(RobotFile, NamesAreAsLongAsTheyMayBe) {
  EXPECT_TRUE(is_name(std::string(kNameMax, 'a')));
  EXPECT_FALSE(is_name(std::string(kNameMax + 1, 'a')));
  EXPECT_FALSE(is_name(""));
  EXPECT_FALSE(is_name(".."));
}

TEST(RobotFile, AsManyComponentsAsAllowed) {
  std::string text;
  for (std::size_t i = 0; i < kComponentsMax; ++i)
    text += "[[component]]\nprogram = \"A\"\ninstance = " + std::to_string(i) + "\n";
  EXPECT_EQ(problems(text), "");
  EXPECT_THAT(problems(text + "[[component]]\nprogram = \"B\"\n"), HasSubstr("at most 200"));
}

TEST(RobotFile, TheSamplesAreGood) {
  for (const char* name : {"sim", "base", "pioneer", "outdoor"}) {
    std::ifstream file(TIMS_SAMPLE_ROBOTS "/" + std::string(name) + ".toml");
    ASSERT_TRUE(file) << name;
    EXPECT_EQ(problems({std::istreambuf_iterator<char>(file), {}}), "") << name;
  }
}

using testing::HasSubstr;
using Parameters = std::map<std::string, std::string>;

std::string edited(const std::string& text, const Parameters& parameters,
                   std::size_t component = 0) {
  const auto result = with_parameters({"r.toml", text}, {}, component, parameters);
  return result ? result->text : "refused: " + result.error().detail();
}

TEST(ParameterEdit, CommentsAndOrderStay) {
  const std::string text = R"(# my robot
system = 3

[[component]]   # wheels
program = "ChassisSim"
parameters = { vxMax = 700, cmdTaskPrio = 30 } # slow

[[component]]
program = "Scan2dSim"
instance = 1
parameters = { odometrySys = "{system}", mapFile = "flöor.dxf", maxRange = 10_000 }
# the end
)";
  const auto result = with_parameters({"r.toml", text}, 5, 1,
                                      {{"maxRange", "9000"},
                                       {"mapFile", "a \"b\"\\.dxf"},
                                       {"odometrySys", "5"},
                                       {"angleRes", "2"}});
  ASSERT_TRUE(result) << result.error().detail();
  EXPECT_EQ(result->text, R"(# my robot
system = 3

[[component]]   # wheels
program = "ChassisSim"
parameters = { vxMax = 700, cmdTaskPrio = 30 } # slow

[[component]]
program = "Scan2dSim"
instance = 1
parameters = { odometrySys = "{system}", mapFile = "a \"b\"\\.dxf", maxRange = 9000, angleRes = 2 }
# the end
)");
  const std::vector<ParameterChange> changes{{"angleRes", std::nullopt, "2"},
                                             {"mapFile", "flöor.dxf", "a \"b\"\\.dxf"},
                                             {"maxRange", "10000", "9000"}};
  EXPECT_EQ(result->changes, changes) << "the system number is that of the file";
}

TEST(ParameterEdit, WhereverParametersMayStand) {
  const std::string head = "[[component]]\nprogram = \"A\"";
  EXPECT_EQ(edited(head, {{"x", "1"}}), head + "\nparameters = { x = 1 }\n");
  EXPECT_EQ(edited("[[component]]\n  program = \"A\" # a\nname = \"b\"\n", {{"x", "y"}}),
            "[[component]]\n  program = \"A\" # a\nname = \"b\"\nparameters = { x = \"y\" }\n");
  EXPECT_EQ(edited(head + "\nparameters = {}\n", {{"x", "1"}, {"y", "-0.5"}}),
            head + "\nparameters = { x = 1, y = -0.5 }\n");
  EXPECT_EQ(edited(head + "\n[component.parameters]\nx = 1 # one\n\n", {{"x", "2"}, {"y", "3"}}),
            head + "\n[component.parameters]\nx = 2 # one\ny = 3\n\n");
  EXPECT_EQ(edited(head + "\n[component.parameters]\n# none\n", {{"y", "3"}}),
            head + "\n[component.parameters]\ny = 3\n# none\n");
  EXPECT_EQ(edited(head + "\n  parameters.x = '1'\n", {{"x", "2"}, {"y", "3"}}),
            head + "\n  parameters.x = \"2\"\n  parameters.y = 3\n");
  EXPECT_EQ(edited("component = [{ program = \"A\" }, { program = \"B\" }]", {{"x", "1"}}, 1),
            "component = [{ program = \"A\" }, { program = \"B\", parameters = { x = 1 } }]");
  EXPECT_EQ(edited(head + "\nparameters = { m = \"\"\"a\nb\"\"\", n = true }\n",
                   {{"m", "c"}, {"n", "0"}}),
            head + "\nparameters = { m = \"c\", n = 0 }\n");
  EXPECT_EQ(edited("[[component]]\r\nprogram = \"A\"\r\n", {{"x", "007"}}),
            "[[component]]\r\nprogram = \"A\"\r\nparameters = { x = \"007\" }\r\n");
}

TEST(ParameterEdit, AFormerNameBecomesThatOfNow) {
  const std::string text =
      "[[component]]\nprogram = \"Scan2d\"\nparameters = { reflectorFilter = 1 } # c\n";
  EXPECT_EQ(edited(text, {{"reflectorFilterMode", "0"}}),
            "[[component]]\nprogram = \"Scan2d\"\nparameters = { reflectorFilterMode = 0 } # c\n");
  EXPECT_EQ(edited(text, {{"reflectorFilterMode", "1"}}), text);
  const RobotFile file = read(text);
  EXPECT_THAT(file.robot.components.at(0).command, testing::Contains("--reflectorFilterMode=1"));
  ASSERT_EQ(file.hints.size(), 1U);
  EXPECT_THAT(file.hints[0].to_string(), HasSubstr("r.toml:3:16: reflectorFilter is called"));
}

TEST(ParameterEdit, WhatTheFileHasAlreadyChangesNothing) {
  const std::string text = "[[component]]\nprogram = \"A\"\nparameters = { x = 1_0 }";
  const auto result = with_parameters({"r.toml", text}, {}, 0, {{"x", "10"}});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->text, text);
  EXPECT_TRUE(result->changes.empty());
}

TEST(ParameterEdit, WhatAFileCannotSayIsRefused) {
  const std::string text = "[[component]]\nprogram = \"A\"\n";
  EXPECT_THAT(edited(text, {{"instance", "2"}}),
              HasSubstr("instance = 2 is not possible in a robot file: instance must be outside"));
  EXPECT_THAT(edited(text, {{"x", "{host}"}}), HasSubstr("unknown placeholder"));
  EXPECT_THAT(edited(text, {{"x", "{system}"}}), HasSubstr("add it by hand"));
}

// --- the components of two robot files

TEST(ComponentOf, ItsProgramSystemAndInstance) {
  EXPECT_EQ(component_of({"ChassisSim", "--system=3", "--instance=1", "--vxMax=900"}),
            "ChassisSim, system 3, instance 1");
  EXPECT_EQ(component_of({"nice", "-n", "-15", "/opt/bin/World", "--file=x", "--system=3"}),
            "World, system 3, instance 0");
}

TEST(ComponentOf, OtherCommandsHaveNone) {
  EXPECT_EQ(component_of({}), std::nullopt);
  EXPECT_EQ(component_of({"sh", "late.sh"}), std::nullopt);
  EXPECT_EQ(component_of({"tool", "--all"}), std::nullopt);
  EXPECT_EQ(component_of({"--system=3"}), std::nullopt);
  EXPECT_EQ(component_of({"ssh", "-oBatchMode=yes", "--", "arm", "--system=3"}), std::nullopt);
}

}  // namespace robot_file_test
}  // namespace timsctl::robot
