#include "tools/evaluation/mcl_eval/truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "base/text.h"
#include "components/localisation/ros_map.h"

namespace rack::mcl_eval {

namespace {

using localisation::CarmenLog;
using localisation::LogScan;

constexpr double kSameTime = 0.05;  // s
constexpr std::size_t kFieldsMax = 8;

struct Line {
  std::array<double, kFieldsMax> values{};
  std::size_t count = 0;
};

tims::Error wrong(std::size_t number, const std::string& what) {
  return {tims::Errc::kMalformed, "line " + std::to_string(number) + ": " + what};
}

tims::Result<Line> numbers_of(std::string_view text, std::size_t number) {
  Line line;
  constexpr std::string_view kBlank = " \t\r,";
  for (;;) {
    text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
    if (text.empty() || text.starts_with('#')) return line;
    const std::string_view field = text.substr(0, text.find_first_of(kBlank));
    text.remove_prefix(field.size());
    if (line.count == kFieldsMax) return wrong(number, "more than 8 numbers");
    const auto value = tims::base::parse_number<double>(field);
    if (!value || !std::isfinite(*value))
      return wrong(number, "\"" + std::string(field.substr(0, 20)) + "\" is not a number");
    line.values[line.count++] = *value;
  }
}

// Whether it is a unit quaternion; the angles of relations would hardly have norm 1 in every line.
bool ends_with_quaternion(const Line& line) {
  if (line.count != kFieldsMax) return false;
  double square = 0;
  for (std::size_t i = 4; i < kFieldsMax; ++i) square += line.values[i] * line.values[i];
  return std::abs(square - 1) < 0.02;
}

// Scans sorted by one of their times; in some logs time is not monotonic.
class Times {
 public:
  Times(const CarmenLog& log, double LogScan::*time) {
    for (std::size_t i = 0; i < log.scans.size(); ++i) times_.emplace_back(log.scans[i].*time, i);
    std::ranges::sort(times_);
  }
  [[nodiscard]] std::optional<std::size_t> nearest(double time) const {
    const auto after = std::ranges::lower_bound(times_, time, {}, &Entry::first);
    std::optional<std::size_t> found;
    double least = kSameTime;
    for (auto at = after == times_.begin() ? after : after - 1; at != times_.end() && at <= after;
         ++at) {
      if (std::abs(at->first - time) > least) continue;
      least = std::abs(at->first - time);
      found = at->second;
    }
    return found;
  }

 private:
  using Entry = std::pair<double, std::size_t>;
  std::vector<Entry> times_;
};

class Reader {
 public:
  Reader(const CarmenLog& log, bool has_quaternions)
      : log_(log),
        by_time_(log, &LogScan::time),
        by_logger_(log, &LogScan::logger_time),
        has_quaternions_(has_quaternions) {}

  tims::Result<void> take(const Line& line, std::size_t number) {
    if (fields_ == 0) fields_ = line.count;
    if (fields_ != 4 && fields_ != 5 && fields_ != 8)
      return wrong(number, std::to_string(line.count) +
                               " numbers: neither a pose (4, 5, or 8 with a quaternion) nor a "
                               "relation (8)");
    if (line.count != fields_)
      return wrong(number, std::to_string(line.count) + " numbers, but " + std::to_string(fields_) +
                               " in the lines before");
    const auto& v = line.values;
    if (fields_ == 8 && has_quaternions_) {
      pose(scan_at(v[0]), v[1], v[2],
           std::atan2(2 * (v[7] * v[6] + v[4] * v[5]), 1 - 2 * (v[5] * v[5] + v[6] * v[6])));
    } else if (fields_ == 8) {
      relation(v);
    } else if (fields_ == 4) {
      pose(scan_at(v[0]), v[1], v[2], v[3]);
    } else {
      if (v[1] < 0 || v[1] != std::floor(v[1]))
        return wrong(number, "the second number is not a scan index");
      if (v[1] >= static_cast<double>(log_.scans.size()))
        return wrong(number, "the log has only " + std::to_string(log_.scans.size()) + " scans");
      pose(static_cast<std::size_t>(v[1]), v[2], v[3], v[4]);
    }
    return {};
  }

