#include "components/scan3d/sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace rack::scan3d {
namespace {

using std::chrono::milliseconds;

constexpr double kTurnedBack = 0.01;  // rad, against the direction: more than noise
constexpr double kWhole = 0.9;        // share of the span that must be seen
constexpr double kLongest = 1000;     // ms, maximum duration of a flat scan
constexpr std::int64_t kComplete = std::numeric_limits<std::int64_t>::max();  // instead of a cell
constexpr milliseconds kWaitMax{2000};  // for samples after a scan

// The plane of the ladar at angle 0: its forward and right directions in the frame of the axis.
std::pair<Place, Place> plane_of(i32 mode) {
  switch (mode) {
    case scan_mode::kYaw:
      return {{1, 0, 0}, {0, 0, 1}};
    case scan_mode::kTop:
      return {{0, 0, -1}, {1, 0, 0}};
    case scan_mode::kTopDown:
      return {{0, 0, 1}, {-1, 0, 0}};
    default:
      return {{1, 0, 0}, {0, 1, 0}};
  }
}

Frame turned_by(i32 mode, double angle) {
  if (mode == scan_mode::kRoll) return Frame::about_x(angle);
  if (mode == scan_mode::kPitch) return Frame::about_y(angle);
  return Frame::about_z(angle);
}

milliseconds whole_ms(double ms) { return milliseconds(std::llround(ms)); }

}  // namespace

Sweep::Sweep(const SweepSettings& settings)
    : settings_(settings), mounting_(settings.mounting.axis), waiting_(kWaitingMax) {
  const auto [ahead, right] = plane_of(settings.mounting.mode);
  const double c = std::cos(settings.mounting.ladar_rho);
  const double s = std::sin(settings.mounting.ladar_rho);
  ahead_ = ahead * c + right * s;
  right_ = (right * c + ahead * -s) * (settings.mounting.upside_down ? -1 : 1);
  settings_.reduce = std::max<std::size_t>(settings.reduce, 1);
  settings_.points_max = std::clamp<std::size_t>(settings.points_max, 1, kScan3dPointsMax);
  settings_.scans_max = std::max<std::size_t>(settings.scans_max, 1);
  settings_.sectors = std::max(settings.sectors, 1);
  settings_.to = std::max(settings.to, settings.from + kTurnedBack);
  points_.resize(settings_.points_max);
  for (LadarData& scan : waiting_) reserve_all(scan);
}

// --- flat scans are queued until their pose is known

void Sweep::add(const LadarData& scan) {
  const double half = half_of(scan);
  const bool is_sane = half >= 0 && 2 * half <= kLongest;  // no NaN
  if (scan.points.empty() || !is_sane) {
    ++losses_.broken;
    return;
  }
  if (count_ == waiting_.size()) {
    ++losses_.crowded;
    drop_oldest();
  }
  waiting_[(first_ + count_) % waiting_.size()] = scan;
  ++count_;
}

void Sweep::drop_oldest() {
  first_ = (first_ + 1) % waiting_.size();
  --count_;
}

double Sweep::half_of(const LadarData& scan) const {
  return (settings_.duration_ms >= 0 ? settings_.duration_ms
                                     : static_cast<double>(scan.duration.raw())) /
         2;
}

// The time of a flat scan is its middle.
TimeStamp Sweep::middle_of(const LadarData& scan) const {
  return scan.recordingTime - whole_ms(settings_.lag_ms);
}

std::optional<Sweep::Span> Sweep::wanted() const {
  if (count_ == 0) return {};
  const TimeStamp middle = middle_of(oldest());
  const milliseconds half(static_cast<std::int64_t>(std::ceil(half_of(oldest()))));
  return Span{middle - half, middle + half};
}

Sweep::Found Sweep::find(const LadarData& scan, Course& course) const {
  course.time = middle_of(scan);
  course.half_ms = half_of(scan);
  const milliseconds half(static_cast<std::int64_t>(std::ceil(course.half_ms)));
  const TimeStamp end = course.time + half;
  const bool is_late = (axis_.is_empty() || axis_.newest() < end) ||
                       (settings_.has_poses && (poses_.is_empty() || poses_.newest() < end));
  if (is_late) {
    // As long as the newest scan is not much later, the samples may still arrive.
    const LadarData& newest = waiting_[(first_ + count_ - 1) % waiting_.size()];
    const auto waited = std::chrono::abs(newest.recordingTime - scan.recordingTime);
    return waited <= kWaitMax ? Found::kNotYet : Found::kNever;
  }
  const auto axis_begin = axis_.at(course.time, -course.half_ms);
  const auto axis_end = axis_.at(course.time, course.half_ms);
  if (!axis_begin || !axis_end) return Found::kNever;
  course.axis_begin = *axis_begin;
  course.axis_end = *axis_end;
  if (!settings_.has_poses) return Found::kYes;
  const auto begin = poses_.at(course.time, -course.half_ms);
  const auto middle = poses_.at(course.time, 0);
  const auto finish = poses_.at(course.time, course.half_ms);
  if (!begin || !middle || !finish) return Found::kNever;
  course.begin = *begin;
  course.middle = *middle;
  course.end = *finish;
  return Found::kYes;
}

