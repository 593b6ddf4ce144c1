#include "components/devices/positioning/nmea_fix.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kHalfDay = 12h;
constexpr Duration kDay = 24h;
constexpr double kKnot = 1852.0 / 3600;  // m/s
constexpr double kUnknownDop = 999.999;  // as in the original
constexpr Duration kRoundTimeMax = 5s;   // all sentences of a round
constexpr Duration kDateAgeMax = 12h;    // longer, and more than one midnight may have passed

std::optional<int> whole(std::string_view field) {
  const auto number = nmea_number(field);
  if (!number || std::abs(*number) > 1e6) return std::nullopt;
  return static_cast<int>(std::lround(*number));
}

}  // namespace

NmeaKind nmea_kind(const NmeaSentence& sentence) {
  constexpr std::array<std::string_view, kNmeaKinds - 1> kTypes = {
      "RMC", "GGA", "GSA", "VTG", "GLL", "GST", "ZDA", "HDT", "GNS"};
  if (sentence.talker.size() != 2) return NmeaKind::kOther;
  for (std::size_t i = 0; i < kTypes.size(); ++i)
    if (sentence.type == kTypes[i]) return static_cast<NmeaKind>(i);
  return NmeaKind::kOther;
}

bool reports_position(NmeaKind kind) {
  return kind == NmeaKind::kRmc || kind == NmeaKind::kGga || kind == NmeaKind::kGll ||
         kind == NmeaKind::kGns;
}

void NmeaFix::reset() { *this = NmeaFix(deviations_); }

void NmeaFix::add(NmeaKind kind, const NmeaSentence& sentence) {
  latest_ = sentence.began;
  const bool ends_with_time = kind == NmeaKind::kGll;
  const bool has_time = reports_position(kind) || kind == NmeaKind::kGst || kind == NmeaKind::kZda;
  if (has_time) take_time(sentence[ends_with_time ? 5 : 1], sentence.began);
  if (!time_of_day_ && round_began_ == Time{}) round_began_ = sentence.began;
  switch (kind) {
    case NmeaKind::kRmc:
      return add_rmc(sentence);
    case NmeaKind::kGga:
      return add_gga(sentence);
    case NmeaKind::kGsa:
      return add_gsa(sentence);
    case NmeaKind::kVtg:
      return add_vtg(sentence);
    case NmeaKind::kGll:
      return add_gll(sentence);
    case NmeaKind::kGst:
      return add_gst(sentence);
    case NmeaKind::kZda:
      return add_zda(sentence);
    case NmeaKind::kHdt:
      return store(heading_, nmea_number(sentence[1]));
    case NmeaKind::kGns:
      return add_gns(sentence);
    case NmeaKind::kOther:
      return;
  }
}

// --- rounds and time

void NmeaFix::take_time(std::string_view field, Time began) {
  const auto time = nmea_time_of_day(field);
  if (!time) return;
  has_time_ = true;
  if (time == time_of_day_) return;
  ++round_;
  time_of_day_ = time;
  is_leap_second_ = field.substr(4, 2) == "60";
  round_began_ = began;
}

void NmeaFix::end_round() {
  if (std::exchange(has_time_, false)) return;
  ++round_;
  time_of_day_.reset();
  round_began_ = {};
}

void NmeaFix::take_date(std::optional<int> day, const NmeaSentence& sentence) {
  const auto time_of_day = nmea_time_of_day(sentence[1]);
  if (day && time_of_day)
    date_ = {.day = *day,
             .time_of_day = *time_of_day,
             .received = sentence.began,
             .had_fix = quality() != Quality::kNone};
}

GpsMoment NmeaFix::moment() const {
  if (!date_ || !time_of_day_ || latest_ - date_->received > kDateAgeMax) return {};
  if (!date_->had_fix && quality() != Quality::kNone) return {};
  // The date and this time may have been received on different sides of midnight.
  int day = date_->day;
  if (*time_of_day_ + kHalfDay < date_->time_of_day) ++day;
  if (*time_of_day_ > date_->time_of_day + kHalfDay) --day;
  return {.utc = kDay * day + *time_of_day_, .is_leap_second = is_leap_second_};
}

// --- sentences

