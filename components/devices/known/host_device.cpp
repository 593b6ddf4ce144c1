#include "components/devices/known/host_device.h"

#include <algorithm>
#include <array>

namespace rack::device {
namespace {

constexpr std::array<std::string_view, 8> kKinds = {"serial", "can", "video", "input",
                                                    "gpio",   "pps", "usb",   "firewire"};
// Must be shorter than the period of a laser range finder at 75 Hz.
constexpr int kLatencyMaxMs = 4;

const KnownUsb* known(const HostDevice& device) {
  return device.usb ? find_usb(device.usb->vendor, device.usb->product) : nullptr;
}

bool is_same(const HostDevice& a, const HostDevice& b) {
  return a.kind == b.kind && a.node == b.node && a.usb == b.usb && a.guid == b.guid;
}

bool has(std::span<const HostDevice> devices, const HostDevice& wanted) {
  return std::ranges::any_of(devices, [&](const HostDevice& one) { return is_same(one, wanted); });
}

std::string module_missing(const HostDevice& device) {
  const KnownUsb* const row = known(device);
  if (device.kind != HostDeviceKind::kUsb || row == nullptr || row->module.empty()) return {};
  const std::string module(row->module);
  return device.driver.empty()
             ? "no kernel driver is bound to it: modprobe " + module
             : "kernel driver " + device.driver + " is bound to it instead of " + module;
}

std::string rights_missing(const HostDevice& device) {
  if (device.may_use || device.path.empty()) return {};
  if (!device.is_there)
    return "no " + device.path + " here: pass it to the container (docker run --device)";
  if (device.group.empty() || device.group == "root")
    return "only root has access to " + device.path + ": install deploy/udev/60-rack.rules";
  return "no access to " + device.path + ": usermod -aG " + device.group +
         " USER, and log in again";
}

}  // namespace

std::string hex4(std::uint16_t value) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (int shift = 12; shift >= 0; shift -= 4) text += kDigits[value >> shift & 0xFU];
  return text;
}

std::string_view name(HostDeviceKind kind) { return kKinds.at(static_cast<std::size_t>(kind)); }

const std::string& best_path(const HostDevice& device) {
  return device.stable.empty() ? device.path : device.stable;
}

std::string device_text(const HostDevice& device) {
  if (const KnownUsb* const row = known(device)) return std::string(row->device);
  if (device.bit_rate.value_or(0) > 0)
    return device.text + ", " + std::to_string(*device.bit_rate) + " bit/s" +
           (device.can_state.empty() ? "" : ", " + device.can_state);
  if (!device.text.empty()) return device.text;
  return device.usb ? device.usb->text : std::string();
}

std::string programs_text(const HostDevice& device) {
  if (const KnownUsb* const row = known(device)) return std::string(row->programs);
  switch (device.kind) {
    case HostDeviceKind::kSerial:
      return "any with a serial line";
    case HostDeviceKind::kCan:
      return "ChassisCan, Chassis402, ChassisRobucar, ServoDrive, LadarIbeo, ObjRecogIbeoLux";
    case HostDeviceKind::kVideo:
      return "CameraV4l";
    case HostDeviceKind::kInput:
      return device.is_stick ? "Joystick" : "";
    case HostDeviceKind::kGpio:
      return "Io";
    case HostDeviceKind::kPps:
      return "GpsNmea";
    case HostDeviceKind::kIidc:
      return "CameraDcam";
    case HostDeviceKind::kUsb:
      break;
  }
  return {};
}

std::string device_address(const HostDevice& device) {
  switch (device.kind) {
    case HostDeviceKind::kSerial:
      return "serial:" + best_path(device);
    case HostDeviceKind::kCan:
      return "can:" + device.node;
    case HostDeviceKind::kVideo:
      return "v4l:" + best_path(device);
    case HostDeviceKind::kGpio:
      return "gpio:" + best_path(device);
    case HostDeviceKind::kInput:
    case HostDeviceKind::kPps:
      return best_path(device);
    case HostDeviceKind::kIidc:
      return "dcam:" + device.guid;
    case HostDeviceKind::kUsb:
      break;
  }
  const KnownUsb* const row = known(device);
  if (row == nullptr || row->use != UsbUse::kRaw) return {};
  const std::string& number = device.usb->serial_number;
  return "usb:" + hex4(row->vendor) + ":" + hex4(row->product) +
         (number.empty() ? "" : "/" + number);
}

std::vector<std::string> what_is_missing(const HostDevice& device) {
  std::vector<std::string> missing;
  if (std::string text = module_missing(device); !text.empty()) missing.push_back(std::move(text));
  if (std::string text = rights_missing(device); !text.empty()) missing.push_back(std::move(text));
  if (device.bit_rate == 0U)
    missing.push_back("no bit rate set: ip link set " + device.node +
                      " up type can bitrate 500000 restart-ms 100");
  else if (device.kind == HostDeviceKind::kCan && !device.is_up)
    missing.push_back("it is down: ip link set " + device.node + " up" +
                      (device.driver.empty() || device.bit_rate
                           ? ""
                           : " type can bitrate 500000 restart-ms 100"));
  if (device.can_state == "bus-off")
    missing.push_back("it is bus-off: ip link set " + device.node + " type can restart");
  if (device.latency_ms.value_or(0) > kLatencyMaxMs)
    missing.push_back("its latency timer is " + std::to_string(*device.latency_ms) +
                      " ms; RACK drivers and deploy/udev/60-rack.rules set 1 ms");
  for (const std::string& program : device.used_by) missing.push_back("used by " + program);
  return missing;
}

std::vector<DeviceChange> changes(std::span<const HostDevice> before,
                                  std::span<const HostDevice> after) {
  std::vector<DeviceChange> all;
  for (const HostDevice& device : before)
    if (!has(after, device)) all.push_back({.is_there = false, .device = device});
  for (const HostDevice& device : after)
    if (!has(before, device)) all.push_back({.is_there = true, .device = device});
  return all;
}

}  // namespace rack::device
