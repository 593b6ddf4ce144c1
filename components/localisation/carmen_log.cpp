#include "components/localisation/carmen_log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "base/text.h"
#include "components/localisation/ros_map.h"

namespace rack::localisation {

void OdometryHistory::add(double time, const Pose& pose) {
  if (!samples_.empty() && time <= samples_.back().time) return;
  samples_.push_back({time, pose});
}

Pose OdometryHistory::at(double time) const {
  const auto after = std::ranges::upper_bound(samples_, time, {}, &Sample::time);
  if (after == samples_.begin()) return samples_.front().pose;
  const auto before = after - 1;
  if (after == samples_.end()) return before->pose;
  return between(before->pose, after->pose, (time - before->time) / (after->time - before->time));
}

namespace {

constexpr double kNearest = 0.02;  // m: anything nearer is the scanner itself

}  // namespace

void CarmenLog::beams(const LogScan& scan, std::vector<BeamEnd>& ends) const {
  ends.clear();
  for (std::size_t i = 0; i < scan.count; ++i) {
    const auto range = static_cast<double>(ranges[scan.begin + i]);
    if (range <= kNearest || range >= range_max) continue;
    const double angle = scan.laser.rho + scan.first + scan.step * static_cast<double>(i);
    ends.push_back({static_cast<float>(scan.laser.x + 1000 * range * std::cos(angle)),
                    static_cast<float>(scan.laser.y + 1000 * range * std::sin(angle))});
  }
}

Pose CarmenLog::odometry_of(const LogScan& scan, double lag) const {
  return lag == 0 || odometry.empty() ? scan.odometry : odometry.at(scan.time - lag);
}

namespace {

constexpr std::string_view kCarmenLogBlank = " \t\r";
constexpr std::size_t kBeamsMax = 10000;
constexpr double kCarmenLogFarthest = 1e6;  // m

// Reads the fields of a line one by one and remembers the first that is missing or not a number.
class Fields {
 public:
  explicit Fields(std::string_view line) : left_(line) {}

  std::string_view next() {
    const auto first = left_.find_first_not_of(kCarmenLogBlank);
    left_.remove_prefix(std::min(first, left_.size()));
    const std::string_view found = left_.substr(0, left_.find_first_of(kCarmenLogBlank));
    left_.remove_prefix(found.size());
    return found;
  }
  double number(std::string_view what) {
    const std::string_view text = next();
    const auto value = tims::base::parse_number<double>(text);
    if (value && std::isfinite(*value)) return *value;
    if (wrong_.empty())
      wrong_ = std::string(what) +
               (text.empty() ? ": the line ends before it"
                             : ": \"" + std::string(text.substr(0, 20)) + "\" is not a number");
    return 0;
  }
  std::size_t count(std::string_view what) {
    const double value = number(what);
    if (wrong_.empty() && (value < 0 || value > kBeamsMax || value != std::floor(value)))
      wrong_ = std::string(what) + ": not 0 to " + std::to_string(kBeamsMax);
    return wrong_.empty() ? static_cast<std::size_t>(value) : 0;
  }
  Pose pose(std::string_view what) {
    const double x = number(what);
    const double y = number(what);
    const double theta = number(what);
    if (wrong_.empty() && (std::abs(x) > kCarmenLogFarthest || std::abs(y) > kCarmenLogFarthest))
      wrong_ = std::string(what) + ": more than 1000 km away";
    return pose_of_ros(x, y, theta);
  }
  [[nodiscard]] const std::string& wrong() const { return wrong_; }
  [[nodiscard]] bool well() const { return wrong_.empty(); }

 private:
  std::string_view left_;
  std::string wrong_;
};

class Reader {
 public:
  explicit Reader(double field) : field_(field) {}

  // A last line without a line end. Even if it can be read, its time may have lost digits.
  void take_unended(std::string_view line, std::size_t number) {
    const std::size_t scans = log_.scans.size();
    const std::size_t ranges = log_.ranges.size();
    const bool malformed = !take(line).empty();
    const bool goes_back = log_.scans.size() > scans && scans > 0 &&
                           log_.scans.back().logger_time < log_.scans[scans - 1].logger_time;
    if (!malformed && !goes_back) return;
    log_.scans.resize(scans);
    log_.ranges.resize(ranges);
    log_.cut_line = number;
  }

