#include "components/devices/positioning/nmea.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/text.h"

namespace rack::device {
namespace {

constexpr char kSentence = '$';
constexpr char kEncapsulated = '!';  // for example AIS

bool begins_sentence(char c) { return c == kSentence || c == kEncapsulated; }

std::optional<unsigned> hex_digit(char c) {
  if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
  if (c >= 'A' && c <= 'F') return static_cast<unsigned>(c - 'A') + 10;
  if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a') + 10;
  return std::nullopt;
}

struct ChecksumAtEnd {
  unsigned sum = 0;
  std::size_t digits = 0;
};

// Some receivers omit a leading zero.
std::optional<ChecksumAtEnd> checksum_at_end(std::string_view line) {
  const auto low = hex_digit(line[line.size() - 1]);
  if (!low) return std::nullopt;
  if (line[line.size() - 2] == '*') return ChecksumAtEnd{.sum = *low, .digits = 1};
  const auto high = hex_digit(line[line.size() - 2]);
  if (!high || line[line.size() - 3] != '*') return std::nullopt;
  return ChecksumAtEnd{.sum = *high << 4 | *low, .digits = 2};
}

unsigned checksum_of(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  return sum;
}

// Whether the text has the start and the checksum of a sentence.
bool looks_like_sentence(std::string_view line) {
  return begins_sentence(line.front()) && line.find('*') != std::string_view::npos;
}

// "$GPRMC,...": a talker, a type and fields, all printable.
bool looks_like_sentence_without_checksum(std::string_view line) {
  constexpr std::size_t kName = 6;
  const auto is_printable = [](char c) { return c >= ' ' && c <= '~'; };
  const auto is_capital = [](char c) { return c >= 'A' && c <= 'Z'; };
  return line.size() > kName && begins_sentence(line.front()) && line[kName] == ',' &&
         std::ranges::all_of(line.substr(1, kName - 1), is_capital) &&
         line.find('*') == std::string_view::npos && std::ranges::all_of(line, is_printable);
}

// The end of the first line: LF, or a CR before the next sentence. Only the part of `text` after
// `from` is searched for LF.
std::size_t end_of_line(std::string_view text, std::size_t from) {
  const std::size_t feed = text.find('\n', from);
  const std::string_view line = text.substr(0, feed);
  for (std::size_t at = line.find('\r', from > 0 ? from - 1 : 0);
       at != std::string_view::npos && at + 1 < line.size(); at = line.find('\r', at + 1))
    if (at > 0 && begins_sentence(line[at + 1])) return at;
  return feed;
}

// Splits the text between $ and * into fields and computes its checksum in one pass. Returns false
// if it contains another $ or *.
bool split(std::string_view text, NmeaSentence& sentence, unsigned& sum) {
  std::size_t head = text.size();
  std::size_t begin = 0;
  sentence.count = 0;
  sum = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    sum ^= static_cast<unsigned char>(c);
    if (c > ',') continue;  // fast path for most characters
    if (begins_sentence(c) || c == '*') return false;
    if (c != ',') continue;
    if (head == text.size())
      head = i;
    else if (sentence.count < NmeaSentence::kFieldsMax)
      sentence.fields[sentence.count++] = text.substr(begin, i - begin);
    begin = i + 1;
  }
  if (head < text.size() && sentence.count < NmeaSentence::kFieldsMax)
    sentence.fields[sentence.count++] = text.substr(begin);
  const std::string_view name = text.substr(0, head);
  const std::size_t talker = name.starts_with('P') ? 1 : std::min<std::size_t>(2, name.size());
  sentence.talker = name.substr(0, talker);
  sentence.type = name.substr(talker);
  return true;
}

std::optional<int> two_digits(std::string_view text) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (text.size() < 2 || !is_digit(text[0]) || !is_digit(text[1])) return std::nullopt;
  return (text[0] - '0') * 10 + (text[1] - '0');
}

}  // namespace

bool parse_nmea(std::string_view line, NmeaSentence& sentence) {
  constexpr std::size_t kLeast = 4;  // "$X*h"
  if (line.size() < kLeast || !begins_sentence(line.front())) return false;
  const auto expected = checksum_at_end(line);
  unsigned sum = 0;
  if (!expected || line.size() < expected->digits + 3) return false;
  return split(line.substr(1, line.size() - 2 - expected->digits), sentence, sum) &&
         sum == expected->sum;
}

void append_nmea(std::vector<std::byte>& out, std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  const unsigned sum = checksum_of(text);
  const auto put = [&out](char c) { out.push_back(static_cast<std::byte>(c)); };
  put(kSentence);
  for (const char c : text) put(c);
  put('*');
  put(kDigits[sum >> 4]);
  put(kDigits[sum & 0xF]);
  put('\r');
  put('\n');
}

