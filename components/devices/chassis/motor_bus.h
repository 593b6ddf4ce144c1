// Emulator of a CAN bus with motor controllers: ODrives, VESCs, CiA 402 drives, each with a turning
// shaft and the watchdog of the real controllers.
#pragma once

#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "components/devices/chassis/cia402.h"
#include "components/devices/chassis/odrive.h"
#include "components/devices/chassis/vesc.h"
#include "components/devices/core/scene.h"
#include "components/geometry/delay.h"
#include "components/geometry/motors.h"

namespace rack::device {

// Model of a motor's shaft, with a target velocity or a target position.
class ShaftModel {
 public:
  void turn(double velocity) { target_.set({.velocity = velocity}); }
  void go_to(double position, double velocity) {
    target_.set({.position = position, .limit = velocity});
  }
  void set_lag(Duration lag) { target_.set_lag(lag); }
  void set_position(double position) { motion_.position = position; }
  void step(Time now);

  [[nodiscard]] double position() const { return motion_.position; }
  [[nodiscard]] double velocity() const { return motion_.speed; }
  [[nodiscard]] double wanted() const { return target_.in_effect().velocity; }
  [[nodiscard]] bool is_there() const;

 private:
  struct Target {
    double velocity = 0;
    std::optional<double> position{};
    double limit = 0;  // maximum velocity towards the position
  };

  LaggingCommand<Target> target_;
  MotorMotion motion_;
};

class EmulatedMotor {
 public:
  virtual ~EmulatedMotor() = default;
  virtual void start(Time now) = 0;
  virtual void on_frame(const Arrival& frame, Output& out) = 0;
  virtual void on_timeout(Time now, Output& out) = 0;
  [[nodiscard]] virtual Time next_timeout() const = 0;

  void step(Time now) { shaft_.step(now); }
  void set_lag(Duration lag) { shaft_.set_lag(lag); }
  [[nodiscard]] const ShaftModel& shaft() const { return shaft_; }
  [[nodiscard]] bool is_enabled() const { return enabled_; }

 protected:
  ShaftModel shaft_;
  bool enabled_ = false;
};

class MotorBus final : public Dialogue, public emulator::Wheelwork {
 public:
  EmulatedMotor& add(std::unique_ptr<EmulatedMotor> motor) {
    return *motors_.emplace_back(std::move(motor));
  }
  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override;

  [[nodiscard]] EmulatedMotor& motor(std::size_t index) { return *motors_[index]; }
  [[nodiscard]] bool stands() const;
  // This motor can no longer send, but still receives.
  void cut_off(std::size_t index) { silent_ = index; }

  [[nodiscard]] std::size_t motor_count() const override { return motors_.size(); }
  void turned(Time now, std::span<double> positions) override;
  [[nodiscard]] bool reports_shafts() const override { return true; }
  void set_lag(Duration lag) override {
    for (const auto& motor : motors_) motor->set_lag(lag);
  }

 private:
  std::vector<std::unique_ptr<EmulatedMotor>> motors_;
  std::optional<std::size_t> silent_;
};

// Vehicles and axes whose motors have nodes 1, 2, and so on.
std::unique_ptr<Dialogue> odrive_base();
std::unique_ptr<Dialogue> vesc_base();
std::unique_ptr<Dialogue> cia402_base();
std::unique_ptr<Dialogue> robucar();
std::unique_ptr<Dialogue> servo();

class OdriveEmulator final : public EmulatedMotor {
 public:
  explicit OdriveEmulator(std::uint8_t node) : node_(node) {}
  void start(Time now) override;
  void on_frame(const Arrival& frame, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  std::uint32_t errors = 0;
  bool sends_encoder = true;  // false: sends it only on request
  bool has_watchdog = true;   // disabled in a new ODrive

 private:
  void send_encoder(Output& out) const;

  std::uint8_t node_;
  bool positions_ = false;
  Time next_ = tims::kNever;
  Time fed_{};
  int tick_ = 0;
};

class VescEmulator final : public EmulatedMotor {
 public:
  VescEmulator(std::uint8_t node, int pole_pairs) : node_(node), pole_pairs_(pole_pairs) {}
  void start(Time now) override;
  void on_frame(const Arrival& frame, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  bool sends_tachometer = true;

 private:
  std::uint8_t node_;
  int pole_pairs_;
  Time next_ = tims::kNever;
  Time fed_{};
};

class Cia402Emulator final : public EmulatedMotor {
 public:
  Cia402Emulator(std::uint8_t node, double increments_of_turn, double velocity_of_turn)
      : node_(node), increments_(increments_of_turn), velocity_(velocity_of_turn) {}
  void start(Time now) override;
  void on_frame(const Arrival& frame, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  void set_fault(std::uint16_t error, Output& out);
  void restart(Output& out);  // as after an interruption of its supply
  [[nodiscard]] Cia402State drive_state() const { return state_; }
  [[nodiscard]] std::optional<std::uint32_t> object(std::uint16_t index, std::uint8_t sub) const;
  std::optional<std::uint16_t> lacks;  // an object that this drive does not have

 private:
  void on_sdo(std::span<const std::byte> bytes, Output& out);
  void on_control(unsigned controlword, std::int32_t target);
  void quick_stop();
  void send_process_data(Output& out) const;
  [[nodiscard]] unsigned statusword() const;

  std::uint8_t node_;
  double increments_;
  double velocity_;
  std::map<std::uint32_t, std::uint32_t> objects_;
  bool operational_ = false;
  Cia402State state_ = Cia402State::kSwitchOnDisabled;
  bool taken_ = false;  // the new position was acknowledged
  bool homed_ = false;
  unsigned control_ = 0;
  Time last_host_heartbeat_ = tims::kNever;
  Time next_ = tims::kNever;
  int tick_ = 0;
};

}  // namespace rack::device
