#include "proxies/gdos_record.h"

#include <gtest/gtest.h>

namespace rack::gdos {
namespace {

using namespace std::chrono_literals;
using namespace std::string_literals;

const RecordTime kTime{1763780400123ms};  // 2025-11-22, three o'clock

Record record(const std::string& text) {
  return {.time = kTime,
          .address = tims::Address(0x00110000),
          .component = "Chassis(0/0)",
          .level = Level::kWarning,
          .text = text};
}
// As it is read again.
std::string kept(const std::string& text) {
  const auto read = record_of(to_line(record(text)));
  return read ? read->text : "not a record";
}

TEST(GdosRecord, OneLineOfJson) {
  EXPECT_EQ(to_line(record("Listener \"GUI(0/0)\" is gone")),
            R"({"time":"2025-11-22T03:00:00.123Z","address":"0x00110000",)"
            R"x("component":"Chassis(0/0)","level":"warning",)x"
            R"("text":"Listener \"GUI(0/0)\" is gone"})"
            "\n");
}

TEST(GdosRecord, ReadsBack) {
  const auto read = record_of(to_line(record("ready")));
  ASSERT_TRUE(read);
  EXPECT_EQ(*read, record("ready"));
  for (const std::string& text :
       {""s, "\"\\/"s, "a\0b"s, "\x1b[31mred\n\r\t\x7f"s, "Käfer €\U0001F916"s})
    EXPECT_EQ(kept(text), text);
}

TEST(GdosRecord, NothingThatATerminalObeysIsInALine) {
  const std::string line = to_line(record("\x1b]0;title\a\n\xC2\x9B"s + "31m"));
  EXPECT_EQ(line.find_first_of("\x1b\a\x9B"), std::string::npos) << line;
  EXPECT_EQ(line.find('\n'), line.size() - 1);
}

TEST(GdosRecord, WhatIsNoUtf8IsLatin1) {
  EXPECT_EQ(kept("K\xE4"
                 "fer"),
            "Käfer");
  EXPECT_EQ(kept("\xC0\x80"), "À\xC2\x80") << "NUL, written too long";
  EXPECT_EQ(kept("\xED\xA0\x80"), "í\xC2\xA0\xC2\x80") << "half of a pair";
  EXPECT_EQ(kept("\xE2\x82"), "â\xC2\x82") << "cut off";
}

TEST(GdosRecord, LongTextsAreCutBetweenCharacters) {
  const std::string text = kept("x" + std::string(kTextMax, '\xE4'));
  EXPECT_EQ(text.size(), kTextMax - 1);
  EXPECT_TRUE(text.ends_with("ää"));
}

TEST(GdosRecord, ReadsWhatOthersWrote) {
  const auto read = record_of(R"( { "text" : "\u00e4\n" , "level":"print", "host":"robot1",)"
                              R"( "address":"0x00110000", "time":"2025-11-22T03:00:00Z" } )");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->text, "ä\n");
  EXPECT_EQ(read->time, kTime - 123ms);
  EXPECT_EQ(read->component, "");
}

TEST(GdosRecord, AnythingElseIsNone) {
  const std::string good = to_line(record("text"));
  for (std::size_t size = 0; size + 1 < good.size(); ++size)
    EXPECT_FALSE(record_of(good.substr(0, size))) << size << " bytes of it";
  EXPECT_FALSE(record_of("{}"));
  EXPECT_FALSE(record_of(good + "}"));
  for (const auto& [part, other] : {std::pair{"warning", "fatal"},
                                    {"0x00110000", "somewhere"},
                                    {"03:00:00.123Z", "25:00:00.123Z"},
                                    {"-11-22", "-02-30"},
                                    {".123Z", ".Z"},
                                    {"\"text\"}", "\"\\ud800\"}"},
                                    {"\"text\"}", "\"\\q\"}"},
                                    {"\"text\"}", "7}"}}) {
    std::string line = good;
    line.replace(line.find(part), std::string(part).size(), other);
    EXPECT_FALSE(record_of(line)) << line;
  }
}

}  // namespace
}  // namespace rack::gdos
