#include "components/devices/positioning/nmea_emulator.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "components/devices/positioning/nmea.h"

namespace rack::device::emulator {
namespace {

constexpr double kKnot = 1852.0 / 3600;  // m/s

// "ddmm.mmmmm,N": with two or three digits of degrees.
std::string angle(double degrees, int digits, std::string_view sides) {
  const double size = std::abs(degrees);
  double whole = std::floor(size);
  double minutes = std::round((size - whole) * 60 * 1e5) / 1e5;
  if (minutes >= 60) {
    minutes = 0;
    ++whole;
  }
  return fmt::format("{:0{}.0f}{:08.5f},{}", whole, digits, minutes, sides[degrees < 0 ? 1 : 0]);
}

std::string time_of_day(Duration utc) {
  const Duration rest = utc % std::chrono::hours(24);
  const auto hundredths = rest.count() / 10'000'000;
  return fmt::format("{:02}{:02}{:02}.{:02}", hundredths / 360000, hundredths / 6000 % 60,
                     hundredths / 100 % 60, hundredths % 100);
}

}  // namespace

void append_sentences(std::vector<std::byte>& out, const CoursePoint& point,
                      const std::string& talker) {
  const std::string time = time_of_day(point.utc);
  const std::chrono::year_month_day date(
      std::chrono::floor<std::chrono::days>(std::chrono::sys_time<Duration>(point.utc)));
  const auto day = static_cast<unsigned>(date.day());
  const auto month = static_cast<unsigned>(date.month());
  const auto year = static_cast<int>(date.year());
  const std::string place =
      point.is_fixed ? angle(point.latitude, 2, "NS") + "," + angle(point.longitude, 3, "EW")
                     : ",,,";
  const auto append = [&](const std::string& text) { append_nmea(out, talker + text); };
  const auto fixed = [&](const std::string& text) { return point.is_fixed ? text : ""; };
  const double knots = point.speed / kKnot;
  const std::string motion = fixed(fmt::format("{:.3f}", knots));
  const std::string course = fixed(fmt::format("{:.2f}", point.course));
  const char mode = point.is_fixed ? 'A' : 'N';
  append(fmt::format("RMC,{},{},{},{},{},{:02}{:02}{:02},,,{}", time, point.is_fixed ? 'A' : 'V',
                     place, motion, course, day, month, year % 100, mode));
  append(fmt::format("VTG,{},T,,M,{},N,{},K,{}", course, motion,
                     fixed(fmt::format("{:.3f}", point.speed * 3.6)), mode));
  append(fmt::format("GGA,{},{},{},{:02},{},{},M,{},M,,", time, place, point.is_fixed ? 1 : 0,
                     point.satellites, point.is_fixed ? "0.9" : "99.9",
                     fixed(fmt::format("{:.2f}", point.altitude)), fixed("46.0")));
  append(fmt::format("GSA,A,{},,,,,,,,,,,,,{}", point.is_fixed ? 3 : 1,
                     point.is_fixed ? "1.6,0.9,1.3" : "99.9,99.9,99.9"));
  append(fmt::format("GST,{},{}", time, fixed("2.1,1.2,1.0,30,1.1,1.2,2.4")));
  append(fmt::format("ZDA,{},{:02},{:02},{:04},00,00", time, day, month, year));
}

void NmeaEmulator::start(Time now, Output&) { began_ = fix_ = now; }

void NmeaEmulator::on_timeout(Time now, Output& out) {
  if (next_timeout() > now) return;
  burst_.clear();
  append_sentences(burst_, settings_.course(fix_, fix_ - began_), settings_.talker);
  out.send(burst_);
  fix_ += settings_.period;
}

}  // namespace rack::device::emulator
