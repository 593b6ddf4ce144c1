#include "components/devices/positioning/nmea.h"

#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/core/pieces.h"
#include "components/devices/core/test_bytes.h"
#include "components/devices/positioning/nmea_receiver.h"

namespace rack::device {
namespace nmea_test {

using namespace std::chrono_literals;

constexpr double kDegree = std::numbers::pi / 180;

std::string line(std::string_view text) {
  std::vector<std::byte> bytes;
  append_nmea(bytes, text);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// --- sentences

TEST(NmeaTest, ASentenceIsItsFieldsFromOneOn) {
  NmeaSentence sentence;
  ASSERT_TRUE(parse_nmea("$GPGLL,5310.8115,N,00525.7025,E,195719,A,A*4D", sentence));
  EXPECT_EQ(sentence.talker, "GP");
  EXPECT_EQ(sentence.type, "GLL");
  EXPECT_EQ(sentence[1], "5310.8115");
  EXPECT_EQ(sentence[7], "A");
  EXPECT_EQ(sentence[8], "");
  EXPECT_EQ(sentence.count, 7U);
}

TEST(NmeaTest, EveryTalkerAndManufacturersOnes) {
  NmeaSentence sentence;
  for (const std::string_view talker : {"GP", "GN", "GL", "GA", "GB", "BD", "QZ", "II"}) {
    const std::string text = line(std::string(talker) + "RMC,1");
    ASSERT_TRUE(parse_nmea(std::string_view(text).substr(0, text.size() - 2), sentence));
    EXPECT_EQ(nmea_kind(sentence), NmeaKind::kRmc);
  }
  ASSERT_TRUE(parse_nmea("$PGRMM,WGS 84*06", sentence));
  EXPECT_EQ(sentence.talker, "P");
  EXPECT_EQ(sentence.type, "GRMM");
  EXPECT_EQ(nmea_kind(sentence), NmeaKind::kOther);
}

TEST(NmeaTest, WhatIsNoSentenceIsNone) {
  NmeaSentence sentence;
  for (const std::string_view text :
       {"", "$", "$*00", "GPGLL,1*00", "$GPGLL,5310.8115,N,00525.7025,E,195719,A,A",
        "$GPGLL,5310.8115,N,00525.7025,E,195719,A,A*4",
        "$GPGLL,5310.8115,N,00525.7025,E,195719,A,A*4E",
        "$SDVLW,$SDVLW,,N,322.0,N,$SDVLW,$SDVLW,,N,322.0,N,2328.9,N,$SDVLW,$SDVLW,,N,322.0,N,"
        "$SDVLW,$SDVLW,,N,322.0,N,2328.9,N,2315.4,N*59"})
    EXPECT_FALSE(parse_nmea(text, sentence)) << text;
}

TEST(NmeaTest, AFlippedBitIsSeen) {
  const std::string text = line("GPGLL,5310.8115,N,00525.7025,E,195719,A,A");
  const std::string whole = text.substr(0, text.size() - 2);
  NmeaSentence sentence;
  for (std::size_t i = 0; i < whole.size() * 8; ++i) {
    std::string broken = whole;
    broken[i / 8] = static_cast<char>(broken[i / 8] ^ (1 << i % 8));
    // The case of the checksum digits does not matter.
    const bool is_case = i / 8 >= whole.size() - 2 && i % 8 == 5;
    EXPECT_TRUE(is_case || !parse_nmea(broken, sentence)) << broken;
  }
}

TEST(NmeaTest, Fields) {
  EXPECT_NEAR(*nmea_angle("4134.49795459", "N"), (41 + 34.49795459 / 60) * kDegree, 1e-12);
  EXPECT_NEAR(*nmea_angle("00525.7025", "W"), -(5 + 25.7025 / 60) * kDegree, 1e-12);
  for (const auto& [field, side] : {std::pair{"", "N"},
                                    {"4134.5", ""},
                                    {"4160.0", "N"},
                                    {"9000.1", "S"},
                                    {"18000.1", "E"},
                                    {"-100", "N"},
                                    {"x", "N"},
                                    {"nan", "N"},
                                    {"4134.5", "X"}})
    EXPECT_FALSE(nmea_angle(field, side)) << field;
  EXPECT_EQ(*nmea_time_of_day("195719"), 19h + 57min + 19s);
  EXPECT_EQ(*nmea_time_of_day("132819.6"), 13h + 28min + 19s + 600ms);
  EXPECT_EQ(*nmea_time_of_day("235960.00"), 24h);
  for (const std::string_view time :
       {"", "19571", "240000", "236000", "235961", "1a5719", "195719,"})
    EXPECT_FALSE(nmea_time_of_day(time)) << time;
  EXPECT_EQ(*nmea_date("010170"), *days_since_1970(2070, 1, 1));
  EXPECT_EQ(*nmea_date("060180"), *days_since_1970(1980, 1, 6));
  EXPECT_EQ(*nmea_date("290224"), 19782);
  for (const std::string_view date : {"", "290223", "311123 ", "321201", "01131x"})
    EXPECT_FALSE(nmea_date(date)) << date;
}

// --- lines

TEST(NmeaTest, EverySplitGivesTheSameSentences) {
  const std::string text = "noise\r\n" + line("GPRMC,1") + "$GPGSA,A,1,,*1E" + line("GPGGA,2") +
                           "$GPRMC,19*00\r\n" + line("GNGLL,3") + "\n\n";
  const auto bytes = bytes_of_text(text);
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    NmeaLines lines;
    std::string found;
    for (const auto piece : {std::span(bytes).first(cut), std::span(bytes).subspan(cut)}) {
      lines.add({.bytes = piece});
      NmeaSentence sentence;
      while (lines.next(sentence)) found += sentence[1];
    }
    EXPECT_EQ(found, "123") << cut;
    EXPECT_EQ(lines.sentences(), 3U);
    EXPECT_EQ(lines.recovered(), 1U);
    EXPECT_EQ(lines.broken(), 2U);
  }
}

TEST(NmeaTest, ASentenceBeganWhenItsFirstByteDid) {
  NmeaLines lines;
  const auto bytes = bytes_of_text("xxxx\n" + line("GPRMC,1"));
  lines.add({.bytes = bytes, .first = Time(1s), .last = Time(1s) + bytes.size() * 1ms});
  NmeaSentence sentence;
  ASSERT_TRUE(lines.next(sentence));
  EXPECT_EQ(sentence.began, Time(1s) + 5ms);
}

TEST(NmeaTest, ALineWithoutEndIsForgotten) {
  NmeaLines lines;
  NmeaSentence sentence;
  const std::vector<std::byte> zeros(5000);
  in_pieces({.bytes = zeros}, NmeaLines::kPieceMax, [&](const Arrival& piece) {
    lines.add(piece);
    EXPECT_FALSE(lines.next(sentence));
  });
  const auto bytes = bytes_of_text(line("GPRMC,1") + line("GPRMC,2"));
  lines.add({.bytes = bytes});
  ASSERT_TRUE(lines.next(sentence));
  EXPECT_EQ(sentence[1], "1");
}

TEST(NmeaTest, LinesMayEndInOtherWays) {
  for (const char* end : {"\r\n", "\n", "\r", "\n\r", "\r\r\n"}) {
    std::string all;
    for (int i = 1; i <= 3; ++i) {
      std::string one = line("GPRMC," + std::to_string(i));
      one.resize(one.size() - 2);
      all += one + end;
    }
    all += "$";
    for (const std::size_t piece : {std::size_t{1}, all.size()}) {
      NmeaLines lines;
      NmeaSentence sentence;
      int found = 0;
      const auto bytes = bytes_of_text(all);
      for (std::size_t at = 0; at < bytes.size(); at += piece) {
        lines.add({.bytes = std::span(bytes).subspan(at, std::min(piece, bytes.size() - at))});
        while (lines.next(sentence)) EXPECT_EQ(sentence[1], std::to_string(++found));
      }
      EXPECT_EQ(found, 3) << piece;
      EXPECT_EQ(lines.broken() + lines.recovered(), 0U) << piece;
    }
  }
}

TEST(NmeaTest, AChecksumMayHaveOneDigit) {
  // The XOR of all characters is below 16.
  NmeaSentence sentence;
  int found = 0;
  for (const char c : {' ', '"', '#'}) {
    std::string text = line(std::string("GPRMC,A") + c);
    text.resize(text.size() - 2);
    if (text[text.size() - 2] != '0') continue;
    ++found;
    text.erase(text.size() - 2, 1);
    EXPECT_TRUE(parse_nmea(text, sentence)) << text;
    text.back() = text.back() == '1' ? '2' : '1';
    EXPECT_FALSE(parse_nmea(text, sentence)) << text;
  }
  EXPECT_EQ(found, 3);
}

// --- a receiver

class NmeaReceiverTest : public testing::Test {
 protected:
  void receive(NmeaReceiver& receiver, std::string_view text) {
    const auto bytes = bytes_of_text(line(text));
    receiver.on_arrival({.bytes = bytes, .first = now_, .last = now_}, out_);
    now_ += 20ms;
  }
  std::optional<GpsData> taken(NmeaReceiver& receiver) {
    GpsData data;
    if (!receiver.take(data, recorded_)) return std::nullopt;
    return data;
  }

