#include "rack/parameters.h"

#include <array>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace rack {
namespace parameters_test {

using testing::Test;

constexpr std::array<ParameterInfo, 4> kOwn = {{
    {"vxMax", 700, "largest speed, mm/s", 0, 10000},
    {"scale", 1.5F, "a factor", -2, 2},
    {"mapFile", "", "the map"},
    {"anything", 0, "any number"},
}};

struct ParametersTest : Test {
  Parameters parameters{"ChassisSim", kOwn};

  static Parameter record(std::string_view name, i32 type) {
    Parameter made;
    EXPECT_TRUE(made.name.assign(name));
    made.type = type;
    return made;
  }
  static Parameter whole(std::string_view name, i32 value) {
    Parameter made = record(name, Parameter::kInt);
    made.valueInt = value;
    return made;
  }
  static Parameter real(std::string_view name, f32 value) {
    Parameter made = record(name, Parameter::kFloat);
    made.valueFloat = value;
    return made;
  }
};

TEST_F(ParametersTest, BeginWithWhatWasDeclared) {
  EXPECT_EQ(parameters.integer("gdosLevel"), 2);
  EXPECT_EQ(parameters.integer("errorTimeout"), -1);
  EXPECT_EQ(parameters.integer("vxMax"), 700);
  EXPECT_EQ(parameters.real("scale"), 1.5F);
  EXPECT_EQ(parameters.text("mapFile"), "");
}

TEST(Parameters, ACommonOneCanHaveAnotherDefault) {
  static constexpr std::array<ParameterInfo, 2> kOfLog = {
      {{"instance", 1, "instance id", 1, 255}, {"folder", "", "where"}}};
  Parameters parameters("gdos-log", kOfLog);
  EXPECT_EQ(parameters.integer("instance"), 1);
  EXPECT_FALSE(parameters.set("instance", "0")) << "its range, too";
  EXPECT_EQ(parameters.list().parameters[2].name, "instance") << "in its usual place";
  EXPECT_EQ(parameters.list().parameters.size(), 1 + common_parameters().size() + 1);
}

TEST(Parameters, SayWhenTheyTakeEffect) {
  static constexpr std::array<ParameterInfo, 3> kSome = {
      ParameterInfo{"instance", 1, "instance id", 1, 255}, ParameterInfo{"vxMax", 700, "speed"},
      at_once({"update", 1, "now"})};
  const Parameters parameters("ClockSystem", kSome);
  const ParameterEffects effects = parameters.effects();
  const ParameterList list = parameters.list();
  ASSERT_EQ(effects.effects.size(), list.parameters.size());
  std::map<std::string_view, TakesEffect> of;
  for (std::size_t i = 0; i < list.parameters.size(); ++i) {
    EXPECT_EQ(effects.effects[i].name, list.parameters[i].name);
    of[effects.effects[i].name.view()] = static_cast<TakesEffect>(effects.effects[i].takesEffect);
  }
  EXPECT_EQ(of["vxMax"], TakesEffect::kAtOn);
  EXPECT_EQ(of["update"], TakesEffect::kNow);
  EXPECT_EQ(of["gdosLevel"], TakesEffect::kNow);
  EXPECT_EQ(of["dataTaskPrio"], TakesEffect::kAtStart);
  EXPECT_EQ(of["instance"], TakesEffect::kAtStart) << "another default changes nothing";
}

Parameter text_record(std::string_view name, std::string_view value) {
  Parameter record;
  (void)record.name.assign(name);
  record.type = Parameter::kString;
  (void)record.valueString.assign(value);
  return record;
}

TEST(Parameters, ThoseThatNameFilesAreNotChangedFromOutside) {
  static constexpr std::array<ParameterInfo, 3> kSome = {
      host_file({"mapFile", "", "the map"}), host_file(at_start({"logPathName", "", "the logs"})),
      ParameterInfo{"mode", "rgb24", "of the picture"}};
  Parameters parameters("FeatureMap", kSome);
  const std::string path(100, 'x');  // longer than a record can have
  ASSERT_TRUE(parameters.set("mapFile", path));
  for (const std::string_view name : {"mapFile", "logPathName"}) {
    const auto refused = parameters.set(text_record(name, "/etc/passwd"), true);
    ASSERT_FALSE(refused) << name;
    EXPECT_TRUE(refused.error().detail().starts_with(std::string(name) + " names a file or"));
  }
  EXPECT_TRUE(parameters.set(text_record("mode", "mono8"), true));
  EXPECT_EQ(parameters.text("mode"), "mono8");
  // Windows of the original send back all parameters.
  for (const bool foreign : {true, false}) {
    for (const Parameter& record : parameters.list().parameters)
      EXPECT_TRUE(parameters.set(record, foreign)) << record.name.view();
    EXPECT_EQ(parameters.text("mapFile"), path) << "not the beginning that the record has";
  }
  EXPECT_TRUE(parameters.set(text_record("mapFile", "/maps/a.dxf"), false));
  EXPECT_EQ(parameters.text("mapFile"), "/maps/a.dxf");
}

TEST_F(ParametersTest, AreListedInTheOrderOfTheOriginal) {
  const ParameterList list = parameters.list();
  const std::array<std::string_view, 13> names = {
      "name",        "system",       "instance", "gdosLevel",    "targetStatus",
      "cmdTaskPrio", "dataTaskPrio", "cpu",      "errorTimeout", "vxMax",
      "scale",       "mapFile",      "anything"};
  ASSERT_EQ(list.parameters.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(list.parameters[i].name, names[i]);
  EXPECT_EQ(list.parameters[0].type, Parameter::kString);
  EXPECT_EQ(list.parameters[0].valueString, "ChassisSim");
  EXPECT_EQ(list.parameters[9].type, Parameter::kInt);
  EXPECT_EQ(list.parameters[9].valueInt, 700);
  EXPECT_EQ(list.parameters[10].type, Parameter::kFloat);
  EXPECT_EQ(list.parameters[10].valueFloat, 1.5F);
}

TEST_F(ParametersTest, TakeTexts) {
  EXPECT_TRUE(parameters.set("vxMax", "10000"));
  EXPECT_TRUE(parameters.set("scale", "-2"));
  EXPECT_TRUE(parameters.set("mapFile", "/maps/hall.dxf"));
  EXPECT_TRUE(parameters.set("anything", "-2147483648"));
  EXPECT_EQ(parameters.integer("vxMax"), 10000);
  EXPECT_EQ(parameters.real("scale"), -2.0F);
  EXPECT_EQ(parameters.text("mapFile"), "/maps/hall.dxf");
  EXPECT_EQ(parameters.integer("anything"), -2147483648);
}

TEST_F(ParametersTest, RefuseWhatIsOutOfRangeAndKeepTheOldValue) {
  for (const std::string_view bad : {"-1", "10001", "fast", "1.5", "", "7 ", "99999999999"}) {
    const auto set = parameters.set("vxMax", bad);
    ASSERT_FALSE(set) << bad;
    EXPECT_EQ(set.error().detail(),
              "vxMax = " + std::string(bad) + ": must be a whole number from 0 to 10000");
  }
  EXPECT_EQ(parameters.integer("vxMax"), 700);
  EXPECT_FALSE(parameters.set("scale", "2.01"));
  EXPECT_FALSE(parameters.set("scale", "nan"));
  EXPECT_FALSE(parameters.set("mapFile", std::string(4096, 'x')));
  EXPECT_TRUE(parameters.set("mapFile", std::string(4095, 'x')));
  EXPECT_FALSE(parameters.set("nothing", "1"));
}

constexpr std::array<ParameterInfo, 5> kPartners = {{
    required_partner("ladar", "the ladar"),
    optional_partner("position", "the position", "the position, for refPos; -1: none"),
    {"vxMax", 700, "speed"},
    or_none(partner("scan2d*B", "the second scan", "that one; -1: none")),
    at_start(partner("chassis", "the chassis")),
}};

TEST(Parameters, TheRowOfAPartnerDeclaresTwo) {
  const Parameters parameters("Scan2d", kPartners);
  std::vector<std::string> lines;
  for (const auto& entry : parameters.entries().subspan(common_parameters().size()))
    lines.push_back(std::string(entry.info->name) + ": " + std::string(entry.info->help) + " (" +
                    default_of(*entry.info) + ", " + allowed(*entry.info) + ")");
  const std::vector<std::string> expected = {
      "ladarSys: system id of the ladar (0, a whole number from 0 to 65535)",
      "ladarInst: instance of the ladar (required, a whole number from 0 to 65535)",
      "positionSys: system id of the position (0, a whole number from 0 to 65535)",
      "positionInst: instance of the position, for refPos; -1: none (-1, a whole number from -1 to "
      "65535)",
      "vxMax: speed (700, a whole number)",
      "scan2dSysB: system id of the second scan (0, a whole number from 0 to 65535)",
      "scan2dInstB: instance of that one; -1: none (0, a whole number from -1 to 65535)",
      "chassisSys: system id of the chassis (0, a whole number from 0 to 65535)",
      "chassisInst: instance of the chassis (0, a whole number from 0 to 65535)",
  };
  EXPECT_EQ(lines, expected);
  EXPECT_EQ(parameters.integer("positionInst"), -1);
  EXPECT_EQ(parameters.entries().back().takes_effect, TakesEffect::kAtStart);
}

TEST(Parameters, IdsFitIntoTheFleetsAddresses) {
  static constexpr std::array<ParameterInfo, 2> kPilot = {
      {{"scan2dSys", 0, "system", 0, kIdMax}, {"scan2dInst", 0, "instance", -1, kIdMax}}};
  Parameters parameters("Pilot", kPilot);
  EXPECT_TRUE(parameters.set("scan2dSys", "300")) << "before the router is known";
  EXPECT_TRUE(parameters.set("instance", "500"));
  EXPECT_TRUE(parameters.set_widths({.system = 9, .class_id = 8, .instance = 9, .local = 6}));
  EXPECT_TRUE(parameters.set("scan2dInst", "511"));
  EXPECT_TRUE(parameters.set("scan2dInst", "-1"));
  const auto large = parameters.set("scan2dInst", "512");
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().detail(), "scan2dInst = 512: must be a whole number from -1 to 511");
  const auto fits = parameters.set_widths({});
  ASSERT_FALSE(fits);
  EXPECT_EQ(fits.error().detail(),
            "instance = 500: addresses of this fleet have 8 bits for the system and 8 for the "
            "instance");
}

TEST_F(ParametersTest, TakeRecords) {
  EXPECT_TRUE(parameters.set(whole("vxMax", 800)).value());
  EXPECT_EQ(parameters.integer("vxMax"), 800);
  EXPECT_TRUE(parameters.set(real("scale", 0.5F)).value());
  EXPECT_EQ(parameters.real("scale"), 0.5F);
  Parameter text = record("mapFile", Parameter::kString);
  text.valueString = "a.dxf";
  EXPECT_TRUE(parameters.set(text).value());
  EXPECT_EQ(parameters.text("mapFile"), "a.dxf");
  EXPECT_FALSE(parameters.set(whole("unknown", 1)).value()) << "not ours, no error";
}

TEST_F(ParametersTest, TakeEitherKindOfNumber) {
  EXPECT_TRUE(parameters.set(real("vxMax", 42.0F)));
  EXPECT_EQ(parameters.integer("vxMax"), 42);
  EXPECT_TRUE(parameters.set(whole("scale", 2)));
  EXPECT_EQ(parameters.real("scale"), 2.0F);
}

TEST_F(ParametersTest, RefuseRecordsOfTheWrongKind) {
  EXPECT_FALSE(parameters.set(whole("vxMax", 10001)));
  EXPECT_FALSE(parameters.set(whole("mapFile", 1)));
  EXPECT_FALSE(parameters.set(record("vxMax", Parameter::kString)));
  EXPECT_FALSE(parameters.set(record("vxMax", 7)));
  EXPECT_FALSE(parameters.set(real("vxMax", std::numeric_limits<f32>::quiet_NaN())));
  EXPECT_FALSE(parameters.set(real("anything", 1e20F)));
  EXPECT_FALSE(parameters.set(real("scale", std::numeric_limits<f32>::infinity())));
  EXPECT_EQ(parameters.integer("vxMax"), 700);
  EXPECT_EQ(parameters.integer("anything"), 0);
}

}  // namespace parameters_test
}  // namespace rack