void NmeaFix::add_rmc(const NmeaSentence& sentence) {
  store(status_, std::optional(quality_of(sentence[2], sentence[12])));
  take_date(nmea_date(sentence[9]), sentence);
  if (status_.value == Quality::kNone) return;
  take_place(sentence, 3);
  take_motion(sentence[7], sentence[8]);
}

void NmeaFix::add_gga(const NmeaSentence& sentence) {
  const auto quality = whole(sentence[6]);
  constexpr int kLast = static_cast<int>(Quality::kSimulated);
  // An empty quality is unknown, neither good nor bad.
  store(gga_, quality && *quality >= 0 && *quality <= kLast
                  ? std::optional(static_cast<Quality>(*quality))
                  : std::nullopt);
  take_height(sentence, 7);
  if (gga_.value != Quality::kNone) take_place(sentence, 2);
}

void NmeaFix::add_gns(const NmeaSentence& sentence) {
  Quality best = Quality::kNone;  // of all satellite systems
  const auto rank = [](Quality quality) {
    constexpr std::array<int, 9> kRanks = {0, 4, 5, 6, 8, 7, 3, 2, 1};
    return kRanks[static_cast<std::size_t>(quality)];
  };
  for (const char mode : sentence[6])
    if (rank(quality_of(mode)) > rank(best)) best = quality_of(mode);
  store(status_, std::optional(best));
  take_height(sentence, 7);
  if (best != Quality::kNone) take_place(sentence, 2);
}

void NmeaFix::add_gll(const NmeaSentence& sentence) {
  store(status_, std::optional(quality_of(sentence[6], sentence[7])));
  if (status_.value != Quality::kNone) take_place(sentence, 1);
}

// Receivers send one GSA per satellite system, all with the same mode and dilution.
void NmeaFix::add_gsa(const NmeaSentence& sentence) {
  store(dimensions_, whole(sentence[2]));
  store(pdop_, nmea_number(sentence[15]));
  if (const auto hdop = nmea_number(sentence[16])) store(hdop_, hdop);
}

void NmeaFix::add_vtg(const NmeaSentence& sentence) {
  const bool is_of_today = sentence[2] == "T" || sentence[2].empty();
  if (!is_of_today || sentence[9] == "N") return;
  take_motion(sentence[5], sentence[1]);
}

void NmeaFix::add_gst(const NmeaSentence& sentence) {
  const auto latitude = nmea_number(sentence[6]);
  const auto longitude = nmea_number(sentence[7]);
  const auto height = nmea_number(sentence[8]);
  if (latitude && longitude && height)
    store(reported_deviations_, std::optional(Deviations{*latitude, *longitude, *height}));
  else
    store(reported_deviations_, {});
}

void NmeaFix::add_zda(const NmeaSentence& sentence) {
  constexpr int kCentury = 100;
  auto year = whole(sentence[4]);
  const auto month = whole(sentence[3]);
  const auto day = whole(sentence[2]);
  if (!year || !month || !day || *month < 0 || *day < 0) return;
  if (*year < kCentury) *year += 2000;
  take_date(days_since_1970(*year, static_cast<unsigned>(*month), static_cast<unsigned>(*day)),
            sentence);
}

void NmeaFix::take_place(const NmeaSentence& sentence, std::size_t first_field) {
  const auto latitude = nmea_angle(sentence[first_field], sentence[first_field + 1]);
  const auto longitude = nmea_angle(sentence[first_field + 2], sentence[first_field + 3]);
  if (latitude && longitude)
    store(place_, std::optional(Place{.latitude = *latitude, .longitude = *longitude}));
  else if (place_.round != round_)
    store(place_, {});  // the place is lost, unless another sentence of this round has one
}

// Satellites, dilution and height are consecutive fields in GGA and GNS.
void NmeaFix::take_height(const NmeaSentence& sentence, std::size_t satellites_field) {
  store(satellites_, whole(sentence[satellites_field]));
  if (const auto hdop = nmea_number(sentence[satellites_field + 1])) store(hdop_, hdop);
  store(height_, nmea_number(sentence[satellites_field + 2]));
}

// A receiver at rest sends no course: the last one is kept.
void NmeaFix::take_motion(std::string_view knots, std::string_view course) {
  if (const auto speed = nmea_number(knots)) store(speed_, std::optional(*speed * kKnot));
  if (const auto degrees = nmea_number(course)) store(course_, degrees);
}