  ReceivedOutput out_;
  Time now_{1000s};
  Time recorded_{};
};

TEST_F(NmeaReceiverTest, RmcIsCompletedByTheOtherSentences) {
  NmeaReceiver receiver({});
  receiver.start(now_, out_);
  const Time began = now_;
  receive(receiver,
          "GNGGA,132820.00,4134.49802199,N,09345.03419022,W,4,10,0.9,278.254,M,-31.4,M,7,1");
  receive(receiver, "GNGSA,A,3,03,22,,,,,,,,,,,1.8,0.9,1.5");
  EXPECT_FALSE(taken(receiver));
  receive(receiver,
          "GNRMC,132820.00,A,4134.49802199,N,09345.03419022,W,1.944,127.194,180320,11.6,E,D");
  const auto data = taken(receiver);
  ASSERT_TRUE(data);
  EXPECT_FALSE(taken(receiver));
  EXPECT_EQ(recorded_, began);
  EXPECT_EQ(data->mode, gps_mode::k3d + gps_mode::kDifferential);
  EXPECT_NEAR(data->latitude, (41 + 34.49802199 / 60) * kDegree, 1e-12);
  EXPECT_NEAR(data->longitude, -(93 + 45.03419022 / 60) * kDegree, 1e-12);
  EXPECT_EQ(data->altitude, 278254);
  EXPECT_EQ(data->speed, 1000);
  EXPECT_NEAR(data->heading, 127.194 * kDegree, 1e-6);
  EXPECT_EQ(data->satelliteNum, 10);
  EXPECT_FLOAT_EQ(data->pdop, 1.8F);
  EXPECT_EQ(data->utcTime, 1584538100);
  EXPECT_EQ(data->var.x, 20000);  // 6 of 8 steps from 50 m to 10 m
  EXPECT_EQ(data->var.z, 40000);
}

TEST_F(NmeaReceiverTest, ADataSetCanBeginAndEndWithDifferentSentences) {
  NmeaReceiver receiver({.start = NmeaKind::kRmc, .end = NmeaKind::kVtg});
  receiver.start(now_, out_);
  receive(receiver, "GPVTG,90.0,T,,M,1.0,N,1.9,K,A");
  EXPECT_FALSE(taken(receiver));
  const Time began = now_;
  receive(receiver, "GPRMC,120000,A,5200.0,N,00900.0,E,0.0,,010120,,,A");
  receive(receiver, "GPGGA,120000,5200.0,N,00900.0,E,1,12,0.9,50.0,M,45,M,,");
  EXPECT_FALSE(taken(receiver));
  receive(receiver, "GPVTG,45.0,T,,M,10.0,N,18.5,K,A");
  const auto data = taken(receiver);
  ASSERT_TRUE(data);
  EXPECT_EQ(recorded_, began);
  EXPECT_EQ(data->mode, gps_mode::k3d);
  EXPECT_EQ(data->speed, 5144);
  EXPECT_EQ(data->var.x, 10000);
}

TEST_F(NmeaReceiverTest, WithoutTheSentenceThatWasAskedForAnotherTakesItsPlace) {
  NmeaReceiver receiver({});
  receiver.start(now_, out_);
  int found = 0;
  for (int i = 0; i < 10; ++i) {
    receive(receiver,
            "GPGGA,12000" + std::to_string(i) + ",5200.0,N,00900.0,E,1,08,0.9,50.0,M,45,M,,");
    found += taken(receiver) ? 1 : 0;
  }
  EXPECT_EQ(found, 7);
  receive(receiver, "GPRMC,120010,A,5200.0,N,00900.0,E,0.0,,010120,,,A");
  EXPECT_TRUE(taken(receiver));
  receive(receiver, "GPGGA,120011,5200.0,N,00900.0,E,1,08,0.9,50.0,M,45,M,,");
  EXPECT_FALSE(taken(receiver));
}

TEST_F(NmeaReceiverTest, AFixIsLostAndFoundAgain) {
  NmeaReceiver receiver({});
  receiver.start(now_, out_);
  const auto round = [&](int second, bool fixed) {
    const std::string time = "1200" + std::to_string(10 + second) + ".00";
    const std::string place = fixed ? "5200.0,N,00900.0,E," : ",,,,";
    receive(receiver, "GPRMC," + time + (fixed ? ",A," : ",V,") + place + "0.0,,010120,,,A");
    const auto data = taken(receiver);
    receive(receiver,
            "GPGGA," + time + "," + place + (fixed ? "5,08" : "0,00") + ",0.9,50.0,M,45,M,,");
    return data ? data->mode : -1;
  };
  constexpr i32 kRtk = gps_mode::k3d + gps_mode::kDifferential;
  EXPECT_EQ(round(1, false), gps_mode::kInvalid);
  EXPECT_EQ(round(2, true), gps_mode::k2d);  // no GGA received yet
  EXPECT_EQ(round(3, true), kRtk);
  EXPECT_EQ(round(4, false), gps_mode::kInvalid);
  EXPECT_EQ(round(5, true), gps_mode::k2d);  // bits are not kept
}

// nmea-valid-without-place.nmea: the status stays valid, but the fields of the place are empty.
TEST_F(NmeaReceiverTest, APlaceThatIsNotSentAnyMoreIsLost) {
  NmeaReceiver receiver({});
  receiver.start(now_, out_);
  const auto round = [&](int second, bool placed) {
    const std::string time = "1200" + std::to_string(10 + second) + ".00";
    const std::string place = placed ? "5200.0,N,00900.0,E," : ",,,,";
    receive(receiver, "GPRMC," + time + ",A," + place + "1.5,90.0,010120,,,A");
    const auto data = taken(receiver);
    receive(receiver, "GPGGA," + time + "," + place + "1,08,0.9,50.0,M,45,M,,");
    return *data;
  };
  (void)round(1, true);
  EXPECT_EQ(round(2, true).mode, gps_mode::k3d);
  for (int second = 3; second < 20; ++second) {
    const GpsData lost = round(second, false);
    EXPECT_EQ(lost.mode, gps_mode::kInvalid) << second;
    EXPECT_EQ(lost.latitude, 0) << second;
  }
  EXPECT_EQ(round(20, true).mode, gps_mode::k3d);
}

TEST_F(NmeaReceiverTest, OneSentenceOfARoundMayHaveThePlace) {
  NmeaReceiver receiver({});
  receiver.start(now_, out_);
  for (int second = 10; second < 20; ++second) {
    const std::string time = "1200" + std::to_string(second);
    receive(receiver, "GPGGA," + time + ",5200.0,N,00900.0,E,1,08,0.9,50.0,M,45,M,,");
    receive(receiver, "GPRMC," + time + ",A,,,,,1.5,90.0,010120,,,A");
    EXPECT_EQ(taken(receiver)->mode, gps_mode::k3d);
  }
}

TEST_F(NmeaReceiverTest, AReceiverThatRepeatsOneMeasurementHasNoFix) {
  NmeaReceiver receiver({});
  receiver.start(now_, out_);
  const auto repeat = [&] {
    now_ += 980ms;
    receive(receiver, "GPRMC,120000,A,5200.0,N,00900.0,E,1.5,90.0,010120,,,A");
    return taken(receiver)->mode;
  };
  for (int i = 0; i < 6; ++i) EXPECT_EQ(repeat(), gps_mode::k2d) << i;  // 5 s
  for (int i = 0; i < 6; ++i) EXPECT_EQ(repeat(), gps_mode::kInvalid) << i;
}

TEST_F(NmeaReceiverTest, HeightCourseAndDateHaveAnAge) {
  NmeaReceiver receiver({});
  receiver.start(now_, out_);
  receive(receiver, "GPGGA,120000,5200.0,N,00900.0,E,1,08,0.9,50.0,M,45,M,,");
  const auto next = [&](int second, const char* motion, const char* date = "010120") {
    const std::string time = std::to_string(120000 + second);
    receive(receiver, "GPRMC," + time + ",A,5200.0,N,00900.0,E," + motion + "," + date + ",,,A");
    return *taken(receiver);
  };
  EXPECT_EQ(next(0, "1.5,90.0").altitude, 50000);
  EXPECT_FLOAT_EQ(next(1, "0.0,").var.rho, 0.349F);
  for (int second = 2; second <= 10; ++second) (void)next(second, "0.0,");
  const GpsData later = next(11, "0.0,");
  EXPECT_EQ(later.altitude, 0);
  EXPECT_NEAR(later.heading, 90 * kDegree, 1e-6) << "the last known one";
  EXPECT_FLOAT_EQ(later.var.rho, std::numbers::pi_v<float>) << "the robot may have turned";
  EXPECT_NE(next(12, "0.0,", "").utcTime, 0);
  now_ += 13h;
  EXPECT_EQ(next(13, "0.0,", "").utcTime, 0) << "the date may be another one";
}

// nmea-cold-date.nmea
TEST_F(NmeaReceiverTest, TheDateOfAReceiverWithoutAFixIsNotThatOfAFix) {
  NmeaReceiver receiver({.start = NmeaKind::kGga, .end = NmeaKind::kGga});
  receiver.start(now_, out_);
  receive(receiver, "GPRMC,120000,V,,,,,,,060180,,,N");
  receive(receiver, "GPGGA,120001,5200.0,N,00900.0,E,1,08,0.9,50.0,M,45,M,,");
  (void)taken(receiver);
  receive(receiver, "GPGGA,120002,5200.0,N,00900.0,E,1,08,0.9,50.0,M,45,M,,");
  EXPECT_EQ(taken(receiver)->utcTime, 0);
  receive(receiver, "GPRMC,120003,A,5200.0,N,00900.0,E,1.5,90.0,010120,,,A");
  receive(receiver, "GPGGA,120003,5200.0,N,00900.0,E,1,08,0.9,50.0,M,45,M,,");
  EXPECT_EQ(taken(receiver)->utcTime, 1577880003);
}

TEST_F(NmeaReceiverTest, QualitiesOfRmcAndGns) {
  for (const auto& [mode, expected] : {std::pair{"A", gps_mode::k2d},
                                       {"D", gps_mode::k2d + gps_mode::kDifferential},
                                       {"R", gps_mode::k2d + gps_mode::kDifferential},
                                       {"E", gps_mode::k2d + gps_mode::kEstimated},
                                       {"N", gps_mode::kInvalid},
                                       {"", gps_mode::k2d}}) {
    NmeaReceiver receiver({});
    receiver.start(now_, out_);
    receive(receiver, std::string("GNRMC,120000,A,5200.0,N,00900.0,E,0,,010120,,,") + mode);
    EXPECT_EQ(taken(receiver)->mode, expected) << mode;
  }
  NmeaReceiver receiver({.start = NmeaKind::kGns, .end = NmeaKind::kGns});
  receiver.start(now_, out_);
  receive(receiver, "GNGNS,120000,5200.0,N,00900.0,E,NAF,12,0.8,50.0,45.0,,");
  EXPECT_EQ(taken(receiver)->mode, gps_mode::k3d + gps_mode::kDifferential);
}

TEST_F(NmeaReceiverTest, MidnightLeapSecondsAndMissingDates) {
  NmeaReceiver receiver({.start = NmeaKind::kGga, .end = NmeaKind::kGga});
  receiver.start(now_, out_);
  const auto utc_at = [&](std::string_view time) {
    receive(receiver, "GPGGA," + std::string(time) + ",5200.0,N,00900.0,E,1,08,0.9,50.0,M,45,M,,");
    return taken(receiver)->utcTime.raw();
  };
  EXPECT_EQ(utc_at("235958"), 0);  // date unknown
  receive(receiver, "GPZDA,235959,31,12,2016,00,00");
  constexpr i64 kNewYear = 1483228800;
  EXPECT_EQ(utc_at("235959.50"), kNewYear - 1);
  EXPECT_EQ(receiver.moment().fraction(), 500ms);
  EXPECT_EQ(utc_at("235960"), kNewYear);
  EXPECT_TRUE(receiver.moment().is_leap_second);
  EXPECT_EQ(utc_at("000000"), kNewYear);
  EXPECT_FALSE(receiver.moment().is_leap_second);
  receive(receiver, "GPZDA,000001,01,01,17,00,00");
  EXPECT_EQ(utc_at("000001"), kNewYear + 1);
  EXPECT_EQ(utc_at("235959"), kNewYear - 1);  // late
}

TEST_F(NmeaReceiverTest, HeadingOfTwoAntennasAndReportedDeviations) {
  NmeaReceiver receiver({});
  receiver.start(now_, out_);
  receive(receiver, "GPHDT,270.0,T");
  receive(receiver, "GNGST,120000,1.0,0.5,0.3,45,0.4,0.6,1.2");
  receive(receiver, "GNRMC,120000,A,5200.0,N,00900.0,E,3.0,90.0,010120,,,A");
  auto data = taken(receiver);
  EXPECT_NEAR(data->heading, 270 * kDegree, 1e-6);
  EXPECT_EQ(data->var.x, 400);
  EXPECT_EQ(data->var.y, 600);
  EXPECT_EQ(data->var.z, 1200);
  receive(receiver, "GNRMC,120001,A,5200.0,N,00900.0,E,3.0,90.0,010120,,,A");
  (void)taken(receiver);
  receive(receiver, "GNRMC,120002,A,5200.0,N,00900.0,E,3.0,,010120,,,A");
  data = taken(receiver);
  EXPECT_NEAR(data->heading, 90 * kDegree, 1e-6);  // no HDT any more; the last course
  EXPECT_EQ(data->var.x, 50000);
}

TEST_F(NmeaReceiverTest, ErrorsAreReported) {
  const auto failure_after = [&](std::string_view text) {
    NmeaReceiver receiver({});
    receiver.start(now_, out_);
    const auto bytes = bytes_of_text(text);
    receiver.on_arrival({.bytes = bytes, .first = now_, .last = now_}, out_);
    receiver.on_timeout(now_ + 10s, out_);
    return receiver.failure() ? receiver.failure()->detail() : "";
  };
  EXPECT_THAT(failure_after(""), testing::HasSubstr("sends nothing"));
  EXPECT_THAT(failure_after("\x80\x78\x80"), testing::HasSubstr("not NMEA at 4800 baud"));
  const std::string bare = "$GPRMC,120000,A,5200.0,N,00900.0,E,1.50,90.0,251126,,,A\r\n";
  EXPECT_THAT(failure_after(bare), testing::HasSubstr("without checksums"));
  EXPECT_THAT(failure_after("$GPRMC,120000,A*00\r\n"), testing::HasSubstr("wrong checksums"));
  const std::string ubx("\xB5\x62\x01\x07\x5C\x00 \xB5\x62\x01\x07\x5C\x00", 13);
  EXPECT_THAT(failure_after(ubx), testing::HasSubstr("use GpsUblox"));
  const std::string sirf("\xA0\xA2\x00\x01\x29\x00\x29\xB0\xB3", 9);
  EXPECT_THAT(failure_after(sirf + sirf), testing::HasSubstr("SiRF binary"));
  EXPECT_THAT(failure_after(sirf), testing::HasSubstr("not NMEA")) << "once may be chance";
  EXPECT_THAT(failure_after(line("GPGSV,1,1,00")), testing::HasSubstr("no position"));
  EXPECT_EQ(failure_after(line("GPRMC,,V,,,,,,,,,,N")), "");
}

TEST_F(NmeaReceiverTest, NoiseAndBrokenSentencesBreakNothing) {
  std::mt19937 random(1);
  NmeaReceiver receiver({.only_listen = true});
  receiver.start(now_, out_);
  const std::string good =
      line("GNGGA,132820.00,4134.49802199,N,09345.03419022,W,4,10,0.9,278.254,M,-31.4,M,7,1") +
      line("GNRMC,132820.00,A,4134.498,N,09345.034,W,1.944,127.194,180320,11.6,E,D");
  for (int i = 0; i < 20000; ++i) {
    auto bytes = bytes_of_text(good);
    for (int flips = static_cast<int>(random() % 4); flips > 0; --flips)
      bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 << random() % 8);
    bytes.resize(random() % bytes.size());
    receiver.on_arrival({.bytes = bytes, .first = now_, .last = now_}, out_);
    if (const auto data = taken(receiver)) {
      EXPECT_LE(std::abs(data->latitude), std::numbers::pi / 2);
    }
  }
}

// --- pulses and deviations

TEST(GpsTest, APulseGivesTheTimeOfAFix) {
  EXPECT_EQ(measured_by_pulse(100s, 0s, 100s + 300ms), 100s);
  EXPECT_EQ(measured_by_pulse(100s, 900ms, 100s + 300ms), 99s + 900ms);
  EXPECT_EQ(measured_by_pulse(100s, 200ms, 100s + 300ms), 100s + 200ms);
  EXPECT_FALSE(measured_by_pulse(100s, 0s, 101s + 1ms));
  EXPECT_FALSE(measured_by_pulse(100s, 0s, 90s));
}

TEST(GpsTest, AFixIsWeighedByHowSureItIs) {
  PositionData known;
  known.pos = {.x = 0, .y = 0, .rho = 0.1F};
  known.var = {.x = 1000, .y = 3000, .rho = 0.1F};
  GpsData fix;
  fix.recordingTime = 77;
  fix.pos = {.x = 1000, .y = 1000, .rho = 6.2F};
  fix.var = {.x = 1000, .y = 1000, .rho = 0.1F};
  const auto both = weighed(known, fix, true);
  ASSERT_TRUE(both);
  EXPECT_EQ(both->recordingTime, 77U);
  EXPECT_EQ(both->pos.x, 500);
  EXPECT_EQ(both->pos.y, 900);
  EXPECT_EQ(both->var.x, 707);
  EXPECT_EQ(both->var.y, 949);
  EXPECT_NEAR(both->pos.rho, (0.1 + 6.2 - 2 * std::numbers::pi) / 2, 1e-5) << "shortest rotation";
  EXPECT_FLOAT_EQ(weighed(known, fix, false)->pos.rho, 0.1F) << "a receiver at rest has no course";
}

// A Position that was never updated is 100 m uncertain about an origin that may be far away: the
// first good fix is where the robot is, to the millimetre, and so is the first course.
TEST(GpsTest, TheFirstGoodFixCountsWhole) {
  PositionData unknown;
  unknown.var = {.x = 100'000, .y = 100'000, .rho = 3.14F};
  GpsData fix;
  fix.pos = {.x = 2'000'000'000, .y = -2'000'000'000, .rho = 4};
  fix.var = {.x = 10'000, .y = 12'000, .rho = 0.35F};
  const auto first = weighed(unknown, fix, false);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->pos.x, 2'000'000'000);
  EXPECT_EQ(first->pos.y, -2'000'000'000);
  EXPECT_EQ(first->var.x, 10'000);
  EXPECT_EQ(first->var.y, 12'000);
  EXPECT_EQ(first->pos.rho, 0.0F);
  EXPECT_EQ(first->var.rho, 3.14F) << "a receiver at rest has no course";
  const auto moving = weighed(unknown, fix, true);
  EXPECT_EQ(moving->pos.rho, 4.0F);
  EXPECT_EQ(moving->var.rho, 0.35F);
  // Just below, both count by their variances.
  unknown.var = {.x = 49'999, .y = 49'999, .rho = 1.57F};
  fix.pos = {.x = 10'000, .y = 0, .rho = 1};
  const auto both = weighed(unknown, fix, true);
  EXPECT_NEAR(both->pos.x.raw(), 10'000 * 0.9615, 10);
  EXPECT_LT(both->pos.rho, 1.0F);
}

// The position of a receiver at rest drifts for minutes: a thousand fixes are not a thousand
// independent measurements.
TEST(GpsTest, FixesMakeNothingSurerThanHalfOfOne) {
  PositionData known;
  known.var = {.x = 100'000, .y = 100'000};
  GpsData fix;
  fix.var = {.x = 1000, .y = 1000};
  int fixes = 0;
  while (const auto both = weighed(known, fix, false)) {
    known = *both;
    ASSERT_LT(++fixes, 10);
  }
  EXPECT_EQ(known.var.x, 500);
  known.var = {};
  fix.var = {};
  EXPECT_FALSE(weighed(known, fix, true));
}

TEST(GpsTest, DeviationsStayBetweenTheirBounds) {
  const GpsDeviations bounds;
  EXPECT_EQ(guessed_deviations(bounds, gps_mode::k3d, 0).x, 50000);
  EXPECT_EQ(guessed_deviations(bounds, gps_mode::k3d, 8).x, 30000);
  EXPECT_EQ(guessed_deviations(bounds, gps_mode::k3d, 12).z, 20000);
  EXPECT_EQ(guessed_deviations(bounds, gps_mode::k3d, 40).x, 10000);
  EXPECT_EQ(guessed_deviations(bounds, gps_mode::kInvalid, 12).x, 50000);
}

}  // namespace nmea_test
}  // namespace rack::device
