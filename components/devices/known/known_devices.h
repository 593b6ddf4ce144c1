// The known USB devices: name, RACK driver programs, and the kernel module that makes them a serial
// port, a CAN interface or a camera.
//
// The identifiers of converters (CP210x, FT232, CH340, PL2303) do not identify the device behind
// the converter: their programs are only likely ones.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace rack::device {

enum class UsbUse : std::uint8_t {
  kSerial,     // a device with a built-in serial port
  kConverter,  // a serial port with an unknown device behind it
  kCan,        // a CAN interface
  kRaw,        // used through libusb
};

struct KnownUsb {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  UsbUse use = UsbUse::kSerial;
  std::string_view name;      // NAME in /dev/rack/NAME-SERIALNUMBER
  std::string_view device;    // description for users
  std::string_view programs;  // RACK programs, "LadarRplidar, LadarHokuyoUrg"; empty: none
  std::string_view module;    // kernel module; empty: none required
};

// By vendor and product, ascending.
std::span<const KnownUsb> known_usb();
// Returns null for unknown devices.
const KnownUsb* find_usb(std::uint16_t vendor, std::uint16_t product);

}  // namespace rack::device
