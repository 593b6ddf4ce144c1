#include "components/runtime/logic/readable_name.h"

#include <array>
#include <string>

#include <gtest/gtest.h>

namespace rack {
namespace {

std::string readable(std::string_view mangled) {
  std::array<char, 80> room{};
  return std::string(readable_name(mangled, room));
}

TEST(ReadableName, OfFunctionsAndMembers) {
  EXPECT_EQ(readable("_Z5sweepi"), "sweep");
  EXPECT_EQ(readable("_ZN4rack6Module9data_taskEv"), "rack::Module::data_task");
  EXPECT_EQ(readable("_ZNK4rack6Module5is_onEv"), "rack::Module::is_on");
  EXPECT_EQ(readable("_ZN4rack12_GLOBAL__N_18Offender11module_loopEv"),
            "rack::(anonymous namespace)::Offender::module_loop");
  EXPECT_EQ(readable("_ZN4rack6ModuleC2ERKNS_10ModuleInfoE"), "rack::Module::Module");
  EXPECT_EQ(readable("_ZN4rack6ModuleD0Ev"), "rack::Module::~Module");
}

TEST(ReadableName, WhatIsRareStaysAsItIs) {
  for (const char* name : {"main", "_ZNSt6vectorIiSaIiEE9push_backEOi", "_Z", "_ZN", "_ZN4rack",
                           "_ZN9rackE", "_Z99999999999999999999a", "_ZNE", ""}) {
    EXPECT_EQ(readable(name), name);
  }
}

TEST(ReadableName, IsCutWhereTheRoomEnds) {
  std::array<char, 6> room{};
  EXPECT_EQ(readable_name("_ZN4rack6Module3runEv", room), "rack::");
  EXPECT_EQ(readable_name("clock_nanosleep", room), "clock_");
}

}  // namespace
}  // namespace rack
