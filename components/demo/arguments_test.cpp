#include "components/demo/arguments.h"

#include <gtest/gtest.h>

namespace tims::demo {
namespace {

using namespace std::chrono_literals;
using Words = std::vector<std::string>;

Arguments parsed(const Words& words) {
  const auto result = parse_arguments(words);
  const auto* arguments = std::get_if<Arguments>(&result);
  EXPECT_NE(arguments, nullptr) << std::get<std::string>(result);
  return arguments == nullptr ? Arguments{} : *arguments;
}

std::string refusal(const Words& words) {
  const auto result = parse_arguments(words);
  return std::holds_alternative<std::string>(result) ? std::get<std::string>(result) : "accepted";
}

TEST(Arguments, EachRoleHasItsDefaults) {
  EXPECT_EQ(parsed({"ladar"}).at, kLadar);
  EXPECT_EQ(parsed({"viewer"}).to, kLadar);
  EXPECT_EQ(parsed({"server"}).at, kServer);
  EXPECT_EQ(parsed({"client"}).to, kServer);
  EXPECT_EQ(parsed({"client"}).period, 100ms);
}

TEST(Arguments, SayWhereItIsAndWhomItTalksTo) {
  const Arguments client =
      parsed({"client", "--to", "Test(2/0)", "--at", "Test(1/2):1", "--rate", "50"});
  EXPECT_EQ(client.at, Address(0x01100201));
  EXPECT_EQ(client.to, Address(0x02100000));
  EXPECT_EQ(client.period, 20ms);
}

TEST(Arguments, RefuseWhatARoleDoesNotKnow) {
  EXPECT_EQ(refusal({}), "which component?");
  EXPECT_EQ(refusal({"lidar"}), "no component \"lidar\"");
  EXPECT_EQ(refusal({"ladar", "--to", "Test(1/0)"}), "ladar has no option \"--to\"");
  EXPECT_EQ(refusal({"server", "--rate", "3"}), "server has no option \"--rate\"");
  EXPECT_EQ(refusal({"ladar", "--at"}), "--at needs a value");
  EXPECT_EQ(refusal({"ladar", "--rate", "0"}), "\"0\" is no rate from 0.1 to 1000 Hz");
  EXPECT_EQ(refusal({"ladar", "--rate", "nan"}), "\"nan\" is no rate from 0.1 to 1000 Hz");
  EXPECT_NE(refusal({"ladar", "--at", "Foo"}).find("is no address"), std::string::npos);
}

}  // namespace
}  // namespace tims::demo
