#include "tools/evaluation/made_drives/made_drive.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "components/geometry/random.h"
#include "components/localisation/ros_map.h"

namespace rack::made_drives {

namespace {

constexpr double kSpeed = 0.5;      // m/s
constexpr double kLookAhead = 700;  // mm along the route
constexpr double kWaviness = 120;   // mm beside it
constexpr double kWave = 9000;      // mm
constexpr double kTurnAtRest = radians(35);
constexpr double kPersonRadius = 200;  // mm

// The points of the route as a line that can be asked for the point after a distance.
class Line {
 public:
  explicit Line(const std::vector<MapPoint>& route) {
    for (const MapPoint& p : route) {
      const MapPoint at{1000 * p.y, 1000 * p.x};  // RACK: x to the north
      if (!points_.empty() && distance(points_.back(), at) < 1) continue;
      begins_.push_back(points_.empty() ? 0 : begins_.back() + distance(points_.back(), at));
      points_.push_back(at);
    }
  }
  [[nodiscard]] double length() const { return begins_.back(); }
  [[nodiscard]] MapPoint at(double mm) const {
    mm = std::clamp(mm, 0.0, length());
    const auto next = std::ranges::upper_bound(begins_, mm);
    const auto i =
        std::min<std::size_t>(static_cast<std::size_t>(next - begins_.begin()), begins_.size() - 1);
    const double part = (mm - begins_[i - 1]) / (begins_[i] - begins_[i - 1]);
    const MapPoint& a = points_[i - 1];
    const MapPoint& b = points_[i];
    return {a.x + part * (b.x - a.x), a.y + part * (b.y - a.y)};
  }
  // The end of the piece of the route that contains `mm`.
  [[nodiscard]] double corner_after(double mm) const {
    const auto next = std::ranges::upper_bound(begins_, mm);
    return next == begins_.end() ? length() : *next;
  }

 private:
  std::vector<MapPoint> points_;
  std::vector<double> begins_;
};

class Robot {
 public:
  Robot(const Site& site, const DriveKind& kind)
      : floor_(site.floor.walls(), 1000, 0, 0), line_(site.route), kind_(kind), random_(kind.seed) {
    scale_ = 1 + kind.scale * normal();
    turn_scale_ = 1 + kind.turn_scale * normal();
    // Of either sign, but never without.
    drift_ = kind.drift * (0.6 + 0.4 * std::abs(normal())) * (random_.below(2) == 0 ? 1 : -1);
    for (std::size_t i = 0; i < kind.people; ++i)
      people_.push_back({uniform(1500, 6000), uniform(-700, 700), uniform(-900, 900)});
    const MapPoint first = line_.at(0);
    const MapPoint next = line_.at(500);
    truth_ = {.x = first.x, .y = first.y, .rho = std::atan2(next.y - first.y, next.x - first.x)};
    odometry_ = truth_;
  }

  std::vector<MadeScan> drive() {
    scan();
    const double end = std::min(line_.length() - 100, 1000 * kind_.length);
    while (at_ < end) {
      step();
      scan();
    }
    return std::move(scans_);
  }

 private:
  struct Person {
    double ahead;   // mm along the route
    double beside;  // mm
    double speed;   // mm/s relative to the robot
  };
  double normal() { return static_cast<double>(random_.normal()); }
  double uniform(double from, double to) {
    return from + (to - from) * static_cast<double>(random_.uniform());
  }

  void step() {
    const double corner = line_.corner_after(at_);
    const double left = corner - at_;
    MapPoint to = line_.at(std::min(at_ + kLookAhead, corner));
    if (left < 60) {
      at_ = corner + 1;
      to = line_.at(at_ + kLookAhead);
    }
    double turn = signed_angle(std::atan2(to.y - truth_.y, to.x - truth_.x) - truth_.rho);
    const bool at_rest = std::abs(turn) > kTurnAtRest;
    turn = std::clamp(turn, -kind_.scan_turn, kind_.scan_turn);
    double forward = at_rest ? 0 : 1000 * kind_.scan_distance * uniform(0.8, 1.2);
    forward = std::min(forward, std::max(20.0, left));
    // Never through a wall.
    const Pose ahead{truth_ + Pose{.x = forward}};
    if (floor_.clearance({ahead.x, ahead.y}) < 150) forward *= 0.3;
    // The waviness of a driver.
    if (!at_rest && left > 1500)
      turn += kWaviness / kWave * std::sin(2 * kPi * at_ / kWave) * forward / 200;
    move(forward, turn);
    at_ += forward;
  }

