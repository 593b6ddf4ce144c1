#include "components/demo/demo.h"

#include <gmock/gmock.h>

namespace tims::demo {
namespace demo_test {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;
using Strings = std::vector<std::string>;

Arguments parsed(const Strings& command_line) {
  const auto result = parse_arguments(command_line);
  const auto* arguments = std::get_if<Arguments>(&result);
  EXPECT_NE(arguments, nullptr) << std::get<Refusal>(result).text;
  return arguments == nullptr ? Arguments{} : *arguments;
}

std::string refusal(const Strings& arguments) {
  const auto result = parse_arguments(arguments);
  const auto* refusal = std::get_if<Refusal>(&result);
  return refusal != nullptr ? std::to_string(refusal->exit_code) + ": " + refusal->text
                            : "accepted";
}

TEST(Arguments, EachRoleHasItsDefaults) {
  EXPECT_EQ(parsed({"ladar"}).at, kLadar);
  EXPECT_EQ(parsed({"viewer"}).to, kLadar);
  EXPECT_EQ(parsed({"server"}).at, kServer);
  EXPECT_EQ(parsed({"client"}).to, kServer);
  EXPECT_EQ(parsed({"client"}).period, 100ms);
}

TEST(Arguments, GiveTheOwnAddressAndThatOfThePeer) {
  const Arguments client =
      parsed({"client", "--to", "Test(2/0)", "--at", "Test(1/2):1", "--rate", "50"});
  EXPECT_EQ(client.at, Address(0x01100201));
  EXPECT_EQ(client.to, Address(0x02100000));
  EXPECT_EQ(client.period, 20ms);
}

TEST(Arguments, RefuseWhatARoleDoesNotKnow) {
  EXPECT_THAT(refusal({}), HasSubstr("2: A subcommand is required"));
  EXPECT_EQ(refusal({"lidar"}), "2: no component \"lidar\"");
  EXPECT_THAT(refusal({"ladar", "--to", "Test(1/0)"}),
              AllOf(HasSubstr("not expected"), HasSubstr("--to")));
  EXPECT_THAT(refusal({"server", "--rate", "3"}),
              AllOf(HasSubstr("not expected"), HasSubstr("--rate")));
  EXPECT_THAT(refusal({"ladar", "--at"}), StartsWith("2: --at"));
  EXPECT_THAT(refusal({"ladar", "--rate", "0"}), HasSubstr("0.1 to 1000 Hz"));
  EXPECT_THAT(refusal({"ladar", "--rate", "nan"}), HasSubstr("0.1 to 1000 Hz"));
  EXPECT_THAT(refusal({"ladar", "--at", "Foo"}), HasSubstr("is not an address"));
}

TEST(Arguments, HelpIsNoError) {
  EXPECT_THAT(refusal({"--help"}), AllOf(StartsWith("0: "), HasSubstr("viewer")));
  EXPECT_THAT(refusal({"client", "--help"}), AllOf(StartsWith("0: "), HasSubstr("--rate")));
  EXPECT_THAT(refusal({"--version"}), StartsWith("0: "));
}

TEST(Scan, IsThatOfARoundRoom) {
  const rack::LadarData scan = scan_of_a_room(7, 1234);
  EXPECT_EQ(scan.recordingTime, rack::TimeStamp(1234));
  EXPECT_EQ(scan.points.size(), 361U);
  EXPECT_EQ(rack::encoded_size(scan), 24U + 361 * 16);
  for (const rack::LadarPoint& point : scan.points) {
    EXPECT_GE(point.distance, 2500);
    EXPECT_LE(point.distance, 3500);
  }
}

}  // namespace demo_test
}  // namespace tims::demo
