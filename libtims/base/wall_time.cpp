#include "base/wall_time.h"

#include <algorithm>
#include <array>

#include "base/text.h"

namespace tims::base {
namespace {

using namespace std::chrono;

std::string padded(std::int64_t number, std::size_t digits) {
  const std::string text = std::to_string(number);
  return std::string(digits - std::min(digits, text.size()), '0') + text;
}

std::string clock_text(WallTime time, int digits) {
  const hh_mm_ss clock(time - floor<days>(time));
  std::string text = padded(clock.hours().count(), 2) + ":" + padded(clock.minutes().count(), 2) +
                     ":" + padded(clock.seconds().count(), 2);
  const std::string fraction = padded(clock.subseconds().count(), 9);
  if (digits > 0) text.append(".").append(fraction, 0, static_cast<std::size_t>(digits));
  return text;
}

// Nanoseconds in 64 bits reach no further.
constexpr year kFirstYear(1678);
constexpr year kLastYear(2261);

// "" or ".123"
std::optional<nanoseconds> parse_fraction(std::string_view text) {
  if (text.empty()) return nanoseconds(0);
  if (text.front() != '.' || text.size() < 2) return std::nullopt;
  std::string digits(text.substr(1, 9));
  if (text.find_first_not_of("0123456789", 1) != std::string_view::npos) return std::nullopt;
  digits.resize(9, '0');
  return nanoseconds(*parse_number<std::int64_t>(digits));
}

}  // namespace

std::string rfc3339(WallTime time, int digits) {
  return date(time) + "T" + clock_text(time, digits) + "Z";
}

std::optional<WallTime> parse_rfc3339(std::string_view text) {
  constexpr std::string_view kForm = "0000-00-00T00:00:00";
  if (text.size() <= kForm.size() || text.back() != 'Z') return std::nullopt;
  const auto fits = [](char c, char form) {
    return form == '0' ? c >= '0' && c <= '9' : c == form;
  };
  if (!std::ranges::equal(text.substr(0, kForm.size()), kForm, fits)) return std::nullopt;
  const auto part = [&](std::size_t at, std::size_t size) {
    return *parse_number<int>(text.substr(at, size));
  };
  const auto day = year(part(0, 4)) / month(static_cast<unsigned>(part(5, 2))) /
                   std::chrono::day(static_cast<unsigned>(part(8, 2)));
  if (day.year() < kFirstYear || day.year() > kLastYear) return std::nullopt;
  const int hour = part(11, 2);
  const int minute = part(14, 2);
  const int second = part(17, 2);
  const auto fraction = parse_fraction(text.substr(kForm.size(), text.size() - kForm.size() - 1));
  if (!day.ok() || hour > 23 || minute > 59 || second > 59 || !fraction) return std::nullopt;
  return sys_days(day) + hours(hour) + minutes(minute) + seconds(second) + *fraction;
}

std::string date(WallTime time) {
  const year_month_day date(floor<days>(time));
  return padded(static_cast<int>(date.year()), 4) + "-" +
         padded(static_cast<unsigned>(date.month()), 2) + "-" +
         padded(static_cast<unsigned>(date.day()), 2);
}

std::string time_of_day(WallTime time) { return clock_text(time, 3); }

}  // namespace tims::base
