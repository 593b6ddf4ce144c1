#include "proxies/message_files.h"

#include <array>
#include <cstdlib>
#include <fstream>

#include <gtest/gtest.h>

#include "rack/codec/message_text.h"
#include "rack/proxies/catalogue.h"
#include "rack/proxies/proxy.h"
#include "tests/support/temporary_folder.h"

namespace rack {
namespace message_files_test {

namespace unit {
struct Millikelvin {
  static constexpr std::string_view kName = "mK";
  static constexpr std::string_view kSiName = "K";
  static constexpr f64 kSi = 1e-3;
};
}  // namespace unit

struct Spot {
  Millimetres<i32> x = 7;
  std::array<u8, 2> colour = {1, 2};
};

struct HeatData {
  TimeStamp recordingTime = 0;
  Quantity<i32, unit::Millikelvin> temperature = 293150;
  tims::Address sensor = kNobody;
  Text<8> label = "air";
  Spot hottest = {};
  f64 gain = 0.5;
  Count spotNum = {};
  Sequence<Spot, 4> spots = {};
};

struct HeatNote {
  Count length = {};
  Sequence<char, 16> letters = {};
};

constexpr u32 kHeat = 0x90;
constexpr MessageInfo kMessages[] = {{kHeat, tims::type::kData, "DATA", kBody<HeatData>},
                                     {kHeat, 21, "NOTE", kBody<HeatNote>},
                                     {kHeat, 22, "RESET"}};
constexpr ClassInfo kHeatClass = {kHeat, "Heat", kMessages};

std::string text() { return *message_file(kHeatClass); }

std::string replaced(std::string_view what, std::string_view by) {
  std::string out = text();
  const std::size_t at = out.find(what);
  EXPECT_NE(at, std::string::npos) << what << " in " << out;
  return out.replace(at, what.size(), by);
}

std::string refusal(std::string_view text) {
  const auto file = MessageFile::parse(text);
  return file ? "accepted" : file.error().detail();
}

TEST(MessageFiles, MatchTheStructs) {
  const auto file = MessageFile::parse(text());
  ASSERT_TRUE(file) << file.error().message() << text();
  const ClassInfo& read = (*file)->class_info();
  EXPECT_EQ(read.class_id, kHeat);
  EXPECT_EQ(read.name, "Heat");
  ASSERT_EQ(read.messages.size(), 3U);
  EXPECT_EQ(read.messages[2].name, "RESET");
  EXPECT_EQ(read.messages[2].body, nullptr);
  const Schema& data = *read.messages[0].body;
  EXPECT_EQ(data.name, "HeatData");
  EXPECT_EQ(data.size_min, kSchema<HeatData>.size_min);
  EXPECT_EQ(data.size_max, kSchema<HeatData>.size_max);
  EXPECT_EQ(columns_of(data), columns_of(kSchema<HeatData>));
  EXPECT_EQ(columns_of(*read.messages[1].body), columns_of(kSchema<HeatNote>));
}

TEST(MessageFiles, BodiesAreReadAndMadeLikeThoseOfTheStruct) {
  const auto file = MessageFile::parse(text());
  ASSERT_TRUE(file);
  const Schema& data = *(*file)->class_info().messages[0].body;
  const std::vector<Assignment> fields = {
      {"temperature", "300.5K"}, {"spots[0].colour[1]", "9"}, {"label", "roof"}};
  for (const PrintStyle style : {PrintStyle{}, PrintStyle{.si = true, .one_line = true}}) {
    const auto made = make_body(data, fields, std::endian::big, style);
    ASSERT_TRUE(made) << made.error().message();
    EXPECT_EQ(*made, *make_body(kSchema<HeatData>, fields, std::endian::big, style));
    EXPECT_EQ(*body_text(data, *made, std::endian::big, style),
              *body_text(kSchema<HeatData>, *made, std::endian::big, style));
    EXPECT_EQ(*body_json(data, *made, std::endian::big, style),
              *body_json(kSchema<HeatData>, *made, std::endian::big, style));
  }
  EXPECT_EQ(
      *body_json(data, *make_body(data, {}, std::endian::little, {}), std::endian::little, {}),
      R"({"recordingTime":0,"temperature":293150,"sensor":null,"label":"air",)"
      R"("hottest":{"x":7,"colour":[1,2]},"gain":0.5,"spotNum":0,"spots":[]})");
}

TEST(MessageFiles, ReportWhereTheyAreWrong) {
  EXPECT_TRUE(refusal("{").starts_with("not JSON: "));
  EXPECT_EQ(refusal("[]"), "the file is not an object");
  EXPECT_EQ(refusal("{}"), "rack_messages is missing: this is not a message file");
  EXPECT_EQ(refusal(replaced("_messages\": 1", "_messages\": 2")),
            "rack_messages is not a whole number from 1 to 1");
  EXPECT_EQ(refusal(replaced("\"class_id\": 144", "\"class_id\": 20")),
            "class_id 20 (0x14) is the number of Ladar: use a number from 128 on");
  EXPECT_EQ(refusal(replaced("\"class\": \"Heat\"", "\"class\": \"Ladar\"")),
            "class Ladar is a class of RACK itself");
  EXPECT_EQ(refusal(replaced("\"class\": \"Heat\"", "\"class\": \"\\u001b[31m\"")),
            "class is not a name of letters, digits and _, at most 64");
  EXPECT_EQ(refusal(replaced("\"type\": -6", "\"type\": 300")),
            "messages[0].type is not a whole number from -128 to 127");
  EXPECT_EQ(refusal(replaced("\"type\": 22", "\"type\": 1")),
            "messages[2].type 1 is a message of every class: commands begin at 21, answers at -21");
  EXPECT_EQ(refusal(replaced("\"type\": 22", "\"type\": 21")),
            "messages[2].type or name is taken by NOTE");
  EXPECT_EQ(refusal(replaced("\"body\": \"HeatNote\"", "\"body\": \"Heat\"")),
            "messages[1].body Heat is not a struct in this file");
  EXPECT_EQ(
      refusal(replaced("\"type\": \"f64\"", "\"type\": \"HeatData\"")),
      "structs[1].fields[5].type HeatData is neither a type nor a struct defined before this one");
  EXPECT_EQ(refusal(replaced("\"at_most\": 4", "\"at_most\": 99999999")),
            "structs[1].fields[7].at_most is not a whole number from 1 to 16777216");
  EXPECT_EQ(refusal(replaced("\"times\": 2", "\"times\": 65536")),
            "structs[0].fields[1].name makes the struct larger than 65536 bytes");
  EXPECT_EQ(refusal(replaced("\"spotNum\", \"type\": \"count\"", "\"spotNum\", \"type\": \"i32\"")),
            "structs[1].fields have a count without a sequence or a sequence without a count");
  EXPECT_EQ(refusal(replaced("\"made\": \"07", "\"made\": \"zz")),
            "structs[0].made is not a text of pairs of hex digits");
  EXPECT_TRUE(refusal(replaced("\"made\": \"07", "\"made\": \"0707"))
                  .starts_with("structs[0].made does not fit: Spot is 6 bytes long"));
  EXPECT_EQ(refusal(replaced("\"unit\": \"mm\"", "\"unit\": \"\\n\"")),
            "structs[0].fields[0].unit is not a unit such as \"mm/s\"");
}

TEST(MessageFiles, DeepTextsEndInAnErrorToo) {
  EXPECT_TRUE(refusal(std::string(100000, '[')).starts_with("not JSON: "));
}

struct Image {
  u32 size = 0;
  Tail<std::byte, 16> bytes = {};
  [[nodiscard]] std::array<std::int64_t, 1> tail_sizes() const { return {size}; }
};
constexpr MessageInfo kImage[] = {{kHeat, 21, "IMAGE", kBody<Image>}};

TEST(MessageFiles, AreNotMadeOfWhatOnlyAProgramKnows) {
  const auto file = message_file({kHeat, "Heat", kImage});
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().detail(),
            "Image.bytes is a Tail, whose length only a program knows: make it a Sequence");
}

// One test, because loaded files cannot be removed.
TEST(MessageFiles, AreFoundInTheFoldersOfTheEnvironment) {
  tims::test::TemporaryFolder folder;
  std::ofstream(folder.path() / "heat.json") << text();
  std::ofstream(folder.path() / "broken.json") << "{}";
  std::ofstream(folder.path() / "notes.txt") << "not looked at";
  ::setenv("RACK_MESSAGES", (folder.path().string() + ":/nowhere").c_str(), 1);
  EXPECT_EQ(find_message(kHeat, "NOTE"), nullptr);
  const auto problems = load_message_files();
  ASSERT_EQ(problems.size(), 2U);
  EXPECT_TRUE(
      problems[0].ends_with("broken.json: rack_messages is missing: this is not a message file"));
  EXPECT_EQ(problems[1], "/nowhere: is not a file");
  const MessageInfo* found = find_message(kHeat, "note");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->body->name, "HeatNote");
  EXPECT_EQ(find_message(
                {.type = -6, .dest = tims::Address(0x00020000), .src = tims::Address(0x00900000)})
                ->body->name,
            "HeatData");
  EXPECT_EQ(added_classes().size(), 1U);
  EXPECT_FALSE(add_class({kHeat, "Other", {}}));
  EXPECT_FALSE(add_class({0x91, "Heat", {}}));
}

}  // namespace message_files_test
}  // namespace rack
