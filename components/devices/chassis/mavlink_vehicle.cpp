#include "components/devices/chassis/mavlink_vehicle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rack::device {
namespace {

using namespace std::chrono_literals;
using mavlink::Message;
using mavlink::Packet;

constexpr Duration kHeartbeat = 1s;
constexpr Duration kHeartbeatLost = 3s;
constexpr Duration kVelocityAgain = 100ms;
constexpr Duration kMavlinkBetween = 20ms;
constexpr double kMavlinkPi = std::numbers::pi;

constexpr std::uint16_t kMavlinkSetMode = 176;
constexpr std::uint16_t kMavlinkArm = 400;
constexpr std::uint16_t kMavlinkMessageInterval = 511;

constexpr std::uint8_t kAutopilot = 1;       // component id
constexpr std::uint8_t kOwnComponent = 190;  // component id of a mission planner
constexpr std::uint8_t kGroundStation = 6;   // MAV_TYPE_GCS
constexpr std::uint8_t kNoAutopilot = 8;
constexpr std::uint8_t kArmedFlag = 0x80;
constexpr std::uint8_t kBodyFrame = 8;             // forward, right, down
constexpr std::uint16_t kOnlyVelocities = 0x05C7;  // type mask of message 84: ignored fields

// The autopilot marks unknown values by NaN. Implausibly large values are rejected as well.
bool is_measured(std::initializer_list<double> values) {
  constexpr double kFar = 1e6;
  return std::ranges::all_of(values, [](double value) { return std::abs(value) <= kFar; });
}

i32 millimetres(double metres) { return Millimetres<i32>::from_si(metres).raw(); }
f32 real(double value) { return static_cast<f32>(value); }

}  // namespace

void MavlinkVehicle::start(Time now, Output&) {
  clear_failure();
  packets_.clear();
  target_ = settings_.only_listen ? settings_.system : 0;
  is_armed_ = has_odometry_ = false;
  last_heartbeat_ = tims::kNever;
  wanted_ = {};
  pose_.reset();
  chassis_ = {};
  gps_ = {};
  gyro_ = {};
  position_ = {};
  next_heartbeat_ = settings_.only_listen ? tims::kNever : now;
  next_velocity_ = tims::kNever;
}

Time MavlinkVehicle::next_timeout() const { return std::min(next_heartbeat_, next_velocity_); }

mavlink::Writer MavlinkVehicle::writer(Message message) {
  return {message, sequence_++, settings_.own_system, kOwnComponent};
}

void MavlinkVehicle::send_heartbeat(Output& out) {
  constexpr std::uint8_t kActive = 4;
  constexpr std::uint8_t kVersion = 3;
  auto packet = writer(Message::kHeartbeat);
  packet.put(std::uint32_t{0}).put(kGroundStation).put(kNoAutopilot);
  packet.put(std::uint8_t{0}).put(kActive).put(kVersion);
  out.send(packet.finish());
}

void MavlinkVehicle::send_command(std::uint16_t command, std::initializer_list<double> parameters,
                                  Output& out) {
  constexpr std::size_t kParameters = 7;
  auto packet = writer(Message::kCommand);
  for (const double parameter : parameters) packet.put_real(parameter);
  for (std::size_t i = parameters.size(); i < kParameters; ++i) packet.put_real(0);
  packet.put(command).put(target_).put(component_).put(std::uint8_t{0});
  out.send(packet.finish());
}

void MavlinkVehicle::send_velocity(Output& out) {
  auto packet = writer(Message::kSetPositionTarget);
  packet.put(std::uint32_t{0});
  for (int i = 0; i < 3; ++i) packet.put_real(0);
  packet.put_real(static_cast<double>(wanted_.vx) / 1000);
  packet.put_real(static_cast<double>(wanted_.vy) / 1000);
  for (int i = 0; i < 5; ++i) packet.put_real(0);
  packet.put_real(static_cast<double>(wanted_.omega));
  packet.put(kOnlyVelocities).put(target_).put(component_).put(kBodyFrame);
  out.send(packet.finish());
}

void MavlinkVehicle::on_timeout(Time now, Output& out) {
  if (next_heartbeat_ <= now) {
    next_heartbeat_ = now + kHeartbeat;
    send_heartbeat(out);
    if (last_heartbeat_ != tims::kNever && now - last_heartbeat_ > kHeartbeatLost)
      fail(tims::Errc::kTimeout, "the autopilot has stopped sending heartbeats");
  }
  if (next_velocity_ <= now) {
    next_velocity_ = now + kVelocityAgain;
    last_velocity_ = now;
    send_velocity(out);
  }
}

