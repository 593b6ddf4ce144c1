// Combines the sentences of a receiver to a fix: each sentence contains a part of it.
//
// RMC: time, date, position, speed, course. GGA, GNS: position, quality, satellites, height. GLL:
// position. GSA: 2D or 3D, dilution. VTG: speed, course. GST: standard deviations. ZDA: time and
// date. HDT: heading of two antennas. All sentences of one measurement have the same time of day
// and form a round. Every value has an age: values older than the previous round are not used, and
// a round ends after some seconds even if the receiver repeats its time of day.
#pragma once

#include "components/devices/positioning/gps.h"
#include "components/devices/positioning/nmea.h"

namespace rack::device {

// The first four have the numbers of the original's trigMsgStart and trigMsgEnd.
enum class NmeaKind : std::uint8_t { kRmc, kGga, kGsa, kVtg, kGll, kGst, kZda, kHdt, kGns, kOther };
inline constexpr std::size_t kNmeaKinds = 10;
NmeaKind nmea_kind(const NmeaSentence& sentence);
// The sentence contains a position.
bool reports_position(NmeaKind kind);

class NmeaFix {
 public:
  explicit NmeaFix(const GpsDeviations& deviations) : deviations_(deviations) {}

  void reset();
  void add(NmeaKind kind, const NmeaSentence& sentence);

  // When the first sentence of this round began.
  [[nodiscard]] Time round_began() const { return round_began_; }
  // Fills in all current values, except recordingTime.
  void fill(GpsData& data) const;
  [[nodiscard]] GpsMoment moment() const;
  // Called after the data were taken. For a receiver that does not know the time, this is the only
  // indication that a new round begins.
  void end_round();

 private:
  // Numbers as in GGA.
  enum class Quality : std::uint8_t {
    kNone = 0,
    kGps = 1,
    kDifferential = 2,
    kPrecise = 3,
    kRtkFixed = 4,
    kRtkFloat = 5,
    kEstimated = 6,
    kManual = 7,
    kSimulated = 8,
  };
  // A value and the round in which it was received.
  template <typename T>
  struct Received {
    std::optional<T> value{};
    std::uint64_t round = 0;
  };
  struct Place {
    double latitude = 0;
    double longitude = 0;
  };
  struct Deviations {  // m
    double latitude = 0;
    double longitude = 0;
    double height = 0;
  };
  struct Date {
    int day = 0;             // since 1970
    Duration time_of_day{};  // time of day at which the date was received
    Time received{};
    bool had_fix = false;  // without one, receivers send the date of their own clock
  };

  void add_rmc(const NmeaSentence& sentence);
  void add_gga(const NmeaSentence& sentence);
  void add_gsa(const NmeaSentence& sentence);
  void add_vtg(const NmeaSentence& sentence);
  void add_gll(const NmeaSentence& sentence);
  void add_gst(const NmeaSentence& sentence);
  void add_zda(const NmeaSentence& sentence);
  void add_gns(const NmeaSentence& sentence);

  void take_time(std::string_view field, Time began);
  void take_date(std::optional<int> day, const NmeaSentence& sentence);
  void take_place(const NmeaSentence& sentence, std::size_t first_field);
  void take_height(const NmeaSentence& sentence, std::size_t satellites_field);
  void take_motion(std::string_view knots, std::string_view course);
  static Quality quality_of(std::string_view status, std::string_view mode);
  static Quality quality_of(char mode);

  template <typename T>
  void store(Received<T>& received, std::optional<T> value) const {
    received = {value, round_};
  }
  template <typename T>
  [[nodiscard]] std::optional<T> known(const Received<T>& received,
                                       std::uint64_t rounds = 1) const {
    return round_ - received.round <= rounds ? received.value : std::nullopt;
  }
  [[nodiscard]] Quality quality() const;
  [[nodiscard]] bool is_stuck() const;
  [[nodiscard]] std::optional<Place> place() const;
  [[nodiscard]] i32 mode() const;

  GpsDeviations deviations_;
  std::uint64_t round_ = kRoundsKept + 1;
  std::optional<Duration> time_of_day_;
  bool has_time_ = false;  // a time was received since the last end_round()
  bool is_leap_second_ = false;
  Time round_began_{};
  std::optional<Date> date_;
  Time latest_{};  // when the newest sentence began
  Received<Place> place_;
  Received<double> course_;  // deg
  Received<Quality> gga_;
  Received<Quality> status_;  // from RMC, GLL, GNS
  Received<int> dimensions_;  // GSA: 1 none, 2, 3
  Received<int> satellites_;
  Received<double> height_;  // m
  Received<double> pdop_;
  Received<double> hdop_;
  Received<double> speed_;  // m/s
  Received<double> heading_;
  Received<Deviations> reported_deviations_;

  static constexpr std::uint64_t kRoundsKept =
      10;  // some receivers send some values every 5 s only
};

}  // namespace rack::device
