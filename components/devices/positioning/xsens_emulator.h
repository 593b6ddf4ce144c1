// Emulator of an Xsens device, label up, on a robot that turns and sways, or follows its scene. It
// sends MTData2, or MTData like older devices.
#pragma once

#include "components/devices/core/scene.h"
#include "components/devices/positioning/xsens.h"

namespace rack::device::emulator {

// Turns on the spot and sways by an angle to both sides with a period of two seconds.
struct Swaying {
  double turn = 0.2;   // rad/s
  double sway = 0.05;  // rad

  Motion operator()(Time when, Duration since_start) const;
};

struct XsensEmulatorSettings {
  bool is_old = false;  // does not support MTData2
  Inertia inertia = Swaying{};
  std::uint32_t id = 0x03780F4A;
};

class XsensEmulator : public Dialogue {
 public:
  XsensEmulator() : XsensEmulator(XsensEmulatorSettings{}) {}
  explicit XsensEmulator(const XsensEmulatorSettings& settings) : settings_(settings) {}

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return next_; }

  [[nodiscard]] bool is_measuring() const { return next_ != tims::kNever; }

 private:
  void on_message(const XsensMessage& message, Time now, Output& out);
  bool configure(const XsensMessage& message);
  void append_data(const Motion& motion);
  void append_data2(const Motion& motion);

  XsensEmulatorSettings settings_;
  XsensMessages messages_;
  Duration period_ = std::chrono::milliseconds(10);
  Time began_{};
  Time next_ = tims::kNever;
  std::uint16_t counter_ = 0;
  std::vector<std::byte> answer_;
  std::vector<std::byte> body_;
};

class XsensOldEmulator final : public XsensEmulator {
 public:
  XsensOldEmulator() : XsensEmulator({.is_old = true}) {}
};

}  // namespace rack::device::emulator
