#include "components/devices/chassis/servo_axis.h"

#include <algorithm>
#include <cmath>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr Duration kServoAxisCycle = 20ms;

Cia402Settings drive_of(const ServoAxisSettings& settings) {
  Cia402Settings drive = settings.drive;
  drive.task = MotorTask::kPositions;
  drive.only_listen = settings.only_listen;
  return drive;
}

}  // namespace

ServoDriveData interpolated(const ServoDriveData& before, const ServoDriveData& after,
                            TimeStamp time) {
  const auto all = after.recordingTime - before.recordingTime;
  const float part = all.count() == 0 ? 0
                                      : static_cast<float>((time - before.recordingTime).count()) /
                                            static_cast<float>(all.count());
  return {.recordingTime = time,
          .position = before.position + part * (after.position - before.position)};
}

ServoAxis::ServoAxis(const ServoAxisSettings& settings)
    : settings_(settings),
      drive_(drive_of(settings)),
      host_(kServoAxisCycle),
      deadline_(settings.move_deadline) {}

void ServoAxis::start(Time now, Output& out) {
  clear_failure();
  is_ready_ = is_stopped_ = has_limits_ = shall_home_ = has_data_ = overdue_ = false;
  deadline_.forget();
  next_cycle_ = now + kServoAxisCycle;
  next_data_ = tims::kNever;
  if (!settings_.only_listen) host_.start(now);
  drive_.start(now, out);
}

Time ServoAxis::next_timeout() const {
  if (is_stopped_) return tims::kNever;
  const Time next = std::min({next_cycle_, next_data_, host_.next_timeout(), deadline_.due()});
  return settings_.only_listen ? next : std::min(next, drive_.next_timeout());
}

void ServoAxis::on_arrival(const Arrival& arrival, Output& out) {
  if (is_stopped_ || (arrival.id & can::kError) != 0) return;
  drive_.on_frame(arrival, out);
  check(arrival.last, out);
}

void ServoAxis::on_timeout(Time now, Output& out) {
  if (is_stopped_) return;
  host_.on_timeout(now, out);
  // A recording does not answer, and its pauses are not failures of the drive.
  if (!settings_.only_listen && drive_.next_timeout() <= now) drive_.on_timeout(now, out);
  check(now, out);
  if (is_stopped_) return;
  if (deadline_.due() <= now) {
    overdue_ = true;
    move_to(position(), 0, 0);
    next_cycle_ = now;
  }
  if (next_cycle_ <= now) {
    next_cycle_ = now + kServoAxisCycle;
    if (is_ready_ && !settings_.only_listen) command(now, out);
  }
  if (next_data_ <= now) {
    next_data_ = std::max(next_data_ + settings_.period, now);
    constexpr Duration kStale = 200ms;
    if (now - drive_.state().measured > kStale) return;
    recorded_ = drive_.state().measured;
    has_data_ = true;
  }
}

std::vector<CanFilter> ServoAxis::wanted_frames() const { return {drive_.wanted_frames()}; }

void ServoAxis::check(Time now, Output& out) {
  if (drive_.failure()) {
    fail(tims::Errc::kSystem,
         "drive of node " + std::to_string(settings_.drive.node) + " " + *drive_.failure());
    stop(now, out);
    return;
  }
  if (is_ready_ || !drive_.is_ready()) return;
  is_ready_ = true;
  next_data_ = now;
  target_ = position();
  velocity_ = settings_.velocity_max;
  has_limits_ = true;
}

void ServoAxis::command(Time now, Output& out) {
  if (std::exchange(shall_home_, false)) {
    target_ = 0;
    drive_.home(now, out);
    return;
  }
  if (drive_.is_homing()) return;
  const double gear = std::abs(settings_.gear);
  if (std::exchange(has_limits_, false)) drive_.limit(velocity_ * gear, acceleration_ * gear, out);
  drive_.command(target_ * settings_.gear, now, out);
}

void ServoAxis::move_to(double position, double velocity, double acceleration) {
  if (!std::isfinite(position)) return;
  deadline_.end();
  const double most = settings_.velocity_max;
  target_ = std::clamp(position, settings_.min, settings_.max);
  velocity_ = velocity > 0 && std::isfinite(velocity) ? std::min(velocity, most) : most;
  acceleration_ = acceleration > 0 && std::isfinite(acceleration) ? acceleration : 0;
  has_limits_ = true;
}

void ServoAxis::move(double velocity, Time now) {
  if (!std::isfinite(velocity) || velocity == 0) {
    move_to(position(), 0, 0);
  } else {
    move_to(velocity > 0 ? settings_.max : settings_.min, std::abs(velocity), 0);
    deadline_.on_move(now);
  }
}

void ServoAxis::home() {
  shall_home_ = true;
  deadline_.end();
}

bool ServoAxis::is_reached() const {
  constexpr double kNear = 1e-2;  // rad of the motor
  return is_ready_ && !shall_home_ && !has_limits_ && drive_.is_reached() &&
         std::abs(drive_.state().position - target_ * settings_.gear) < kNear * 10;
}

bool ServoAxis::take(ServoDriveData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data.position = static_cast<f32>(position());
  recorded = recorded_;
  return true;
}

std::vector<Telegram> ServoAxis::stop_commands() const {
  KeptTelegrams kept;
  drive_.stand(kept);
  return kept.take();
}

void ServoAxis::stop(Time /*now*/, Output& out) {
  if (std::exchange(is_stopped_, true) || settings_.only_listen) return;
  drive_.stop(out);
  host_.stop();
}

}  // namespace rack::device
