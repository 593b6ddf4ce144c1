#include "components/pictures/plain_text.h"

#include <gtest/gtest.h>

namespace rack::pictures {
namespace plain_text_test {

TEST(PlainText, OfAsciiIsTheSame) {
  std::string all;
  for (char c = ' '; c <= '~'; ++c) all += c;
  EXPECT_EQ(plain_text(all), all);
  EXPECT_EQ(plain_text(""), "");
}

TEST(PlainText, LettersAndSignsAreReadable) {
  EXPECT_EQ(plain_text("Straße, Übersicht, Ørsted"), "Strasse, Uebersicht, Oersted");
  EXPECT_EQ(plain_text("Škoda, Łódź, São Paulo, Çeşme, naïve"),
            "Skoda, Lodz, Sao Paulo, Cesme, naive");
  EXPECT_EQ(plain_text("90° ± 5 µm² → “x” – …"), "90deg +- 5 um^2 -> \"x\" - ...");
}

TEST(PlainText, OthersAreOneQuestionMarkEach) {
  EXPECT_EQ(plain_text("ロボット 1 🤖"), "???? 1 ?");
  EXPECT_EQ(plain_text("a\x1b[31m\n\x7f"), "a?[31m??");
  EXPECT_EQ(plain_text("\xC2\x85"), "?") << "a control character of ISO 8859";
  EXPECT_EQ(plain_text("K\xE4se \xE2\x82 \xFF\xC0\x80"), "K?se ?? ???") << "not UTF-8";
  EXPECT_EQ(plain_text(std::string_view("a\0b", 3)), "a?b");
}

TEST(PlainText, ItsLengthIsLimited) {
  EXPECT_EQ(plain_text(std::string(kPlainTextMax, 'a')), std::string(kPlainTextMax, 'a'));
  for (const std::size_t more : {1U, 2U, 1'000'000U})
    EXPECT_EQ(plain_text(std::string(kPlainTextMax + more, 'a')),
              std::string(kPlainTextMax - 3, 'a') + "...");
  std::string dots;
  for (int i = 0; i < 1000; ++i) dots += "…";
  EXPECT_EQ(plain_text(dots).size(), kPlainTextMax);
}

}  // namespace plain_text_test
}  // namespace rack::pictures
