// The language of Hokuyo's range finders, SCIP 1.1 and SCIP 2.0: lines of characters.
//
// A question is a line. The answer is the question again, a line with the status, lines of data,
// and an empty line. In SCIP 2 each line but the question ends with a sum of its characters, and
// data are cut into lines of 64 of them; in SCIP 1 there are no sums. Numbers are characters of six
// bits: distances two of them (up to 4095 mm) or three, time stamps four.
//
//   MD0044072501000     00P     99b        from step 44 to 725, each, all scans
//   G04472503           0                  the same in SCIP 1, three steps together, once
//
// Source: Hokuyo, "Communication Protocol Specification for SCIP2.0 Standard", C-42-03320B; what
// RACK 0.6.1 sends in SCIP 1.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "components/devices/core/stream_buffer.h"
#include "rack/proxies/ladar.h"

namespace rack::device {

// Of all characters, as the character that ends a line.
char scip_sum(std::string_view text);
// Nothing: a character that cannot be in a number.
std::optional<std::uint32_t> scip_number(std::string_view characters);
void append_scip_number(std::string& out, std::uint32_t number, int characters);
// The text, its sum, the end of the line.
void append_scip_line(std::string& out, std::string_view text);

struct ScipAnswer {
  std::string_view question{};
  std::string_view status{};  // two characters, in SCIP 1 one
  std::string_view data{};    // the lines after it, each with its end
  Time began{};

  [[nodiscard]] bool has_sums() const { return status.size() == 2; }
};

// Valid until the next call.
class ScipAnswers {
 public:
  void add(const Arrival& arrival);
  bool next(ScipAnswer& answer);
  void clear();

  // Answers that were none, or whose status did not fit its sum.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  static constexpr std::size_t kLongest = 1 << 17;

  StreamBuffer buffer_{kLongest};
  std::size_t searched_ = 0;  // no end of an answer before it
  std::size_t used_ = 0;      // of the answer that was handed out
  std::uint64_t broken_ = 0;
};

// What a scanner says about itself (PP). The first values are those of the URG-04LX.
struct ScipParameters {
  std::string model{};
  int range_min = 20;  // mm; less is a code, not a distance
  int range_max = 5600;
  int steps_of_turn = 1024;
  int first = 44;
  int last = 725;
  int front = 384;  // the step that looks ahead; they are counted counter-clockwise
  int turns_of_minute = 600;
};
// False: lines are missing or broken.
bool parse_scip_parameters(const ScipAnswer& answer, ScipParameters& parameters);
// The text behind "NAME:" of VV, PP or II; empty: there is none.
std::string_view scip_field(const ScipAnswer& answer, std::string_view name);

// Which steps are measured, as the question says: MD, MS, ME, GD, GS, GE and G.
struct ScipRange {
  int first = 0;
  int last = 0;
  int cluster = 1;     // steps that become one distance, the least of theirs
  int characters = 3;  // of a distance
  bool has_intensities = false;

  [[nodiscard]] std::size_t values() const {
    return static_cast<std::size_t>((last - first) / std::max(1, cluster) + 1);
  }
  bool operator==(const ScipRange&) const = default;
};
std::optional<ScipRange> scip_range(std::string_view question);

// Answers with distances become scans, clockwise.
class ScipScans {
 public:
  ScipScans() { characters_.reserve(kCharactersMax); }

  void set_parameters(const ScipParameters& parameters) { parameters_ = parameters; }
  // Where the first step looks, to the right, rad; nothing: as the parameters say.
  void set_start_angle(std::optional<double> angle) { start_angle_ = angle; }

  // False: it is none, or broken. `counter`: the scanner's time, ms, 24 bits.
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
