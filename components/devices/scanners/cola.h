// CoLa, the command language of SICK scanners: LMS1xx, LMS5xx, TiM, MRS1000, over TCP (ports 2111
// and 2112).
//
// A body consists of a three-letter command type, a name, and values:
//
//   from the host     sRN reads, sWN writes, sMN calls a method, sEN subscribes to an event
//   from the scanner  sRA, sWA, sAN, sEA answer; sSN is an event; sFA is an error with its number
//
// CoLa A is text: 02, body, 03; values are hexadecimal, or decimal after a sign, separated by
// blanks. CoLa B is binary: 02 02 02 02, length of the body (u32), body, XOR of the body's bytes;
// values are big-endian without padding.
//
// Sources: SICK's "Telegram listing" for ranging sensors; recordings of LMS111, LMS511 and TiM781S.
#pragma once

#include <bit>
#include <string_view>
#include <type_traits>

#include "rack/devices/stream_buffer.h"

namespace rack::device {

enum class ColaDialect : std::uint8_t { kAscii, kBinary };

struct ColaTelegram {
  ColaDialect dialect = ColaDialect::kBinary;
  std::span<const std::byte> body{};  // valid until the next call
  Time arrived{};                     // arrival of its first byte
};

// Splits a stream into telegrams of both dialects; skips noise between them.
class ColaTelegrams {
 public:
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  bool next(ColaTelegram& telegram);
  void clear();

  // Number of telegrams with a wrong check byte, or truncated.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  // Five echoes of 1141 values with remission are 23 kB, or 60 kB as text. The limit should not be
  // larger than necessary, because a corrupted length blocks the stream until so many bytes arrive.
  static constexpr std::size_t kBinaryMax = 1 << 15;
  static constexpr std::size_t kBodyMax = 1 << 16;

  enum class Found : std::uint8_t { kTelegram, kNothing, kIncomplete };

  Found find_binary(std::span<const std::byte> bytes, ColaTelegram& telegram);
  Found find_ascii(std::span<const std::byte> bytes, ColaTelegram& telegram);

  StreamBuffer buffer_{kBodyMax + 16};
  std::uint64_t broken_ = 0;
  std::size_t used_ = 0;      // size of the telegram that was returned
  std::size_t searched_ = 0;  // bytes of an incomplete text already searched
};

// Appends a complete telegram.
void append_cola(std::vector<std::byte>& out, ColaDialect dialect, std::span<const std::byte> body);

// Reads a body value by value. Missing values are read as 0 and make good() false.
class ColaReader {
 public:
  ColaReader(ColaDialect dialect, std::span<const std::byte> body);
  explicit ColaReader(const ColaTelegram& telegram) : ColaReader(telegram.dialect, telegram.body) {}

  [[nodiscard]] std::string_view kind() const { return kind_; }  // "sSN"
  [[nodiscard]] std::string_view name() const { return name_; }  // "LMDscandata"
  [[nodiscard]] bool good() const { return good_; }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }

  template <typename Number>
  Number take() {
    if (dialect_ == ColaDialect::kAscii) return static_cast<Number>(take_token_number());
    if (!has(sizeof(Number))) return 0;
    const Number number = big_endian<Number>(rest_);
    rest_ = rest_.subspan(sizeof(Number));
    return number;
  }
  float take_float() { return std::bit_cast<float>(take<std::uint32_t>()); }
  // Text of a known size: "DIST1".
  std::string_view take_text(std::size_t size);
  // Text preceded by its length (u16).
  std::string_view take_string();
  // Reads `count` values of one or two bytes; returns false and clears `values` if there are fewer.
  bool take_values(std::size_t count, bool is_wide, std::vector<std::uint16_t>& values);

 private:
  bool has(std::size_t bytes) {
    if (rest_.size() < bytes) good_ = false;
    return good_;
  }
  std::string_view take_token();
  std::uint32_t take_token_number();

  ColaDialect dialect_;
  std::span<const std::byte> rest_;
  std::string_view kind_;
  std::string_view name_;
  bool good_ = true;
};

// Writes a body at the end of `body`: first the command, then its values.
class ColaWriter {
 public:
  ColaWriter(ColaDialect dialect, std::vector<std::byte>& body, std::string_view command)
      : dialect_(dialect), body_(body) {
    append(command);
  }

  template <typename Number>
  ColaWriter& put(Number number) {
    using Bits = std::make_unsigned_t<Number>;
    separate();
    if (dialect_ == ColaDialect::kAscii)
      append_hex(static_cast<Bits>(number));
    else
      for (std::size_t i = sizeof(Number); i-- > 0;)
        body_.push_back(static_cast<std::byte>(static_cast<Bits>(number) >> 8 * i));
    return *this;
  }
  ColaWriter& put_float(float number);
  ColaWriter& put_text(std::string_view text);    // ColaReader::take_text
  ColaWriter& put_string(std::string_view text);  // ColaReader::take_string

 private:
  void append(std::string_view text);
  void append_hex(std::uint32_t number);
  // Appends a blank: before every value of CoLa A, before the first value of CoLa B.
  void separate();

  ColaDialect dialect_;
  std::vector<std::byte>& body_;
  bool has_values_ = false;
};

// The meaning of an sFA error number; empty if unknown.
std::string_view cola_error_text(unsigned number);

}  // namespace rack::device
