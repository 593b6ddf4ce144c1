// The protocol of Hokuyo range finders, SCIP 1.1 and SCIP 2.0: lines of text.
//
// A request is one line. The answer is the request, a line with the status, lines of data, and an
// empty line. In SCIP 2, each line except the request ends with a checksum character, and data are
// split into lines of 64 characters; SCIP 1 has no checksums. Numbers are encoded in characters of
// six bits: distances in two (up to 4095 mm) or three, time stamps in four.
//
//   MD0044072501000     00P     99b        steps 44 to 725, every step, endless scans
//   G04472503           0                  the same in SCIP 1, three steps combined, one scan
//
// Source: Hokuyo, "Communication Protocol Specification for SCIP2.0 Standard", C-42-03320B; for
// SCIP 1, RACK 0.6.1.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "rack/devices/stream_buffer.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

// Checksum of all characters, as a character.
char scip_sum(std::string_view text);
// Decodes a number; empty if a character is invalid.
std::optional<std::uint32_t> scip_number(std::string_view characters);
void append_scip_number(std::string& out, std::uint32_t number, int characters);
// Appends the text, its checksum and the line end.
void append_scip_line(std::string& out, std::string_view text);

struct ScipAnswer {
  std::string_view question{};
  std::string_view status{};  // two characters, in SCIP 1 one
  std::string_view data{};    // the lines after the status, with their line ends
  Time began{};

  [[nodiscard]] bool has_sums() const { return status.size() == 2; }
};

// Valid until the next call.
class ScipAnswers {
 public:
  void add(const Arrival& arrival);
  bool next(ScipAnswer& answer);
  void clear();

  // Number of invalid answers, and of those with a wrong checksum of the status.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  static constexpr std::size_t kLongest = 1 << 17;

  StreamBuffer buffer_{kLongest};
  std::size_t searched_ = 0;  // bytes known to contain no end of an answer
  std::size_t used_ = 0;      // size of the answer that was returned
  std::uint64_t broken_ = 0;
};

// Parameters of a scanner (PP). The initial values are those of the URG-04LX.
struct ScipParameters {
  std::string model{};
  int range_min = 20;  // mm; lower values are codes
  int range_max = 5600;
  int steps_of_turn = 1024;
  int first = 44;
  int last = 725;
  int front = 384;  // step straight ahead; steps are counted counterclockwise
  int turns_of_minute = 600;
};
// Returns false if lines are missing or invalid.
bool parse_scip_parameters(const ScipAnswer& answer, ScipParameters& parameters);
// The text after "NAME:" in an answer to VV, PP or II; empty if there is none.
std::string_view scip_field(const ScipAnswer& answer, std::string_view name);

// The measured steps in a request MD, MS, ME, GD, GS, GE or G.
struct ScipRange {
  int first = 0;
  int last = 0;
  int cluster = 1;     // steps combined into one distance, their minimum
  int characters = 3;  // characters per distance
  bool has_intensities = false;

  [[nodiscard]] std::size_t values() const {
    return static_cast<std::size_t>((last - first) / std::max(1, cluster) + 1);
  }
  bool operator==(const ScipRange&) const = default;
};
std::optional<ScipRange> scip_range(std::string_view question);

// Converts answers with distances to clockwise scans.
class ScipScans {
 public:
  ScipScans() { characters_.reserve(kCharactersMax); }

  void set_parameters(const ScipParameters& parameters) { parameters_ = parameters; }
  // Angle of the first step to the right, rad; empty: according to the parameters.
  void set_start_angle(std::optional<double> angle) { start_angle_ = angle; }

  // Returns false for other or invalid answers. `counter`: time of the scanner, ms, 24 bits.
  bool decode(const ScipAnswer& answer, LadarData& scan, std::uint32_t& counter);

 private:
  static constexpr std::size_t kCharactersMax = 1 << 14;

  bool join(const ScipAnswer& answer, std::uint32_t& counter);
  void fill(const ScipRange& range, LadarData& scan) const;

  ScipParameters parameters_;
  std::optional<double> start_angle_;
  std::string characters_;
};

}  // namespace rack::device