  // Empty, or the reason why the line is malformed.
  std::string take(std::string_view line) {
    Fields fields(line);
    const std::string_view type = fields.next();
    if (type == "ODOM") odometry(fields);
    if (type == "FLASER") front_laser(fields);
    if (type == "ROBOTLASER1") robot_laser(fields, true);
    if (type == "RAWLASER1") robot_laser(fields, false);
    return fields.wrong();
  }

  tims::Result<CarmenLog> end() {
    if (log_.scans.empty())
      return tims::Error(tims::Errc::kMalformed,
                         "no FLASER, ROBOTLASER1 or RAWLASER1: not a CARMEN log?");
    if (log_.odometry.empty() && has_raw_)
      return tims::Error(tims::Errc::kMalformed,
                         "RAWLASER1 without ODOM: the motion of the robot is unknown");
    if (has_raw_)
      for (LogScan& scan : log_.scans)
        if (scan.is_raw) scan.odometry = log_.odometry.at(scan.time);
    if (log_.odometry.empty())
      for (const LogScan& scan : log_.scans) log_.odometry.add(scan.time, scan.odometry);
    // Scanners report their maximum range where a beam hits nothing.
    const float longest = log_.ranges.empty() ? 0 : *std::ranges::max_element(log_.ranges);
    const double seen = 0.985 * static_cast<double>(longest);
    log_.range_max = stated_max_ > 0 ? std::min(0.985 * stated_max_, seen) : std::min(40.0, seen);
    return std::move(log_);
  }

 private:
  void odometry(Fields& fields) {
    const Pose pose = fields.pose("pose");
    for (const auto* speed : {"tv", "rv", "accel"}) fields.number(speed);
    const double time = fields.number("ipc time");
    fields.next();
    fields.number("logger time");
    if (fields.well()) log_.odometry.add(time, pose);
  }

  void ranges(Fields& fields, LogScan& scan) {
    scan.begin = log_.ranges.size();
    for (std::size_t i = 0; i < scan.count && fields.well(); ++i)
      log_.ranges.push_back(static_cast<float>(fields.number("range")));
  }

  void poses_and_times(Fields& fields, LogScan& scan) {
    const Pose laser = fields.pose("pose of the laser");
    scan.odometry = fields.pose("pose of the robot");
    scan.laser = laser - scan.odometry;
  }

  void add(Fields& fields, LogScan& scan) {
    scan.time = fields.number("ipc time");
    fields.next();
    scan.logger_time = fields.number("logger time");
    if (fields.well()) log_.scans.push_back(scan);
  }

  void front_laser(Fields& fields) {
    LogScan scan{.count = fields.count("number of ranges")};
    // Scans of 180 and 360 beams end one step before the left limit, scans of 181 and 361 at it.
    const double steps = static_cast<double>(scan.count - scan.count % 2);
    const double field = radians(field_ > 0 ? field_ : usual_field(scan.count));
    scan.first = field / 2;
    scan.step = scan.count < 2 ? 0 : -field / steps;
    ranges(fields, scan);
    poses_and_times(fields, scan);
    add(fields, scan);
  }

  void robot_laser(Fields& fields, bool has_poses) {
    fields.number("type");
    LogScan scan{.is_raw = !has_poses};
    scan.first = -fields.number("start angle");
    fields.number("field of view");
    scan.step = -fields.number("resolution");
    stated_max_ = std::max(stated_max_, fields.number("range_max"));
    for (const auto* unused : {"accuracy", "remission mode"}) fields.number(unused);
    scan.count = fields.count("number of ranges");
    ranges(fields, scan);
    const std::size_t remissions = fields.count("number of remissions");
    for (std::size_t i = 0; i < remissions && fields.well(); ++i) fields.number("remission");
    has_raw_ = has_raw_ || !has_poses;
    if (!has_poses) return add(fields, scan);
    poses_and_times(fields, scan);
    for (const auto* unused : {"tv", "rv", "forward safety", "side safety", "turn axis"})
      fields.number(unused);
    add(fields, scan);
  }

  // FLASER lines do not contain the field of view; it follows from the number of beams.
  static double usual_field(std::size_t count) {
    switch (count) {
      case 271:
      case 541:
      case 811:
      case 1081:
        return 270;
      case 101:
      case 201:
      case 401:
        return 100;
      default:
        return 180;
    }
  }

