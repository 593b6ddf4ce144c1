#include "components/devices/chassis/roomba.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr int kStart = 0x80;
constexpr int kRoombaBaud = 0x81;
constexpr int kControl = 0x82;
constexpr int kFull = 0x84;
constexpr int kDrive = 0x89;
constexpr int kMotors = 0x8A;
constexpr int kSensors = 0x8E;
constexpr int kDock = 0x8F;
constexpr int kDriveDirect = 0x91;
constexpr int kStream = 0x94;
constexpr int kPauseStream = 0x96;

constexpr std::uint32_t kBaudAtPowerOn = 57600;
constexpr std::uint32_t kBaudWorking = 19200;
constexpr int kBaudWorkingCode = 7;
constexpr std::uint32_t kBaudCreate2 = 115200;

constexpr Duration kRoombaPeriod = 100ms;
constexpr Duration kRoombaBetween = 15ms;  // cycle of the interface
constexpr Duration kOvercurrentMax = 1s;
constexpr std::size_t kAnswer = 26;
constexpr int kSpeedMax = 500;
constexpr int kRadiusMax = 2000;
constexpr int kStraight = 0x8000;

int rounded(double value) { return static_cast<int>(std::lround(value)); }

// Position of a sensor, mm: forward, right.
struct Place {
  i32 x;
  i32 y;
};
constexpr Place kWall{110, 200};
constexpr std::array<Place, 4> kCliffs = {{{70, -170}, {170, -45}, {170, 45}, {70, 170}}};
constexpr Place kBumpLeft{195, -95};
constexpr Place kBumpRight{195, 95};

}  // namespace

bool decode_roomba_sensors(std::span<const std::byte> bytes, double track, RoombaSensors& sensors) {
  if (bytes.size() != kAnswer || byte_at(bytes, 0) > 0x1F || byte_at(bytes, 7) > 0x1F) return false;
  for (std::size_t i = 1; i <= 6; ++i)
    if (byte_at(bytes, i) > 1) return false;
  constexpr int kChargingMax = 5;
  if (byte_at(bytes, 16) > kChargingMax) return false;
  sensors.bumps = static_cast<std::uint8_t>(byte_at(bytes, 0));
  sensors.wall = byte_at(bytes, 1) != 0;
  for (std::size_t i = 0; i < 4; ++i) sensors.cliffs[i] = byte_at(bytes, 2 + i) != 0;
  sensors.overcurrents = static_cast<std::uint8_t>(byte_at(bytes, 7));
  const double distance = big_endian<std::int16_t>(bytes, 12);
  // Half of the difference between right and left wheel, mm; positive: counterclockwise.
  const double turn = big_endian<std::int16_t>(bytes, 14) / (track / 2);
  sensors.distances = {static_cast<float>(distance - turn * track / 2),
                       static_cast<float>(distance + turn * track / 2)};
  sensors.charging = static_cast<std::uint8_t>(byte_at(bytes, 16));
  sensors.battery = static_cast<float>(big_endian<std::uint16_t>(bytes, 17)) / 1000;
  return true;
}

// --- Create 2

std::size_t create2_packet_size(std::uint8_t id) { return id == 22 || id >= 43 ? 2 : 1; }

void Create2Frames::clear() {
  buffer_.clear();
  counts_.reset();
}

bool Create2Frames::next(RoombaSensors& sensors, Time& began) {
  constexpr int kHead = 0x13;
  constexpr std::size_t kBody = [] {
    std::size_t size = 0;
    for (const std::uint8_t id : kCreate2Packets) size += id == 22 || id >= 43 ? 3 : 2;
    return size;
  }();
  while (buffer_.size() >= 2) {
    const auto bytes = buffer_.bytes();
    if (byte_at(bytes, 0) != kHead || byte_at(bytes, 1) != static_cast<int>(kBody)) {
      buffer_.consume(1);
      continue;
    }
    if (bytes.size() < kBody + 3) return false;
    int sum = 0;
    for (std::size_t i = 0; i < kBody + 3; ++i) sum += byte_at(bytes, i);
    bool good = (sum & 0xFF) == 0;
    std::array<int, kCreate2Packets.size()> values{};
    std::size_t where = 2;
    for (std::size_t i = 0; i < values.size(); ++i) {
      good = good && byte_at(bytes, where) == kCreate2Packets[i];
      const bool has_two_bytes = create2_packet_size(kCreate2Packets[i]) == 2;
      values[i] =
          has_two_bytes ? big_endian<std::uint16_t>(bytes, where + 1) : byte_at(bytes, where + 1);
      where += has_two_bytes ? 3 : 2;
    }
    if (!good) {
      ++broken_;
      buffer_.consume(1);
      continue;
    }
    began = buffer_.time_of(0);
    buffer_.consume(kBody + 3);
    sensors.bumps = static_cast<std::uint8_t>(values[0]);
    sensors.wall = values[1] != 0;
    for (std::size_t i = 0; i < 4; ++i) sensors.cliffs[i] = values[2 + i] != 0;
    sensors.overcurrents = static_cast<std::uint8_t>(values[6]);
    sensors.charging = static_cast<std::uint8_t>(values[7]);
    sensors.battery = static_cast<float>(values[8]) / 1000;
    const std::array counts{static_cast<std::uint16_t>(values[9]),
                            static_cast<std::uint16_t>(values[10])};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto moved =
          counts_ ? static_cast<std::int16_t>(counts[i] - (*counts_)[i]) : std::int16_t{0};
      sensors.distances[i] = static_cast<float>(moved * kCreate2MillimetresOfCount);
    }
    counts_ = counts;
    return true;
  }
  return false;
}

