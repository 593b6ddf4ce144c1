#include "components/mapping/drive.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/text.h"
#include "rack/proxies/scan2d.h"

namespace rack::mapping {

namespace {

constexpr double kFarthest = 1e8;       // mm
constexpr double kOdometryGap = 1;      // s: in longer gaps the pose is unknown
constexpr std::size_t kFieldsMax = 16;  // fields of a line
constexpr i32 kDynamic = 3;

tims::Error wrong(std::string_view file, std::size_t line, const std::string& what) {
  return {tims::Errc::kMalformed,
          std::string(file) + ", line " + std::to_string(line) + ": " + what};
}

struct Line {
  std::array<double, kFieldsMax> values{};
  std::size_t count = 0;
};

// Reads lines of numbers; skips comments and empty lines.
class Table {
 public:
  Table(std::string_view text, std::string_view file, std::size_t fields_least)
      : left_(text), file_(file), fields_least_(fields_least) {}

  // False at the end.
  tims::Result<bool> next(Line& line) {
    while (!left_.empty()) {
      ++number_;
      const auto end = left_.find('\n');
      const std::string_view text = left_.substr(0, end);
      if (end == std::string_view::npos) {  // its last number may have lost digits
        left_ = {};
        if (is_data(text)) cut_ = number_;
        return false;
      }
      left_.remove_prefix(end + 1);
      if (auto taken = take(text, line); !taken) return taken.error();
      if (line.count == 0) continue;
      if (line.count < fields_least_)
        return wrong(file_, number_,
                     std::to_string(line.count) + " numbers, at least " +
                         std::to_string(fields_least_) + " expected: the wrong file?");
      return true;
    }
    return false;
  }
  [[nodiscard]] std::size_t number() const { return number_; }
  // Adds a remark about a last line without its end: it was being written when the recorder ended,
  // and is left out.
  void remark(std::vector<std::string>& remarks) const {
    if (cut_ > 0)
      remarks.push_back(std::string(file_) + ", line " + std::to_string(cut_) +
                        ": incomplete, left out");
  }

 private:
  static bool is_data(std::string_view text) {
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r"), text.size()));
    return !text.empty() && !text.starts_with('%') && !text.starts_with('#');
  }

  // Fields beyond kFieldsMax are ignored.
  [[nodiscard]] tims::Result<void> take(std::string_view text, Line& line) const {
    constexpr std::string_view kBlank = " \t\r";
    line.count = 0;
    for (;;) {
      text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
      if (text.empty() || text.starts_with('%') || text.starts_with('#')) return {};
      if (line.count == kFieldsMax) return {};
      const std::string_view field = text.substr(0, text.find_first_of(kBlank));
      text.remove_prefix(field.size());
      const auto value = tims::base::parse_number<double>(field);
      if (!value || !std::isfinite(*value))
        return wrong(file_, number_,
                     "\"" + std::string(field.substr(0, 20)) + "\" is not a number");
      line.values[line.count++] = *value;
    }
  }

  std::string_view left_;
  std::string_view file_;
  std::size_t fields_least_;
  std::size_t number_ = 0;
  std::size_t cut_ = 0;
};

bool is_far(double mm) { return std::abs(mm) > kFarthest; }

struct Odometry {
  localisation::OdometryHistory history{};
  std::vector<double> times{};  // s