void MavlinkVehicle::drive(const ChassisSpeed& speed, Time now) {
  if (target_ != 0 && !settings_.only_listen && !(speed == wanted_))
    next_velocity_ = std::min(next_velocity_, std::max(now, last_velocity_ + kMavlinkBetween));
  wanted_ = speed;
}

void MavlinkVehicle::stop(Time, Output& out) {
  if (settings_.only_listen || target_ == 0) return;
  wanted_ = {};
  send_velocity(out);
  if (settings_.arms) send_command(kMavlinkArm, {0}, out);
  next_heartbeat_ = next_velocity_ = tims::kNever;
}

void MavlinkVehicle::on_arrival(const Arrival& arrival, Output& out) {
  packets_.add(arrival);
  while (packets_.next(packet_)) on_packet(packet_, arrival.last, out);
}

void MavlinkVehicle::on_packet(const Packet& packet, Time now, Output& out) {
  if (packet.message == Message::kHeartbeat) return on_heartbeat(packet, now, out);
  if (packet.system != target_ || target_ == 0) return;
  switch (packet.message) {
    case Message::kSystemStatus: {
      const auto millivolts = packet.number<std::uint16_t>(14);
      if (millivolts != 0xFFFF) battery_ = millivolts / 1000.0;
      return;
    }
    case Message::kCommandAck:
      return on_answer(packet, out);
    case Message::kGpsRaw:
      return on_gps(packet);
    case Message::kAttitude:
      return on_attitude(packet);
    case Message::kLocalPosition:
      return on_local_position(packet);
    case Message::kOdometry:
      return on_odometry(packet);
    default:
      return;
  }
}

void MavlinkVehicle::on_heartbeat(const Packet& packet, Time now, Output& out) {
  const bool is_autopilot = packet.number<std::uint8_t>(5) != kNoAutopilot;
  const bool is_wanted = settings_.system == 0 || packet.system == settings_.system;
  if (!is_autopilot || !is_wanted || (target_ != 0 && packet.system != target_)) return;
  last_heartbeat_ = now;
  is_armed_ = (packet.number<std::uint8_t>(6) & kArmedFlag) != 0;
  if (settings_.only_listen) {
    target_ = packet.system;
    return;
  }
  const bool is_new = std::exchange(target_, packet.system) == 0;
  component_ = kAutopilot;
  const double interval = static_cast<double>(settings_.period / 1us);
  if (is_new) {
    for (const Message message : {Message::kSystemStatus, Message::kGpsRaw, Message::kAttitude,
                                  Message::kLocalPosition, Message::kOdometry})
      send_command(kMavlinkMessageInterval, {static_cast<double>(message), interval}, out);
    next_velocity_ = now + kMavlinkBetween;
  }
  constexpr double kCustomMode = 1;
  const bool is_in_mode = !settings_.mode || packet.number<std::uint32_t>(0) == *settings_.mode;
  if (!is_in_mode)
    send_command(kMavlinkSetMode, {kCustomMode, static_cast<double>(*settings_.mode)}, out);
  if (settings_.arms && !is_armed_ && is_in_mode) send_command(kMavlinkArm, {1}, out);
}

// After the mode is acknowledged, the vehicle can be armed without waiting for the next heartbeat.
void MavlinkVehicle::on_answer(const Packet& packet, Output& out) {
  constexpr std::uint8_t kAccepted = 0;
  const bool is_done = packet.number<std::uint8_t>(2) == kAccepted;
  if (is_done && packet.number<std::uint16_t>(0) == kMavlinkSetMode && settings_.arms &&
      !is_armed_ && !settings_.only_listen)
    send_command(kMavlinkArm, {1}, out);
}

void MavlinkVehicle::on_gps(const Packet& packet) {
  constexpr double kDegrees = 1e-7 * kMavlinkPi / 180;
  constexpr std::uint16_t kUnknown = 0xFFFF;
  const auto fix = packet.number<std::uint8_t>(28);
  GpsData& gps = gps_.data;
  gps.mode = fix < 2 ? gps_mode::kInvalid : fix == 2 ? gps_mode::k2d : gps_mode::k3d;
  if (fix >= 4) gps.mode = gps_mode::k3d | gps_mode::kDifferential;
  gps.latitude = packet.number<std::int32_t>(8) * kDegrees;
  gps.longitude = packet.number<std::int32_t>(12) * kDegrees;
  gps.altitude = packet.number<std::int32_t>(16);
  const auto dop = packet.number<std::uint16_t>(20);
  const auto speed = packet.number<std::uint16_t>(24);
  const auto course = packet.number<std::uint16_t>(26);
  const auto satellites = packet.number<std::uint8_t>(29);
  gps.pdop = dop == kUnknown ? 0 : static_cast<f32>(dop) / 100;
  gps.speed = speed == kUnknown ? 0 : speed * 10;
  gps.heading = course == kUnknown ? 0 : real(course * kMavlinkPi / 18000);
  gps.satelliteNum = satellites == 0xFF ? 0 : satellites;
  // The time is since 1970 if the autopilot knows it, otherwise since power-on.
  constexpr std::uint64_t kYear2000 = 946684800ULL * 1000000;
  const auto time = packet.number<std::uint64_t>(0);
  gps.utcTime = time > kYear2000 ? static_cast<i64>(time / 1000000) : 0;
  gps_.recorded = packet.began;
  gps_.is_new = true;
}

