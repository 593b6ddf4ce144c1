#include "components/devices/scanners/scip.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace rack::device {
namespace scip_test {

std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

// Steps 44 to 725, three combined: 228 distances.
std::string scan_text(std::uint32_t counter, std::uint32_t distance) {
  std::string text = "MD0044072503000\n";
  append_scip_line(text, "99");
  std::string characters;
  append_scip_number(characters, counter, 4);
  append_scip_line(text, characters);
  characters.clear();
  for (std::uint32_t i = 0; i < 228; ++i) append_scip_number(characters, distance + i, 3);
  for (std::size_t at = 0; at < characters.size(); at += 64)
    append_scip_line(text, std::string_view(characters).substr(at, 64));
  return text + "\n";
}

// Number of scans decoded from the pieces of a stream.
int scans_in(std::initializer_list<std::string_view> pieces) {
  ScipAnswers answers;
  ScipScans scans;
  ScipAnswer answer;
  LadarData scan;
  std::uint32_t counter = 0;
  int found = 0;
  for (const std::string_view piece : pieces) {
    answers.add({.bytes = bytes(piece)});
    while (answers.next(answer)) found += scans.decode(answer, scan, counter) ? 1 : 0;
  }
  return found;
}

// The examples of the specification, section 6.
TEST(ScipTest, NumbersOfTheSpecification) {
  EXPECT_EQ(scip_number("CB"), 1234U);
  EXPECT_EQ(scip_number("1Dh"), 5432U);
  EXPECT_EQ(scip_number("m2@0"), 16'000'000U);
  std::string text;
  append_scip_number(text, 1234, 2);
  append_scip_number(text, 5432, 3);
  append_scip_number(text, 16'000'000, 4);
  EXPECT_EQ(text, "CB1Dhm2@0");
  EXPECT_FALSE(scip_number("C/"));
  EXPECT_FALSE(scip_number("p0"));
}

// Answers from the specification and from the wiki of the URG library.
TEST(ScipTest, SumsOfPublishedAnswers) {
  EXPECT_EQ(scip_sum("00"), 'P');
  EXPECT_EQ(scip_sum("99"), 'b');
  EXPECT_EQ(scip_sum("02"), 'R');
  EXPECT_EQ(scip_sum("DMIN:20"), '4');
  EXPECT_EQ(scip_sum("DMAX:5600"), '_');
  EXPECT_EQ(scip_sum("AMIN:44"), '7');
  EXPECT_EQ(scip_sum("AMAX:725"), 'o');
  EXPECT_EQ(scip_sum("AFRT:384"), '6');
  EXPECT_EQ(scip_sum("SCAN:600"), 'e');
  EXPECT_EQ(scip_sum("PROT:SCIP 2.0"), 'N');
  EXPECT_EQ(scip_sum("SERI:H0614967"), 'V');
}

TEST(ScipTest, TheIdentityOfAScanner) {
  const std::string text =
      "PP\n00P\nMODL:URG-04LX(Hokuyo Automatic Co.,Ltd.);N\nDMIN:20;4\nDMAX:5600;_\n"
      "ARES:1024;\\\nAMIN:44;7\nAMAX:725;o\nAFRT:384;6\nSCAN:600;e\n\n";
  ScipAnswers answers;
  answers.add({.bytes = bytes(text)});
  ScipAnswer answer;
  ASSERT_TRUE(answers.next(answer));
  EXPECT_EQ(answer.question, "PP");
  EXPECT_EQ(answer.status, "00");
  ScipParameters parameters{.range_max = 1, .last = 1};
  ASSERT_TRUE(parse_scip_parameters(answer, parameters));
  EXPECT_EQ(parameters.model, "URG-04LX(Hokuyo Automatic Co.,Ltd.)");
  EXPECT_EQ(parameters.range_max, 5600);
  EXPECT_EQ(parameters.last, 725);
  EXPECT_FALSE(answers.next(answer));

  // A line with a wrong checksum is missing, which makes the whole answer invalid.
  std::string broken = text;
  broken[broken.find("5600")] = '6';
  answers.add({.bytes = bytes(broken)});
  ASSERT_TRUE(answers.next(answer));
  EXPECT_FALSE(parse_scip_parameters(answer, parameters));
  EXPECT_EQ(parameters.range_max, 5600);
}

TEST(ScipTest, QuestionsThatMeasure) {
  EXPECT_EQ(scip_range("MD0044072501000"), (ScipRange{44, 725, 1, 3, false}));
  EXPECT_EQ(scip_range("ME0000108003099"), (ScipRange{0, 1080, 3, 3, true}));
  EXPECT_EQ(scip_range("GS0044072500"), (ScipRange{44, 725, 1, 2, false}));
  EXPECT_EQ(scip_range("G04472503"), (ScipRange{44, 725, 3, 2, false}));
  EXPECT_EQ(scip_range("G04472503")->values(), 228U);
  for (const std::string_view none :
       {"", "G", "MD", "MD00440725", "MD0725004401000", "VV", "G0447250x"})
    EXPECT_FALSE(scip_range(none)) << none;
}

TEST(ScipTest, AScanGoesClockwise) {
  ScipAnswers answers;
  ScipScans scans;
  const std::string text = scan_text(0xABCDEF, 1000);
  answers.add({.bytes = bytes(text)});
  ScipAnswer answer;
  ASSERT_TRUE(answers.next(answer));
  LadarData scan;
  std::uint32_t counter = 0;
  ASSERT_TRUE(scans.decode(answer, scan, counter));
  EXPECT_EQ(counter, 0xABCDEFU);
  ASSERT_EQ(scan.points.size(), 228U);
  EXPECT_EQ(scan.points[227].distance, 1000);  // the first value is on the right
  EXPECT_EQ(scan.points[0].distance, 1227);
  const double step = 2 * std::numbers::pi / 1024;
  EXPECT_NEAR(scan.endAngle, (384 - 45) * step, 1e-6);  // of 44, 45 and 46
  EXPECT_NEAR(scan.startAngle, (384 - 726) * step, 1e-6);
  EXPECT_NEAR(scan.points[0].angle, scan.startAngle, 1e-6);
  EXPECT_NEAR(scan.points[227].angle, scan.endAngle, 1e-6);
  EXPECT_EQ(scan.duration, 66U);
  EXPECT_EQ(scan.maxRange, 5600);
}

TEST(ScipTest, CodesAndWhatIsTooFarAreNoPoints) {
  ScipAnswers answers;
  ScipScans scans;
  scans.set_start_angle(120 * std::numbers::pi / 180);
  // Three steps in SCIP 1: no echo, 20 mm, 4095 mm.
  answers.add({.bytes = bytes("G04404601\n0\n030Doo\n\n")});
  ScipAnswer answer;
  ASSERT_TRUE(answers.next(answer));
  EXPECT_FALSE(answer.has_sums());
  LadarData scan;
  std::uint32_t counter = 0;
  ASSERT_TRUE(scans.decode(answer, scan, counter));
  ASSERT_EQ(scan.points.size(), 3U);
  EXPECT_EQ(scan.points[2].type, ladar_point::kInvalid);
  EXPECT_EQ(scan.points[2].distance, 0);
  EXPECT_NEAR(scan.points[2].angle, 120 * std::numbers::pi / 180, 1e-6);
  EXPECT_EQ(scan.points[1].type, ladar_point::kUnknown);
  EXPECT_EQ(scan.points[1].distance, 20);
  EXPECT_EQ(scan.points[0].distance, 4095);

  ScipParameters near;
  near.range_max = 4000;
  scans.set_parameters(near);
  ASSERT_TRUE(scans.decode(answer, scan, counter));
  EXPECT_EQ(scan.points[0].type, ladar_point::kInvalid);
}

TEST(ScipTest, IntensitiesStandBehindDistances) {
  std::string text = "ME0384038501000\n";
  append_scip_line(text, "99");
  append_scip_line(text, "0001");
  std::string characters;
  for (const std::uint32_t number : {1500U, 12000U, 1501U, 345U})
    append_scip_number(characters, number, 3);
  append_scip_line(text, characters);
  text += "\n";
  ScipAnswers answers;
  ScipScans scans;
  answers.add({.bytes = bytes(text)});
  ScipAnswer answer;
  ASSERT_TRUE(answers.next(answer));
  LadarData scan;
  std::uint32_t counter = 0;
  ASSERT_TRUE(scans.decode(answer, scan, counter));
  ASSERT_EQ(scan.points.size(), 2U);
  EXPECT_EQ(scan.points[1].distance, 1500);
  EXPECT_EQ(scan.points[1].intensity, 12000);
  EXPECT_EQ(scan.points[0].distance, 1501);
  EXPECT_EQ(scan.points[0].intensity, 345);
}

TEST(ScipTest, EverySplitGivesTheSameScans) {
  const std::string stream =
      scan_text(1, 500) + scan_text(2, 600) + "QT\n00P\n\n" + scan_text(3, 700);
  for (std::size_t cut = 0; cut <= stream.size(); ++cut) {
    const std::string_view all = stream;
    EXPECT_EQ(scans_in({all.substr(0, cut), all.substr(cut)}), 3) << cut;
  }
}

TEST(ScipTest, AReaderThatJoinsLateGetsTheNextScan) {
  const std::string stream = scan_text(1, 500) + scan_text(2, 600);
  for (std::size_t cut = 1; cut < stream.size() / 2; ++cut)
    EXPECT_EQ(scans_in({std::string_view(stream).substr(cut)}), 1) << cut;
}

// The request in an answer has no checksum; it is compared with the request sent.
TEST(ScipTest, AFlippedBitCostsTwoScansAtMost) {
  const std::string one = scan_text(1, 500);
  for (std::size_t i = one.find('\n') * 8; i < one.size() * 8; ++i) {
    std::string broken = one;
    broken[i / 8] = static_cast<char>(broken[i / 8] ^ 1 << i % 8);
    const int found = scans_in({one, broken, one, one});
    EXPECT_GE(found, 2) << i;
    EXPECT_LE(found, 3) << i;
  }
}

TEST(ScipTest, NoiseIsNoScan) {
  std::mt19937 random(3);
  ScipAnswers answers;
  ScipScans scans;
  ScipAnswer answer;
  LadarData scan;
  std::uint32_t counter = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string noise(random() % 300, ' ');
    for (char& c : noise) c = random() % 9 == 0 ? '\n' : static_cast<char>(random() % 256);
    answers.add({.bytes = bytes(noise)});
    while (answers.next(answer)) EXPECT_FALSE(scans.decode(answer, scan, counter));
  }
  // An endless line must not exhaust the memory.
  const std::string endless(100'000, 'x');
  for (int i = 0; i < 10; ++i) answers.add({.bytes = bytes(endless)});
  answers.add({.bytes = bytes("\n\n" + scan_text(9, 100))});
  int found = 0;
  while (answers.next(answer)) found += scans.decode(answer, scan, counter) ? 1 : 0;
  EXPECT_EQ(found, 1);
}

}  // namespace scip_test
}  // namespace rack::device
