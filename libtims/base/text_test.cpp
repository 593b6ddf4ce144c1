#include "base/text.h"

#include <array>

#include <gtest/gtest.h>

namespace tims::base {
namespace text_test {

using namespace std::string_literals;

TEST(Utf8, CharactersHaveOneForm) {
  for (const auto& [text, code] : {std::pair{"a"s, 0x61U},
                                   {"\x7F"s, 0x7FU},
                                   {"ä"s, 0xE4U},
                                   {"€"s, 0x20ACU},
                                   {"\U0001F916"s, 0x1F916U}}) {
    EXPECT_EQ(first_character(text + "x").code, code);
    EXPECT_EQ(first_character(text + "x").bytes, text.size());
    std::string back;
    append_utf8(code, back);
    EXPECT_EQ(back, text);
  }
}

TEST(Utf8, WhatIsNoCharacter) {
  for (const auto& text :
       {"\x80"s, "\xC0\x80"s, "\xE0\x80\x80"s, "\xED\xA0\x80"s, "\xF4\x90\x80\x80"s,
        "\xF5\x80\x80\x80"s, "\xC3"s, "\xE2\x82"s, "\xC3x"s, "\xFF"s})
    EXPECT_EQ(first_character(text).bytes, 0U);
}

TEST(Utf8, BrokenBytesBecomeQuestionMarks) {
  EXPECT_EQ(valid_utf8("K\xE4"
                       "fer Käfer"),
            "K?fer Käfer");
  EXPECT_EQ(valid_utf8("\xE2\x82"), "??");
  EXPECT_EQ(valid_utf8("a\nb"), "a\nb");
}

TEST(Printable, NothingThatATerminalObeysIsLeft) {
  EXPECT_EQ(printable("a\x1b[31mb\n\x7F"), "a?[31mb??");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "?31m");
  EXPECT_EQ(printable("Käfer €"), "Käfer €");
  EXPECT_EQ(printable_lines("a\n\tb\n"), "a\n?b\n");
}

TEST(Printable, WidthIsThatOfCharacters) {
  EXPECT_EQ(display_width("Käfer"), 5U);
  EXPECT_EQ(display_width(""), 0U);
}

TEST(Text, LowerCase) { EXPECT_EQ(lower("LADAR-3 Ä"), "ladar-3 Ä"); }

TEST(Text, InQuotes) {
  EXPECT_EQ(in_quotes(R"(a "b" \c)"), R"("a \"b\" \\c")");
  EXPECT_EQ(in_quotes("a\nb\x7f"), R"("a\u000Ab\u007F")");
  EXPECT_EQ(in_quotes("Süd"), "\"Süd\"");
}

TEST(Text, NumbersAreAllOfTheText) {
  EXPECT_EQ(parse_number<int>("-12"), -12);
  EXPECT_EQ(parse_number<unsigned>("ff", 16), 255U);
  for (const char* bad : {"", " 1", "1 ", "1x", "+1", "99999999999"})
    EXPECT_FALSE(parse_number<int>(bad)) << bad;
  EXPECT_FALSE(parse_number<unsigned>("-1"));
}

TEST(Text, HexIsWrittenAndRead) {
  const auto bytes = parse_hex("01 0xff:AB\n00");
  ASSERT_TRUE(bytes);
  EXPECT_EQ(to_hex(*bytes), "01ffab00");
  EXPECT_TRUE(parse_hex("")->empty());
  for (const char* bad : {"0", "0g", "0x", "1 2", "012", "-1"}) EXPECT_FALSE(parse_hex(bad)) << bad;
}

TEST(Text, SplitsWordsLikeAShell) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(trimmed(" \ta b\r"), "a b");
  EXPECT_EQ(trimmed("a"), "a");
  EXPECT_EQ(trimmed(" \t"), "");
  EXPECT_EQ(trimmed(""), "");
  EXPECT_EQ(trimmed("\" a\"", " \""), "a");
  EXPECT_EQ(split_words("tims-demo ladar  --at 'Ladar(1/0)'\n"),
            (Words{"tims-demo", "ladar", "--at", "Ladar(1/0)"}));
  EXPECT_EQ(split_words(R"(a"b c"d '' )"), (Words{"ab cd", ""}));
  EXPECT_EQ(split_words(" "), Words());
  EXPECT_FALSE(split_words("a 'b"));
}

const Placeholders kValues = {{"robot", "robot1"}, {"host", "robot1-arm"}, {"system", "1"}};
const std::array<std::string, 2> kPlaceholders = {"host", "system"};

TEST(Placeholders, AreFilledIn) {
  EXPECT_EQ(filled_in("{robot}/{host}:{system}.", kValues), "robot1/robot1-arm:1.");
  EXPECT_EQ(filled_in("{system}{system}", kValues), "11");
  EXPECT_EQ(filled_in("a{x}b", kValues), "ab") << "not known";
  EXPECT_EQ(filled_in("", kValues), "");
}

TEST(Placeholders, OfOthersAreFound) {
  EXPECT_EQ(unknown_placeholder("{host} {x} {y}", kPlaceholders), "x");
  EXPECT_EQ(unknown_placeholder("{}", kPlaceholders), "");
  EXPECT_EQ(unknown_placeholder("{host} and {system}", kPlaceholders), std::nullopt);
}

TEST(Placeholders, ABraceAloneIsItself) {
  for (const char* text : {"{", "}", "}{", "{system"}) {
    EXPECT_EQ(unknown_placeholder(text, kPlaceholders), std::nullopt) << text;
    EXPECT_EQ(filled_in(text, kValues), text);
  }
}

TEST(Nearest, CountsEdits) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("listen", "listen"), 0U);
  EXPECT_EQ(edit_distance("listn", "listen"), 1U);
  EXPECT_EQ(edit_distance("listeen", "listen"), 1U);
  EXPECT_EQ(edit_distance("liszen", "listen"), 1U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("abc", ""), 3U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Nearest, ASwapOfNeighboursIsOneEdit) {
  EXPECT_EQ(edit_distance("litsen", "listen"), 1U);
  EXPECT_EQ(edit_distance("tpc", "tcp"), 1U);
}

TEST(Nearest, GivesTheBestOfWhatIsNear) {
  constexpr std::array<std::string_view, 4> kKnown{"tcp.listen", "http.listen", "tcp.queue", "log"};
  EXPECT_EQ(nearest("tcp.lisen", kKnown), "tcp.listen");
  EXPECT_EQ(nearest("htp.listen", kKnown), "http.listen");
  EXPECT_EQ(nearest("tcp.qeue", kKnown), "tcp.queue");
  EXPECT_EQ(nearest("lgo", kKnown), "log");
  EXPECT_EQ(nearest("lgo", std::vector<std::string>{"tcp", "log"}), "log");
}

TEST(Nearest, GivesNothingWhenNothingIsNear) {
  constexpr std::array<std::string_view, 2> kKnown{"tcp.listen", "log"};
  EXPECT_EQ(nearest("flux.capacitor", kKnown), std::nullopt);
  EXPECT_EQ(nearest("x", kKnown), std::nullopt);
  EXPECT_EQ(nearest("", kKnown), std::nullopt);
  EXPECT_EQ(nearest("tcp.listen", std::span<const std::string_view>()), std::nullopt);
}

}  // namespace text_test
}  // namespace tims::base
