// A device of this host, as the kernel tells of it, and what that means to who wants to use it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "components/devices/known/known_devices.h"

namespace rack::device {

enum class HostDeviceKind : std::uint8_t { kSerial, kCan, kVideo, kInput, kGpio, kPps, kUsb };
std::string_view name(HostDeviceKind kind);  // "serial"

struct UsbIdentity {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  std::string serial_number{};
  std::string text{};            // what it calls itself
  std::uint32_t plugged_as = 0;  // the bus's number of it: another one when it is plugged in again

  bool operator==(const UsbIdentity&) const = default;
};

struct HostDevice {
  HostDeviceKind kind = HostDeviceKind::kSerial;
  std::string node{};    // "ttyUSB0", "can0", "video0", "event3", "1-2" of the bus
  std::string path{};    // "/dev/ttyUSB0"; nothing when there is no file
  std::string stable{};  // a link that stays the same when it is plugged in elsewhere
  std::optional<UsbIdentity> usb{};
  std::string text{};    // what the kernel calls it
  std::string driver{};  // of the kernel; empty: none

  bool is_there = true;                // its file
  bool may_use = true;                 // this user
  std::string group{};                 // that may
  std::vector<std::string> used_by{};  // "LadarSickLms200 (pid 4711)"
  std::optional<int> latency_ms{};     // of a USB converter's timer
  bool is_up = true;                   // of a CAN interface
  // Of a CAN interface that is no virtual one; 0: none was set.
  std::optional<std::uint32_t> bit_rate{};
  std::string can_state{};  // "error-active", "bus-off"
  bool is_stick = false;    // of input: a joystick or gamepad
};

// A file that programs are given: the one that stays, if there is one.
const std::string& best_path(const HostDevice& device);
std::string device_text(const HostDevice& device);    // for people: "laser range finder Hokuyo"
std::string programs_text(const HostDevice& device);  // of ours, for it; nothing: none
// As `--device` takes it; nothing: none of our transports reaches it.
std::string device_address(const HostDevice& device);
// What has to be done before a program of ours can use it, a sentence each.
std::vector<std::string> what_is_missing(const HostDevice& device);

// --- what has changed between two looks

struct DeviceChange {
  bool is_there = false;  // it came; else it went
  HostDevice device{};
};
// Those that went first.
std::vector<DeviceChange> changes(std::span<const HostDevice> before,
                                  std::span<const HostDevice> after);

// Four hexadecimal digits, as numbers of USB are written.
std::string hex4(std::uint16_t value);

}  // namespace rack::device
