#include "components/devices/chassis/motor_chassis.h"

#include <algorithm>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kMotorChassisReadyTime = 8s;  // includes the encoder search of some motors
constexpr Duration kMotorChassisBetween = 5ms;   // limits the load of the bus
constexpr Duration kStale = 200ms;               // age at which the state of a motor is outdated

}  // namespace

MotorChassis::MotorChassis(const MotorChassisSettings& settings, Wheels wheels,
                           std::vector<MotorLink> links)
    : settings_(settings),
      wheels_(std::move(wheels)),
      links_(std::move(links)),
      host_(settings.cycle),
      targets_(links_.size()),
      positions_(links_.size()),
      measured_(links_.size()) {}

void MotorChassis::start(Time now, Output& out) {
  clear_failure();
  is_ready_ = false;
  has_data_ = false;
  wanted_ = {};
  std::ranges::fill(targets_, 0);
  is_stopped_ = false;
  if (settings_.is_canopen && !settings_.only_listen) host_.start(now);
  ready_due_ = settings_.only_listen ? tims::kNever : now + kMotorChassisReadyTime;
  next_cycle_ = now + settings_.cycle;
  next_data_ = tims::kNever;
  for (MotorLink& link : links_) link.motor->start(now, out);
}

Time MotorChassis::next_timeout() const {
  if (is_stopped_) return tims::kNever;
  Time next = std::min({next_cycle_, next_data_, host_.next_timeout()});
  if (settings_.only_listen) return next;
  for (const MotorLink& link : links_) next = std::min(next, link.motor->next_timeout());
  return next;
}

std::vector<CanFilter> MotorChassis::wanted_frames() const {
  std::vector<CanFilter> all;
  all.reserve(links_.size());
  for (const MotorLink& link : links_) all.push_back(link.motor->wanted_frames());
  return all;
}

void MotorChassis::on_arrival(const Arrival& arrival, Output& out) {
  if (is_stopped_ || (arrival.id & can::kError) != 0) return;
  for (MotorLink& link : links_)
    if (link.motor->on_frame(arrival, out)) break;
  check(arrival.last, out);
}

void MotorChassis::on_timeout(Time now, Output& out) {
  if (is_stopped_) return;
  host_.on_timeout(now, out);
  // A recording does not answer, and its pauses are not failures of the motors.
  if (!settings_.only_listen)
    for (MotorLink& link : links_)
      if (link.motor->next_timeout() <= now) link.motor->on_timeout(now, out);
  check(now, out);
  if (is_stopped_) return;
  if (next_cycle_ <= now) {
    next_cycle_ = now + settings_.cycle;
    if (is_ready_) command_all(now, out);
  }
  if (next_data_ <= now) {
    next_data_ = std::max(next_data_ + settings_.period, now);
    measure(now);
  }
}

// Checks whether all motors are ready. If one has failed, all are stopped at once.
void MotorChassis::check(Time now, Output& out) {
  bool all = true;
  for (const MotorLink& link : links_) {
    if (link.motor->failure()) {
      fail(tims::Errc::kSystem, link.name + " " + *link.motor->failure());
      stop(now, out);
      return;
    }
    all = all && link.motor->is_ready();
  }
  if (all && !is_ready_) {
    is_ready_ = true;
    next_data_ = now;
    for (std::size_t i = 0; i < links_.size(); ++i)
      positions_[i] = links_[i].motor->state().position / links_[i].gear;
    // Steering starts at its current position.
    for (std::size_t i = 0; i < links_.size(); ++i)
      if (wheels_.is_steering(i))
        targets_[i] = (links_[i].motor->state().position - links_[i].zero) / links_[i].gear;
  }
  if (is_ready_ || now < ready_due_) return;
  std::string missing;
  for (const MotorLink& link : links_)
    if (!link.motor->is_ready()) missing += (missing.empty() ? "" : ", ") + link.name;
  fail(tims::Errc::kTimeout,
       "not ready within " + std::to_string(kMotorChassisReadyTime / 1s) + " s: " + missing);
  stop(now, out);
}

void MotorChassis::drive(const ChassisSpeed& speed, Time now) {
  if (is_ready_ && !(speed == wanted_))
    next_cycle_ = std::min(next_cycle_, std::max(now, last_cycle_ + kMotorChassisBetween));
  wanted_ = speed;
}

void MotorChassis::command_all(Time now, Output& out) {
  last_cycle_ = now;
  if (settings_.only_listen) return;
  wheels_.targets(wanted_, targets_);
  for (std::size_t i = 0; i < links_.size(); ++i)
    links_[i].motor->command(targets_[i] * links_[i].gear + links_[i].zero, now, out);
}

void MotorChassis::measure(Time now) {
  Time oldest = now;
  double volts = 0;
  for (const MotorLink& link : links_) {
    oldest = std::min(oldest, link.motor->state().measured);
    volts = std::max(volts, link.motor->state().volts);
  }
  if (now - oldest > kStale) return;  // the driver fails after three periods without data
  const auto movement = [&](bool is_distance) {
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const MotorState& state = links_[i].motor->state();
      const double gear = links_[i].gear;
      if (wheels_.is_steering(i)) {
        measured_[i] = (state.position - links_[i].zero) / gear;
      } else if (is_distance) {
        measured_[i] = state.position / gear - positions_[i];
        positions_[i] = state.position / gear;
      } else {
        measured_[i] = state.velocity / gear;
      }
    }
    return wheels_.movement(measured_);
  };
  const ChassisSpeed displacement = movement(true);
  const ChassisSpeed speed = movement(false);
  data_.deltaX = data_.deltaX + displacement.vx;
  data_.deltaY = data_.deltaY + displacement.vy;
  data_.deltaRho = data_.deltaRho + displacement.omega;
  data_.vx = speed.vx;
  data_.vy = speed.vy;
  data_.omega = speed.omega;
  data_.battery = static_cast<f32>(volts);
  recorded_ = oldest;
  has_data_ = true;
}

bool MotorChassis::take(ChassisData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data = data_;
  data_.deltaX = data_.deltaY = 0;
  data_.deltaRho = 0;
  recorded = recorded_;
  return true;
}

std::vector<Telegram> MotorChassis::stop_commands() const {
  KeptTelegrams kept;
  for (const MotorLink& link : links_) link.motor->stand(kept);
  return kept.take();
}

void MotorChassis::stop(Time /*now*/, Output& out) {
  if (std::exchange(is_stopped_, true) || settings_.only_listen) return;
  for (MotorLink& link : links_) link.motor->stop(out);
  host_.stop();
}

}  // namespace rack::device
