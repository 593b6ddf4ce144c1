// A vehicle with a MAVLink autopilot (mavlink.h): rovers of ArduPilot and PX4, and any other
// vehicle that accepts velocity commands.
//
// The autopilot and this driver send a heartbeat (0) once a second. The driver requests data
// (command 511) and sends a velocity and a turning speed in the body frame (84) at 10 Hz or more.
// The autopilot stops the vehicle after three seconds without a velocity (a setting), and by its
// ground station failsafe when the heartbeat of the driver is missing. It accepts commands only in
// a suitable mode and when it is armed; the driver sets both only if configured.
//
// The frames are the same as in RACK: north, east, down; forward, right, clockwise.
#pragma once

#include "components/devices/chassis/chassis_control.h"
#include "components/devices/chassis/mavlink.h"
#include "rack/proxies/gps.h"
#include "rack/proxies/gyro.h"
#include "rack/proxies/position.h"

namespace rack::device {

struct MavlinkSettings {
  std::uint8_t system = 0;        // id of the autopilot; 0: the first one received
  std::uint8_t own_system = 255;  // id of a ground station
  bool arms = false;              // arm at the start and disarm at the end
  std::optional<std::uint32_t>
      mode{};  // custom mode, for example that of "guided" or "offboard", set at the start
  Duration period = std::chrono::milliseconds(100);  // period of the data
  bool only_listen = false;                          // the device is a recording
};

class MavlinkVehicle final : public ChassisDialogue {
 public:
  explicit MavlinkVehicle(const MavlinkSettings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override;

  void drive(const ChassisSpeed& speed, Time now) override;
  // A heartbeat was received.
  [[nodiscard]] bool is_ready() const override { return target_ != 0; }
  bool take(ChassisData& data, Time& recorded) override;
  bool take_gps(GpsData& data, Time& recorded);
  bool take_gyro(GyroData& data, Time& recorded);
  bool take_position(PositionData& data, Time& recorded);

  [[nodiscard]] bool is_armed() const { return is_armed_; }

 private:
  struct Pose {
    double x = 0;  // m
    double y = 0;
    double z = 0;
  };

  void on_packet(const mavlink::Packet& packet, Time now, Output& out);
  void on_heartbeat(const mavlink::Packet& packet, Time now, Output& out);
  void on_answer(const mavlink::Packet& packet, Output& out);
  void on_gps(const mavlink::Packet& packet);
  void on_attitude(const mavlink::Packet& packet);
  void on_local_position(const mavlink::Packet& packet);
  void on_odometry(const mavlink::Packet& packet);
  void on_motion(const Pose& pose, double north, double east, Time when);
  void send_heartbeat(Output& out);
  void send_command(std::uint16_t command, std::initializer_list<double> parameters, Output& out);
  void send_velocity(Output& out);
  mavlink::Writer writer(mavlink::Message message);

  MavlinkSettings settings_;
  mavlink::Packets packets_;
  mavlink::Packet packet_;
  std::uint8_t target_ = 0;  // system id of the autopilot
  std::uint8_t component_ = 0;
  std::uint8_t sequence_ = 0;
  bool is_armed_ = false;
  bool has_odometry_ = false;  // odometry was received and takes precedence over local position
  Time last_heartbeat_ = tims::kNever;
  Time next_heartbeat_ = tims::kNever;
  Time next_velocity_ = tims::kNever;
  Time last_velocity_{};
  ChassisSpeed wanted_;

  double roll_ = 0;
  double pitch_ = 0;
  double yaw_ = 0;
  double yaw_speed_ = 0;
  std::optional<Pose> pose_;
  double yaw_before_ = 0;
  double battery_ = 0;

  // Data that were not yet taken.
  template <class Data>
  struct Slot {
    Data data{};
    Time recorded{};
    bool is_new = false;
    bool take(Data& to, Time& when) {
      if (!std::exchange(is_new, false)) return false;
      to = data;
      when = recorded;
      return true;
    }
  };
  Slot<ChassisData> chassis_;
  Slot<GpsData> gps_;
  Slot<GyroData> gyro_;
  Slot<PositionData> position_;
};

}  // namespace rack::device
