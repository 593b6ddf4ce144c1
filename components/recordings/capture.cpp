#include "rack/devices/capture.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "base/text.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;

constexpr std::string_view kMagic = "# rack capture 1";
constexpr std::string_view kDigits = "0123456789ABCDEF";
constexpr std::string_view kDirections = "<>*~=";  // all except events
constexpr std::int64_t kNanoseconds = 1'000'000'000;
constexpr std::uint32_t kExtendedId = 0x80000000;  // CAN_EFF_FLAG
constexpr std::uint32_t kRemote = 0x40000000;      // CAN_RTR_FLAG
constexpr std::size_t kShortId = 3;                // digits of a standard CAN identifier
constexpr std::uint32_t kErrorFrame = 0x20000000;  // CAN_ERR_FLAG
constexpr std::size_t kCanBytes = 8;
constexpr std::size_t kCanFdBytes = 64;
constexpr std::size_t kInterfaceMax = 15;  // characters, IFNAMSIZ - 1
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

void append_time(std::string& text, Duration time) {
  std::array<char, 32> digits{};
  const std::int64_t count = std::max<std::int64_t>(0, time.count());
  const auto whole =
      std::to_chars(digits.data(), digits.data() + digits.size(), count / kNanoseconds);
  text.append(digits.data(), whole.ptr);
  text += '.';
  std::int64_t scale = kNanoseconds / 10;
  for (std::int64_t rest = count % kNanoseconds; scale > 0; rest %= scale, scale /= 10)
    text += kDigits[static_cast<std::size_t>(rest / scale)];
}

void append_id(std::string& text, std::uint32_t id) {
  for (int shift = 28; shift >= 0; shift -= 4) text += kDigits[id >> shift & 0xF];
}

Error malformed(std::string_view line, std::string_view why) {
  constexpr std::size_t kShown = 40;
  return {Errc::kMalformed, std::string(why) + ": " +
                                tims::base::printable(line.substr(0, kShown)) +
                                (line.size() > kShown ? "..." : "")};
}

std::string_view next_field(std::string_view& line) {
  const std::size_t begin = std::min(line.find_first_not_of(" \t"), line.size());
  line.remove_prefix(begin);
  const std::string_view field = line.substr(0, line.find_first_of(" \t"));
  line.remove_prefix(field.size());
  return field;
}

// Parses seconds such as "12.345" exactly, with any number of digits.
std::optional<Duration> parse_time(std::string_view text) {
  const std::size_t point = text.find('.');
  const auto whole = tims::base::parse_number<std::int64_t>(text.substr(0, point));
  if (!whole || *whole < 0 || *whole > INT64_MAX / kNanoseconds - 1) return std::nullopt;
  std::int64_t fraction = 0;
  std::int64_t scale = kNanoseconds / 10;
  if (point == std::string_view::npos) return Duration(*whole * kNanoseconds);
  for (const char c : text.substr(point + 1)) {
    if (c < '0' || c > '9') return std::nullopt;
    fraction += (c - '0') * scale;
    scale /= 10;
  }
  return Duration(*whole * kNanoseconds + fraction);
}

// Values of hex digits by character code; other characters have this bit set.
constexpr unsigned kNoDigit = 0x10;
constexpr std::array<std::uint8_t, 256> kDigitOf = [] {
  std::array<std::uint8_t, 256> digits{};
  digits.fill(kNoDigit);
  for (std::size_t i = 0; i < kDigits.size(); ++i) {
    const auto upper = static_cast<unsigned char>(kDigits[i]);
    digits[upper] = static_cast<std::uint8_t>(i);
    if (upper >= 'A') digits[upper - 'A' + 'a'] = static_cast<std::uint8_t>(i);
  }
  return digits;
}();

bool parse_bytes(std::string_view text, std::vector<std::byte>& bytes) {
  bytes.clear();
  if (text.size() % 2 != 0) return false;
  bytes.resize(text.size() / 2);
  unsigned seen = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const unsigned high = kDigitOf[static_cast<unsigned char>(text[2 * i])];
    const unsigned low = kDigitOf[static_cast<unsigned char>(text[2 * i + 1])];
    seen |= high | low;
    bytes[i] = static_cast<std::byte>(high << 4 | low);
  }
  return (seen & kNoDigit) == 0;
}

