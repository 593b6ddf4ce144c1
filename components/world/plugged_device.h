// An emulated device on its line, which can be unplugged and plugged in. A device with its own
// power supply keeps running: a base drives on until its watchdog expires.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "rack/devices/device.h"

namespace rack::device {

class PluggedDevice {
 public:
  // `name`: "scout/laser", for messages. `baud`: of its line after power-on.
  PluggedDevice(std::string name, DeviceAddress address, std::uint32_t baud,
                std::unique_ptr<Dialogue> emulator)
      : name_(std::move(name)),
        address_(std::move(address)),
        baud_(baud),
        emulator_(std::move(emulator)) {}

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const DeviceAddress& address() const { return address_; }
  [[nodiscard]] bool is_plugged() const { return is_plugged_; }

  // No effect when it is plugged in. Error: its line cannot be opened; it stays unplugged.
  tims::Result<void> plug();
  void pull();

  // Processes timers and received bytes. A lost line is opened again after a while; the text is the
  // reason, returned once.
  std::optional<std::string> serve(Time now);
  // The descriptor to poll, or -1.
  [[nodiscard]] int descriptor() const { return device_ ? device_->descriptor() : -1; }
  [[nodiscard]] Time next_timeout() const;

 private:
  tims::Result<void> open();

  std::string name_;
  DeviceAddress address_;
  std::uint32_t baud_;
  std::unique_ptr<Dialogue> emulator_;
  std::unique_ptr<Device> device_;  // nullptr: the line is closed
  bool is_plugged_ = false;
  Time retry_ = tims::kNever;
};

}  // namespace rack::device
