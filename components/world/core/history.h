// The poses of all moving objects in the last second: a ring buffer of the states at the ends of
// steps, and linear interpolation in between. An object that was placed elsewhere did not move
// there: it was at its old place until then.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <vector>

#include "components/geometry/pose.h"
#include "components/world/core/people.h"
#include "components/world/core/world.h"

namespace rack::world {

struct RobotSample {
  MapPoint at{};
  double rho = 0;  // not normalised: continuous over turns
  double vx = 0;   // in its own frame
  double vy = 0;
  double omega = 0;
  double ax = 0;  // of the reference point
  double ay = 0;
  double alpha = 0;                 // rad/s2
  tims::Duration jumped = kNoJump;  // time at which it was placed there, since the start

  static constexpr tims::Duration kNoJump{-1};
};

class History {
 public:
  History(std::size_t robots, std::size_t people, std::size_t axes, tims::Time begin)
      : robots_(robots),
        people_(people),
        axes_(axes),
        begin_(begin),
        robot_samples_(robots * kSamples),
        person_samples_(people * kSamples),
        axis_samples_(axes * kSamples) {}

  // The samples before and after a time.
  struct Moment {
    std::size_t before = 0;  // indices in the ring
    std::size_t after = 0;
    double part = 0;  // position between both, 0 to 1
    tims::Duration age{};
  };
  [[nodiscard]] Moment moment(tims::Time at) const {
    const std::uint64_t oldest = steps_ < kSamples ? 0 : steps_ - kSamples + 1;
    const tims::Duration age = at - begin_;
    if (age <= static_cast<std::int64_t>(oldest) * kStep)
      return {place(oldest), place(oldest), 0, age};
    const auto step = static_cast<std::uint64_t>(age / kStep);
    if (step >= steps_) return {place(steps_), place(steps_), 0, age};
    const auto rest = static_cast<double>((age % kStep).count());
    return {place(step), place(step + 1), rest / static_cast<double>(kStep.count()), age};
  }

  // The newest state, which a step changes into the next one.
  [[nodiscard]] std::uint64_t steps() const { return steps_; }
  void begin_step() { ++steps_; }
  RobotSample& robot(std::size_t number) {
    return robot_samples_[place(steps_) * robots_ + number];
  }
  Figure& person(std::size_t number) { return person_samples_[place(steps_) * people_ + number]; }
  double& axis(std::size_t number) { return axis_samples_[place(steps_) * axes_ + number]; }

  [[nodiscard]] RobotSample robot(std::size_t number, const Moment& moment) const {
    const RobotSample& a = robot_samples_[moment.before * robots_ + number];
    const RobotSample& b = robot_samples_[moment.after * robots_ + number];
    if (b.jumped != RobotSample::kNoJump) return moment.age >= b.jumped ? b : a;
    if (moment.part == 0) return a;
    const auto mix = [&](double from, double to) { return from + (to - from) * moment.part; };
    return {.at = {mix(a.at.x, b.at.x), mix(a.at.y, b.at.y)},
            .rho = mix(a.rho, b.rho),
            .vx = mix(a.vx, b.vx),
            .vy = mix(a.vy, b.vy),
            .omega = mix(a.omega, b.omega),
            .ax = mix(a.ax, b.ax),
            .ay = mix(a.ay, b.ay),
            .alpha = mix(a.alpha, b.alpha)};
  }
  [[nodiscard]] Figure person(std::size_t number, const Moment& moment) const {
    const Figure& a = person_samples_[moment.before * people_ + number];
    const Figure& b = person_samples_[moment.after * people_ + number];
    const auto mix = [&](double from, double to) { return from + (to - from) * moment.part; };
    return {.at = {mix(a.at.x, b.at.x), mix(a.at.y, b.at.y)},
            .vx = mix(a.vx, b.vx),
            .vy = mix(a.vy, b.vy),
            .rho = a.rho + signed_angle(b.rho - a.rho) * moment.part,
            .gait = mix(a.gait, b.gait)};
  }
  [[nodiscard]] double axis(std::size_t number, const Moment& moment) const {
    const double before = axis_samples_[moment.before * axes_ + number];
    const double after = axis_samples_[moment.after * axes_ + number];
    return before + (after - before) * moment.part;
  }
  // Approximate position, to skip people far from a ray.
  [[nodiscard]] const MapPoint& person_about(std::size_t number, const Moment& moment) const {
    return person_samples_[moment.before * people_ + number].at;
  }

 private:
  static constexpr std::size_t kSamples = kRemembered / kStep + 2;
  static std::size_t place(std::uint64_t step) { return step % kSamples; }

  std::size_t robots_;
  std::size_t people_;
  std::size_t axes_;
  tims::Time begin_;
  std::uint64_t steps_ = 0;
  std::vector<RobotSample> robot_samples_;  // by index in the ring, then by number
  std::vector<Figure> person_samples_;
  std::vector<double> axis_samples_;
};

}  // namespace rack::world