  void move(double forward, double turn) {
    truth_ = truth_ + Pose{.x = forward, .rho = turn};
    const double metres = forward / 1000;
    Pose went{.x = forward * scale_ + 20 * std::sqrt(metres) * normal(),
              .y = 10 * std::sqrt(metres) * normal(),
              .rho = turn * turn_scale_ + drift_ * metres +
                     kind_.turn_noise * std::sqrt(metres) * normal() + 0.02 * turn * normal()};
    if (uniform(0, 1) < metres / kind_.slip_distance) {
      went.rho += kind_.slip_turn * normal();
      went.x += 1000 * kind_.slip_length * uniform(0, 1);
    }
    odometry_ = odometry_ + went;
    time_ += std::max(forward / 1000 / kSpeed, std::abs(turn) / 0.6);
  }

  void scan() {
    const double step = kPi / static_cast<double>(kind_.beams - kind_.beams % 2);
    std::vector<double> clockwise(kind_.beams);
    floor_.cast({{truth_.x, truth_.y}, truth_.rho - kPi / 2, step}, 1000 * kind_.range_max,
                clockwise);
    put_people(step, clockwise);
    MadeScan made{.time = time_, .truth = truth_, .odometry = odometry_};
    for (std::size_t i = clockwise.size(); i-- > 0;) {  // CARMEN: counter-clockwise
      const double range = clockwise[i] / 1000;
      const bool nothing = range >= kind_.range_max - 0.01;
      made.ranges.push_back(static_cast<float>(
          nothing ? kind_.range_max + 1 : std::max(0.05, range + kind_.range_noise * normal())));
    }
    scans_.push_back(std::move(made));
  }

  void put_people(double step, std::vector<double>& ranges) {
    const double passed = time_ - people_at_;
    people_at_ = time_;
    for (Person& person : people_) {
      person.ahead += person.speed * passed;
      if (person.ahead < -3000 || person.ahead > 9000)
        person = {person.speed < 0 ? 9000.0 : 1500.0, uniform(-700, 700), uniform(-900, 900)};
      const MapPoint on_route = line_.at(at_ + person.ahead);
      const Pose relative = Pose{.x = on_route.x + person.beside, .y = on_route.y} - truth_;
      const double range = std::hypot(relative.x, relative.y);
      if (range < 600) continue;
      const double middle = std::atan2(relative.y, relative.x);
      for (std::size_t i = 0; i < ranges.size(); ++i) {
        const double angle = -kPi / 2 + static_cast<double>(i) * step;
        const double beside = range * std::sin(signed_angle(angle - middle));
        if (std::cos(angle - middle) < 0 || std::abs(beside) >= kPersonRadius) continue;
        const double front = std::sqrt(kPersonRadius * kPersonRadius - beside * beside);
        ranges[i] = std::min(ranges[i], range * std::cos(angle - middle) - front);
      }
    }
  }

  FloorMap floor_;
  Line line_;
  DriveKind kind_;
  Random random_;
  double scale_ = 1;
  double turn_scale_ = 1;
  double drift_ = 0;
  std::vector<Person> people_;
  double people_at_ = 0;
  Pose truth_{};
  Pose odometry_{};
  double at_ = 0;  // mm on the route
  double time_ = 0;
  std::vector<MadeScan> scans_;
};

}  // namespace

std::vector<MadeScan> drive(const Site& site, const DriveKind& kind) {
  return Robot(site, kind).drive();
}

std::string to_carmen(const std::vector<MadeScan>& scans) {
  std::string text;
  auto to = std::back_inserter(text);
  for (const MadeScan& scan : scans) {
    const auto pose = localisation::ros_of_pose(scan.odometry);
    fmt::format_to(to, "ODOM {:.4f} {:.4f} {:.5f} 0 0 0 {:.4f} made {:.4f}\n", pose.x, pose.y,
                   pose.theta, scan.time, scan.time);
    fmt::format_to(to, "FLASER {}", scan.ranges.size());
    for (const float range : scan.ranges) fmt::format_to(to, " {:.2f}", range);
    fmt::format_to(to, " {:.4f} {:.4f} {:.5f} {:.4f} {:.4f} {:.5f} {:.4f} made {:.4f}\n", pose.x,
                   pose.y, pose.theta, pose.x, pose.y, pose.theta, scan.time, scan.time);
  }
  return text;
}

std::string to_truth(const std::vector<MadeScan>& scans) {
  std::string text = "# time index x y theta\n";
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const auto pose = localisation::ros_of_pose(scans[i].truth);
    fmt::format_to(std::back_inserter(text), "{:.4f} {} {:.4f} {:.4f} {:.5f}\n", scans[i].time, i,
                   pose.x, pose.y, pose.theta);
  }
  return text;
}

}  // namespace rack::made_drives
