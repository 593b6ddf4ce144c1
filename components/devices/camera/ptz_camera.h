// Emulator of a camera mount: moves at the commanded speeds and reports its position.
#pragma once

#include "components/devices/camera/visca.h"

namespace rack::device::emulator {

class PtzCamera final : public Dialogue {
 public:
  explicit PtzCamera(bool is_datagrams = false) : is_datagrams_(is_datagrams) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;

  // Position in steps.
  [[nodiscard]] double pan() const { return pan_.is; }
  [[nodiscard]] double tilt() const { return tilt_.is; }
  [[nodiscard]] double zoom() const { return zoom_.is; }
  [[nodiscard]] bool stands() const {
    return pan_.velocity == 0 && tilt_.velocity == 0 && zoom_.velocity == 0;
  }

 private:
  struct Axis {
    double is = 0;
    double velocity = 0;  // steps/s
    double target = 0;
    double min = 0;
    double max = 0;

    void advance(double seconds);
    void go_to(double place, double speed);
    void go(double wanted);
  };

  void advance(Time now);
  void on_message(std::span<const std::byte> message, std::uint32_t number, Output& out);
  bool obey(std::span<const std::byte> command);
  void reply(std::span<const std::byte> body, std::uint32_t number, Output& out);

  bool is_datagrams_;
  ViscaMessages messages_;
  Time last_{};
  Axis pan_{.min = -2448, .max = 2448};
  Axis tilt_{.min = -432, .max = 1296};
  Axis zoom_{.min = 0, .max = 0x4000};
  std::vector<std::byte> sending_;
  std::vector<std::byte> message_;
};

}  // namespace rack::device::emulator