// --- the dialogue

template <typename... Bytes>
void Roomba::send(Output& out, Bytes... bytes) {
  const std::array command{static_cast<std::byte>(bytes)...};
  out.send(command);
}

void Roomba::start(Time now, Output&) {
  clear_failure();
  step_ = 0;
  asked_ = false;
  answer_.clear();
  frames_.clear();
  has_data_ = false;
  distance_ = turn_ = 0;
  wanted_ = {};
  recorded_before_ = {};
  overcurrent_since_ = tims::kNever;
  is_running_ = settings_.only_listen;
  next_step_ = settings_.only_listen ? tims::kNever : now;
  next_drive_ = tims::kNever;
}

// Sends one command per call, with the required pause.
void Roomba::setup(Time now, Output& out) {
  const bool is_old = settings_.model == RoombaModel::kRoomba;
  next_step_ = now + 20ms;
  switch (step_++) {
    case 0:
      out.set_baud(is_old ? kBaudAtPowerOn : kBaudCreate2);
      send(out, kStart);
      if (is_old) next_step_ = now + 100ms;
      return;
    case 1:
      if (!is_old) return;
      send(out, kRoombaBaud, kBaudWorkingCode);
      next_step_ = now + 250ms;
      return;
    case 2:
      if (!is_old) return;
      out.set_baud(kBaudWorking);
      send(out, kStart);
      return;
    case 3:
      if (is_old) send(out, kControl);
      return;
    case 4:
      send(out, kFull);
      return;
    case 5:
      send(out, kMotors,
           (settings_.side_brush ? 1 : 0) | (settings_.vacuum ? 2 : 0) |
               (settings_.main_brush ? 4 : 0));
      return;
    case 6:
      if (settings_.dock) send(out, kDock);
      return;
    default:
      break;
  }
  if (!is_old) {
    std::array<std::byte, 2 + kCreate2Packets.size()> stream{
        static_cast<std::byte>(kStream), static_cast<std::byte>(kCreate2Packets.size())};
    for (std::size_t i = 0; i < kCreate2Packets.size(); ++i)
      stream[2 + i] = static_cast<std::byte>(kCreate2Packets[i]);
    out.send(stream);
  }
  is_running_ = true;
  next_drive_ = now + kRoombaBetween;
}

Time Roomba::next_timeout() const {
  return is_running_ ? std::min(next_step_, next_drive_) : next_step_;
}

void Roomba::on_timeout(Time now, Output& out) {
  if (!is_running_) {
    if (next_step_ <= now) setup(now, out);
    return;
  }
  if (next_drive_ <= now) send_speed(now, out);
  if (next_step_ > now) return;
  if (settings_.model == RoombaModel::kCreate2) {
    next_step_ = tims::kNever;
    return;
  }
  // The answer has no frame: only bytes received after the request belong to it.
  answer_.clear();
  asked_ = true;
  send(out, kSensors, 0);
  next_step_ = now + kRoombaPeriod;
}

void Roomba::drive(const ChassisSpeed& speed, Time now) {
  if (settings_.only_listen) return;
  if (is_running_ && !(speed == wanted_))
    next_drive_ = std::min(next_drive_, std::max(now, last_drive_ + kRoombaBetween));
  wanted_ = speed;
}

