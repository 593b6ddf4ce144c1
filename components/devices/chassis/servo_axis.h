// One axis with a drive after CiA 402: a pan unit, a turntable, a lift.
#pragma once

#include <utility>

#include "components/devices/chassis/cia402.h"
#include "components/devices/chassis/move_deadline.h"
#include "rack/proxies/servo_drive.h"

namespace rack::device {

struct ServoAxisSettings {
  Cia402Settings drive{};
  double gear =
      1;  // rad of the motor for 1 rad, or 1 mm, of the axis; below 0: the other way round
  // Where it may be, rad or mm.
  double min = -1e9;
  double max = 1e9;
  double velocity_max = 1;  // rad/s or mm/s
  Duration period = std::chrono::milliseconds(50);
  Duration move_deadline{};  // of move(); 0: three periods of who calls it
  bool only_listen = false;  // to a recording
};

// At `time`, at an even speed between two data sets.
ServoDriveData interpolated(const ServoDriveData& before, const ServoDriveData& after,
                            TimeStamp time);

class ServoAxis final : public Dialogue {
 public:
  explicit ServoAxis(const ServoAxisSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  void stop(Time now, Output& out) override;
  [[nodiscard]] std::vector<Telegram> last_words() const override;
  [[nodiscard]] Time next_timeout() const override;
  [[nodiscard]] std::vector<CanFilter> wanted_frames() const override;

  // velocity, acceleration: limits on the way; 0: the largest.
  void move_to(double position, double velocity, double acceleration);
  // Until it is at the end of its way, or nobody has said it again in time (move_deadline.h). 0: it
  // stays where it is.
  void move(double velocity, Time now);
  // It was stopped because nobody said it again. True once for each time.
  bool take_overdue() { return std::exchange(overdue_, false); }
  // Here, or where its homing method finds it, is 0.
  void home();

  [[nodiscard]] bool is_ready() const { return is_ready_; }
  // It is where it was told to be.
  [[nodiscard]] bool is_reached() const;
  bool take(ServoDriveData& data, Time& recorded);

 private:
  void check(Time now, Output& out);
  void command(Time now, Output& out);
  [[nodiscard]] double position() const { return drive_.state().position / settings_.gear; }

  ServoAxisSettings settings_;
  Cia402 drive_;
  canopen::Host host_;
  bool is_ready_ = false;
  bool is_stopped_ = true;
  Time next_cycle_ = tims::kNever;
  Time next_data_ = tims::kNever;
  MoveDeadline deadline_;
  bool overdue_ = false;
  double target_ = 0;  // rad or mm
  double velocity_ = 0;
  double acceleration_ = 0;
  bool has_limits_ = false;  // that were not sent yet
  bool shall_home_ = false;
  bool has_data_ = false;
  Time recorded_{};
};

}  // namespace rack::device