// Parses a frame of a capture: "00000181#3701", with all flags in the identifier.
bool parse_frame(std::string_view text, CaptureRecord& record) {
  const std::size_t mark = text.find('#');
  const auto id = tims::base::parse_number<std::uint32_t>(text.substr(0, mark), 16);
  if (!id) return false;
  record.id = *id;
  return parse_bytes(text.substr(mark + 1), record.bytes);
}

// Parses a frame of a candump log: "181#3701", "18DAF110#R", "181##13701" (CAN FD: a digit with
// flags before the bytes). Eight digits are an extended identifier, or an error.
bool parse_candump_frame(std::string_view text, CaptureRecord& record) {
  const std::size_t mark = text.find('#');
  const auto id = tims::base::parse_number<std::uint32_t>(text.substr(0, mark), 16);
  if (!id) return false;
  std::string_view data = text.substr(mark + 1);
  record.id = *id;
  record.frame = FrameKind::kData;
  if (mark > kShortId) {
    const bool is_error = (*id & kErrorFrame) != 0;
    record.id |= is_error ? 0 : kExtendedId;
    if (is_error) record.frame = FrameKind::kError;
  }
  if (data.starts_with('R')) {
    record.id |= kRemote;
    data = {};
  }
  if (data.starts_with('#')) {
    constexpr std::size_t kMarkAndFlags = 2;
    if (data.size() < kMarkAndFlags) return false;
    record.frame = FrameKind::kFd;
    data.remove_prefix(kMarkAndFlags);
  }
  const std::size_t most = record.frame == FrameKind::kFd ? kCanFdBytes : kCanBytes;
  return parse_bytes(data, record.bytes) && record.bytes.size() <= most;
}

Result<bool> parse_candump(std::string_view line, CaptureRecord& record) {
  const std::string_view whole = line;
  std::string_view time = next_field(line);
  const std::string_view interface = next_field(line);
  const std::string_view frame = next_field(line);
  const bool in_brackets = time.size() > 2 && time.ends_with(')');
  const auto stamp =
      in_brackets ? parse_time(time.substr(1, time.size() - 2)) : std::optional<Duration>();
  if (!stamp || interface.empty() || interface.size() > kInterfaceMax ||
      frame.find('#') == std::string_view::npos || !parse_candump_frame(frame, record))
    return malformed(whole, "not a line of candump");
  record.time = *stamp;
  record.took = {};
  record.direction = next_field(line) == "T" ? Direction::kSent : Direction::kReceived;
  record.bus = interface;
  return true;
}

std::string_view next_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return line;
}

// Whether the first lines after comments are records. The first one may be incomplete at its
// beginning (the end of a long recording), and the last one at its end.
bool begins_with_record(std::string_view text) {
  std::size_t good = 0;
  std::size_t bad = 0;
  while (!text.empty() && bad < 2) {
    const bool is_whole = text.find('\n') != std::string_view::npos;
    std::string_view line = next_line(text);
    CaptureRecord record;
    auto parsed = parse_record(line, record);
    if (!is_whole && !parsed && !line.empty()) {
      line.remove_suffix(1);  // half of a pair of hex digits
      parsed = parse_record(line, record);
    }
    if (parsed && !*parsed) continue;
    if (parsed && bad == 0) return true;
    ++(parsed ? good : bad);
    if (good > 1) return true;
  }
  return false;
}

// "  can0  181   [8]  00 00 ...", optionally after a time in parentheses.
bool begins_with_candump_view(std::string_view text) {
  std::string_view line = next_line(text);
  std::string_view field = next_field(line);
  if (field.starts_with('(')) field = next_field(line);
  const std::string_view id = next_field(line);
  std::string_view count = next_field(line);
  const bool is_direction = count == "RX" || count == "TX";
  if (is_direction) count = next_field(line);
  return !field.empty() && tims::base::parse_number<std::uint32_t>(id, 16) && count.size() >= 3 &&
         count.front() == '[' && count.back() == ']';
}

