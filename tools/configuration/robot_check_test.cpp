#include "tools/configuration/robot_check.h"

#include <boost/json/parse.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace timsctl::configuration {
namespace robot_check_test {

using testing::HasSubstr;

const Description& scan2d() {
  static const Description kScan2d = *description_of(
      boost::json::parse(
          R"({"rack_description": 1, "program": "Scan2d", "class": "Scan2d", "class_id": 25,
        "parameters": [
          {"name": "reflectorFilterMode", "type": "int", "default": 0, "min": 0, "max": 1},
          {"name": "maxRange", "type": "int", "default": 8000, "min": 0, "max": 100000, "unit": "mm"},
          {"name": "gain", "type": "float", "default": 1.5, "min": -1, "max": 2},
          {"name": "mode", "type": "text", "default": "a", "choices": [{"value": "rgb24"}, {"value": "raw8"}]},
          {"name": "mapFile", "type": "text", "default": "", "host_file": true},
          {"name": "ladarSys", "type": "int", "default": 0, "min": 0, "max": 65535},
          {"name": "ladarInst", "type": "int", "default": 0, "min": -1, "max": 65535, "required": true},
          {"name": "dataTaskPrio", "type": "int", "default": 1, "min": 0, "max": 99}],
        "inputs": [{"class": "Ladar", "system": "ladarSys", "instance": "ladarInst", "optional": true}],
        "outputs": [{"class": "Scan2d", "message": "DATA"}]})")
          .as_object());
  return kScan2d;
}

Surroundings around() {
  return {.describe =
              [](const std::string& program) { return program == "Scan2d" ? &scan2d() : nullptr; },
          .has_file = [](const std::string& name) { return name == "floor.dxf"; },
          .files_beside = [](const std::string&) { return std::vector<std::string>{"floor.dxf"}; },
          .priority_max = 20};
}

// The findings on a robot with these parameters, one a line.
std::string found(const std::string& parameters) {
  const std::string text =
      "# c\n[[component]]\nprogram = \"Scan2d\"\nparameters = { " + parameters + " }\n";
  std::string lines;
  for (const Finding& each : check_robot({"robots/r.toml", text}, around()))
    lines += (each.is_error ? "" : "warning ") + std::to_string(each.line) + ": " + each.path +
             " " + each.text + "\n";
  return lines;
}

TEST(RobotCheck, AcceptsEachLimit) {
  for (const std::string good :
       {"maxRange = 0", "maxRange = 100000", "gain = -1.0", "gain = 2", "mode = \"raw8\"",
        "mapFile = \"floor.dxf\"", "ladarInst = -1", "dataTaskPrio = 20"})
    EXPECT_EQ(found("ladarInst = 0, " + good).find("ladarInst ="), std::string::npos) << good;
  EXPECT_EQ(found("ladarInst = 0"), "");
}

TEST(RobotCheck, RefusesBelowAndAbove) {
  EXPECT_EQ(found("ladarInst = 0, maxRange = -1"),
            "4: component[0].parameters.maxRange maxRange must be a whole number from 0 to 100000, "
            "not -1\n");
  for (const std::string bad : {"maxRange = 100001", "maxRange = 1.5", "maxRange = \"far\"",
                                "gain = 2.1", "gain = -1.1", "ladarInst = 1, ladarSys = -1"})
    EXPECT_THAT(found(bad.find("ladarInst") == 0 ? bad : "ladarInst = 0, " + bad),
                HasSubstr("must be"))
        << bad;
}

TEST(RobotCheck, SuggestsNamesChoicesAndFiles) {
  EXPECT_THAT(found("ladarInst = 0, maxRnage = 1"), HasSubstr("did you mean maxRange?"));
  EXPECT_THAT(found("ladarInst = 0, mode = \"rgb42\""), HasSubstr("must be one of rgb24, raw8"));
  EXPECT_THAT(found("ladarInst = 0, mapFile = \"flor.dxf\""),
              HasSubstr("flor.dxf is not there; did you mean floor.dxf?"));
}

TEST(RobotCheck, HintsAtFormerNames) {
  EXPECT_THAT(found("ladarInst = 0, reflectorFilter = 1"),
              HasSubstr("warning 4:  reflectorFilter is called reflectorFilterMode since 0.2"));
  EXPECT_THAT(found("ladarInst = 0, reflectorFilter = 2"), HasSubstr("must be a whole number"));
}

TEST(RobotCheck, NeedsRequiredParametersAndKnowsPriorities) {
  EXPECT_THAT(found("maxRange = 1"),
              HasSubstr("2: component[0].parameters Scan2d needs the parameter "
                        "ladarInst"));
  EXPECT_THAT(found("ladarInst = 0, dataTaskPrio = 21"), HasSubstr("warning 4:"));
}

TEST(RobotCheck, ErrorsOfTheFileComeFirst) {
  const auto findings =
      check_robot({"robots/r.toml", "[[component]]\nprogrm = \"Scan2d\"\n"}, around());
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings[0].line, 1U);
}

std::vector<std::string> sentences(const std::string& before, const std::string& after) {
  return robot_difference("name = \"r\"\n" + before, "name = \"r\"\n" + after, "robots/r.toml",
                          around().describe)
      .sentences;
}

TEST(RobotDifference, IsSentencesForPeople) {
  const std::string scan = "[[component]]\nprogram = \"Scan2d\"\n";
  using testing::ElementsAre;
  EXPECT_THAT(sentences(scan + "parameters = { maxRange = 8000 }\n",
                        "# comment\n" + scan + "parameters = { maxRange = 10000 }\n"),
              ElementsAre("Scan2d maxRange 8000 -> 10000 mm; needs restart of Scan2d"));
  EXPECT_THAT(sentences(scan, scan + "parameters = { maxRange = 10000 }\n"),
              ElementsAre("Scan2d maxRange 8000 (default) -> 10000 mm; needs restart of Scan2d"));
  EXPECT_THAT(sentences(scan, scan + "restart = \"always\"\n"),
              ElementsAre("Scan2d is started in another way; needs restart of Scan2d"));
  EXPECT_THAT(sentences(scan, scan + "[[component]]\nprogram = \"Ladar\"\n"),
              ElementsAre("Ladar is added"));
  EXPECT_THAT(sentences(scan + "[[component]]\nprogram = \"Ladar\"\n", scan),
              ElementsAre("Ladar is removed"));
  EXPECT_THAT(sentences(scan, "# only a comment\n" + scan), ElementsAre());
}

}  // namespace robot_check_test
}  // namespace timsctl::configuration