  [[nodiscard]] bool knows(double time) const {
    const auto after = std::ranges::lower_bound(times, time);
    const bool soon = after != times.end() && *after - time <= kOdometryGap;
    const bool before = after != times.begin() && time - *(after - 1) <= kOdometryGap;
    return soon || before;
  }
};

// Columns: recordingTime x y z phi psi rho. Files of Position have more columns behind them.
tims::Result<Odometry> read_odometry(std::string_view text, std::vector<std::string>& remarks) {
  Odometry odometry;
  Table table(text, "odometry", 7);
  Line line;
  for (;;) {
    const auto more = table.next(line);
    if (!more) return more.error();
    if (!*more) break;
    const auto& v = line.values;
    if (is_far(v[1]) || is_far(v[2]) || is_far(v[6]))
      return wrong("odometry", table.number(), "a pose more than 100 km away");
    const double time = v[0] / 1000;
    if (!odometry.times.empty() && time <= odometry.times.back()) continue;
    odometry.history.add(time, {.x = v[1], .y = v[2], .rho = heading(v[6])});
    odometry.times.push_back(time);
  }
  table.remark(remarks);
  if (odometry.times.empty())
    return tims::Error(tims::Errc::kMalformed, "odometry: no line with a pose");
  return odometry;
}

// Columns: x y z type segment intensity, one point per line; z is the range.
tims::Result<void> read_points(std::string_view text, const std::string& file, double range_max,
                               std::vector<BeamEnd>& ends) {
  constexpr i32 kUseless = scan_point::kInvalid | scan_point::kMaxRange;
  Table table(text, file, 4);
  Line line;
  for (;;) {
    const auto more = table.next(line);
    if (!more) return more.error();
    if (!*more) return {};
    const auto& v = line.values;
    if (is_far(v[0]) || is_far(v[1]) || is_far(v[3])) continue;
    const auto type = static_cast<i32>(v[3]);
    if ((type & kUseless) != 0 || (type & scan_point::kClassMask) == kDynamic) continue;
    if (v[2] <= 0 || (range_max > 0 && v[2] >= range_max)) continue;
    ends.push_back({static_cast<float>(v[0]), static_cast<float>(v[1])});
  }
}

// The pose of the scanner is not recorded; all beams start at the reference point of the robot.
void add_scan(Drive& drive, double time, const Pose& odometry, std::size_t row, std::size_t begin) {
  drive.scans.push_back({.time = time,
                         .odometry = odometry,
                         .row = row,
                         .begin = begin,
                         .count = drive.ends.size() - begin});
}

}  // namespace

Drive drive_of(const localisation::CarmenLog& log, double lag) {
  Drive drive;
  if (log.cut_line > 0)
    drive.remarks.push_back("line " + std::to_string(log.cut_line) + ": incomplete, left out");
  std::vector<BeamEnd> ends;
  for (std::size_t row = 0; row < log.scans.size(); ++row) {
    const localisation::LogScan& scan = log.scans[row];
    log.beams(scan, ends);
    const std::size_t begin = drive.ends.size();
    for (const BeamEnd& end : ends)
      if (std::isfinite(end.x) && std::isfinite(end.y)) drive.ends.push_back(end);
    add_scan(drive, scan.logger_time, log.odometry_of(scan, lag), row, begin);
    drive.scans.back().scanner = scan.laser;
  }
  return drive;
}

// recordingTime duration maxRange sectorNum sectorIndex refPos (6) pointNum fileNum
tims::Result<Drive> read_recording(std::string_view odometry_text, std::string_view scans,
                                   const ScanFile& scan_file) {
  Drive drive;
  const auto odometry = read_odometry(odometry_text, drive.remarks);
  if (!odometry) return odometry.error();
  Table table(scans, "scans", 13);
  Line line;
  for (std::size_t row = 0;; ++row) {
    const auto more = table.next(line);
    if (!more) return more.error();
    if (!*more) break;
    const auto& v = line.values;
    const double time = v[0] / 1000;
    if (v[12] < 1 || v[12] > 1e9 || v[12] != std::floor(v[12]))
      return wrong("scans", table.number(), "its last number is not the number of a file");
    if (!odometry->knows(time)) {
      ++drive.left_out;
      continue;
    }
    const auto number = static_cast<std::size_t>(v[12]);
    const auto text = scan_file(number);
    if (!text) return text.error();
    const std::size_t begin = drive.ends.size();
    const std::string name = "scan " + std::to_string(number);
    if (auto read = read_points(*text, name, v[2], drive.ends); !read) return read.error();
    add_scan(drive, time, odometry->history.at(time), row, begin);
  }
  table.remark(drive.remarks);
  if (drive.scans.empty())
    return tims::Error(tims::Errc::kMalformed,
                       drive.left_out > 0 ? "no scan has odometry within a second of it: were "
                                            "the two recorded together?"
                                          : "scans: no line with a scan");
  return drive;
}

}  // namespace rack::mapping