bool Sweep::next(Scan3dData& scan) {
  for (;;) {
    if (is_sector_due_) {
      is_sector_due_ = false;
      fill(sector_, scan);
      scan.sectorNum = settings_.sectors;
      scan.sectorIndex = sector_index_;
      sector_ = {.point = size_};
      return true;
    }
    if (is_sweep_due_) {
      is_sweep_due_ = false;
      const auto seen = static_cast<double>(end_cell_ - first_cell_);
      const bool is_whole = seen >= kWhole * static_cast<double>(cells_);
      if (is_whole) fill(sweep_, scan);
      sweep_ = sector_ = {};
      size_ = 0;
      if (is_whole) return true;
    }
    if (count_ == 0) return false;
    Course course;
    const Found found = find(oldest(), course);
    if (found == Found::kNotYet) return false;
    if (found == Found::kNever)
      ++losses_.unplaced;
    else if (!take(oldest(), course))
      continue;
    drop_oldest();
  }
}

// --- position in the sweep

bool Sweep::take(const LadarData& scan, const Course& course) {
  const double axis = course.axis();
  if (!follow_direction(axis)) return false;
  if (direction_ == 0) return true;
  if (settings_.is_round && !follow_round(axis)) return false;
  const double at = progress(axis);
  if (at < 0 || at > 1 || last_cell_ == kComplete) return true;
  if (sweep_.scans == 0) begin_sweep(scan, course);
  const auto cell =
      std::min(static_cast<std::int64_t>(at * static_cast<double>(cells_)), cells_ - 1);
  if (cell <= last_cell_) return true;
  const auto sector = std::min(static_cast<i32>(at * settings_.sectors), settings_.sectors - 1);
  if (settings_.sectors > 1 && sector_.scans > 0 && sector != sector_index_) {
    is_sector_due_ = true;
    return false;
  }
  if (sweep_.scans == 0) first_cell_ = cell;
  sector_index_ = sector;
  last_cell_ = cell;
  end_cell_ = cell + 1;
  if (sector_.scans == 0) sector_.begin = course.time - whole_ms(course.half_ms);
  last_ = course;
  put_points(scan, course);
  ++sweep_.scans;
  ++sector_.scans;
  if (cell == cells_ - 1) {  // nothing can follow in this direction, or this turn
    end_sweep();
    last_cell_ = kComplete;
  }
  return true;
}

// False: the axis has turned back, and the sweep has ended.
bool Sweep::follow_direction(double axis) {
  if (!farthest_) farthest_ = axis;
  if (direction_ == 0) {
    if (std::abs(axis - *farthest_) < kTurnedBack) return true;
    direction_ = axis > *farthest_ ? 1 : -1;
  }
  if ((*farthest_ - axis) * direction_ < kTurnedBack) {
    farthest_ = direction_ > 0 ? std::max(*farthest_, axis) : std::min(*farthest_, axis);
    return true;
  }
  direction_ = -direction_;
  farthest_ = axis;
  last_cell_ = -1;
  end_sweep();
  return !is_sweep_due_;
}

// False: the next span has begun, and the sweep has ended.
bool Sweep::follow_round(double axis) {
  const double turn = std::floor((axis - settings_.from) / (settings_.to - settings_.from));
  // A movement back that is less than a change of direction does not start another span.
  if (turn == turn_ || (sweep_.scans > 0 && (turn - turn_) * direction_ < 0)) return true;
  turn_ = turn;
  last_cell_ = -1;
  end_sweep();
  return !is_sweep_due_;
}

// Position in the span in the direction of the sweep, 0 to 1; outside of the span, beyond these
// limits.
double Sweep::progress(double axis) const {
  const double span = settings_.to - settings_.from;
  const double turned = (axis - settings_.from) / span - (settings_.is_round ? turn_ : 0);
  return direction_ > 0 ? turned : 1 - turned;
}

void Sweep::end_sweep() {
  if (sweep_.scans == 0) return;
  is_sector_due_ = settings_.sectors > 1 && sector_.scans > 0;
  is_sweep_due_ = true;
}

void Sweep::begin_sweep(const LadarData& scan, const Course& course) {
  const std::size_t points = (scan.points.size() + settings_.reduce - 1) / settings_.reduce;
  line_points_ = std::min(points, settings_.points_max);
  cells_ = static_cast<std::int64_t>(
      std::clamp<std::size_t>(settings_.points_max / line_points_, 1, settings_.scans_max));
  line_range_ = settings_.range_max > 0 ? std::min(settings_.range_max, scan.maxRange.raw())
                                        : scan.maxRange.raw();
  to_origin_ = Frame(course.middle).inverse();
  mode_ = mode();
  size_ = 0;
  sweep_ = sector_ = {.begin = course.time - whole_ms(course.half_ms)};
}