bool is_hex_text(std::string_view text) {
  constexpr std::size_t kLeast = 16;
  std::size_t digits = 0;
  for (const char c : text) {
    if (kDigitOf[static_cast<unsigned char>(c)] != kNoDigit)
      ++digits;
    else if (c != ' ' && c != '\n' && c != '\r' && c != '\t')
      return false;
  }
  return digits >= kLeast;
}

}  // namespace

std::string capture_header(std::string_view device, std::string_view date) {
  std::string line(kMagic);
  line += ' ';
  line += tims::base::printable(device);
  line += ' ';
  line += date;
  line += '\n';
  return line;
}

void append_record(std::string& text, Duration time, Direction direction, std::uint32_t id,
                   std::span<const std::byte> bytes, Duration took) {
  append_time(text, time);
  if (took.count() > 0) {
    text += '-';
    append_time(text, took);
  }
  text += ' ';
  text += static_cast<char>(direction);
  text += ' ';
  if (id != 0) {
    append_id(text, id);
    text += '#';
  }
  for (const std::byte byte : bytes) {
    text += kDigits[std::to_integer<unsigned>(byte) >> 4];
    text += kDigits[std::to_integer<unsigned>(byte) & 0xF];
  }
  text += '\n';
}

void append_event(std::string& text, Duration time, std::string_view event) {
  append_time(text, time);
  text += " ! ";
  text += tims::base::printable(event);
  text += '\n';
}

RecordingFormat format_of(std::span<const std::byte> beginning) {
  constexpr std::array<std::uint32_t, 5> kPcap = {0xA1B2C3D4, 0xD4C3B2A1, 0xA1B23C4D, 0x4D3CB2A1,
                                                  0x0A0D0D0A};
  std::uint32_t magic = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(4, beginning.size()); ++i)
    magic = magic << 8 | std::to_integer<std::uint32_t>(beginning[i]);
  if (std::ranges::find(kPcap, magic) != kPcap.end()) return RecordingFormat::kPcap;

  std::string_view text(reinterpret_cast<const char*>(beginning.data()), beginning.size());
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  if (text.starts_with(kMagic) || begins_with_record(text)) return RecordingFormat::kCapture;
  if (begins_with_candump_view(text)) return RecordingFormat::kCandumpView;
  return is_hex_text(text) ? RecordingFormat::kHexText : RecordingFormat::kRaw;
}

Result<bool> parse_record(std::string_view line, CaptureRecord& record) {
  if (line.ends_with('\r')) line.remove_suffix(1);
  if (line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
  if (line.empty() || line.front() == '#') return false;
  if (line.front() == '(') return parse_candump(line, record);

  const std::string_view whole = line;
  const std::string_view times = next_field(line);
  const std::size_t mark = times.find('-');
  const auto time = parse_time(times.substr(0, mark));
  const auto took =
      mark == std::string_view::npos ? Duration(0) : parse_time(times.substr(mark + 1));
  if (!time || !took) return malformed(whole, "a line of a recording must begin with seconds");
  record.time = *time;
  record.took = *took;
  record.direction = Direction::kReceived;
  record.id = 0;
  record.event.clear();
  record.frame = FrameKind::kData;
  record.bus.clear();
  std::string_view field = next_field(line);
  if (field == "!") {
    record.direction = Direction::kEvent;
    record.bytes.clear();
    record.event = line.substr(std::min<std::size_t>(1, line.size()));
    return true;
  }
  if (field.size() == 1 && kDirections.find(field.front()) != std::string_view::npos) {
    record.direction = static_cast<Direction>(field.front());
    field = next_field(line);
  }
  const bool has_id = field.find('#') != std::string_view::npos;
  const bool good = has_id ? parse_frame(field, record) : parse_bytes(field, record.bytes);
  if (!good || !next_field(line).empty())
    return malformed(whole, "bytes must be pairs of hex digits");
  return true;
}

}  // namespace rack::device