void Roomba::send_speed(Time now, Output& out) {
  last_drive_ = now;
  next_drive_ = now + kRoombaPeriod;
  if (settings_.dock) return;  // the robot drives autonomously
  const auto speed = static_cast<double>(wanted_.vx);
  const auto omega = static_cast<double>(wanted_.omega);
  if (settings_.model == RoombaModel::kCreate2) {
    const int right =
        std::clamp(rounded(speed - omega * settings_.track / 2), -kSpeedMax, kSpeedMax);
    const int left =
        std::clamp(rounded(speed + omega * settings_.track / 2), -kSpeedMax, kSpeedMax);
    send(out, kDriveDirect, right >> 8, right, left >> 8, left);
    return;
  }
  int along = std::clamp(rounded(speed), -kSpeedMax, kSpeedMax);
  int radius = kStraight;
  if (along == 0 && omega != 0) {  // on the spot: 1 counterclockwise, -1 clockwise
    along = std::min(rounded(std::abs(omega) * settings_.track / 2), kSpeedMax);
    radius = omega > 0 ? -1 : 1;
  } else if (omega != 0 && std::abs(speed / omega) <= kRadiusMax) {
    radius = rounded(-speed / omega);  // positive: left curve
  }
  send(out, kDrive, along >> 8, along, radius >> 8, radius);
}

void Roomba::stop(Time, Output& out) {
  if (settings_.only_listen) return;
  out.send(kRoombaStop);
  send(out, kMotors, 0);
  if (settings_.model == RoombaModel::kCreate2) send(out, kPauseStream, 0);
  is_running_ = false;
  next_step_ = next_drive_ = tims::kNever;
}

void Roomba::on_arrival(const Arrival& arrival, Output&) {
  if (settings_.model == RoombaModel::kCreate2) {
    frames_.add(arrival);
    RoombaSensors sensors;
    Time began;
    while (frames_.next(sensors, began)) on_sensors(sensors, began);
    return;
  }
  if (!asked_ && !settings_.only_listen) return;
  answer_.add(arrival);
  if (answer_.size() < kAnswer) return;
  RoombaSensors sensors;
  if (decode_roomba_sensors(answer_.bytes().first(kAnswer), settings_.track, sensors))
    on_sensors(sensors, answer_.time_of(0));
  answer_.clear();
  asked_ = false;
}

void Roomba::on_sensors(const RoombaSensors& sensors, Time measured) {
  if (!is_running_) return;
  sensors_ = sensors;
  distance_ += static_cast<double>(sensors.distances[0] + sensors.distances[1]) / 2;
  turn_ += static_cast<double>(sensors.distances[0] - sensors.distances[1]) / settings_.track;
  if (sensors.overcurrents == 0) {
    overcurrent_since_ = tims::kNever;
  } else if (overcurrent_since_ == tims::kNever) {
    overcurrent_since_ = measured;
  } else if (measured - overcurrent_since_ >= kOvercurrentMax) {
    fail(tims::Errc::kSystem, (sensors.overcurrents & 0x18) != 0
                                  ? "overcurrent of a wheel for 1 s: check whether it is blocked"
                                  : "overcurrent of a brush for 1 s: check whether it is blocked");
    return;
  }
  constexpr Duration kJitter = 10ms;
  if (recorded_before_ != Time{} && measured - recorded_before_ < kRoombaPeriod - kJitter) return;
  const double seconds = std::chrono::duration<double>(measured - recorded_before_).count();
  const bool is_first = recorded_before_ == Time{};
  data_.deltaX = is_first ? 0 : static_cast<f32>(distance_);
  data_.deltaRho = is_first ? 0 : static_cast<f32>(turn_);
  data_.vx = is_first ? 0 : static_cast<f32>(distance_ / seconds);
  data_.omega = is_first ? 0 : static_cast<f32>(turn_ / seconds);
  data_.battery = sensors.battery;
  distance_ = turn_ = 0;
  recorded_ = recorded_before_ = measured;
  has_data_ = true;
}

bool Roomba::take(ChassisData& data, Time& recorded) {
  if (!std::exchange(has_data_, false)) return false;
  data = data_;
  recorded = recorded_;
  return true;
}

void Roomba::look(Scan2dData& scan) const {
  scan.points.clear();
  const auto add = [&](bool seen, Place place, i16 segment) {
    if (!seen) return;
    const double range = std::hypot(place.x, place.y);
    scan.points.push_back({.x = place.x, .y = place.y, .z = rounded(range), .segment = segment});
  };
  add(sensors_.wall, kWall, 0);
  for (std::size_t i = 0; i < kCliffs.size(); ++i) add(sensors_.cliffs[i], kCliffs[i], 1);
  add((sensors_.bumps & 2) != 0, kBumpLeft, 2);
  add((sensors_.bumps & 1) != 0, kBumpRight, 2);
}

}  // namespace rack::device