NmeaFix::Quality NmeaFix::quality_of(char mode) {
  switch (mode) {
    case 'A':
      return Quality::kGps;
    case 'D':
      return Quality::kDifferential;
    case 'P':
      return Quality::kPrecise;
    case 'R':
      return Quality::kRtkFixed;
    case 'F':
      return Quality::kRtkFloat;
    case 'E':
      return Quality::kEstimated;
    case 'M':
      return Quality::kManual;
    case 'S':
      return Quality::kSimulated;
    default:
      return Quality::kNone;
  }
}

// Receivers made before 2000 send no mode.
NmeaFix::Quality NmeaFix::quality_of(std::string_view status, std::string_view mode) {
  if (status != "A" && status != "D") return Quality::kNone;
  return mode.empty() ? Quality::kGps : quality_of(mode.front());
}

// --- combination

// The most recent sentence decides that there is no position; GGA has the most detailed quality.
NmeaFix::Quality NmeaFix::quality() const {
  const auto status = known(status_);
  const auto gga = known(gga_);
  if (!status || !gga) return gga.value_or(status.value_or(Quality::kNone));
  if (status_.round == gga_.round) return *status == Quality::kNone ? Quality::kNone : *gga;
  const bool gga_is_newer = gga_.round > status_.round;
  const Quality newer = gga_is_newer ? *gga : *status;
  return newer == Quality::kNone || *gga == Quality::kNone ? newer : *gga;
}

// The receiver sends the same time of day again and again.
bool NmeaFix::is_stuck() const { return time_of_day_ && latest_ - round_began_ > kRoundTimeMax; }

std::optional<NmeaFix::Place> NmeaFix::place() const {
  return is_stuck() ? std::nullopt : known(place_);
}

i32 NmeaFix::mode() const {
  constexpr int kSatellitesOf3d = 4;
  const Quality found = quality();
  if (found == Quality::kNone || !place()) return gps_mode::kInvalid;
  const auto dimensions = known(dimensions_, kRoundsKept);
  const bool has_height =
      known(height_).has_value() && known(satellites_).value_or(0) >= kSatellitesOf3d;
  i32 mode = (dimensions ? *dimensions >= 3 : has_height) ? gps_mode::k3d : gps_mode::k2d;
  if (found == Quality::kDifferential || found == Quality::kRtkFixed || found == Quality::kRtkFloat)
    mode += gps_mode::kDifferential;
  if (found >= Quality::kEstimated) mode += gps_mode::kEstimated;
  return mode;
}

void NmeaFix::fill(GpsData& data) const {
  data.mode = mode();
  const auto found = place();
  data.latitude = found ? found->latitude : 0;
  data.longitude = found ? found->longitude : 0;
  data.altitude = Millimetres<i32>::from_si(known(height_, kRoundsKept).value_or(0));
  const auto heading = known(heading_);
  data.heading = heading_of(heading ? *heading : course_.value.value_or(0));
  data.speed = MillimetresPerSecond<i32>::from_si(known(speed_).value_or(0));
  data.satelliteNum = known(satellites_, kRoundsKept).value_or(0);
  const auto pdop = known(pdop_, kRoundsKept);
  data.pdop = static_cast<f32>(pdop ? *pdop : known(hdop_, kRoundsKept).value_or(kUnknownDop));
  const GpsMoment now = moment();
  data.utcTime = now.utc ? std::chrono::floor<std::chrono::seconds>(*now.utc).count() : 0;
  data.pos = {};
  data.var = guessed_deviations(deviations_, data.mode, data.satelliteNum);
  // A robot may have turned since a receiver at rest sent the last course.
  if (!heading && !known(course_, kRoundsKept)) data.var.rho = std::numbers::pi_v<float>;
  if (const auto reported = known(reported_deviations_);
      reported && data.mode != gps_mode::kInvalid) {
    data.var.x = Millimetres<i32>::from_si(reported->latitude);
    data.var.y = Millimetres<i32>::from_si(reported->longitude);
    data.var.z = Millimetres<i32>::from_si(reported->height);
  }
}

}  // namespace rack::device
