#include "rack/proxies/catalogue.h"

#include <array>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "rack/codec/message_text.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/pilot.h"

namespace rack {
namespace catalogue_test {

using tims::Address;
using tims::Header;

constexpr Address kChassis(0x00110000);
constexpr Address kPilot(0x00180100);
constexpr Address kGui(0x00020100);

std::string_view name_of(const Header& header) {
  const MessageInfo* found = find_message(header);
  return found == nullptr ? "unknown" : found->name;
}

TEST(Catalogue, EveryMessageOnce) {
  std::set<std::pair<u32, i8>> seen;
  std::size_t count = 0;
  for (const auto table : message_tables()) {
    for (const MessageInfo& message : table) {
      seen.emplace(message.class_id, message.type);
      ++count;
      EXPECT_FALSE(message.name.empty());
    }
  }
  EXPECT_EQ(seen.size(), count);
}

TEST(Catalogue, EveryClassOfTheOriginalHasData) {
  for (u32 id = tims::class_id::kChassis; id <= tims::class_id::kCompass; ++id) {
    const MessageInfo* data = find_message(id, tims::type::kData);
    ASSERT_NE(data, nullptr) << tims::class_name(id);
    ASSERT_NE(data->body, nullptr);
    const auto columns = columns_of(*data->body);
    EXPECT_EQ(columns.front(), (Column{"recordingTime", "ms", "s", "u32"})) << data->body->name;
    EXPECT_TRUE(data->body->name.starts_with(tims::class_name(id))) << data->body->name;
  }
}

TEST(Catalogue, CommandsByReceiverRepliesBySender) {
  EXPECT_EQ(name_of({.type = 21, .dest = kChassis, .src = kPilot}), "MOVE");
  EXPECT_EQ(name_of({.type = 21, .dest = kPilot, .src = kGui}), "SET_DESTINATION");
  EXPECT_EQ(name_of({.type = -21, .dest = kPilot, .src = kChassis}), "PARAMETER");
  EXPECT_EQ(name_of({.type = -6, .dest = kGui, .src = kChassis}), "DATA");
}

TEST(Catalogue, TheFrameworksOwnAreTheSameForAll) {
  EXPECT_EQ(name_of({.type = 3, .dest = kChassis, .src = kGui}), "GET_STATUS");
  EXPECT_EQ(name_of({.type = -1, .dest = kGui, .src = kChassis}), "ERROR");
  EXPECT_EQ(name_of({.type = 10, .dest = Address(0x00800000), .src = kGui}), "SET_PARAM");
}

TEST(Catalogue, RepliesWithPositiveNumbers) {
  EXPECT_EQ(name_of({.type = 25, .dest = kGui, .src = kPilot}), "STATUS");
}

TEST(Catalogue, MessagesToRoutersAndUnknownTypesHaveNoName) {
  EXPECT_EQ(name_of({.type = 10}), "unknown");
  EXPECT_EQ(name_of({.type = 77, .dest = kChassis, .src = kGui}), "unknown");
}

TEST(Catalogue, PrintsABody) {
  const MessageInfo* move = find_message(tims::class_id::kChassis, ChassisType::kMove);
  ASSERT_NE(move, nullptr);
  EXPECT_EQ(move->body->name, "ChassisMoveData");
  const std::array<std::byte, 12> body = {std::byte{}, std::byte{}, std::byte{2}, std::byte{1}};
  EXPECT_EQ(*body_json(*move->body, body, std::endian::big, {}), R"({"vx":513,"vy":0,"omega":0})");
  EXPECT_EQ(*body_text(*move->body, body, std::endian::big, {}),
            "vx: 513 mm/s\nvy: 0 mm/s\nomega: 0 rad/s\n");
  const auto little = recode(*move->body, body, std::endian::big, std::endian::little);
  ASSERT_TRUE(little);
  EXPECT_EQ(little->at(0), std::byte{1});
  EXPECT_EQ(body_json(*move->body, {}, std::endian::big, {}).error().code(),
            tims::Errc::kMalformed);
}

TEST(Catalogue, MessagesByName) {
  const MessageInfo* move = find_message(tims::class_id::kChassis, "move");
  ASSERT_NE(move, nullptr);
  EXPECT_EQ(move->type, ChassisType::kMove);
  EXPECT_EQ(find_message(tims::class_id::kLadar, "Get_Status")->type, tims::type::kGetStatus);
  EXPECT_EQ(find_message(tims::class_id::kLadar, "move"), nullptr);
}

TEST(Catalogue, MakesABodyOfFieldsByName) {
  const Schema& move = *find_message(tims::class_id::kChassis, "move")->body;
  const std::array<Assignment, 2> fields = {{{"vx", "0.2m/s"}, {"omega", "0.5"}}};
  const auto bytes = make_body(move, fields, std::endian::big, {});
  ASSERT_TRUE(bytes);
  EXPECT_EQ(*body_json(move, *bytes, std::endian::big, {}), R"({"vx":200,"vy":0,"omega":0.5})");
  const std::array<Assignment, 1> wrong = {{{"vz", "1"}}};
  EXPECT_EQ(make_body(move, wrong, std::endian::big, {}).error().detail(),
            "ChassisMoveData has no field \"vz\"");
}

// The data of every class with default values can be created and printed on one line.
TEST(Catalogue, EveryMessageCanBeMadeAndPrinted) {
  for (const auto table : message_tables()) {
    for (const MessageInfo& message : table) {
      if (message.body == nullptr) continue;
      const auto bytes = make_body(*message.body, {}, std::endian::little, {});
      ASSERT_TRUE(bytes) << message.body->name << bytes.error().message();
      const auto line = body_text(*message.body, *bytes, std::endian::little, {.one_line = true});
      ASSERT_TRUE(line) << message.body->name << line.error().message();
      EXPECT_FALSE(line->empty()) << message.body->name;
      EXPECT_EQ(line->find('\n'), std::string::npos) << *line;
    }
  }
}

}  // namespace catalogue_test
}  // namespace rack
