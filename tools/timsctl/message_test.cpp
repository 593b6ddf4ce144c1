#include "tools/timsctl/message.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/text.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/ladar.h"
#include "tools/cli/arguments.h"
#include "tools/cli/failure.h"

namespace timsctl {
namespace message_test {

using testing::HasSubstr;

Message message(std::size_t bytes, std::uint8_t flags = tims::flag::kBodyLittleEndian) {
  Message m{.header = {.flags = flags,
                       .type = -6,
                       .priority = 200,
                       .seq_nr = 9,
                       .dest = tims::Address(0x030F0709),
                       .src = tims::Address(0x03140000),
                       .length = static_cast<std::uint32_t>(16 + bytes)},
            .body = {}};
  // Every value, also those that look like marks of the format: '-', '|', '.', blanks.
  for (std::size_t i = 0; i < bytes; ++i) m.body.push_back(static_cast<std::byte>(i * 7));
  return m;
}
constexpr base::WallTime kTime(std::chrono::seconds(1'800'000'000));

void expect_same(const Draft& draft, const Message& m) {
  EXPECT_EQ(draft.type, m.header.type);
  EXPECT_EQ(draft.priority, m.header.priority);
  EXPECT_EQ(draft.seq_nr, m.header.seq_nr);
  EXPECT_EQ(draft.little_endian, m.header.body_order() == std::endian::little);
  EXPECT_EQ(draft.body, m.body);
}

std::string refusal(const std::string& text) {
  try {
    (void)parse_recorded(text);
  } catch (const Failure& failure) {
    return failure.message;
  }
  return "accepted";
}

TEST(MessageText, LooksLikeThis) {
  Message m = message(0);
  m.body = *base::parse_hex("01 02 41 42");
  EXPECT_EQ(dump(m, kTime, {.utc = true}),
            "-- 08:00:00.000Z Ladar(3/0) -> Tool(3/7):9 type=-6 (data) priority=200 seq=9 "
            "order=little bytes=4\n"
            "   0000  01 02 41 42                                       |..AB|\n");
}

TEST(MessageText, AddressesAreDividedAsTheFleetDoes) {
  constexpr tims::AddressWidths kWidths{6, 8, 10, 8};
  Message m = message(0);
  m.header.src = tims::Address::of({.system = 3, .class_id = 0x14, .instance = 500}, kWidths);
  EXPECT_THAT(dump(m, kTime, {.widths = kWidths}), HasSubstr(" Ladar(3/500) -> "));
  EXPECT_EQ(text_at(message_json(m, kTime, kWidths), "src.name"), "Ladar(3/500)");
}

TEST(MessageText, WhatIsWrittenCanBeRead) {
  for (const std::size_t bytes : {0U, 1U, 15U, 16U, 17U, 1000U, 70'000U}) {
    const Message m = message(bytes);
    const std::string text = dump(m, kTime, {});
    ASSERT_TRUE(is_recorded(text));
    const auto drafts = parse_recorded(text);
    ASSERT_EQ(drafts.size(), 1U);
    expect_same(drafts[0], m);
  }
}

TEST(MessageText, SeveralMessagesAndBothOrders) {
  const Message big = message(20, 0);
  const auto drafts = parse_recorded(dump(message(40), kTime, {}) + dump(big, kTime, {}));
  ASSERT_EQ(drafts.size(), 2U);
  expect_same(drafts[1], big);
}

TEST(MessageText, JsonCanBeReadToo) {
  const Message m = message(40, 0);
  const std::string lines = to_text(message_json(m, kTime, {})) + "\n" +
                            to_text(message_json(message(3), kTime, {})) + "\n";
  ASSERT_TRUE(is_recorded(lines));
  const auto drafts = parse_recorded(lines);
  ASSERT_EQ(drafts.size(), 2U);
  expect_same(drafts[0], m);
  expect_same(drafts[1], message(3));
}

TEST(MessageText, ABodyInDotsIsNotAShortenedOne) {
  Message m = message(0);
  m.body = *base::parse_hex("2e2e2e20 2e2e2e20 2e2e2e20 2e2e2e20");
  expect_same(parse_recorded(dump(m, kTime, {})).at(0), m);
}

TEST(MessageText, ShortenedForATerminalIsRefused) {
  const std::string text = dump(message(100), kTime, {.bytes_max = 32});
  EXPECT_THAT(text, HasSubstr("... 68 more bytes"));
  EXPECT_THAT(refusal(text), HasSubstr("shortened"));
}

TEST(MessageText, DamageIsRefusedWithTheLine) {
  const std::string good = dump(message(20), kTime, {});
  EXPECT_THAT(refusal(good.substr(0, good.rfind("   0010"))), HasSubstr("16 bytes, not 20"));
  std::string no_type = good;
  no_type.replace(no_type.find(" type="), 6, " tipe=");
  EXPECT_THAT(refusal(no_type), HasSubstr("line 1"));
  EXPECT_THAT(refusal(good + "what is this?\n"), HasSubstr("line 4"));
  EXPECT_THAT(refusal("{\"schema\":\"tims/message/1\",\"type\":300,\"body_hex\":\"\"}"),
              HasSubstr("line 1"));
  EXPECT_THAT(refusal("{\"schema\":\"tims/message/1\",\"type\":1,\"body_hex\":\"0\"}"),
              HasSubstr("line 1"));
}

TEST(MessageText, OtherFilesAreBodies) {
  EXPECT_FALSE(is_recorded(""));
  EXPECT_FALSE(is_recorded("--- a patch"));
  EXPECT_FALSE(is_recorded("{\"a\":1}"));
}

using testing::HasSubstr;

constexpr std::uint32_t kChassis = tims::class_id::kChassis;

template <typename Body>
Message message(tims::Address from, std::int8_t type, const Body& body) {
  Message m{
      .header = {.flags = std::endian::native == std::endian::little ? tims::flag::kBodyLittleEndian
                                                                     : std::uint8_t{},
                 .type = type,
                 .dest = tims::Address(0x000F0709),
                 .src = from},
      .body = std::vector<std::byte>(rack::encoded_size(body))};
  EXPECT_TRUE(rack::encode(body, m.body));
  return m;
}
Message chassis_data() {
  return message(tims::Address(0x00110000), tims::type::kData,
                 rack::ChassisData{.recordingTime = 7, .vx = 200, .omega = INFINITY});
}
Message scan() {
  rack::LadarData data{.recordingTime = 1};
  data.points.resize(3);
  data.points[2].distance = 250;
  return message(tims::Address(0x00140000), tims::type::kData, data);
}

template <typename Call>
std::string refusal(const Call& call) {
  try {
    call();
  } catch (const Failure& failure) {
    return failure.message + " -> " + failure.hint;
  }
  return "accepted";
}

TEST(MessageFields, ALineAMessage) {
  EXPECT_EQ(describe(chassis_data(), kTime, {.utc = true}),
            "08:00:00.000Z Chassis(0/0) data recordingTime 7 ms, deltaX 0 mm, deltaY 0 mm, "
            "deltaRho 0 rad, vx 200 mm/s, vy 0 mm/s, omega inf rad/s, battery 0 V, "
            "activePilot none\n");
}

TEST(MessageFields, ALineAFieldInSi) {
  EXPECT_THAT(describe(chassis_data(), kTime, {.utc = true, .si = true, .fields = true}),
              HasSubstr("Chassis(0/0) data\n  recordingTime: 0.007 s\n"));
  EXPECT_THAT(describe(chassis_data(), kTime, {.si = true}), HasSubstr(", vx 0.2 m/s, "));
}

TEST(MessageFields, TheReceiverToo) {
  EXPECT_THAT(describe(chassis_data(), kTime, {.header = true}),
              HasSubstr(" Chassis(0/0) -> Tool(0/7):9 data (priority 0, seq 0, 36 bytes) "));
}

TEST(MessageFields, UnknownAndDamagedOnesAreBytes) {
  Message unknown = chassis_data();
  unknown.header.type = -100;
  EXPECT_THAT(describe(unknown, kTime, {}), HasSubstr("type=-100 "));
  Message damaged = chassis_data();
  damaged.body.pop_back();
  EXPECT_THAT(describe(damaged, kTime, {}), HasSubstr("ChassisData has at least 36 bytes"));
  EXPECT_THAT(text_at(described_json(damaged, kTime, {}), "malformed"),
              HasSubstr("ChassisData has at least 36 bytes"));
}

TEST(MessageFields, JsonHasUnitsAndCanStillBeSent) {
  const json::object described = described_json(chassis_data(), kTime, {.si = true});
  EXPECT_EQ(text_at(described, "schema"), "tims/message/1");
  EXPECT_EQ(text_at(described, "type_name"), "data");
  EXPECT_EQ(text_at(described, "body"), "ChassisData");
  EXPECT_EQ(text_at(described, "units.vx"), "m/s");
  EXPECT_EQ(number_at(described, "data.vx"), 0.2);
  EXPECT_EQ(at_path(described, "data.omega"), nullptr) << "JSON has no infinity: null";
  const auto drafts = parse_recorded(to_text(described) + "\n");
  ASSERT_EQ(drafts.size(), 1U);
  EXPECT_EQ(drafts[0].body, chassis_data().body);
}

TEST(MessageFields, CsvNamesItsColumnsWhenTheyChange) {
  CsvLines csv;
  const std::string first = csv.add(described_json(chassis_data(), kTime, {}));
  EXPECT_THAT(first, HasSubstr("time,type_name,src,dest,recordingTime,deltaX,"));
  EXPECT_THAT(first, HasSubstr(",data,Chassis(0/0),Tool(0/7):9,7,0,"));
  EXPECT_THAT(csv.add(described_json(chassis_data(), kTime, {})),
              testing::Not(HasSubstr("recordingTime")));
  EXPECT_THAT(csv.add(described_json(scan(), kTime, {})), HasSubstr("pointNum,points\n"));
}

TEST(MessageFields, Filters) {
  const json::object chassis = described_json(chassis_data(), kTime, {});
  const json::object ladar = described_json(scan(), kTime, {});
  const auto passes = [](const char* text, const json::object& of) {
    return FieldFilter(text).passes(of);
  };
  EXPECT_TRUE(passes("", chassis));
  EXPECT_TRUE(passes("vx>100", chassis));
  EXPECT_TRUE(passes("vx=200,vy=0", chassis));
  EXPECT_FALSE(passes("vx>100,vy>0", chassis));
  EXPECT_TRUE(passes("vx>=200,vx<=200,vx!=199", chassis));
  EXPECT_FALSE(passes("vx<200", chassis));
  EXPECT_TRUE(passes("type_name=data,src=Chassis/0/0", chassis));
  EXPECT_FALSE(passes("src=Chassis/0/1", chassis));
  EXPECT_TRUE(passes("points[].distance>200", ladar));
  EXPECT_FALSE(passes("points[].distance>250", ladar));
  EXPECT_TRUE(passes("points[2].distance=250", ladar));
  EXPECT_FALSE(passes("points[3].distance=250", ladar));
  EXPECT_FALSE(passes("vx>100", ladar)) << "it has none";
}

TEST(MessageFields, FiltersAreRefusedWithWhatIsMeant) {
  EXPECT_THAT(refusal([] { FieldFilter("vx"); }), HasSubstr("\"vx\" is not a condition"));
  EXPECT_THAT(refusal([] { FieldFilter("vx=<1"); }), HasSubstr("is not a condition"));
  EXPECT_THAT(refusal([] { FieldFilter(">1"); }), HasSubstr("is not a condition"));
  const rack::Schema& data = *rack::find_message(kChassis, "data")->body;
  EXPECT_EQ(refusal([&] { FieldFilter("vx>1,priority>3,src=Chassis/0/0").check(data); }),
            "accepted");
  EXPECT_EQ(refusal([&] { FieldFilter("omga>1").check(data); }),
            "--filter: ChassisData has no field omga -> did you mean omega?");
}

std::vector<std::byte> made(const std::vector<std::string>& fields, const char* name = "move") {
  return make_body(need_message(kChassis, name), kChassis, fields, {});
}

TEST(MessageFields, BodiesByName) {
  EXPECT_EQ(made({"vx=200", "omega=0.5"}),
            message({}, 21, rack::ChassisMoveData{200, 0, 0.5F}).body);
  EXPECT_EQ(made({}), message({}, 21, rack::ChassisMoveData{}).body);
  EXPECT_EQ(made({"activePilot=Pilot/0/1"}, "set_active_pilot"),
            message({}, 23, rack::ChassisSetActivePilotData{tims::Address(0x00180100)}).body);
  EXPECT_TRUE(made({}, "get_parameter").empty());
}

TEST(MessageFields, BodiesAreRefusedWithWhatIsMeant) {
  EXPECT_EQ(refusal([] { made({"omga=1"}); }),
            "ChassisMoveData has no field \"omga\" -> did you mean omega?");
  EXPECT_EQ(refusal([] { made({"z=1"}); }),
            "ChassisMoveData has no field \"z\" -> known: vx, vy, omega");
  EXPECT_EQ(refusal([] { made({"vx=fast"}); }),
            "vx=fast: expected a number in mm/s -> timsctl msg show Chassis move");
  EXPECT_EQ(refusal([] { made({"activePilot=Pilt/0/1"}, "set_active_pilot"); }),
            "\"Pilt/0/1\" is not an address: no class is called Pilt -> did you mean Pilot/0/1?");
  EXPECT_EQ(refusal([] { made({"vx=1"}, "get_parameter"); }),
            "get_parameter has no fields -> timsctl msg show Chassis get_parameter");
  EXPECT_EQ(refusal([] { made({}, "moove"); }),
            "Chassis: \"moove\" is not a message -> did you mean move?");
}

}  // namespace message_test
}  // namespace timsctl
