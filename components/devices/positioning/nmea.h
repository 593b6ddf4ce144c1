// NMEA 0183: what nearly every satellite receiver speaks, and other instruments of ships.
//
// A sentence is a line "$GPRMC,fields*hh": talker (two letters; GP: GPS, GN: several systems), type
// (three letters), fields, and the XOR of all characters between $ and *. At 4800 baud a second's
// sentences take most of the second; receivers of today send at 9600 to 115200, up to 20 times a
// second. Fields may be empty: what is not known is not said.
//
// Source: IEC 61162-1 as receivers' manuals quote it; recordings of 17 receivers.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "components/devices/core/stream_buffer.h"

namespace rack::device {

struct NmeaSentence {
  static constexpr std::size_t kFieldsMax = 32;

  std::string_view talker{};                          // "GP"; "P" of a manufacturer
  std::string_view type{};                            // "RMC"; of a manufacturer all that follows
  std::array<std::string_view, kFieldsMax> fields{};  // valid until the next call
  std::size_t count = 0;
  Time began{};  // its first byte on the line

  // Of the number that the standard counts from 1; empty where there is none.
  [[nodiscard]] std::string_view operator[](std::size_t number) const {
    return number - 1 < count ? fields[number - 1] : std::string_view{};
  }
};

// A line without its end. False: it is not one sentence, or its checksum is wrong or missing.
bool parse_nmea(std::string_view line, NmeaSentence& sentence);
// "GPRMC,1,2" becomes "$GPRMC,1,2*hh" and the end of a line.
void append_nmea(std::vector<std::byte>& out, std::string_view text);

// --- fields. None: empty, or not what it should be

std::optional<double> nmea_number(std::string_view field);
// "ddmm.mmmm" and "N", "S", "E" or "W"; rad.
std::optional<double> nmea_angle(std::string_view field, std::string_view side);
// "hhmmss.ss" since midnight; a leap second is the first second after it.
std::optional<Duration> nmea_time_of_day(std::string_view field);
// "ddmmyy": 1980 to 2079, in days since 1970.
std::optional<int> nmea_date(std::string_view field);
std::optional<int> days_since_1970(int year, unsigned month, unsigned day);

// Sentences out of a stream of lines. A line that was cut, with the next one behind it, still gives
// the next one.
class NmeaLines {
 public:
  // Of what comes at once: next() is to be called until there is none before more is added.
  static constexpr std::size_t kPieceMax = 1024;

  void add(const Arrival& arrival) { buffer_.add(arrival); }
  // Valid until the next call.
  bool next(NmeaSentence& sentence);
  void clear();

  [[nodiscard]] std::uint64_t sentences() const { return sentences_; }
  // Of these, found behind the rest of another one.
  [[nodiscard]] std::uint64_t recovered() const { return recovered_; }
  // Lines that begin like a sentence and have a checksum, and are not one.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  // Some manufacturers send more than the 82 characters of the standard.
  static constexpr std::size_t kLineMax = 512;

  bool parse_line(std::string_view line, NmeaSentence& sentence);

  StreamBuffer buffer_{8 * kLineMax};
  std::size_t used_ = 0;      // of the line that was handed out
  std::size_t searched_ = 0;  // without an end of a line
  bool is_rest_ = false;      // of a line that was too long
  std::uint64_t sentences_ = 0;
  std::uint64_t recovered_ = 0;
  std::uint64_t broken_ = 0;
};

}  // namespace rack::device