std::optional<double> nmea_number(std::string_view field) {
  const auto number = tims::base::parse_number<double>(field);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

std::optional<double> nmea_angle(std::string_view field, std::string_view side) {
  if (side.size() != 1) return std::nullopt;
  const bool is_latitude = side == "N" || side == "S";
  if (!is_latitude && side != "E" && side != "W") return std::nullopt;
  const auto number = nmea_number(field);
  if (!number || *number < 0) return std::nullopt;
  const double degrees = std::floor(*number / 100);
  const double minutes = *number - degrees * 100;
  const double angle = degrees + minutes / 60;
  if (minutes >= 60 || angle > (is_latitude ? 90 : 180)) return std::nullopt;
  const double sign = side == "S" || side == "W" ? -1 : 1;
  return sign * angle * std::numbers::pi / 180;
}

std::optional<Duration> nmea_time_of_day(std::string_view field) {
  constexpr std::size_t kWhole = 6;
  if (field.size() < kWhole) return std::nullopt;
  const auto hour = two_digits(field);
  const auto minute = two_digits(field.substr(2));
  const auto second = two_digits(field.substr(4));
  if (!hour || !minute || !second || *hour > 23 || *minute > 59 || *second > 60)
    return std::nullopt;
  Duration time =
      std::chrono::hours(*hour) + std::chrono::minutes(*minute) + std::chrono::seconds(*second);
  if (field.size() == kWhole) return time;
  if (field[kWhole] != '.') return std::nullopt;
  std::int64_t scale = 100'000'000;
  for (const char c : field.substr(kWhole + 1)) {
    if (c < '0' || c > '9') return std::nullopt;
    time += Duration(scale * (c - '0'));
    scale /= 10;
  }
  return time;
}

std::optional<int> days_since_1970(int year, unsigned month, unsigned day) {
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month),
                                         std::chrono::day(day)};
  if (!date.ok()) return std::nullopt;
  return static_cast<int>(std::chrono::sys_days(date).time_since_epoch().count());
}

std::optional<int> nmea_date(std::string_view field) {
  constexpr int kFirstYear = 80;  // GPS time starts in 1980
  if (field.size() != 6) return std::nullopt;
  const auto day = two_digits(field);
  const auto month = two_digits(field.substr(2));
  const auto year = two_digits(field.substr(4));
  if (!day || !month || !year) return std::nullopt;
  return days_since_1970(*year + (*year < kFirstYear ? 2000 : 1900), static_cast<unsigned>(*month),
                         static_cast<unsigned>(*day));
}

void NmeaLines::clear() {
  buffer_.clear();
  used_ = searched_ = 0;
  is_rest_ = false;
}

bool NmeaLines::next(NmeaSentence& sentence) {
  buffer_.consume(std::exchange(used_, 0));
  while (buffer_.size() > searched_) {
    const auto bytes = buffer_.bytes().first(std::min(buffer_.size(), kLineMax));
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::size_t end = end_of_line(text, searched_);
    if (end == std::string_view::npos) {
      searched_ = bytes.size();
      if (searched_ < kLineMax) return false;
      buffer_.consume(std::exchange(searched_, 0));  // no sentence is that long
      is_rest_ = true;
      continue;
    }
    std::string_view line = text.substr(0, end);
    const std::size_t size = line.size() + 1;
    searched_ = 0;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    if (!line.empty() && parse_line(line, sentence)) {
      used_ = size;
      return true;
    }
    buffer_.consume(size);
  }
  return false;
}

bool NmeaLines::parse_line(std::string_view line, NmeaSentence& sentence) {
  const bool is_rest = std::exchange(is_rest_, false);
  std::size_t at = std::min(line.find_first_not_of('\r'), line.size());  // lines that end LF CR
  line.remove_prefix(at);
  if (line.empty()) return false;
  bool good = !is_rest && parse_nmea(line, sentence);
  if (!good) {
    if (!is_rest && looks_like_sentence(line)) ++broken_;
    if (!is_rest && looks_like_sentence_without_checksum(line)) ++without_checksum_;
    const std::size_t last = line.find_last_of("$!");
    good = last != std::string_view::npos && (last > 0 || is_rest) &&
           parse_nmea(line.substr(last), sentence);
    if (good) ++recovered_;
    if (good) at += last;
  }
  if (!good) return false;
  ++sentences_;
  sentence.began = buffer_.time_of(at);
  return true;
}

}  // namespace rack::device
