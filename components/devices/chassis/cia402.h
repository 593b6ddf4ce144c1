// A CiA 402 drive on a CANopen bus.
//
// The host has its own node id (127 here). It sets the state of all nodes (NMT 000: 01 operational,
// 80 pre-operational), writes objects by SDO (600 + node, answered at 580 + node), and then
// controls the drive by process data: RPDO1 (200 + node) contains the controlword and the target;
// TPDO1 (180 + node) the statusword and the position, TPDO2 (280 + node) the velocity, sent after
// each SYNC (080). The controlwords 06, 07, 0F lead from switch-on disabled to operation enabled;
// 80 clears a fault.
//
// Both sides send heartbeats (700 + node). The drive monitors that of the host (1016) and makes a
// quick stop (6007, 605A) when it is missing. A vehicle therefore stops when its host crashes or
// its cable is cut.
//
// Source: CiA 301 and CiA 402, as quoted in the manuals of many drives.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "components/devices/chassis/motor.h"

namespace rack::device {

namespace canopen {

inline constexpr std::uint8_t kHost = 127;
inline constexpr std::uint32_t kNmt = 0x000;
inline constexpr std::uint32_t kSync = 0x080;
inline constexpr std::uint32_t kEmergency = 0x080;
inline constexpr std::uint32_t kTpdo1 = 0x180;
inline constexpr std::uint32_t kRpdo1 = 0x200;
inline constexpr std::uint32_t kTpdo2 = 0x280;
inline constexpr std::uint32_t kRpdo2 = 0x300;
inline constexpr std::uint32_t kSdoAnswer = 0x580;
inline constexpr std::uint32_t kSdoRequest = 0x600;
inline constexpr std::uint32_t kHeartbeat = 0x700;

inline constexpr std::byte kOperational{0x05};
inline constexpr Duration kHostHeartbeat = std::chrono::milliseconds(50);
// A drive stops after this time without the heartbeat of the host.
inline constexpr Duration kHostLost = std::chrono::milliseconds(200);

// An SDO download of up to four bytes, and its abort.
std::array<std::byte, 8> sdo_write(std::uint16_t index, std::uint8_t sub, std::uint32_t value,
                                   std::size_t size);

// The part of the host common to all drives of a bus: heartbeat and SYNC.
class Host {
 public:
  explicit Host(Duration sync) : sync_(sync) {}
  void start(Time now);
  void on_timeout(Time now, Output& out);
  [[nodiscard]] Time next_timeout() const { return std::min(next_heartbeat_, next_sync_); }
  void stop() { next_heartbeat_ = next_sync_ = tims::kNever; }

 private:
  Duration sync_;
  Time next_heartbeat_ = tims::kNever;
  Time next_sync_ = tims::kNever;
};

}  // namespace canopen

// The state in the statusword.
enum class Cia402State : std::uint8_t {
  kNotReady,
  kSwitchOnDisabled,
  kReadyToSwitchOn,
  kSwitchedOn,
  kOperationEnabled,
  kQuickStopActive,
  kFaultReaction,
  kFault,
};
Cia402State cia402_state(std::uint16_t statusword);

enum class Cia402Mode : std::int8_t { kProfilePosition = 1, kProfileVelocity = 3, kHoming = 6 };

struct Cia402Settings {
  std::uint8_t node = 1;
  MotorTask task = MotorTask::kTurns;
  double increments_of_turn = 4096;  // units of object 6064 per turn
  double velocity_of_turn = 4096;    // value of 606C and 60FF at 1 turn/s; 60 if the unit is rpm
  // rad/s2 at the shaft.
  double acceleration = 100;
  double deceleration = 100;
  double quick_stop = 400;
  std::int8_t homing_method = 35;  // 35, 37: the current position becomes 0
  bool only_listen = false;        // recording, which may start after the drive was set up
};

class Cia402 final : public Motor {
 public:
  explicit Cia402(const Cia402Settings& settings);

  void start(Time now, Output& out) override;
  bool on_frame(const Arrival& frame, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }
  [[nodiscard]] CanFilter wanted_frames() const override {
    return {.id = settings_.node, .mask = can::kExtended | can::kRemote | 0x7F};
  }
  void command(double target, Time now, Output& out) override;
  void stand(Output& out) const override;
  void stop(Output& out) override;
  [[nodiscard]] bool is_ready() const override {
    return is_set_up_ && drive_state() == Cia402State::kOperationEnabled &&
           state_.measured != tims::kNever;
  }
  [[nodiscard]] Cia402State drive_state() const { return cia402_state(statusword_); }

  // For positioning drives: limits of velocity and acceleration, rad/s and rad/s2; 0: unchanged.
  void limit(double velocity, double acceleration, Output& out) const;
  void home(Time now, Output& out);
  [[nodiscard]] bool is_homing() const { return homing_ != Homing::kNone; }
  // The drive has reached its target.
  [[nodiscard]] bool is_reached() const;

 private:
  struct Object {
    std::uint16_t index;
    std::uint8_t sub;
    std::uint8_t size;
    std::uint32_t value;
    bool is_optional = false;  // the drive need not have this object
  };
  enum class Homing : std::uint8_t { kNone, kMethod, kMode, kRuns, kBack };

  void plan();
  void map(std::uint16_t communication, std::uint32_t id, std::uint8_t transmission,
           std::initializer_list<std::uint32_t> objects);
  void nmt(int command, Output& out) const;
  void write(const Object& object, Time now, Output& out);
  void on_written(Time now, Output& out);
  void on_sdo(std::span<const std::byte> bytes, Time now, Output& out);
  void on_status(std::span<const std::byte> bytes, Time when, Output& out);
  void on_heartbeat(std::span<const std::byte> bytes, Time when, Output& out);
  void send_control(unsigned controlword, std::int32_t target, Output& out,
                    Time deadline = tims::kNever) const;
  void climb(Output& out);
  [[nodiscard]] bool is_mine(std::uint32_t id, std::uint32_t function) const {
    return id == function + settings_.node;
  }

  Cia402Settings settings_;
  std::vector<Object> setup_;
  std::size_t step_ = 0;
  bool is_set_up_ = false;
  std::optional<Object> writing_;  // the write that waits for an answer
  RetryTimer answer_;
  Time next_ = tims::kNever;
  Time last_heartbeat_ = tims::kNever;
  Time ready_due_ = tims::kNever;

  std::uint16_t statusword_ = 0;
  std::uint16_t error_ = 0;  // code of the last emergency message
  bool was_enabled_ = false;
  bool pulse_ = false;  // current level of the bit for clearing a fault or for a new position
  std::int32_t target_ = 0;
  bool is_new_target_ = false;
  std::optional<std::int32_t> position_;
  Homing homing_ = Homing::kNone;
};

}  // namespace rack::device
