#include "proxies/gdos_texts.h"

#include <fstream>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.h"

namespace rack::gdos {

namespace gdos_texts_test {

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
// The text after writing and reading the record.
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

}  // namespace gdos_texts_test

namespace gdos_texts_test {

TEST(GdosFiles, NamesCount) {
  EXPECT_EQ(numbered_file(17), "texts.000017.jsonl");
  EXPECT_EQ(file_number("texts.000017.jsonl"), 17U);
  EXPECT_EQ(file_number(numbered_file(12345678)), 12345678U);
  for (const char* other : {"texts.jsonl", "texts..jsonl", "texts.x.jsonl", "texts.1.json", "t"})
    EXPECT_FALSE(file_number(other)) << other;
}

TEST(GdosFiles, OldestFirst) {
  const tims::test::TemporaryFolder folder;
  EXPECT_TRUE(log_paths(folder.path()).empty());
  EXPECT_TRUE(log_paths(folder.path() / "nowhere").empty());
  EXPECT_EQ(log_files(folder.path()).next_number(), 1U);
  for (const char* name : {"texts.jsonl", "texts.000010.jsonl", "texts.000009.jsonl", "notes"})
    std::ofstream(folder.path() / name) << "";
  const auto paths = log_paths(folder.path());
  ASSERT_EQ(paths.size(), 3U);
  EXPECT_EQ(paths[0].filename(), "texts.000009.jsonl");
  EXPECT_EQ(paths[1].filename(), "texts.000010.jsonl");
  EXPECT_EQ(paths[2].filename(), "texts.jsonl");
  EXPECT_EQ(log_files(folder.path()).next_number(), 11U);
}

}  // namespace gdos_texts_test

namespace gdos_texts_test {

std::string line(const std::string& text) { return to_line({.time = {}, .text = text}); }

TEST(GdosReader, HoweverAFileIsCutIntoPieces) {
  const std::string file = line("one") + "nonsense\n" + line("two");
  for (std::size_t size = 1; size <= file.size(); ++size) {
    RecordReader reader;
    std::vector<std::string> texts;
    for (std::size_t at = 0; at < file.size(); at += size)
      reader.read(std::string_view(file).substr(at, size),
                  [&](Record&& record) { texts.push_back(record.text); });
    EXPECT_EQ(texts, (std::vector<std::string>{"one", "two"})) << size << " bytes each";
    EXPECT_EQ(reader.strange(), 1U);
  }
}

TEST(GdosReader, ALineWithoutEndTakesNoMemory) {
  RecordReader reader;
  int texts = 0;
  const auto count = [&](const Record&) { ++texts; };
  for (int i = 0; i < 1000; ++i) reader.read(std::string(10000, '{'), count);
  reader.read("\n" + line("one") + line("two").substr(0, 20), count);
  EXPECT_EQ(texts, 1);
  EXPECT_EQ(reader.strange(), 1U);
}

}  // namespace gdos_texts_test

}  // namespace rack::gdos