  tims::Result<Truth> end() {
    if (truth_.poses.empty() && truth_.relations.empty())
      return tims::Error(tims::Errc::kMalformed,
                         truth_.beside > 0
                             ? "no scan of the log has one of its times: does it belong to "
                               "another log?"
                             : "the file contains no poses or relations");
    std::ranges::stable_sort(truth_.poses, {}, &TruePose::scan);
    return std::move(truth_);
  }

 private:
  [[nodiscard]] std::optional<std::size_t> scan_at(double time) const {
    const auto scan = by_logger_.nearest(time);
    return scan ? scan : by_time_.nearest(time);
  }
  void pose(std::optional<std::size_t> scan, double x, double y, double theta) {
    if (!scan) {
      ++truth_.beside;
      return;
    }
    truth_.poses.push_back({*scan, localisation::pose_of_ros(x, y, theta)});
  }
  void relation(const std::array<double, kFieldsMax>& v) {
    const auto from = by_time_.nearest(v[0]);
    const auto to = by_time_.nearest(v[1]);
    if (!from || !to) {
      ++truth_.beside;
      return;
    }
    // In the frame of the robot, y points to the left in the file and to the right here.
    truth_.relations.push_back({*from, *to, {.x = 1000 * v[2], .y = -1000 * v[3], .rho = -v[7]}});
  }

  const CarmenLog& log_;
  Times by_time_;
  Times by_logger_;
  bool has_quaternions_;
  std::size_t fields_ = 0;
  Truth truth_;
};

// The rigid transformation that aligns the trajectory with the true poses.
Pose frame_of(std::span<const Pose> laser, const Truth& truth) {
  Pose is;
  Pose should;
  const auto count = static_cast<double>(truth.poses.size());
  for (const TruePose& pose : truth.poses) {
    is.x += laser[pose.scan].x / count;
    is.y += laser[pose.scan].y / count;
    should.x += pose.laser.x / count;
    should.y += pose.laser.y / count;
  }
  double along = 0;
  double across = 0;
  for (const TruePose& pose : truth.poses) {
    const double ix = laser[pose.scan].x - is.x;
    const double iy = laser[pose.scan].y - is.y;
    const double sx = pose.laser.x - should.x;
    const double sy = pose.laser.y - should.y;
    along += ix * sx + iy * sy;
    across += ix * sy - iy * sx;
  }
  const Pose turn{.rho = std::atan2(across, along)};
  const Pose middle = turn + is;
  return {.x = should.x - middle.x, .y = should.y - middle.y, .rho = turn.rho};
}

}  // namespace

tims::Result<Truth> read_truth(std::string_view text, const CarmenLog& log) {
  struct Numbered {
    Line line;
    std::size_t number;
  };
  std::vector<Numbered> lines;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = text.find('\n');
    const auto line = numbers_of(text.substr(0, end), number);
    if (!line) return line.error();
    if (line->count > 0) lines.push_back({*line, number});
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  const bool has_quaternions = std::ranges::all_of(
      lines, [](const Numbered& numbered) { return ends_with_quaternion(numbered.line); });
  Reader reader(log, has_quaternions);
  for (const auto& [line, number] : lines)
    if (auto taken = reader.take(line, number); !taken) return taken.error();
  return reader.end();
}

TrackError track_error(std::span<const Pose> laser, const Truth& truth) {
  TrackError error;
  const auto add = [&](const Pose& off) {
    error.metres.push_back(std::hypot(off.x, off.y) / 1000);
    error.degrees.push_back(degrees(std::abs(signed_angle(off.rho))));
  };
  if (!truth.poses.empty()) {
    const Pose frame = frame_of(laser, truth);
    for (const TruePose& pose : truth.poses) add((frame + laser[pose.scan]) - pose.laser);
  }
  for (const Relation& relation : truth.relations)
    add((laser[relation.to] - laser[relation.from]) - relation.step);
  return error;
}

}  // namespace rack::mcl_eval