  double field_;  // deg; 0: derived from the number of beams
  double stated_max_ = 0;
  bool has_raw_ = false;
  CarmenLog log_;
};

}  // namespace

tims::Result<CarmenLog> read_carmen(std::string_view text, double field) {
  Reader reader(field);
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = text.find('\n');
    if (end == std::string_view::npos) {
      reader.take_unended(text, number);
      break;
    }
    const std::string wrong = reader.take(text.substr(0, end));
    if (!wrong.empty())
      return tims::Error(tims::Errc::kMalformed, "line " + std::to_string(number) + ": " + wrong);
    text.remove_prefix(end + 1);
  }
  return reader.end();
}

namespace {

constexpr int kLagSteps = 30;
constexpr double kLagStep = 0.01;          // s
constexpr double kTurnLeast = radians(2);  // between two scans; less is not significant
constexpr double kTurnMost = radians(25);
constexpr double kOffMax = radians(5);  // more means slip or a different view
constexpr double kMisfitMax = 0.5;      // m
constexpr std::size_t kPairsMax = 3000;
constexpr std::size_t kPairsLeast = 30;
constexpr double kBetter = 0.9;  // factor, compared to no lag

// Rotation of the robot between two scans, by matching one against the other.
class TurnBetween {
 public:
  explicit TurnBetween(const CarmenLog& log) : log_(log) {}

  // Nothing: the views differ, or the robot hardly turned.
  std::optional<double> operator()(const LogScan& a, const LogScan& b) {
    if (a.count != b.count || a.step != b.step || a.step == 0 || a.count < 90) return std::nullopt;
    const auto most = static_cast<std::ptrdiff_t>(std::abs(kTurnMost / a.step));
    misfits_.clear();
    for (std::ptrdiff_t shift = -most; shift <= most; ++shift)
      misfits_.push_back(misfit(a, b, shift));
    const auto best = std::ranges::min_element(misfits_) - misfits_.begin();
    if (best == 0 || best == 2 * most) return std::nullopt;
    // Minimum of the parabola through the best lag and its neighbours.
    const auto at = static_cast<std::size_t>(best);
    const double left = misfits_[at - 1];
    const double right = misfits_[at + 1];
    const double bow = left - 2 * misfits_[at] + right;
    const double part = bow > 0 ? (left - right) / (2 * bow) : 0;
    const double turn = (static_cast<double>(best - most) + part) * a.step;
    if (std::abs(turn) < kTurnLeast) return std::nullopt;
    return turn;
  }

 private:
  [[nodiscard]] double misfit(const LogScan& a, const LogScan& b, std::ptrdiff_t shift) const {
    double all = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < b.count; ++i) {
      const auto j = static_cast<std::ptrdiff_t>(i) + shift;
      if (j < 0 || j >= static_cast<std::ptrdiff_t>(a.count)) continue;
      const auto one = static_cast<double>(log_.ranges[a.begin + static_cast<std::size_t>(j)]);
      const auto other = static_cast<double>(log_.ranges[b.begin + i]);
      if (one >= log_.range_max || other >= log_.range_max) continue;
      all += std::min(std::abs(one - other), kMisfitMax);
      ++count;
    }
    return count > b.count / 2 ? all / static_cast<double>(count) : kMisfitMax;
  }

  const CarmenLog& log_;
  std::vector<double> misfits_;
};

}  // namespace

double estimate_lag(const CarmenLog& log) {
  struct Pair {
    std::size_t first;
    double turn;
  };
  std::vector<Pair> pairs;
  TurnBetween turn_between(log);
  for (std::size_t i = 0; i + 1 < log.scans.size() && pairs.size() < kPairsMax; ++i)
    if (const auto turn = turn_between(log.scans[i], log.scans[i + 1])) pairs.push_back({i, *turn});
  if (pairs.size() < kPairsLeast) return 0;
  const auto off = [&](double lag) {
    double all = 0;
    for (const Pair& pair : pairs) {
      const Pose from = log.odometry_of(log.scans[pair.first], lag);
      const Pose to = log.odometry_of(log.scans[pair.first + 1], lag);
      all += std::min(std::abs(signed_angle(to.rho - from.rho - pair.turn)), kOffMax);
    }
    return all / static_cast<double>(pairs.size());
  };
  const double without = off(0);
  double least = without;
  double best = 0;
  for (int step = 1; step <= kLagSteps; ++step) {
    const double lag = step * kLagStep;
    const double now = off(lag);
    if (now >= least) continue;
    least = now;
    best = lag;
  }
  return least < kBetter * without ? best : 0;
}

}  // namespace rack::localisation
