#include "components/devices/positioning/dcf77.h"

#include <chrono>

#include "base/text.h"

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr char kStart = 0x02;
constexpr char kEnd = 0x03;
constexpr Duration kDcf77FirstData = 5s;
constexpr Duration kEmcProDelay = 22ms;
constexpr i32 kDeviation = 10;        // ms, of long wave reception with a simple receiver
constexpr i32 kDeviationFree = 1000;  // ms, free running for an unknown time

std::optional<int> digits(std::string_view text, std::size_t at, std::size_t count) {
  int number = 0;
  for (const char c : text.substr(at, count)) {
    if (c < '0' || c > '9') return std::nullopt;
    number = 10 * number + (c - '0');
  }
  return number;
}

struct Shown {
  std::optional<int> hour, minute, second, day, month, year, weekday;
};

// Returns false for an impossible time. `ahead`: offset of local time from UTC.
bool fill(const Shown& shown, std::chrono::hours ahead, bool is_synchronised, ClockData& clock) {
  using namespace std::chrono;
  if (!shown.hour || !shown.minute || !shown.second || !shown.day || !shown.month || !shown.year ||
      !shown.weekday)
    return false;
  constexpr int kFirstYear = 80;  // two-digit years from here are 19xx
  const int century = *shown.year < kFirstYear ? 2000 : 1900;
  const year_month_day date(year(century + *shown.year), month(static_cast<unsigned>(*shown.month)),
                            day(static_cast<unsigned>(*shown.day)));
  if (*shown.hour > 23 || *shown.minute > 59 || *shown.second > 60 || !date.ok()) return false;
  const sys_days midnight(date);
  if (static_cast<unsigned>(*shown.weekday) != weekday(midnight).iso_encoding()) return false;
  const seconds time = hours(*shown.hour) + minutes(*shown.minute) + seconds(*shown.second);
  clock.hour = *shown.hour;
  clock.minute = *shown.minute;
  clock.second = *shown.second;
  clock.day = *shown.day;
  clock.month = *shown.month;
  clock.year = static_cast<i32>(static_cast<int>(date.year()));  // 2026, not 26
  clock.dayOfWeek = *shown.weekday;
  clock.utcTime = (midnight.time_since_epoch() + time - ahead).count();
  clock.syncMode = is_synchronised ? 1 : 0;
  clock.varT = is_synchronised ? kDeviation : kDeviationFree;
  return true;
}

}  // namespace

bool parse_meinberg(std::string_view telegram, ClockData& clock) {
  constexpr std::string_view kShape =
      "\x02"
      "D:dd.dd.dd;T:d;U:dd.dd.dd;????"
      "\x03";
  if (telegram.size() != kShape.size()) return false;
  for (std::size_t i = 0; i < kShape.size(); ++i) {
    const bool is_free = kShape[i] == 'd' || kShape[i] == '?';
    if (!is_free && telegram[i] != kShape[i]) return false;
  }
  const Shown shown{.hour = digits(telegram, 18, 2),
                    .minute = digits(telegram, 21, 2),
                    .second = digits(telegram, 24, 2),
                    .day = digits(telegram, 3, 2),
                    .month = digits(telegram, 6, 2),
                    .year = digits(telegram, 9, 2),
                    .weekday = digits(telegram, 14, 1)};
  const char zone = telegram[29];
  if (zone != ' ' && zone != 'S' && zone != 'U') return false;
  const bool is_synchronised = telegram[27] == ' ' && telegram[28] == ' ';
  return fill(shown,
              std::chrono::hours(zone == 'U'   ? 0
                                 : zone == 'S' ? 2
                                               : 1),
              is_synchronised, clock);
}

bool parse_emc_pro(std::string_view telegram, ClockData& clock) {
  constexpr std::size_t kSize = 24;  // including both brackets
  constexpr std::size_t kSizeWithSum = kSize + 2;
  if (telegram.size() != kSize && telegram.size() != kSizeWithSum) return false;
  if (telegram.front() != '<' || telegram[kSize - 1] != '>') return false;
  if (telegram.size() == kSizeWithSum) {
    unsigned sum = 0;
    for (const char c : telegram.substr(0, kSize)) sum += static_cast<unsigned char>(c);
    const auto stated = tims::base::parse_number<unsigned>(telegram.substr(kSize), 16);
    if (!stated || *stated != (sum & 0xFF)) return false;
  }
  const Shown shown{.hour = digits(telegram, 1, 2),
                    .minute = digits(telegram, 3, 2),
                    .second = digits(telegram, 21, 2),
                    .day = digits(telegram, 5, 2),
                    .month = digits(telegram, 7, 2),
                    .year = digits(telegram, 9, 2),
                    .weekday = digits(telegram, 11, 1)};
  const bool is_summer = telegram[15] == '1';
  return fill(shown, std::chrono::hours(is_summer ? 2 : 1), telegram[12] == 'F', clock);
}

void Dcf77::start(Time now, Output&) {
  clear_failure();
  size_ = 0;
  bytes_ = broken_ = 0;
  has_received_ = has_data_ = false;
  timer_.wait_until(now + kDcf77FirstData);
}

void Dcf77::on_arrival(const Arrival& arrival, Output&) {
  constexpr std::byte kParity{0x80};
  for (std::size_t i = 0; i < arrival.bytes.size(); ++i)
    take_byte(static_cast<char>(arrival.bytes[i] & ~kParity), arrival, i);
  bytes_ += arrival.bytes.size();
}

void Dcf77::take_byte(char c, const Arrival& arrival, std::size_t index) {
  // When the byte at this index began; that of the next index is when it ended.
  const auto time_of = [&](std::size_t at) {
    return arrival.first + (arrival.last - arrival.first) * static_cast<std::int64_t>(at) /
                               static_cast<std::int64_t>(arrival.bytes.size());
  };
  const bool is_meinberg = kind_ == Dcf77Kind::kMeinberg;
  if (c == (is_meinberg ? kStart : '<')) {
    size_ = 0;
    began_ = time_of(index);
  } else if (size_ == 0) {
    return;
  }
  const bool ends = c == (is_meinberg ? kEnd : '\r');
  if (!ends || is_meinberg) text_[size_++] = c;
  if (!ends && size_ < kTelegramMax) return;
  const std::string_view text(text_.data(), std::exchange(size_, 0));
  if (!(is_meinberg ? parse_meinberg(text, data_) : parse_emc_pro(text, data_))) {
    ++broken_;
    return;
  }
  recorded_ = is_meinberg ? began_ : time_of(index + 1) - kEmcProDelay;
  has_data_ = has_received_ = true;
}

void Dcf77::on_timeout(Time now, Output&) {
  if (!timer_.take_due(now)) return;
  if (has_received_) return;
  fail(tims::Errc::kTimeout,
       bytes_ == 0 ? "the clock sends nothing; check its power and that it sends each second"
                   : "received data are not telegrams of this clock; check its format and "
                     "baudrate");
}

bool Dcf77::take(ClockData& clock, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  clock = data_;
  recorded = recorded_;
  return true;
}

}  // namespace rack::device
