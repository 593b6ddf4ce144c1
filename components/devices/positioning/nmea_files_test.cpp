// Recordings of 17 receivers: numbers of sentences, invalid lines and fixes, counted by hand.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "components/devices/core/test_bytes.h"
#include "components/devices/positioning/nmea_receiver.h"
#include "rack/devices/pieces.h"

namespace rack::device {
namespace nmea_files_test {

struct File {
  const char* name;
  std::uint64_t sentences;
  std::uint64_t broken;
  int fixed;                       // rounds with a position
  int unfixed;                     // rounds without a position
  NmeaKind kind = NmeaKind::kGga;  // last sentence of a round
};

void PrintTo(const File& file, std::ostream* out) { *out << file.name; }

constexpr File kFiles[] = {
    {"plaka-boat-cut.nmea", 4800, 0, 300, 0, NmeaKind::kGll},
    {"gofree-corrupted.nmea", 6182, 142, 142, 0},
    {"gps-20min-cut.nmea", 4820, 0, 1005, 0},
    {"bt451.log", 144, 0, 13, 4},
    {"ublox-lea-4h.log", 108, 0, 9, 5},
    {"quectel-eg25-g.log", 861, 0, 23, 37},
    {"haicom-305N.log", 325, 0, 68, 5},
    {"garmin-10x.log", 84, 0, 10, 4},
    {"nmea-rtk.log", 244, 0, 122, 0},
    {"telit-he910.log", 1558, 0, 187, 37},
    {"hemi.log", 753, 0, 21, 194},
    {"unicore-um621.log", 882, 0, 16, 4},
    {"ublox-zed-f9p-nmea.log", 1015, 0, 29, 0},
    {"ublox-neo-m9n-nmea.log", 1403, 0, 61, 0},
    {"gp-320fw-2019-04-07-coldboot.log", 86, 41, -1, -1},  // including recovered lines
    {"firefly-II.log", 46, 23, 23, 0, NmeaKind::kRmc},
    {"garmin48.log", 91, 1, 7, 0},
};

class NmeaFilesTest : public testing::TestWithParam<File> {
 protected:
  // Takes all data sets of the file, passed in pieces as from a line.
  std::vector<GpsData> all_of(NmeaReceiver& receiver, std::size_t piece) {
    ReceivedOutput out;
    receiver.start(Time{}, out);
    std::vector<GpsData> all;
    auto bytes = bytes_of_file("nmea/" + std::string(GetParam().name));
    bytes.push_back(std::byte{'\n'});  // one recording ends with an incomplete line
    in_pieces({.bytes = bytes}, piece, [&](const Arrival& arrival) {
      receiver.on_arrival(arrival, out);
      GpsData data;
      Time recorded;
      if (receiver.take(data, recorded)) all.push_back(data);
    });
    return all;
  }
};

TEST_P(NmeaFilesTest, HasItsSentencesBrokenLinesAndFixes) {
  const File& file = GetParam();
  NmeaReceiver receiver({.start = file.kind, .end = file.kind, .only_listen = true});
  const auto all = all_of(receiver, 16);
  EXPECT_EQ(receiver.lines().sentences() - receiver.lines().recovered(), file.sentences);
  EXPECT_EQ(receiver.lines().broken(), file.broken);
  if (file.fixed < 0) return;
  const auto fixed = std::ranges::count_if(
      all, [](const GpsData& data) { return data.mode != gps_mode::kInvalid; });
  EXPECT_EQ(fixed, file.fixed);
  EXPECT_EQ(static_cast<int>(all.size()) - fixed, file.unfixed);
}

// Includes receivers without RMC.
TEST_P(NmeaFilesTest, GivesDataAsTheProgramIsSetByDefault) {
  NmeaReceiver receiver({.only_listen = true});
  EXPECT_GE(all_of(receiver, 16).size(), 4U);
}

TEST_P(NmeaFilesTest, PiecesOfAnySizeGiveTheSameSentences) {
  std::vector<std::uint64_t> counts;
  for (const std::size_t piece : {1U, 7U, 64U, 1000U, 100000U}) {
    NmeaReceiver receiver({.only_listen = true});
    (void)all_of(receiver, piece);
    counts.push_back(receiver.lines().sentences());
  }
  EXPECT_EQ(counts, std::vector(counts.size(), counts.front()));
}

INSTANTIATE_TEST_SUITE_P(Recordings, NmeaFilesTest, testing::ValuesIn(kFiles),
                         [](const testing::TestParamInfo<File>& file) {
                           std::string name(file.param.name);
                           std::erase_if(name, [](char c) { return std::isalnum(c) == 0; });
                           return name;
                         });

// --- known properties of single files

std::vector<GpsData> data_of(const std::string& name, NmeaKind kind) {
  NmeaReceiver receiver({.start = kind, .end = kind, .only_listen = true});
  ReceivedOutput out;
  receiver.start(Time{}, out);
  std::vector<GpsData> all;
  const auto bytes = bytes_of_file("nmea/" + name);
  in_pieces({.bytes = bytes}, 16, [&](const Arrival& arrival) {
    receiver.on_arrival(arrival, out);
    GpsData data;
    Time recorded;
    if (receiver.take(data, recorded)) all.push_back(data);
  });
  return all;
}

// m, in a planar approximation that suffices for some kilometres.
double distance(const GpsData& a, const GpsData& b) {
  constexpr double kRadius = 6371e3;
  const double north = (b.latitude - a.latitude) * kRadius;
  const double east = (b.longitude - a.longitude) * kRadius * std::cos(a.latitude);
  return std::hypot(north, east);
}

TEST(NmeaFileTest, TheBoatSailsWithoutJumps) {
  const auto track = data_of("plaka-boat-cut.nmea", NmeaKind::kGll);
  for (std::size_t i = 1; i < track.size(); ++i)
    EXPECT_LE(distance(track[i - 1], track[i]), 11.5) << i;
  EXPECT_GT(distance(track.front(), track.back()), 500);
  constexpr double kDegree = std::numbers::pi / 180;
  EXPECT_NEAR(track.front().latitude, 60.084517 * kDegree, 1e-6);
  EXPECT_NEAR(track.front().speed, 5.80 * 514.4, 30);
}

TEST(NmeaFileTest, RtkBeginsDifferentialAndBecomesFixed) {
  const auto track = data_of("nmea-rtk.log", NmeaKind::kGga);
  for (const GpsData& data : track)
    EXPECT_EQ(data.mode & gps_mode::kDifferential, gps_mode::kDifferential);
  EXPECT_EQ(track[4].utcTime - track[3].utcTime, 1);  // 19.9 s to 20.0 s
}

TEST(NmeaFileTest, DeadReckoningIsEstimated) {
  int estimated = 0;
  for (const GpsData& data : data_of("garmin-10x.log", NmeaKind::kGga))
    estimated += (data.mode & gps_mode::kEstimated) != 0 ? 1 : 0;
  EXPECT_EQ(estimated, 1);
}

TEST(NmeaFileTest, TwoAntennasGiveAHeading) {
  const auto track = data_of("hemi.log", NmeaKind::kGga);
  EXPECT_GT(std::ranges::count_if(track, [](const GpsData& data) { return data.heading > 0; }), 10);
}

TEST(NmeaFileTest, ReportedDeviationsAreUsed) {
  const auto track = data_of("ublox-zed-f9p-nmea.log", NmeaKind::kGga);
  EXPECT_LT(track.back().var.x, 5000);
  EXPECT_GT(track.back().var.x, 0);
}

}  // namespace nmea_files_test
}  // namespace rack::device