// --- points

Frame Sweep::ladar_at(const Course& course, double part) const {
  const double angle = between(course.axis_begin, course.axis_end, part);
  const Frame on_robot = mounting_ * turned_by(settings_.mounting.mode, angle);
  if (!settings_.has_poses) return on_robot;
  const Pose pose = part < 0.5 ? between(course.begin, course.middle, 2 * part)
                               : between(course.middle, course.end, 2 * part - 1);
  return to_origin_ * Frame(pose) * on_robot;
}

void Sweep::put_points(const LadarData& scan, const Course& course) {
  const std::size_t end = size_ + line_points_;
  const double last = static_cast<double>(std::max<std::size_t>(scan.points.size(), 2) - 1);
  for (std::size_t i = 0; i < scan.points.size() && size_ < end; i += settings_.reduce) {
    const double part = static_cast<double>(i) / last;
    put_point(scan.points[i], line_range_,
              ladar_at(course, settings_.mounting.is_reversed ? 1 - part : part));
  }
  for (; size_ < end; ++size_) points_[size_] = {.type = scan_point::kInvalid};
}

void Sweep::put_point(const LadarPoint& point, i32 range_max, const Frame& ladar) {
  Stored& stored = points_[size_++];
  stored = {.intensity = static_cast<i16>(std::clamp(point.intensity, -32768, 32767))};
  const double angle = static_cast<double>(point.angle.raw());
  const bool is_reflector = (point.type & ladar_point::kReflector) != 0;
  if (is_reflector)
    stored.type = scan_point::kReflector;
  else if (point.type != ladar_point::kUnknown)
    stored.type = scan_point::kInvalid;
  if (!std::isfinite(angle) || point.distance <= std::max(settings_.range_min, 0)) {
    stored.type = scan_point::kInvalid;
    return;
  }
  if (point.distance >= range_max) {
    stored.type |= scan_point::kInvalid | scan_point::kMaxRange;
    return;
  }
  const auto distance = static_cast<double>(point.distance.raw());
  const Place place = ladar * (settings_.mounting.ladar + ahead_ * (distance * std::cos(angle)) +
                               right_ * (distance * std::sin(angle)));
  stored.x = static_cast<float>(place.x);
  stored.y = static_cast<float>(place.y);
  stored.z = static_cast<float>(place.z);
}

// --- messages

void Sweep::fill(const Part& part, Scan3dData& scan) const {
  scan.recordingTime = last_.time;
  scan.duration = static_cast<u32>(
      std::max<std::int64_t>((last_.time + whole_ms(last_.half_ms) - part.begin).count(), 0));
  scan.maxRange = line_range_;
  scan.scanNum = part.scans;
  scan.scanPointNum = static_cast<i32>(line_points_);
  scan.scanMode = mode_;
  scan.scanHardware = 0;
  scan.sectorNum = 1;
  scan.sectorIndex = 0;
  scan.refPos = settings_.has_poses ? last_.middle.position() : Position3d{};
  scan.compressed = 0;
  scan.compressedPoints.clear();
  // Uses the reference position as it is sent, in whole millimetres.
  const Frame from_origin =
      settings_.has_poses ? (to_origin_ * Frame(Pose::of(scan.refPos))).inverse() : Frame();
  scan.points.resize(size_ - part.point);
  for (std::size_t i = part.point; i < size_; ++i) {
    const Stored& stored = points_[i];
    ScanPoint& point = scan.points[i - part.point];
    point = {.type = stored.type, .intensity = stored.intensity};
    if ((stored.type & scan_point::kInvalid) != 0) continue;
    const Place place = from_origin * Place{stored.x, stored.y, stored.z};
    point.x = whole_millimetres(place.x);
    point.y = whole_millimetres(place.y);
    point.z = whole_millimetres(place.z);
  }
  scan.pointNum = static_cast<i32>(scan.points.size());
}

// The sign for the original's graphical interface: a positive pitch goes from top to bottom, all
// other positive modes clockwise.
i32 Sweep::mode() const {
  const i32 mode = settings_.mounting.mode;
  const bool is_positive = mode == scan_mode::kPitch ? direction_ < 0 : direction_ > 0;
  const double middle = heading((settings_.from + settings_.to) / 2 +
                                (settings_.is_round ? turn_ * (settings_.to - settings_.from) : 0));
  return mode | scan_mode::kSquareGrid | (is_positive ? scan_mode::kPositiveTurn : 0) |
         (middle > kPi ? scan_mode::kStartAt180 : 0);
}

}  // namespace rack::scan3d
