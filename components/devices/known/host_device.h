// A device of this host according to the kernel: its name, program, address and missing setup.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "components/devices/known/known_devices.h"

namespace rack::device {

enum class HostDeviceKind : std::uint8_t {
  kSerial,
  kCan,
  kVideo,
  kInput,
  kGpio,
  kPps,
  kUsb,
  kIidc
};
std::string_view name(HostDeviceKind kind);  // "serial"

struct UsbIdentity {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string serial_number{};
  std::string text{};            // manufacturer and product reported by the device
  std::uint32_t plugged_as = 0;  // number on the bus; changes when the device is plugged in again

  bool operator==(const UsbIdentity&) const = default;
};

struct HostDevice {
  HostDeviceKind kind = HostDeviceKind::kSerial;
  std::string node{};    // "ttyUSB0", "can0", "video0", "event3", or "1-2" on the USB bus
  std::string path{};    // "/dev/ttyUSB0"; empty if there is no device file
  std::string stable{};  // a link that does not depend on the port the device is plugged into
  std::optional<UsbIdentity> usb{};
  std::string guid{};    // of a FireWire camera, 16 hex digits
  std::string text{};    // name given by the kernel
  std::string driver{};  // kernel driver; empty: none

  bool is_there = true;                // the device file exists
  bool may_use = true;                 // this user has access
  std::string group{};                 // group with access
  std::vector<std::string> used_by{};  // "LadarSickLms200 (pid 4711)"
  std::optional<int> latency_ms{};     // latency timer of a USB converter
  bool is_up = true;                   // CAN interface is up
  // Bit rate of a hardware CAN interface; 0: not set. Empty for virtual ones.
  std::optional<std::uint32_t> bit_rate{};
  std::string can_state{};  // "error-active", "bus-off"
  bool is_stick = false;    // input device is a joystick or gamepad
};

// The path to pass to programs: the stable link if there is one, otherwise the device file.
const std::string& best_path(const HostDevice& device);
std::string device_text(const HostDevice& device);    // for users: "laser range finder Hokuyo"
std::string programs_text(const HostDevice& device);  // its RACK programs; empty: none
// The address for option --device; empty if no transport supports the device.
std::string device_address(const HostDevice& device);
// The setup that is missing before a RACK program can use the device, one sentence each.
std::vector<std::string> what_is_missing(const HostDevice& device);

// --- changes between two lists of devices

struct DeviceChange {
  bool is_there = false;  // true: plugged in; false: unplugged
  HostDevice device{};
};
// Lists unplugged devices first.
std::vector<DeviceChange> changes(std::span<const HostDevice> before,
                                  std::span<const HostDevice> after);

// Four hexadecimal digits, as in USB identifiers.
std::string hex4(std::uint16_t value);

}  // namespace rack::device
