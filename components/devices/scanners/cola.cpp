#include "components/devices/scanners/cola.h"

#include <array>
#include <cstdlib>

#include "base/text.h"

namespace rack::device {
namespace {

constexpr std::byte kColaStart{0x02};
constexpr std::byte kColaEnd{0x03};
constexpr std::byte kBlank{' '};
constexpr std::byte kFirstLetter{'s'};
constexpr std::size_t kStarts = 4;  // start bytes of a binary telegram
constexpr std::size_t kColaHead = 8;
constexpr std::size_t kKind = 3;

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::byte check_byte(std::span<const std::byte> body) {
  auto check = std::byte{0};
  for (const std::byte byte : body) check ^= byte;
  return check;
}

constexpr std::uint8_t kNoDigit = 0xFF;
constexpr std::array<std::uint8_t, 256> digit_table() {
  std::array<std::uint8_t, 256> table{};
  table.fill(kNoDigit);
  for (std::uint8_t i = 0; i < 10; ++i) table[std::size_t{'0'} + i] = i;
  for (std::uint8_t i = 0; i < 6; ++i)
    table[std::size_t{'A'} + i] = table[std::size_t{'a'} + i] = static_cast<std::uint8_t>(10 + i);
  return table;
}
constexpr std::array<std::uint8_t, 256> kDigits = digit_table();

}  // namespace

void ColaTelegrams::clear() {
  buffer_.clear();
  used_ = searched_ = 0;
}

// Skips noise byte by byte.
bool ColaTelegrams::next(ColaTelegram& telegram) {
  buffer_.consume(std::exchange(used_, 0));
  while (buffer_.size() > 0) {
    const auto bytes = buffer_.bytes();
    if (bytes.front() != kColaStart) {
      const void* const start =
          std::memchr(bytes.data(), std::to_integer<int>(kColaStart), bytes.size());
      buffer_.consume(start == nullptr ? bytes.size()
                                       : static_cast<std::size_t>(
                                             static_cast<const std::byte*>(start) - bytes.data()));
      continue;
    }
    if (bytes.size() < 2) return false;
    const Found found = bytes[1] == kColaStart     ? find_binary(bytes, telegram)
                        : bytes[1] == kFirstLetter ? find_ascii(bytes, telegram)
                                                   : Found::kNothing;
    if (found == Found::kIncomplete) return false;
    searched_ = 0;
    if (found == Found::kTelegram) {
      telegram.arrived = buffer_.time_of(0);
      return true;
    }
    buffer_.consume(1);
  }
  return false;
}

ColaTelegrams::Found ColaTelegrams::find_binary(std::span<const std::byte> bytes,
                                                ColaTelegram& telegram) {
  for (std::size_t i = 2; i < std::min(kStarts, bytes.size()); ++i)
    if (bytes[i] != kColaStart) return Found::kNothing;
  if (bytes.size() < kColaHead) return Found::kIncomplete;
  const std::size_t size = big_endian<std::uint32_t>(bytes, kStarts);
  if (size < kKind || size > kBinaryMax) return Found::kNothing;
  if (bytes.size() > kColaHead && bytes[kColaHead] != kFirstLetter) return Found::kNothing;
  if (bytes.size() < kColaHead + size + 1) return Found::kIncomplete;
  const auto body = bytes.subspan(kColaHead, size);
  if (check_byte(body) != bytes[kColaHead + size]) {
    ++broken_;
    return Found::kNothing;
  }
  telegram = {.dialect = ColaDialect::kBinary, .body = body};
  used_ = kColaHead + size + 1;
  return Found::kTelegram;
}

// A text telegram has no control characters: a truncated one is detected at the next start byte.
ColaTelegrams::Found ColaTelegrams::find_ascii(std::span<const std::byte> bytes,
                                               ColaTelegram& telegram) {
  std::size_t end = std::max<std::size_t>(1, searched_);
  while (end < bytes.size() && bytes[end] >= kBlank) ++end;
  searched_ = end;
  if (end == bytes.size() && end <= kBodyMax) return Found::kIncomplete;
  if (end == bytes.size() || bytes[end] != kColaEnd || end <= kKind) {
    ++broken_;
    return Found::kNothing;
  }
  telegram = {.dialect = ColaDialect::kAscii, .body = bytes.subspan(1, end - 1)};
  used_ = end + 1;
  return Found::kTelegram;
}

void append_cola(std::vector<std::byte>& out, ColaDialect dialect,
                 std::span<const std::byte> body) {
  if (dialect == ColaDialect::kAscii) {
    out.push_back(kColaStart);
    out.insert(out.end(), body.begin(), body.end());
    out.push_back(kColaEnd);
    return;
  }
  out.insert(out.end(), kStarts, kColaStart);
  for (int shift = 24; shift >= 0; shift -= 8)
    out.push_back(static_cast<std::byte>(body.size() >> shift));
  out.insert(out.end(), body.begin(), body.end());
  out.push_back(check_byte(body));
}

ColaReader::ColaReader(ColaDialect dialect, std::span<const std::byte> body)
    : dialect_(dialect), rest_(body) {
  if (!has(kKind)) return;
  kind_ = text_of(rest_.first(kKind));
  rest_ = rest_.subspan(kKind);
  // In CoLa B, the number of an sFA follows without a blank.
  if (rest_.empty() || rest_.front() != kBlank) return;
  rest_ = rest_.subspan(1);
  if (kind_ == "sFA") return;
  name_ = take_token();
}

std::string_view ColaReader::take_token() {
  const void* const blank = std::memchr(rest_.data(), ' ', rest_.size());
  const std::size_t size =
      blank == nullptr
          ? rest_.size()
          : static_cast<std::size_t>(static_cast<const std::byte*>(blank) - rest_.data());
  const std::string_view token = text_of(rest_.first(size));
  rest_ = rest_.subspan(std::min(size + 1, rest_.size()));
  if (token.empty()) good_ = false;
  return token;
}

// Reads a number such as "1F", "+31", "-5".
std::uint32_t ColaReader::take_token_number() {
  const std::string_view token = take_token();
  if (!good_) return 0;
  if (token.front() == '+' || token.front() == '-') {
    const std::string_view digits = token.substr(token.front() == '+' ? 1 : 0);
    const auto number = tims::base::parse_number<std::int32_t>(digits);
    if (!number) good_ = false;
    return static_cast<std::uint32_t>(number.value_or(0));
  }
  std::uint32_t number = 0;
  for (const char c : token) {
    const std::uint8_t digit = kDigits[static_cast<unsigned char>(c)];
    if (digit == kNoDigit) good_ = false;
    number = number << 4 | digit;
  }
  if (token.size() > 8) good_ = false;
  return good_ ? number : 0;
}

std::string_view ColaReader::take_text(std::size_t size) {
  if (dialect_ == ColaDialect::kAscii) return take_token();
  if (!has(size)) return {};
  const std::string_view text = text_of(rest_.first(size));
  rest_ = rest_.subspan(size);
  return text;
}

std::string_view ColaReader::take_string() {
  const std::size_t size = take<std::uint16_t>();
  if (!has(size)) return {};
  const std::string_view text = text_of(rest_.first(size));
  rest_ = rest_.subspan(size);
  // In CoLa A, also skips the blank after the text.
  if (dialect_ == ColaDialect::kAscii && !rest_.empty()) rest_ = rest_.subspan(1);
  return text;
}

bool ColaReader::take_values(std::size_t count, bool is_wide, std::vector<std::uint16_t>& values) {
  values.clear();
  // A value in CoLa A has at least a digit and a blank: a corrupted count cannot allocate more
  // memory than the size of the body allows.
  const std::size_t least = count * (dialect_ == ColaDialect::kAscii || is_wide ? 2 : 1);
  if (dialect_ == ColaDialect::kAscii ? rest_.size() + 1 < least : !has(least)) good_ = false;
  if (!good_) return false;
  values.resize(count);
  if (dialect_ == ColaDialect::kBinary) {
    for (std::size_t i = 0; i < count; ++i)
      values[i] = is_wide ? big_endian<std::uint16_t>(rest_, 2 * i)
                          : std::to_integer<std::uint16_t>(rest_[i]);
    rest_ = rest_.subspan(least);
    return true;
  }
  const std::byte* at = rest_.data();
  const std::byte* const end = at + rest_.size();
  for (std::uint16_t& value : values) {
    unsigned number = 0;
    const std::byte* const begin = at;
    for (; at != end && *at != kBlank; ++at) {
      const unsigned digit = kDigits[std::to_integer<unsigned>(*at)];
      if (digit == kNoDigit) good_ = false;
      number = number << 4 | digit;
    }
    if (at == begin || at - begin > 4 || (!is_wide && number > 0xFF)) good_ = false;
    if (at != end) ++at;
    value = static_cast<std::uint16_t>(number);
  }
  rest_ = rest_.subspan(static_cast<std::size_t>(at - rest_.data()));
  if (!good_) values.clear();
  return good_;
}

ColaWriter& ColaWriter::put_float(float number) {
  const auto bits = std::bit_cast<std::uint32_t>(number);
  if (dialect_ == ColaDialect::kBinary) return put(bits);
  separate();
  for (int shift = 28; shift >= 0; shift -= 4)
    body_.push_back(static_cast<std::byte>("0123456789ABCDEF"[bits >> shift & 0xF]));
  return *this;
}

ColaWriter& ColaWriter::put_text(std::string_view text) {
  separate();
  append(text);
  return *this;
}

ColaWriter& ColaWriter::put_string(std::string_view text) {
  put(static_cast<std::uint16_t>(text.size()));
  if (dialect_ == ColaDialect::kAscii) separate();
  append(text);
  return *this;
}

void ColaWriter::append(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  body_.insert(body_.end(), bytes.begin(), bytes.end());
}

void ColaWriter::append_hex(std::uint32_t number) {
  int shift = 28;
  while (shift > 0 && number >> shift == 0) shift -= 4;
  for (; shift >= 0; shift -= 4)
    body_.push_back(static_cast<std::byte>("0123456789ABCDEF"[number >> shift & 0xF]));
}

void ColaWriter::separate() {
  if (dialect_ == ColaDialect::kAscii || !has_values_) body_.push_back(kBlank);
  has_values_ = true;
}

std::string_view cola_error_text(unsigned number) {
  static constexpr std::array<std::string_view, 26> kTexts = {
      "no error",
      "method requires another user level",
      "unknown method",
      "unknown variable",
      "local condition failed, or value out of range",
      "invalid data",
      "unknown error",
      "buffer too small for the data",
      "data missing",
      "unknown type",
      "variable not writable at this user level",
      "unknown command of the name server",
      "unknown command type",
      "method is busy",
      "array too large",
      "unknown event",
      "value too large",
      "character not allowed in CoLa A",
      "no message of the operating system",
      "no answer of the operating system",
      "internal error",
      "wrong hub address",
      "hub address cannot be decoded",
      "hub address too long",
      "blank missing after the hub address",
      "asynchronous methods are suppressed"};
  return number < kTexts.size() ? kTexts[number] : std::string_view();
}

}  // namespace rack::device
