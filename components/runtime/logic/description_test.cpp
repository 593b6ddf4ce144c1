#include "components/runtime/logic/description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tims/address.h"

namespace rack {
namespace description_test {

using testing::HasSubstr;
using testing::Not;

constexpr std::array<ParameterInfo, 6> kOwn = {{
    {"periodTime", 50, "period of the data [ms]", 10, 1000},
    at_once({"gain", 0.5F, "a \"factor\" [1/m]; 0: none", -2, 2}),
    one_of("0 RMC, 1 GGA", {"start", 1, "first sentence", 0, 1}),
    one_of("rgb24, raw8 (no colours)", host_file({"mode", "rgb24", "format", 0, 0, true})),
    partner("chassis", "the chassis"),
    optional_partner("position", "the position", "the position; -1: none"),
}};
constexpr std::array<UsedComponent, 2> kInputs = {{
    {tims::class_id::kChassis, "chassisSys", "chassisInst"},
    {tims::class_id::kPosition, "positionSys", "positionInst"},
}};
constexpr Described kPilotDescribed = {
    .purpose = "drives", .class_id = tims::class_id::kPilot, .inputs = kInputs, .has_data = true};

std::string described() { return description({"PilotNew", kOwn}, kPilotDescribed); }

TEST(Description, BeginsWithTheProgramAndItsClass) {
  EXPECT_THAT(described(),
              testing::StartsWith(R"({"rack_description": 1, "program": "PilotNew", )"
                                  R"("purpose": "drives", "class": "Pilot", "class_id": 24, )"));
}

TEST(Description, NumbersHaveUnitRangeAndDefault) {
  EXPECT_THAT(described(),
              HasSubstr(R"({"name": "periodTime", "type": "int", "default": 50, "min": 10, )"
                        R"("max": 1000, "unit": "ms", "help": "period of the data", )"
                        R"("takes_effect": "on"})"));
  EXPECT_THAT(described(),
              HasSubstr(R"({"name": "gain", "type": "float", "default": 0.5, "min": -2, "max": 2, )"
                        R"("unit": "1/m", "help": "a \"factor\"; 0: none", )"
                        R"("takes_effect": "now"})"));
}

TEST(Description, ChoicesHaveTheirMeaning) {
  EXPECT_THAT(described(), HasSubstr(R"("choices": [{"value": 0, "meaning": "RMC"}, )"
                                     R"({"value": 1, "meaning": "GGA"}])"));
  EXPECT_THAT(described(),
              HasSubstr(R"("choices": [{"value": "rgb24"}, )"
                        R"-({"value": "raw8", "meaning": "(no colours)"}], "takes_effect": "on", )-"
                        R"("required": true, "host_file": true})"));
}

TEST(Description, PartnersReferToTheirClass) {
  EXPECT_THAT(described(),
              HasSubstr(R"("name": "chassisSys", "type": "int", "default": 0, )"
                        R"("min": 0, "max": 65535, "help": "system id of the chassis", )"
                        R"("refers": "Chassis", "part": "system")"));
  EXPECT_THAT(described(), HasSubstr(R"("refers": "Position", "part": "instance")"));
  EXPECT_THAT(
      described(),
      HasSubstr("\"inputs\": [\n"
                R"(  {"class": "Chassis", "system": "chassisSys", "instance": "chassisInst"},)"
                "\n"
                R"(  {"class": "Position", "system": "positionSys", )"
                R"("instance": "positionInst", "optional": true}])"));
}

TEST(Description, DataHaveAPeriod) {
  EXPECT_THAT(described(), HasSubstr("\"outputs\": [\n"
                                     R"(  {"class": "Pilot", "message": "DATA", )"
                                     R"("period": "periodTime", "default_ms": 50}]})"));
  const std::string none = description({"Test", {}}, {.class_id = tims::class_id::kTest});
  EXPECT_THAT(none, HasSubstr(R"("inputs": [], "outputs": []})"));
}

TEST(Description, CommonParametersAreMarked) {
  EXPECT_THAT(described(), HasSubstr(R"({"name": "gdosLevel", "type": "int", "default": 2, )"
                                     R"("min": 0, "max": 4, "help": "level of log texts", )"
                                     R"("choices": [{"value": 0, "meaning": "print"})"));
  EXPECT_THAT(described(), HasSubstr(R"("unit": "ms", "help": "delay of the retry after an error; )"
                                     R"(at least 10; -1: random, 2 to 4 s", )"
                                     R"("takes_effect": "start", "common": true})"));
}

TEST(Description, ClassesWithoutANameAreNumbers) {
  EXPECT_THAT(description({"New", {}}, {.class_id = 222}), HasSubstr(R"("class": "222")"));
}

TEST(Units, AreInBracketsInTheHelpText) {
  constexpr auto kUnitOf = [](std::string_view help) { return ParameterInfo{"x", 0, help}.unit(); };
  static_assert(kUnitOf("period [ms]; 0: none") == "ms");
  static_assert(kUnitOf("period").empty());
  static_assert(kUnitOf("a [ alone").empty());
  static_assert(kUnitOf("] before [").empty());
  static_assert(kUnitOf("").empty());
  EXPECT_EQ(help_without_unit({"x", 0, "period [ms]; 0: none"}), "period; 0: none");
  EXPECT_EQ(help_without_unit({"x", 0, "[ms]"}), "");
  EXPECT_EQ(help_without_unit({"x", 0, "a ] b"}), "a ] b");
}

}  // namespace description_test
}  // namespace rack
