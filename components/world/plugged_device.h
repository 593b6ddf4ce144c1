// An emulated device at its line, which can be pulled out and plugged in. What has power of its own
// lives on meanwhile: a base drives on until its watchdog has waited long enough.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "components/devices/io/device.h"

namespace rack::device {

class PluggedDevice {
 public:
  // `name`: "scout/laser", for people. `baud`: of its line when it is switched on.
  PluggedDevice(std::string name, DeviceAddress address, std::uint32_t baud,
                std::unique_ptr<Dialogue> emulator)
      : name_(std::move(name)),
        address_(std::move(address)),
        baud_(baud),
        emulator_(std::move(emulator)) {}

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const DeviceAddress& address() const { return address_; }
  [[nodiscard]] bool is_plugged() const { return is_plugged_; }

  // Already so: nothing happens. An error: its line cannot be opened; it is pulled out.
  tims::Result<void> plug();
  void pull();

  // What is due, and what has come. A line that was lost is opened again after a while; the text
  // says why, once.
  std::optional<std::string> serve(Time now);
  // To be waited for, or -1.
  [[nodiscard]] int descriptor() const { return device_ ? device_->descriptor() : -1; }
  [[nodiscard]] Time next_timeout() const;

 private:
  tims::Result<void> open();

  std::string name_;
  DeviceAddress address_;
  std::uint32_t baud_;
  std::unique_ptr<Dialogue> emulator_;
  std::unique_ptr<Device> device_;  // or none: it hears nothing, and nobody hears it
  bool is_plugged_ = false;
  Time retry_ = tims::kNever;
};

}  // namespace rack::device