// Unknown angular rates are replaced by 0; messages with unknown angles are discarded.
void MavlinkVehicle::on_attitude(const Packet& packet) {
  const auto speed = [&](std::size_t at) {
    return is_measured({packet.real(at)}) ? packet.real(at) : 0;
  };
  if (!is_measured({packet.real(4), packet.real(8), packet.real(12)})) return;
  roll_ = packet.real(4);
  pitch_ = packet.real(8);
  yaw_ = packet.real(12);
  yaw_speed_ = speed(24);
  GyroData& gyro = gyro_.data;
  gyro.roll = real(roll_);
  gyro.pitch = real(pitch_);
  gyro.yaw = real(yaw_);
  gyro.wRoll = real(speed(16));
  gyro.wPitch = real(speed(20));
  gyro.wYaw = real(yaw_speed_);
  gyro_.recorded = packet.began;
  gyro_.is_new = true;
}

void MavlinkVehicle::on_local_position(const Packet& packet) {
  if (has_odometry_) return;
  on_motion({packet.real(4), packet.real(8), packet.real(12)}, packet.real(16), packet.real(20),
            packet.began);
}

// Contains the speed in the body frame and the attitude as a quaternion.
void MavlinkVehicle::on_odometry(const Packet& packet) {
  constexpr std::uint8_t kLocalNed = 1;
  if (packet.number<std::uint8_t>(228) != kLocalNed) return;
  const double w = packet.real(20);
  const double x = packet.real(24);
  const double y = packet.real(28);
  const double z = packet.real(32);
  if (!is_measured({w, x, y, z})) return;
  has_odometry_ = true;
  yaw_ = std::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
  yaw_speed_ = is_measured({packet.real(56)}) ? packet.real(56) : 0;
  const double forward = packet.real(36);
  const double right = packet.real(40);
  on_motion({packet.real(8), packet.real(12), packet.real(16)},
            forward * std::cos(yaw_) - right * std::sin(yaw_),
            forward * std::sin(yaw_) + right * std::cos(yaw_), packet.began);
}

void MavlinkVehicle::on_motion(const Pose& pose, double north, double east, Time when) {
  if (!is_measured({pose.x, pose.y, pose.z, north, east})) return;
  ChassisData& data = chassis_.data;
  if (!chassis_.is_new) {
    data.deltaX = data.deltaY = 0;
    data.deltaRho = 0;
  }
  if (pose_) {
    const double dx = (pose.x - pose_->x) * 1000;
    const double dy = (pose.y - pose_->y) * 1000;
    const double turned = std::remainder(yaw_ - yaw_before_, 2 * kMavlinkPi);
    const double middle = yaw_before_ + turned / 2;
    data.deltaX = data.deltaX + real(dx * std::cos(middle) + dy * std::sin(middle));
    data.deltaY = data.deltaY + real(dy * std::cos(middle) - dx * std::sin(middle));
    data.deltaRho = data.deltaRho + real(turned);
  }
  pose_ = pose;
  yaw_before_ = yaw_;
  data.vx = real((north * std::cos(yaw_) + east * std::sin(yaw_)) * 1000);
  data.vy = real((east * std::cos(yaw_) - north * std::sin(yaw_)) * 1000);
  data.omega = real(yaw_speed_);
  data.battery = real(battery_);
  chassis_.recorded = when;
  chassis_.is_new = true;

  Position3d& position = position_.data.pos;
  position.x = millimetres(pose.x);
  position.y = millimetres(pose.y);
  position.z = millimetres(pose.z);
  position.phi = real(roll_);
  position.psi = real(pitch_);
  position.rho = real(yaw_ < 0 ? yaw_ + 2 * kMavlinkPi : yaw_);
  position_.recorded = when;
  position_.is_new = true;
}

bool MavlinkVehicle::take(ChassisData& data, Time& recorded) {
  return chassis_.take(data, recorded);
}
bool MavlinkVehicle::take_gps(GpsData& data, Time& recorded) { return gps_.take(data, recorded); }
bool MavlinkVehicle::take_gyro(GyroData& data, Time& recorded) {
  return gyro_.take(data, recorded);
}
bool MavlinkVehicle::take_position(PositionData& data, Time& recorded) {
  return position_.take(data, recorded);
}

}  // namespace rack::device
