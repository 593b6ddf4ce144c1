#include "components/devices/positioning/dcf77_emulator.h"

#include <fmt/format.h>

namespace rack::device::emulator {
namespace {

using namespace std::chrono_literals;

// Daylight saving time: from the last Sunday of March to that of October, each at 01:00 UTC.
bool is_summer(std::chrono::sys_seconds utc) {
  using namespace std::chrono;
  const year_month_day date(floor<days>(utc));
  const sys_days begin(date.year() / March / Sunday[last]);
  const sys_days end(date.year() / October / Sunday[last]);
  return utc >= begin + 1h && utc < end + 1h;
}

}  // namespace

std::string dcf77_telegram(Dcf77Kind kind, std::chrono::seconds utc, bool is_synchronised) {
  using namespace std::chrono;
  const bool summer = is_summer(sys_seconds(utc));
  const sys_seconds shown(utc + (summer ? 2h : 1h));
  const auto midnight = floor<days>(shown);
  const year_month_day date(midnight);
  const hh_mm_ss time(shown - midnight);
  const auto day = static_cast<unsigned>(date.day());
  const auto month = static_cast<unsigned>(date.month());
  const int year = static_cast<int>(date.year()) % 100;
  const unsigned weekday = std::chrono::weekday(midnight).iso_encoding();
  const auto hour = time.hours().count();
  const auto minute = time.minutes().count();
  const auto second = time.seconds().count();
  if (kind == Dcf77Kind::kMeinberg)
    return fmt::format(
        "\x02"
        "D:{:02}.{:02}.{:02};T:{};U:{:02}.{:02}.{:02};{}{}{} \x03",
        day, month, year, weekday, hour, minute, second, is_synchronised ? ' ' : '#',
        is_synchronised ? ' ' : '*', summer ? 'S' : ' ');
  std::string text =
      fmt::format("<{:02}{:02}{:02}{:02}{:02}{}{}00{}00000{:02}>", hour, minute, day, month, year,
                  weekday, is_synchronised ? 'F' : 'Q', summer ? 1 : 0, second);
  unsigned sum = 0;
  for (const char c : text) sum += static_cast<unsigned char>(c);
  return text + fmt::format("{:02X}\r", sum & 0xFF);
}

void Dcf77Emulator::start(Time now, Output&) {
  passed_ = 0s;
  next_ = now + 1s;
}

void Dcf77Emulator::on_timeout(Time now, Output& out) {
  if (next_ > now) return;
  ++passed_;
  const std::string telegram = dcf77_telegram(settings_.kind, settings_.begins + passed_,
                                              passed_ >= settings_.synchronised_after);
  out.send(std::as_bytes(std::span(telegram)));
  next_ += 1s;
}

}  // namespace rack::device::emulator
