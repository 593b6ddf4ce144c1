#include "tools/timsctl/robot/parameter_edit.h"

#include <gmock/gmock.h>

namespace timsctl::robot {
namespace {

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
  EXPECT_EQ(result->changes, changes) << "the system's number is what the file says";
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
              HasSubstr("instance = 2 cannot stand in a robot file: instance stands outside"));
  EXPECT_THAT(edited(text, {{"x", "{host}"}}), HasSubstr("unknown placeholder"));
  EXPECT_THAT(edited(text, {{"x", "{system}"}}), HasSubstr("write it there by hand"));
}

}  // namespace
}  // namespace timsctl::robot
