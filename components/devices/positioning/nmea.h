// NMEA 0183: the protocol of nearly all satellite receivers and of marine instruments.
//
// A sentence is a line "$GPRMC,fields*hh": talker (two letters; GP: GPS, GN: several systems), type
// (three letters), fields, and the XOR of all characters between $ and *. At 4800 baud, the
// sentences of one second take most of a second; current receivers send at 9600 to 115200 baud, up
// to 20 times a second. Fields with unknown values are empty.
//
// Source: IEC 61162-1 as receivers' manuals quote it; recordings of 17 receivers.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "rack/devices/stream_buffer.h"

namespace rack::device {

struct NmeaSentence {
  static constexpr std::size_t kFieldsMax = 32;

  std::string_view talker{};                          // "GP"; "P": proprietary sentence
  std::string_view type{};                            // "RMC"; proprietary: all that follows the P
  std::array<std::string_view, kFieldsMax> fields{};  // valid until the next call
  std::size_t count = 0;
  Time began{};  // when its first byte was on the line

  // The field with this number, counted from 1 as in the standard; empty if it does not exist.
  [[nodiscard]] std::string_view operator[](std::size_t number) const {
    return number - 1 < count ? fields[number - 1] : std::string_view{};
  }
};

// Parses a line without its line end. Returns false if it is not exactly one sentence, or if the
// checksum is wrong or missing. A checksum below 16 may have one digit.
bool parse_nmea(std::string_view line, NmeaSentence& sentence);
// Appends "GPRMC,1,2" as "$GPRMC,1,2*hh" with its line end.
void append_nmea(std::vector<std::byte>& out, std::string_view text);

// --- fields; the result is empty if the field is empty or invalid

std::optional<double> nmea_number(std::string_view field);
// "ddmm.mmmm" and "N", "S", "E" or "W"; rad.
std::optional<double> nmea_angle(std::string_view field, std::string_view side);
// "hhmmss.ss" since midnight; a leap second counts as the first second of the next day.
std::optional<Duration> nmea_time_of_day(std::string_view field);
// "ddmmyy": 1980 to 2079, in days since 1970.
std::optional<int> nmea_date(std::string_view field);
std::optional<int> days_since_1970(int year, unsigned month, unsigned day);

// Splits a stream into sentences. Lines end with CR LF, LF, or CR before the next sentence. If a
// truncated line is directly followed by a sentence, that sentence is recovered.
class NmeaLines {
 public:
  // Maximum size of a piece; call next() until it returns false before adding more.
  static constexpr std::size_t kPieceMax = 1024;

  void add(const Arrival& arrival) { buffer_.add(arrival); }
  // Valid until the next call.
  bool next(NmeaSentence& sentence);
  void clear();

  [[nodiscard]] std::uint64_t sentences() const { return sentences_; }
  // Number of sentences that were recovered after a truncated line.
  [[nodiscard]] std::uint64_t recovered() const { return recovered_; }
  // Number of lines with the start and checksum of a sentence that are invalid.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }
  // Number of sentences that are refused because they have no checksum.
  [[nodiscard]] std::uint64_t without_checksum() const { return without_checksum_; }

 private:
  // Some manufacturers send more than the 82 characters of the standard.
  static constexpr std::size_t kLineMax = 512;

  bool parse_line(std::string_view line, NmeaSentence& sentence);

  StreamBuffer buffer_{8 * kLineMax};
  std::size_t used_ = 0;      // bytes of the line that was returned
  std::size_t searched_ = 0;  // bytes known to contain no line end
  bool is_rest_ = false;      // discarding the rest of a line that was too long
  std::uint64_t sentences_ = 0;
  std::uint64_t recovered_ = 0;
  std::uint64_t broken_ = 0;
  std::uint64_t without_checksum_ = 0;
};

}  // namespace rack::device
